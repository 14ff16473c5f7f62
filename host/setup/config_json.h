/* setup/config_json.h: configurations in JSON. The keys are csm_config's fields, as csm_config_describe gives them. */
#ifndef HOST_CONFIG_JSON_H
#define HOST_CONFIG_JSON_H

#include "csm/csm.h"
#include <jansson.h>

/*
 * The default configuration with the scene's shadow distance, then what the preset says, then what the file says. Both
 * may be NULL. Precondition: preset_find has found the preset. The library checks ranges. 0, or HOST_BAD_INPUT after a
 * message that names the key.
 */
int config_load(csm_config *out, const char *preset, const char *path, double shadow_distance);
/* What an object says, over what `config` holds. `from` begins messages. 0, or HOST_BAD_INPUT as above. */
int config_read(csm_config *config, const char *from, json_t *object);

/* Whether the library would take it. 0, or HOST_BAD_INPUT after a message. */
int config_check(const csm_config *config, const char *from);

/* A new object with every field's value. Enumerations by name. */
json_t *config_to_json(const csm_config *config);

/* A new object with every field's type, unit, range (least and greatest, or an enumeration's names), default, about. */
json_t *config_describe_json(void);

#endif
