/* seen_depth.h: which depths a view's camera sees in this frame, tile by tile, read back before maps are planned. */
#ifndef TECHNIQUES_SEEN_DEPTH_H
#define TECHNIQUES_SEEN_DEPTH_H

#include "techniques/technique.h"

/* Runs in a reduction alone: technique_picture.reduces. */
extern const technique technique_seen_depth;

/*
 * What the view's last reduction saw; it stays until the next one. Waits for an own device. Errors: INVALID_STATE (there
 * was none on this device, or the engine's frame is not retired), OUT_OF_MEMORY, and those of waiting.
 */
csm_result seen_depth_collect(const technique_set *view, device *device, const plan_seen_depth **out);

#endif
