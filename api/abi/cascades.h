/* cascades.h: one light seen from one camera: settings, maps, the mask, and what was planned and measured last. */
#ifndef CASCADES_H
#define CASCADES_H

#include "abi/context.h"

typedef struct cascade_maps {
  retired retired;
  gpu_image *image;
  gpu_target *targets[CSM_MAX_CASCADES]; /* by layer */
  plan_layout layout;
  gpu_format format;
} cascade_maps;

/* What lies on the device for a configuration. */
typedef struct cascade_resources {
  cascade_maps *maps;
  caster_programs *casters;
} cascade_resources;

typedef struct sample_read sample_read;

/* What the depths of masks of one size are brought down to. */
typedef struct sample_tiles {
  retired retired;
  uint32_t width, height; /* of the masks */
  uint32_t columns, rows; /* of large tiles */
  gpu_image *images[2];   /* small tiles, large ones */
  gpu_target *targets[2];
  sample_read *reads;
} sample_tiles;

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
  cascade_resources resources;
  cascade_mask *mask;   /* NULL until one is asked for */
  plan_history history; /* what the last drawn frame handed on */
  sample_tiles *tiles;  /* NULL until a mask is resolved with depth_samples */
  plan_samples samples; /* of the newest frame that is done; without columns if there was none */
  void *samples_memory; /* that its depths lie in */
  size_t samples_size;
  planned plans[2]; /* the last one that was drawn, and room for the next */
  uint32_t current;
  bool drawn; /* maps hold plans[current], planned with config */
  csm_stats stats;
};

/* ---- cascades.c ---- */

/* Takes over what a recording for these cascades measured, in nanoseconds. */
void cascades_take_timing(csm_cascades *cascades, const timing *timing, const uint64_t *stamps);

/* NULL_POINTER, or DEVICE_LOST. */
csm_result cascades_usable(csm_cascades *cascades);

/* Maps and programs for a configuration, on a device that need not be the context's; what `old`, which may be NULL, has
   of the right shape is used on. */
csm_result resources_create(device *device, const csm_config *config, const cascade_resources *old,
                            cascade_resources *out);
/* Frees them at once. */
void resources_free(device *device, cascade_resources *resources);

/* Leaves a device, with what was made on another one: what lies on the old one is retired there. */
void cascades_move(csm_cascades *cascades, device *from, const cascade_resources *resources);

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

/* ---- samples.c ---- */

/*
 * Reserves what it takes to bring a camera's depth down to tiles and read them back; `constants` is the recording's
 * ring. Nothing is recorded yet.
 */
csm_result samples_prepare(csm_cascades *cascades, const plan_camera *camera, uint32_t width, uint32_t height,
                           gpu_buffer *constants, gpu_image *depth, sample_read **out);
/* Records it; the depth is readable. The ring holds DEPTH_TILES_BLOCKS bytes at the offset. */
void samples_record(csm_cascades *cascades, sample_read *read, uint32_t constants_offset);
/* Takes over what has come back. */
void samples_collect(csm_cascades *cascades);
/* Retires everything, and forgets what was seen. */
void samples_drop(csm_cascades *cascades, device *device);
void sample_tiles_free(device *device, retired *self);

/* ---- mask_images.c ---- */

/* Retires the mask, if there is one. */
void mask_drop(csm_cascades *cascades, device *device);
/* Frees it at once. */
void mask_free(device *device, retired *self);

#endif
