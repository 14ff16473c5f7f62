/* measure/measure.h: the command that measures what is drawn against the truth. */
#ifndef HOST_MEASURE_H
#define HOST_MEASURE_H

#include "setup/options.h"

/* An exit code. */
int measure_command(const host_options *options);

#endif
