/* frame_input.h: a frame as the caller gives it, copied and checked. */
#ifndef ABI_FRAME_INPUT_H
#define ABI_FRAME_INPUT_H

#include "abi/context.h"

typedef struct frame_input {
  csm_frame frame; /* camera and light point into this struct */
  csm_camera camera;
  csm_light light;
} frame_input;

/* Reads a frame but for the content of its list; `light` says whether its light is read. */
csm_result frame_input_read(csm_context *context, const csm_frame *in, bool light, frame_input *out);

/* Its instances: those of its scene, or of its list, which `list` takes. */
csm_result frame_input_scene(csm_context *context, const frame_input *input, instances *list, plan_scene *out);

#endif
