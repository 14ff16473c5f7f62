/* picture.h: what csm drew, read by an engine or by csm itself. */
#ifndef PICTURE_H
#define PICTURE_H

#include "rig.h"

typedef struct picture_layer {
  uint32_t width, height;
  float *texels;
} picture_layer;

/* The maps, and the mask if it has a size. */
typedef struct picture {
  uint32_t count;
  picture_layer layers[CSM_MAX_CASCADES + 1];
} picture;

typedef struct picture_size {
  uint32_t width, height; /* of the mask; 0: none */
} picture_size;

/* From a context with a device of its own, which waits. */
picture picture_read(csm_context *context, csm_cascades *cascades, csm_view *view, picture_size mask);

/* Copies recorded into an engine's command buffer, to be taken when it has run. */
typedef struct picture_copy {
  rig_buffer buffer;
  uint32_t cascades, resolution, map_bytes;
  picture_size mask;
} picture_copy;

/* Of maps in `map_bytes` bytes a texel: 4, or 2. */
picture_copy picture_record(rig *rig, csm_cascades *cascades, csm_view *view, picture_size mask, uint32_t map_bytes);
picture picture_take(rig *rig, picture_copy *copy);

void picture_free(picture *picture);
/* Asserts that every texel is the same; `b` is freed. */
void picture_expect_equal(const picture *a, picture *b);
/* Whether every texel is the same. */
bool picture_equal(const picture *a, const picture *b);
/* Asserts that something that is not flat was drawn into each of the first maps. */
void picture_expect_casters(const picture *picture, uint32_t cascades);
/* Share of the mask's pixels that differ by more than `steps` of 255. */
double picture_mask_difference(const picture *a, const picture *b, double steps);

#endif
