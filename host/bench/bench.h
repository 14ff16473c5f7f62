/* bench/bench.h: the command that times the depth pass of each backend and of a bare loop, in turn in one process. */
#ifndef HOST_BENCH_H
#define HOST_BENCH_H

#include "setup/options.h"

/* An exit code. */
int bench_command(const host_options *options);

#endif
