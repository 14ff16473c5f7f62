/*
 * rig_forward.h: a forward shader of an engine's, which is fixed to filter exact and sends rays, or follows the configuration
 * and sends none: all that it reads it binds by the handles that csm_bind tells. Its samplers repeat, as pages need them.
 */
#ifndef RIG_FORWARD_H
#define RIG_FORWARD_H

#include "rig.h"

typedef struct rig_forward rig_forward;

enum { FORWARD_PLANE = 16 /* floats, of ../binding/plane.h */ };

rig_forward *rig_forward_make(rig *rig, uint32_t width, uint32_t height, bool rays);
/* Records a picture of the plane, and its copy. What was recorded before has run. */
void rig_forward_draw(rig_forward *forward, const csm_binding *binding, const float plane[FORWARD_PLANE]);
/* The picture that has run: rig_pitch(width, 1) bytes a row. */
const unsigned char *rig_forward_picture(const rig_forward *forward);
void rig_forward_free(rig_forward *forward);

#endif
