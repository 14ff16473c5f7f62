/* mesh_check.h: whether a mesh that a caller describes can be drawn, and where it is. */
#ifndef SCENE_MESH_CHECK_H
#define SCENE_MESH_CHECK_H

#include "scene/assets.h"

/* Checks a mesh for a device, and fills in strides that are 0. Errors as csm_mesh_create. */
csm_result mesh_check(const assets *assets, const device *device, csm_mesh_info *info, plan_bounds *bounds);
/* Checks new positions of a mesh, or new bounds of one in an engine's buffers. Errors as csm_mesh_update. */
csm_result mesh_check_update(const assets *assets, uint32_t mesh, csm_mesh_update_info *info, plan_bounds *bounds);

#endif
