/* camera_depth.h: the depth that a picture's camera sees: the engine's, or drawn from the scene. */
#ifndef TECHNIQUES_CAMERA_DEPTH_H
#define TECHNIQUES_CAMERA_DEPTH_H

#include "techniques/technique.h"

/* Sets technique_picture.depth. */
extern const technique technique_camera_depth;

#endif
