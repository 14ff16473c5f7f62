/* ray_record.h: an instance as rays find it. */
#ifndef TECHNIQUES_RAY_RECORD_H
#define TECHNIQUES_RAY_RECORD_H

#include "device/device.h"
#include "plan/plan.h"

enum { RAY_RECORD_ROWS = 8, RAY_RECORD_SIZE = 128 };

/* Writes the rows that csm_rays.inc reads: RAY_RECORD_SIZE bytes. `rays` may be NULL: the instance cannot be traced. So is
   one that is so flat that no place within it can be told. */
void ray_record_write(void *out, const plan_instance *instance, const plan_bounds *bounds, const mesh_rays *rays);

#endif
