/* map_image.h: the images that a configuration's maps lie in. */
#ifndef TECHNIQUES_MAP_IMAGE_H
#define TECHNIQUES_MAP_IMAGE_H

#include "device/device.h"
#include "plan/plan.h"

/* Maps without what keeps moving: see plan_pages. */
typedef struct map_second {
  gpu_image *image; /* NULL: nothing has moved yet */
  gpu_target *targets[CSM_MAX_CASCADES];
  gpu_program *copy;
  gpu_bindings *from_maps, *from_here; /* what a copy reads */
  bool written;
} map_second;

typedef struct map_image {
  retired retired;
  gpu_image *image;
  gpu_target *targets[CSM_MAX_CASCADES]; /* by layer */
  plan_layout layout;
  gpu_format format;
  bool written; /* something has been recorded into it */
  map_second second;
} map_image;

/* Errors: those of the device, OUT_OF_MEMORY. */
csm_result map_image_create(device *device, const plan_layout *layout, gpu_format format, map_image **out);
void map_image_free(device *device, retired *self);
/* Makes the second layers, if they are not there. After an error there are none. */
csm_result map_image_extend(device *device, map_image *image);
/* Device memory of both. */
uint64_t map_image_bytes(const device *device, const map_image *image);

#endif
