/* base/image.h: pictures as PNG files, and what a picture is made of. */
#ifndef HOST_IMAGE_H
#define HOST_IMAGE_H

#include <stdint.h>

typedef struct image {
  uint32_t width, height;
  uint8_t *pixels; /* three bytes each (sRGB), top row first */
} image;

void image_create(image *out, uint32_t width, uint32_t height);
void image_free(image *picture);
/* Linear light, 0 to 1, is brought to sRGB. */
void image_set(image *picture, uint32_t x, uint32_t y, const float linear[3]);
/* A share of linear light over what is there, 0 to 1. */
void image_mix(image *picture, uint32_t x, uint32_t y, const float linear[3], float share);
/* 0, or HOST_BAD_INPUT after a message. */
int image_write_png(const image *picture, const char *path);

/* The mean colour (linear) of a PNG file in memory, weighted by alpha. 0, or nonzero if it cannot be read. */
int image_mean_of_png(const void *data, uint64_t size, float mean[3]);
/*
 * The alpha of a PNG file in memory: width * height bytes, top row first, for the caller to free. NULL if it cannot be
 * read.
 */
uint8_t *image_alpha_of_png(const void *data, uint64_t size, uint32_t *width, uint32_t *height);

#endif
