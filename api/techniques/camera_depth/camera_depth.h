/* camera_depth.h: the depth that a picture's camera sees: the engine's, or drawn from the scene. */
#ifndef TECHNIQUES_CAMERA_DEPTH_H
#define TECHNIQUES_CAMERA_DEPTH_H

#include "techniques/technique.h"

/* Sets technique_picture.depth. */
extern const technique technique_camera_depth;

/* Whether the view holds what csm drew in its last reduction. */
bool camera_depth_kept(const technique_set *view);

#endif
