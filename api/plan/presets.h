/* presets.h: configurations by name: csm's own, and those of other systems. Each is a file of api/presets. */
#ifndef PLAN_PRESETS_H
#define PLAN_PRESETS_H

#include "csm/csm.h"

/* One number of csm_config that a preset sets. */
typedef struct plan_setting {
  uint32_t offset; /* in csm_config, in bytes; of an array's element */
  double number;
  const char *value; /* of an enumeration, by name; else NULL */
} plan_setting;

typedef struct plan_preset {
  const char *name, *about, *read_in; /* see csm_preset_info */
  const char *const *notes;
  const plan_setting *settings; /* what differs from the defaults */
  uint32_t setting_count;
} plan_preset;

extern const plan_preset plan_presets[];
extern const uint32_t plan_preset_count;

/* NULL: no preset has the name. */
const plan_preset *plan_preset_find(const char *name);
/* CSM_PRESET_* */
uint32_t plan_preset_flags(const plan_preset *preset);
/* Fills a configuration with the defaults, then with what the preset sets. */
void plan_preset_config(csm_config *out, const plan_preset *preset);

#endif
