#include "setup/presets.h"
#include "base/host.h"
#include <stdbool.h>
#include <string.h>

static bool describe(uint32_t index, csm_preset_info *info) {
  *info = (csm_preset_info){.struct_size = sizeof *info};
  return csm_config_preset_describe(index, info) == CSM_SUCCESS;
}

const char *preset_name(uint32_t index) {
  csm_preset_info info;
  return describe(index, &info) ? info.name : NULL;
}

const char *preset_find(const char *option, const char *name) {
  char names[2048] = "";
  size_t used = 0;
  for (uint32_t i = 0; preset_name(i); i++) {
    if (strcmp(preset_name(i), name) == 0)
      return preset_name(i);
    if (used < sizeof names)
      used += (size_t)snprintf(names + used, sizeof names - used, "%s%s", i ? ", " : "", preset_name(i));
  }
  host_fail(HOST_BAD_INPUT, "%s: no preset is called '%s'; there are %s", option, name, names);
  return NULL;
}

void preset_config(csm_config *out, const char *name, double shadow_distance) {
  csm_preset_info info;
  uint32_t index = 0;
  while (describe(index, &info) && strcmp(info.name, name) != 0)
    index++;
  *out = (csm_config){.struct_size = sizeof *out};
  csm_config_preset(name, out);
  if (!(info.flags & CSM_PRESET_SHADOW_DISTANCE))
    out->shadow_distance = shadow_distance;
}

json_t *presets_to_json(void) {
  json_t *all = json_object();
  csm_preset_info info;
  for (uint32_t i = 0; describe(i, &info); i++) {
    json_t *preset = json_object(), *notes = json_array();
    for (uint32_t k = 0; info.notes[k]; k++)
      json_array_append_new(notes, json_string(info.notes[k]));
    json_object_set_new(preset, "about", json_string(info.about));
    json_object_set_new(preset, "read_in", json_string(info.read_in));
    json_object_set_new(preset, "notes", notes);
    json_object_set_new(all, info.name, preset);
  }
  return all;
}
