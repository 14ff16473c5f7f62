/* setup/presets.h: configurations by name: csm's own, and those of other systems. They are files of presets/, embedded.
 */
#ifndef HOST_PRESETS_H
#define HOST_PRESETS_H

#include <jansson.h>
#include <stdint.h>

/* Static text; NULL past the last one. */
const char *preset_name(uint32_t index);

/*
 * The name as presets have it, which is static text, or NULL after a message that begins with `option` and lists the
 * names there are.
 */
const char *preset_find(const char *option, const char *name);

/* A preset's document: "about", "read_in", "notes", and "config", whose keys are csm_config's. A new object. */
json_t *preset_load(uint32_t index);
/* The configuration of a preset that preset_find has found. A new object. */
json_t *preset_config(const char *name);

/* All there are, by name, without their configurations. A new object. */
json_t *presets_to_json(void);

#endif
