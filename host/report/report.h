/* report/report.h: the command that sweeps configurations and writes a page on error against time. */
#ifndef HOST_REPORT_H
#define HOST_REPORT_H

#include "setup/options.h"

/* An exit code. */
int report_command(const host_options *options);

#endif
