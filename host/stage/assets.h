/* stage/assets.h: a scene's meshes and alpha masks in a context. */
#ifndef HOST_STAGE_ASSETS_H
#define HOST_STAGE_ASSETS_H

#include "csm/csm.h"
#include "scene/scene.h"

/* The context owns what the handles stand for. */
typedef struct assets {
  const scene *scene;
  csm_mesh *meshes;            /* as the scene's */
  csm_alpha_mask *alpha_masks; /* by material; 0: opaque */
  bool *watertight;            /* by mesh */
} assets;

/* `from` must live as long as the assets. assets_free is allowed after an error, too. */
csm_result assets_upload(assets *out, csm_context *context, const scene *from);
void assets_free(assets *a);
/* The same, and the context lets go of them, too. Precondition: no scene holds one of the meshes. */
void assets_destroy(assets *a, csm_context *context);

/* What an uploaded mesh was made of. */
csm_mesh_info assets_mesh_info(const assets *a, size_t mesh);

#endif
