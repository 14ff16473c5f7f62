/*
 * instances.h: the tree over a scene's instances that rays are led through, and a record of each. It is kept from frame to
 * frame: what has not changed is neither computed nor uploaded.
 */
#ifndef TECHNIQUES_RAYS_INSTANCES_H
#define TECHNIQUES_RAYS_INSTANCES_H

#include "techniques/technique.h"

extern const technique technique_ray_instances;

/* What the last recording left on the device; NULL: none, or no filter asks for it. */
gpu_buffer *ray_instances_buffer(const technique_set *cascades);
/* Tells the constants of a plan where they lie: csm_constants.h's CSM_R_LOW.w, CSM_R_SCALE and CSM_R_OFFSET; and
   CSM_R_UNSURE.z. */
void ray_instances_write(const technique_set *cascades, const plan_frame *frame, void *constants);

#endif
