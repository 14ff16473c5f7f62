#include "abi/cascades.h"

#include "abi/budget.h"
#include "abi/view.h"
#include "techniques/depth_samples/depth_samples.h"

static csm_result read_config(csm_context *context, const csm_config *in, csm_config *out) {
  csm_result result = host_check_struct(&context->host, struct_read(out, sizeof *out, in), "csm_config");
  if (result)
    return result;
  out->struct_size = sizeof *out;
  const char *text = "";
  result = plan_config_check(out, &text);
  return result ? host_fail(&context->host, result, "csm_config: %s", text) : CSM_SUCCESS;
}

csm_result cascades_usable(csm_cascades *cascades) {
  return cascades ? context_usable(cascades->context) : CSM_ERROR_NULL_POINTER;
}

csm_result cascades_drawn(csm_cascades *cascades) {
  return cascades->drawn ? CSM_SUCCESS
                         : host_fail(&cascades->context->host, CSM_ERROR_INVALID_STATE,
                                     "no maps have been drawn with this configuration yet");
}

bool cascades_known(const csm_context *context, const csm_cascades *cascades) {
  const csm_cascades *known = context->cascades;
  while (known && known != cascades)
    known = known->next;
  return known;
}

bool planned_current(const csm_cascades *cascades) {
  const planned *planned = cascades_planned(cascades);
  const mesh_table *meshes = &cascades->context->assets.meshes;
  if (planned->scene) /* a mesh that changes counts as a change of its instances */
    return planned->scene->store.revision == planned->revision;
  bool current = !planned->scene_gone;
  for (uint32_t i = 0; i < planned->list.live && current; ++i)
    current = meshes->revisions[planned->list.slots[i].mesh] <= planned->meshes_revision;
  return current;
}

void cascades_forget_scene(csm_context *context, const csm_scene *scene) {
  for (csm_cascades *c = context->cascades; c; c = c->next)
    for (int i = 0; i < 2; ++i)
      if (c->plans[i].scene == scene) {
        c->plans[i].scene = NULL;
        c->plans[i].scene_gone = true;
      }
}

/* ---- creation ---- */

static csm_result allocate_cascades(csm_context *context, const csm_config *config, csm_cascades **out) {
  host *host = &context->host;
  csm_cascades *cascades = host_allocate(host, sizeof *cascades);
  if (!cascades)
    return CSM_ERROR_OUT_OF_MEMORY;
  cascades->context = context;
  cascades->asked = *config;
  cascades->settings = ++context->settings;
  csm_result result = technique_set_begin_cascades(&cascades->techniques, host);
  if (!result)
    result = budget_make(cascades, context_device(context), config, &cascades->config);
  if (result) {
    technique_set_end(&cascades->techniques);
    host_release(host, cascades);
    return result;
  }
  technique_set_adopt(&cascades->techniques, context_device(context), &cascades->config);
  plan_budget_begin(&cascades->budget, &cascades->config, budget_late(context_device(context)));
  *out = cascades;
  return CSM_SUCCESS;
}

csm_result CSM_CALL csm_cascades_create(csm_context *context, const csm_config *config, csm_cascades **out) {
  if (out)
    *out = NULL;
  if (!context)
    return CSM_ERROR_NULL_POINTER;
  csm_result result = context_usable(context);
  if (!result && !out)
    result = host_fail(&context->host, CSM_ERROR_NULL_POINTER, "cascades is NULL");
  csm_config own;
  csm_cascades *cascades;
  if (!result)
    result = read_config(context, config, &own);
  if (!result)
    result = allocate_cascades(context, &own, &cascades);
  if (result)
    return result;
  cascades->next = context->cascades;
  cascades->link = &context->cascades;
  if (cascades->next)
    cascades->next->link = &cascades->next;
  context->cascades = cascades;
  *out = cascades;
  return CSM_SUCCESS;
}

csm_result CSM_CALL csm_cascades_configure(csm_cascades *cascades, const csm_config *config) {
  csm_result result = cascades_usable(cascades);
  if (result)
    return result;
  device *device = context_device(cascades->context);
  csm_config asked, own;
  result = read_config(cascades->context, config, &asked);
  if (!result)
    result = budget_make(cascades, device, &asked, &own);
  if (result)
    return result;
  technique_set_adopt(&cascades->techniques, device, &own);
  cascades->asked = asked;
  cascades->config = own;
  plan_budget_begin(&cascades->budget, &own, budget_late(device));
  cascades->settings = ++cascades->context->settings;
  cascades->drawn = false;
  for (csm_view *v = cascades->context->views; v && own.depth_samples == CSM_DEPTH_SAMPLES_OFF; v = v->next)
    if (v->cascades == cascades)
      depth_samples_drop(&v->techniques, device);
  plan_history_reconfigure(&cascades->history);
  return CSM_SUCCESS;
}

csm_result CSM_CALL csm_cascades_destroy(csm_cascades *cascades) {
  if (!cascades)
    return CSM_SUCCESS;
  csm_context *context = cascades->context;
  host *host = &context->host;
  technique_set_drop(&cascades->techniques, context_device(context));
  technique_set_end(&cascades->techniques);
  for (csm_view *v = context->views; v; v = v->next)
    v->cascades = v->cascades == cascades ? NULL : v->cascades;
  *cascades->link = cascades->next;
  if (cascades->next)
    cascades->next->link = cascades->link;
  for (int i = 0; i < 2; ++i) {
    host_release(host, cascades->plans[i].memory.at);
    instances_end(&cascades->plans[i].list, NULL);
  }
  host_release(host, cascades->cache.memory);
  host_release(host, cascades->samples);
  host_release(host, cascades);
  return CSM_SUCCESS;
}
