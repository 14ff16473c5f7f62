/* report/preset_table.h: presets side by side: what each gets wrong in a scene, and what it takes. */
#ifndef HOST_REPORT_PRESET_TABLE_H
#define HOST_REPORT_PRESET_TABLE_H

#include "setup/options.h"

/* Runs `csm-host measure --presets`. Returns the exit code. */
int preset_table_command(const host_options *options);

#endif
