#include "plan/plan.h"
#include "plan/presets.h"
#include "structs.h"

csm_result CSM_CALL csm_config_describe(uint32_t index, csm_config_field *out) {
  const csm_result result = struct_check(sizeof *out, out);
  if (result)
    return result;
  const csm_config_field *field = plan_config_field(index);
  if (!field)
    return CSM_ERROR_INVALID_INDEX;
  struct_write(out, sizeof *field, field);
  return CSM_SUCCESS;
}

csm_result CSM_CALL csm_config_default(csm_config *out) {
  const csm_result result = struct_check(sizeof *out, out);
  if (result)
    return result;
  csm_config config = {.struct_size = sizeof config};
  plan_config_default(&config);
  struct_write(out, sizeof config, &config);
  return CSM_SUCCESS;
}

csm_result CSM_CALL csm_config_preset(const char *name, csm_config *out) {
  const csm_result result = name ? struct_check(sizeof *out, out) : CSM_ERROR_NULL_POINTER;
  if (result)
    return result;
  const plan_preset *preset = plan_preset_find(name);
  if (!preset)
    return CSM_ERROR_INVALID_VALUE;
  csm_config config = {.struct_size = sizeof config};
  plan_preset_config(&config, preset);
  struct_write(out, sizeof config, &config);
  return CSM_SUCCESS;
}

csm_result CSM_CALL csm_config_preset_describe(uint32_t index, csm_preset_info *out) {
  const csm_result result = struct_check(sizeof *out, out);
  if (result)
    return result;
  if (index >= plan_preset_count)
    return CSM_ERROR_INVALID_INDEX;
  const plan_preset *preset = &plan_presets[index];
  const csm_preset_info info = {.struct_size = sizeof info,
                                .flags = plan_preset_flags(preset),
                                .name = preset->name,
                                .about = preset->about,
                                .read_in = preset->read_in,
                                .notes = preset->notes};
  struct_write(out, sizeof info, &info);
  return CSM_SUCCESS;
}

csm_result CSM_CALL csm_shader_defines(const csm_config *in, char *text, uint64_t *size) {
  if (!size)
    return CSM_ERROR_NULL_POINTER;
  csm_config config;
  const char *wrong;
  csm_result result = struct_read(&config, sizeof config, in);
  if (!result)
    result = plan_config_check(&config, &wrong);
  if (result)
    return result;
  const uint64_t room = *size;
  *size = plan_shader_defines(&config, NULL, 0);
  if (!text)
    return CSM_SUCCESS;
  if (room < *size)
    return CSM_ERROR_INVALID_VALUE;
  plan_shader_defines(&config, text, room);
  return CSM_SUCCESS;
}
