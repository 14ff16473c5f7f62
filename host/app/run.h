/* app/run.h: the command that draws one frame on each backend, compares them and writes pictures. */
#ifndef HOST_RUN_H
#define HOST_RUN_H

#include "setup/options.h"

/* An exit code. */
int run_command(const host_options *options);

#endif
