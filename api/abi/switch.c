#include "abi/budget.h"
#include "abi/view.h"

/* Maps and programs on the new device for all cascades, or for none. */
static csm_result make_all(csm_context *context, device *fresh) {
  csm_result result = CSM_SUCCESS;
  csm_cascades *c = context->cascades;
  while (c && !result) {
    result = budget_make(c, fresh, &c->asked, &c->fresh);
    c = result ? c : c->next;
  }
  for (csm_cascades *made = context->cascades; result && made != c; made = made->next)
    technique_set_forget(&made->techniques, fresh);
  return result;
}

/* From here on nothing can fail. */
static void change_device(csm_context *context, opened *fresh) {
  opened *old = context->opened;
  for (csm_cascades *c = context->cascades; c; c = c->next) {
    technique_set_adopt(&c->techniques, old->device, &c->fresh);
    c->config = c->fresh; /* the same, unless the device pads images otherwise */
    plan_budget_forget(&c->budget, budget_late(fresh->device));
    c->drawn = false;
  }
  for (csm_view *v = context->views; v; v = v->next)
    technique_set_drop(&v->techniques, old->device);
  context->opened = fresh;
  assets_moved(&context->assets, fresh->device);
  if (old->device->own || old->device->lost || old->device->serial <= old->device->done) {
    context_close(context, old);
  } else {
    old->next = context->former;
    context->former = old;
  }
}

csm_result CSM_CALL csm_switch_backend(csm_context *context, const csm_create_info *in) {
  if (!context)
    return CSM_ERROR_NULL_POINTER;
  csm_create_info info;
  const char *text;
  opened *fresh;
  csm_result result = host_check_struct(&context->host, struct_read(&info, sizeof info, in), "csm_create_info");
  if (result)
    return result;
  result = create_info_check(&info, &text);
  result = result ? host_fail(&context->host, result, "%s", text) : context_open(context, &info, &fresh);
  if (result)
    return create_info_refuse(&info, result, context->host.error);
  result = assets_move(&context->assets, fresh->device);
  if (!result)
    result = make_all(context, fresh->device);
  if (result) {
    assets_stay(&context->assets);
    context_close(context, fresh);
    return create_info_refuse(&info, result, context->host.error);
  }
  change_device(context, fresh);
  return CSM_SUCCESS;
}
