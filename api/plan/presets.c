/* presets.c: what a preset makes of a configuration. */
#include "plan/presets.h"

#include "plan/internal.h"
#include <string.h>

const plan_preset *plan_preset_find(const char *name) {
  for (uint32_t i = 0; i < plan_preset_count; ++i)
    if (strcmp(plan_presets[i].name, name) == 0)
      return &plan_presets[i];
  return NULL;
}

uint32_t plan_preset_flags(const plan_preset *preset) {
  uint32_t flags = 0;
  for (uint32_t i = 0; i < preset->setting_count; ++i)
    if (preset->settings[i].offset == offsetof(csm_config, shadow_distance))
      flags |= CSM_PRESET_SHADOW_DISTANCE;
  return flags;
}

/* The enumerator's number. One past the last, which no check lets through, where there is none of that name. */
static uint32_t enumerator(const csm_config_field *field, const char *name) {
  uint32_t number = 0;
  while (field->values[number] && strcmp(field->values[number], name) != 0)
    ++number;
  return number;
}

static void set(csm_config *config, const csm_config_field *field, const plan_setting *setting) {
  void *const at = (char *)config + setting->offset;
  if (plan_is_double(field))
    *(double *)at = setting->number;
  else
    *(uint32_t *)at = setting->value ? enumerator(field, setting->value) : (uint32_t)setting->number;
}

void plan_preset_config(csm_config *out, const plan_preset *preset) {
  plan_config_default(out);
  const csm_config_field *field;
  for (uint32_t i = 0; (field = plan_config_field(i)); ++i) {
    const size_t size = field->length * (plan_is_double(field) ? sizeof(double) : sizeof(uint32_t));
    for (uint32_t k = 0; k < preset->setting_count; ++k) {
      const uint32_t offset = preset->settings[k].offset;
      if (offset >= field->offset && offset < field->offset + size)
        set(out, field, &preset->settings[k]);
    }
  }
}
