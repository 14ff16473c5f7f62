/* image.h: the image that moments lie in, what they are blurred in, and which of its tiles hold what the maps hold. */
#ifndef TECHNIQUES_MOMENTS_IMAGE_H
#define TECHNIQUES_MOMENTS_IMAGE_H

#include "device/device.h"
#include "plan/plan.h"

enum { MOMENT_LEVELS_MOST = 12 };

typedef struct moment_image {
  retired retired;
  plan_moments shape;
  gpu_format format;
  uint32_t cascades, layers; /* layers: cascades times layers of depth */
  gpu_image *image;
  gpu_view *levels[MOMENT_LEVELS_MOST];
  gpu_image *between; /* one layer, blurred along rows; NULL: there is no blur */
  gpu_view *between_view;
  gpu_target **targets; /* layer after layer of level after level: images begin with zeros */
  uint32_t target_count;
  bool begun;                        /* it has been cleared */
  uint32_t across[CSM_MAX_CASCADES]; /* tiles in a row of a cascade's */
  uint8_t *valid[CSM_MAX_CASCADES];  /* by tile: it holds what the map holds */
  uint8_t *due[CSM_MAX_CASCADES];    /* by tile, of the recording on its way: it is to be made */
  uint8_t *spread;                   /* room for as many tiles as the largest cascade has */
  void *memory;                      /* of the three above */
  uint32_t tile_count;               /* of all cascades */
} moment_image;

/* Errors: UNSUPPORTED, and those of creation. */
csm_result moment_image_create(device *device, const csm_config *config, moment_image **out);
void moment_image_free(device *device, retired *self);
uint64_t moment_image_bytes(const device *device, const moment_image *image);
gpu_format moment_format(const plan_moments *shape, const csm_config *config);
/* Fills it with zeros, so that whatever shaders look at is a number. */
void moment_image_clear(gpu gpu, const moment_image *image);

#endif
