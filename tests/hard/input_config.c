/* input_config.c: a configuration file, as --config reads it, and what csm makes of it. */
#include "csm/csm.h"
#include "input.h"
#include "setup/config_json.h"

#include <stdlib.h>
#include <string.h>

uint32_t input_seeds(input_seed out[INPUT_SEEDS]) {
  enum { PRESETS = 4, COUNT = 6 };
  static const char *const presets[COUNT] = {"low", "godot", "survey12", "exact_soft", "medium", "medium"};
  static char *texts[COUNT];
  for (int i = 0; i < COUNT; i++) {
    csm_config config = {.struct_size = sizeof config};
    csm_config_preset(presets[i], &config);
    if (i >= PRESETS) { /* moments with levels, and soft shadows with a history */
      config.filter = i == PRESETS ? CSM_FILTER_EVSM4 : CSM_FILTER_PCSS;
      config.moment_levels = 4;
      config.moment_sampling = CSM_SAMPLING_ANISOTROPIC;
      config.history = CSM_HISTORY_ON;
    }
    json_t *object = config_to_json(&config);
    free(texts[i]);
    texts[i] = json_dumps(object, JSON_COMPACT);
    json_decref(object);
    out[i] = (input_seed){texts[i], strlen(texts[i])};
  }
  return COUNT;
}

/* What is checked here, csm takes: but for what a device cannot do. */
static void configure(const csm_config *config) {
  const csm_create_info info = {
      .struct_size = sizeof info, .flags = CSM_CREATE_RAYS, .version = CSM_VERSION, .backend = "null"};
  static csm_context *context;
  csm_cascades *cascades;
  if (!context && csm_create(&info, &context))
    abort();
  const csm_result result = csm_cascades_create(context, config, &cascades);
  if (result && result != CSM_ERROR_LIMIT_EXCEEDED && result != CSM_ERROR_UNSUPPORTED)
    abort();
  csm_cascades_destroy(cascades);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  csm_config config;
  input_quiet();
  if (config_load(&config, NULL, input_file(data, size, ".json"), 100.0) == 0 && config_check(&config, "input") == 0) {
    json_decref(config_to_json(&config));
    config.resolution = config.resolution > 64 ? 64 : config.resolution; /* large maps take a while */
    memset(config.resolutions, 0, sizeof config.resolutions);
    if (config_check(&config, "input") == 0) /* a blur may be too wide for a small map */
      configure(&config);
  }
  return 0;
}
