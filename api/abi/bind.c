#include "abi/cascades.h"
#include "abi/view.h"
#include "techniques/maps/maps.h"

#include <string.h>

csm_result CSM_CALL csm_bind(csm_cascades *cascades, csm_binding *out) {
  csm_result result = cascades_usable(cascades);
  if (result)
    return result;
  csm_context *context = cascades->context;
  csm_binding given;
  result = host_check_struct(&context->host, struct_read(&given, sizeof given, out), "csm_binding");
  if (!result)
    result = cascades_drawn(cascades);
  if (!result && given.view && !view_known(context, given.view))
    result = host_fail(&context->host, CSM_ERROR_INVALID_HANDLE, "csm_binding: view is none of this context");
  if (result)
    return result;
  const planned *planned = cascades_planned(cascades);
  const plan_frame *plan = &planned->frame;
  csm_binding binding = {.cascade_count = plan->cascade_count,
                         .view = given.view,
                         .cascade_constants = &planned->constants.cascades,
                         .setting_constants = &planned->constants.settings,
                         .cascade_constants_size = sizeof planned->constants.cascades,
                         .setting_constants_size = sizeof planned->constants - offsetof(csm_constants, settings),
                         .maps_descriptor = given.maps_descriptor,
                         .mask_descriptor = given.mask_descriptor,
                         .moments_descriptor = given.moments_descriptor};
  memcpy(binding.origin, plan->origin, sizeof binding.origin);
  for (uint32_t i = 0; i < plan->cascade_count; ++i) {
    binding.cascades[i] = plan->cascades[i].info;
    binding.resolutions[i] = plan->cascades[i].resolution;
  }
  technique_set_bind(&cascades->techniques, context_device(context), &binding);
  if (given.view)
    technique_set_bind(&given.view->techniques, context_device(context), &binding);
  struct_write(out, sizeof binding, &binding);
  return CSM_SUCCESS;
}

csm_result CSM_CALL csm_get_draw_target(csm_cascades *cascades, csm_draw_target *out) {
  csm_result result = cascades_usable(cascades);
  if (result)
    return result;
  csm_context *context = cascades->context;
  csm_draw_target target = {0};
  result = host_check_struct(&context->host, struct_check(sizeof *out, out), "csm_draw_target");
  if (!result)
    result = maps_draw_target(&cascades->techniques, context_device(context), &target);
  if (!result)
    struct_write(out, sizeof target, &target);
  return result;
}
