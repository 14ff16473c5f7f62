/* engine_image.h: an engine's image, taken in for one recording. */
#ifndef TECHNIQUES_ENGINE_IMAGE_H
#define TECHNIQUES_ENGINE_IMAGE_H

#include "device/device.h"
#include "plan/plan.h"

typedef struct engine_image {
  const void *native;     /* csm_vulkan_image, csm_d3d12_image, or NULL */
  const char *name;       /* for errors */
  gpu_texels texels;      /* what it is to hold */
  uint32_t width, height; /* that it must have */
} engine_image;

typedef struct engine_imported {
  gpu_image *image; /* NULL: there is none */
  bool unorm;       /* its texels are normalised integers from 0 to 1 */
  plan_grain rounding;
} engine_imported;

/*
 * Takes an image in until the frame that is about to be recorded is done.
 * Errors: those of gpu_image_import, and INVALID_VALUE (another size).
 */
csm_result engine_image_import(device *device, const engine_image *from, engine_imported *out);

#endif
