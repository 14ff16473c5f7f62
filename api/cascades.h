/* cascades.h: one light seen from one camera: settings, maps, the mask, and what was planned and measured last. */
#ifndef CASCADES_H
#define CASCADES_H

#include "context.h"

typedef struct cascade_maps {
  retired retired;
  gpu_image *image;
  gpu_target *targets[CSM_MAX_CASCADES];
  uint32_t count, resolution;
} cascade_maps;

typedef struct cascade_mask {
  retired retired;
  uint32_t width, height;
  gpu_image *depth, *mask;
  gpu_target *depth_target, *mask_target;
  gpu_buffer *constants; /* MASK_BLOCKS bytes for each slot */
  gpu_bindings *bindings;
  bool drawn;
} cascade_mask;

/* A plan, with the memory that its lists and its copy of the instances lie in. */
typedef struct planned {
  void *memory;
  size_t size;
  plan_frame frame;
  plan_scene scene;
} planned;

struct csm_cascades {
  csm_context *context;
  csm_cascades *next, **link;
  csm_config config;
  cascade_maps *maps;
  cascade_mask *mask; /* NULL until one is asked for */
  planned plans[2];   /* the last one that was drawn, and room for the next */
  uint32_t current;
  bool drawn; /* maps hold plans[current], planned with config */
  csm_stats stats;
};

/* Takes over what a recording for these cascades measured, in nanoseconds. */
void cascades_take_timing(csm_cascades *cascades, const slot_timing *timing, const uint64_t *stamps);

/* Has the newest recording's timestamps delivered to these cascades. */
void cascades_expect_timing(csm_cascades *cascades, uint32_t count, bool mask);

/* NULL_POINTER, or DEVICE_LOST. */
csm_result cascades_usable(csm_cascades *cascades);

/* The mask's images for a size, made if they are not there. */
csm_result cascades_mask(csm_cascades *cascades, uint32_t width, uint32_t height, cascade_mask **out);

/* Frees the cascades at once; the device is idle. */
void cascades_destroy_now(csm_cascades *cascades);

#endif
