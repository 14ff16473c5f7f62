/* measure_presets.h: presets side by side: what each gets wrong in a scene, and what it takes. */
#ifndef HOST_MEASURE_PRESETS_H
#define HOST_MEASURE_PRESETS_H

#include "options.h"

/* Runs `csm-host measure --presets`. Returns the exit code. */
int measure_presets(const host_options *options);

#endif
