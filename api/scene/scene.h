/* scene.h: instances that stay from frame to frame, and lists of them that come with a frame. */
#ifndef SCENE_SCENE_H
#define SCENE_SCENE_H

#include "scene/assets.h"

struct csm_scene {
  csm_context *context; /* for the calls that come with a scene alone; not looked into here */
  assets *assets;
  csm_scene *next, **link; /* of assets->scenes */
  instances store;
};

/* ---- the calls of csm.h; the device is not lost ---- */
csm_result scene_create(assets *assets, csm_context *context, csm_scene **out);
void scene_destroy(csm_scene *scene);
csm_result scene_add(csm_scene *scene, const csm_scene_batch *batch);
csm_result scene_move(csm_scene *scene, const csm_scene_batch *batch);
csm_result scene_change(csm_scene *scene, const csm_scene_batch *batch);
csm_result scene_remove(csm_scene *scene, uint32_t count, const csm_instance_id *ids);

/* ---- for frames ---- */
/* Whether a scene is one of these assets'. The pointer is compared, not followed. */
bool scene_known(const assets *assets, const csm_scene *scene);
/* Makes a frame's list all that a store holds. Errors as csm_render_cascades has them; the store is empty then. */
csm_result scene_take_list(assets *assets, instances *store, const csm_instance *list, uint32_t count);
/* What the plan reads of a store; until it, or a mesh, changes. */
plan_scene scene_of(const assets *assets, const instances *store);

#endif
