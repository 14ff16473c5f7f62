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

/* What one resolve of a mask reads, in use until its frame is done. */
typedef struct mask_input {
  struct mask_input *next;
  gpu_bindings *bindings;
  uint64_t serial;
} mask_input;

typedef struct cascade_mask {
  retired retired;
  uint32_t width, height;
  gpu_image *mask;
  gpu_target *mask_target;
  gpu_image *depth; /* NULL as long as the engine brings its own */
  gpu_target *depth_target;
  mask_input *inputs[2]; /* without and with normals */
  bool drawn, depth_drawn;
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

/* ---- cascades.c ---- */

/* Takes over what a recording for these cascades measured, in nanoseconds. */
void cascades_take_timing(csm_cascades *cascades, const timing *timing, const uint64_t *stamps);

/* NULL_POINTER, or DEVICE_LOST. */
csm_result cascades_usable(csm_cascades *cascades);

/* Maps for a configuration, on a device that need not be the context's. */
csm_result maps_create(device *device, const csm_config *config, cascade_maps **out);
/* Frees them at once. */
void maps_free(device *device, retired *self);

/* Leaves a device, with `maps` of another one: what lies on the old one is retired there. */
void cascades_move(csm_cascades *cascades, device *from, cascade_maps *maps);

/* Frees the cascades at once; the GPU is done with them. */
void cascades_destroy_now(csm_cascades *cascades);

/* ---- mask_images.c ---- */

/* A mask with images of a size, with `depth` an own camera depth too: the one that is there if it fits, else a new one,
   which is to be kept or forgotten. */
csm_result mask_prepare(csm_cascades *cascades, uint32_t width, uint32_t height, bool depth, cascade_mask **out);
/* Puts a prepared mask in the place of the one that was there. */
void mask_keep(csm_cascades *cascades, cascade_mask *mask);
/* Frees a prepared mask that nothing came of; NULL is allowed. */
void mask_forget(csm_cascades *cascades, cascade_mask *mask);

/* Something that no recording in flight reads through, made if there is none. */
csm_result mask_input_find(csm_cascades *cascades, cascade_mask *mask, const gpu_bindings_info *reads, bool normals,
                           mask_input **out);

/* Retires the mask, if there is one. */
void mask_drop(csm_cascades *cascades, device *device);
/* Frees it at once. */
void mask_free(device *device, retired *self);

#endif
