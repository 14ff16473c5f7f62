/* drawn_image.h: an image that a view's technique draws, in the size of the view's pictures. */
#ifndef TECHNIQUES_DRAWN_IMAGE_H
#define TECHNIQUES_DRAWN_IMAGE_H

#include "techniques/technique.h"

typedef struct drawn_image {
  retired retired;
  gpu_image *image;
  gpu_target *target;
  gpu_format format;
  uint32_t width, height;
  gpu_view *stores; /* what shaders write it through; NULL: they do not */
  bool drawn;
} drawn_image;

/* What a state has, and what is made beside it. */
typedef struct drawn_images {
  drawn_image *now, *fresh; /* may be NULL */
} drawn_images;

/* Makes a fresh one if there is none of this name's format and size, and of GPU_IMAGE_STORED where that is asked for. */
csm_result drawn_image_reserve(drawn_images *images, device *device, const gpu_image_info *wanted);
/* The one that the recording on its way draws into. */
drawn_image *drawn_image_next(const drawn_images *images);
/* As a technique's functions of these names. */
void drawn_image_adopt(drawn_images *images, device *device);
void drawn_image_forget(drawn_images *images, device *device);
void drawn_image_drop(drawn_images *images, device *device);
uint64_t drawn_image_bytes(const drawn_images *images, const device *device);
/* The image as a view's mask in a binding, if it was drawn. */
void drawn_image_bind(const drawn_images *images, device *device, csm_binding *binding);
/* INVALID_STATE if there is none, or it was not drawn. */
csm_result drawn_image_find(const drawn_images *images, technique_image *out);

#endif
