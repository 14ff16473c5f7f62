#include "abi/cascades.h"

csm_result CSM_CALL csm_scene_create(csm_context *context, csm_scene **scene) {
  if (scene)
    *scene = NULL;
  if (!context)
    return CSM_ERROR_NULL_POINTER;
  csm_result result = context_usable(context);
  if (!result && !scene)
    result = host_fail(&context->host, CSM_ERROR_NULL_POINTER, "scene is NULL");
  return result ? result : scene_create(&context->assets, context, scene);
}

csm_result CSM_CALL csm_scene_destroy(csm_scene *scene) {
  if (!scene)
    return CSM_SUCCESS;
  cascades_forget_scene(scene->context, scene);
  scene_destroy(scene);
  return CSM_SUCCESS;
}

static csm_result usable(const csm_scene *scene) {
  return scene ? context_usable(scene->context) : CSM_ERROR_NULL_POINTER;
}

csm_result CSM_CALL csm_scene_add(csm_scene *scene, const csm_scene_batch *batch) {
  const csm_result result = usable(scene);
  return result ? result : scene_add(scene, batch);
}

csm_result CSM_CALL csm_scene_move(csm_scene *scene, const csm_scene_batch *batch) {
  const csm_result result = usable(scene);
  return result ? result : scene_move(scene, batch);
}

csm_result CSM_CALL csm_scene_change(csm_scene *scene, const csm_scene_batch *batch) {
  const csm_result result = usable(scene);
  return result ? result : scene_change(scene, batch);
}

csm_result CSM_CALL csm_scene_remove(csm_scene *scene, uint32_t count, const csm_instance_id *ids) {
  const csm_result result = usable(scene);
  return result ? result : scene_remove(scene, count, ids);
}
