/* setup/presets.h: the library's presets, for the command line. */
#ifndef HOST_PRESETS_H
#define HOST_PRESETS_H

#include "csm/csm.h"
#include <jansson.h>

/* Static text; NULL past the last one. */
const char *preset_name(uint32_t index);

/*
 * The name as presets have it: static text. NULL after a message that begins with `option` and lists the names there
 * are.
 */
const char *preset_find(const char *option, const char *name);

/* The configuration of a preset that preset_find has found, with the scene's shadow distance where it says none. */
void preset_config(csm_config *out, const char *name, double shadow_distance);

/* All there are, by name, without their configurations. A new object. */
json_t *presets_to_json(void);

#endif
