#include "plan/plan.h"
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
