/* depth_samples.h: the depths that a view's camera saw, tile by tile, read back once their frame is done. */
#ifndef TECHNIQUES_DEPTH_SAMPLES_H
#define TECHNIQUES_DEPTH_SAMPLES_H

#include "techniques/technique.h"

extern const technique technique_depth_samples;

/* Takes over what has come back; *out is what is known now, without columns if nothing is. It stays until the view's
   next call. */
void depth_samples_collect(const technique_set *view, const device *device, plan_depth_samples *out);

/* Nothing that the view saw is used any more, and its images go. */
void depth_samples_drop(const technique_set *view, device *device);

#endif
