/* scene/mesh_watertight.h: whether a mesh has an inside. */
#ifndef HOST_MESH_WATERTIGHT_H
#define HOST_MESH_WATERTIGHT_H

#include "scene/scene.h"

/*
 * Whether a mesh is watertight: each directed edge has its opposite, where vertices at one place are one, and each
 * connected piece is counter-clockwise seen from outside. The first surface that a ray from outside meets is then never
 * seen from behind.
 */
bool mesh_is_closed(const scene_mesh *mesh);

#endif
