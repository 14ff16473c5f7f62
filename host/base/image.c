#include "base/image.h"
#include "base/host.h"
#include "base/output_file.h"
#include <math.h>
#include <spng.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void image_create(image *out, uint32_t width, uint32_t height) {
  *out = (image){.width = width, .height = height, .pixels = host_allocate((size_t)width * height, 3)};
}

void image_free(image *picture) {
  free(picture->pixels);
  *picture = (image){0};
}

static uint8_t to_srgb(float linear) {
  const float clamped = fminf(fmaxf(linear, 0.0f), 1.0f);
  const float encoded = clamped <= 0.0031308f ? 12.92f * clamped : 1.055f * powf(clamped, 1.0f / 2.4f) - 0.055f;
  return (uint8_t)(encoded * 255.0f + 0.5f);
}

static float from_srgb(uint8_t encoded) {
  const float value = encoded / 255.0f;
  return value <= 0.04045f ? value / 12.92f : powf((value + 0.055f) / 1.055f, 2.4f);
}

void image_set(image *picture, uint32_t x, uint32_t y, const float linear[3]) {
  uint8_t *pixel = picture->pixels + 3 * ((size_t)y * picture->width + x);
  for (int i = 0; i < 3; i++)
    pixel[i] = to_srgb(linear[i]);
}

void image_mix(image *picture, uint32_t x, uint32_t y, const float linear[3], float share) {
  uint8_t *pixel = picture->pixels + 3 * ((size_t)y * picture->width + x);
  for (int i = 0; i < 3; i++) {
    const float before = from_srgb(pixel[i]);
    pixel[i] = to_srgb(before + (linear[i] - before) * share);
  }
}

int image_write_png(const image *picture, const char *path) {
  output_file file;
  const char *problem = output_file_open(&file, path);
  if (problem)
    return host_fail(HOST_BAD_INPUT, "cannot write '%s': %s", path, problem);
  spng_ctx *png = spng_ctx_new(SPNG_CTX_ENCODER);
  struct spng_ihdr header = {
      .width = picture->width, .height = picture->height, .bit_depth = 8, .color_type = SPNG_COLOR_TYPE_TRUECOLOR};
  int error = png ? spng_set_png_file(png, file.stream) : SPNG_EMEM;
  if (!error)
    error = spng_set_ihdr(png, &header);
  if (!error)
    error = spng_set_option(png, SPNG_IMG_COMPRESSION_LEVEL, 5);
  if (!error)
    error = spng_set_option(png, SPNG_FILTER_CHOICE, SPNG_FILTER_CHOICE_UP | SPNG_FILTER_CHOICE_SUB);
  if (!error)
    error = spng_encode_image(png, picture->pixels, (size_t)picture->width * picture->height * 3, SPNG_FMT_PNG,
                              SPNG_ENCODE_FINALIZE);
  spng_ctx_free(png);
  problem = output_file_close(&file, error ? spng_strerror(error) : NULL);
  return problem ? host_fail(HOST_BAD_INPUT, "cannot write '%s': %s", path, problem) : 0;
}

static void mean_of_pixels(const uint8_t *rgba, size_t count, float mean[3]) {
  double sum[3] = {0}, weight = 0.0;
  for (size_t i = 0; i < count; i++) {
    const double alpha = rgba[4 * i + 3] / 255.0;
    for (int c = 0; c < 3; c++)
      sum[c] += alpha * from_srgb(rgba[4 * i + c]);
    weight += alpha;
  }
  for (int c = 0; c < 3; c++)
    mean[c] = weight > 0.0 ? (float)(sum[c] / weight) : 1.0f;
}

enum { LARGEST_SIDE = 16384 };

/* Four bytes a pixel, for the caller to free; NULL if it cannot be read. */
static uint8_t *decode_png(const void *data, uint64_t size, uint32_t *width, uint32_t *height) {
  spng_ctx *png = spng_ctx_new(0);
  struct spng_ihdr header = {0};
  size_t bytes = 0;
  uint8_t *pixels = NULL;
  int error = png ? spng_set_image_limits(png, LARGEST_SIDE, LARGEST_SIDE) : SPNG_EMEM;
  if (!error)
    error = spng_set_png_buffer(png, data, size);
  if (!error)
    error = spng_get_ihdr(png, &header);
  if (!error)
    error = spng_decoded_image_size(png, SPNG_FMT_RGBA8, &bytes);
  if (!error) {
    pixels = host_allocate(bytes, 1);
    error = spng_decode_image(png, pixels, bytes, SPNG_FMT_RGBA8, SPNG_DECODE_TRNS);
  }
  spng_ctx_free(png);
  if (error) {
    free(pixels);
    return NULL;
  }
  *width = header.width;
  *height = header.height;
  return pixels;
}

int image_mean_of_png(const void *data, uint64_t size, float mean[3]) {
  uint32_t width, height;
  uint8_t *pixels = decode_png(data, size, &width, &height);
  if (!pixels)
    return 1;
  mean_of_pixels(pixels, (size_t)width * height, mean);
  free(pixels);
  return 0;
}

uint8_t *image_alpha_of_png(const void *data, uint64_t size, uint32_t *width, uint32_t *height) {
  uint8_t *pixels = decode_png(data, size, width, height);
  for (size_t i = 0; pixels && i < (size_t)*width * *height; i++)
    pixels[i] = pixels[4 * i + 3];
  return pixels;
}
