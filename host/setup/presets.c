#include "setup/presets.h"
#include "base/host.h"
#include "setup/preset_texts.h"
#include <string.h>

#define PRESET_COUNT (sizeof preset_texts / sizeof preset_texts[0] - 1)

const char *preset_name(uint32_t index) {
  return index < PRESET_COUNT ? preset_texts[index].name : NULL;
}

const char *preset_find(const char *option, const char *name) {
  char names[1024] = "";
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

json_t *preset_load(uint32_t index) {
  return json_loads(preset_texts[index].text, JSON_REJECT_DUPLICATES, NULL);
}

json_t *preset_config(const char *name) {
  uint32_t index = 0;
  while (strcmp(preset_name(index), name) != 0)
    index++;
  json_t *preset = preset_load(index), *config = json_incref(json_object_get(preset, "config"));
  json_decref(preset);
  return config;
}

json_t *presets_to_json(void) {
  json_t *all = json_object();
  for (uint32_t i = 0; preset_name(i); i++) {
    json_t *preset = preset_load(i);
    json_object_del(preset, "config");
    json_object_set_new(all, preset_name(i), preset);
  }
  return all;
}
