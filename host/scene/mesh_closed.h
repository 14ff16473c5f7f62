/* scene/mesh_closed.h: whether a mesh has an inside. */
#ifndef HOST_MESH_CLOSED_H
#define HOST_MESH_CLOSED_H

#include "scene/scene.h"

/*
 * Whether each directed edge has its opposite, vertices at one place being one, and each connected piece is wound so
 * that counter-clockwise is outside: then the first surface that a ray from outside meets is never seen from behind.
 */
bool mesh_is_closed(const scene_mesh *mesh);

#endif
