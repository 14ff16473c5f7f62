/* steady.h: what the tests of steady frames share: many casters, a count of what rendering them asks for, and the test
   of the hook that counts. */
#ifndef STEADY_H
#define STEADY_H

#include "../conformance/support.h"

enum { STEADY_WARM_UP = 6, STEADY_FRAMES = 20, STEADY_BOXES = 2000 };

/* STEADY_BOXES instances of the two meshes by turns; the caller frees them. */
csm_instance *steady_boxes(const csm_mesh meshes[2]);

/* Renders the boxes in a frame; from frame STEADY_WARM_UP on, nothing may be asked of allocator or heap. */
void steady_render(csm_cascades *cascades, csm_frame frame, const csm_instance *boxes, const record *record,
                   int number);

/* A test: the hook sees a library of csm's that allocates, for no allocator is given there. */
void steady_hook_sees_allocations(void **state);

#endif
