#include "report/page_picture.h"
#include "base/host.h"
#include <spng.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define GREY_STEPS 31u

/* ---- smaller ---- */

static const uint8_t *pixel_of(const image *picture, uint32_t x, uint32_t y) {
  return picture->pixels + 3 * ((size_t)y * picture->width + x);
}

static bool is_grey(const uint8_t *pixel) {
  return pixel[0] == pixel[1] && pixel[1] == pixel[2];
}

static void shrink_by_rank(uint8_t *to, const image *from, const uint8_t *rank, uint32_t x0, uint32_t y0,
                           uint32_t side) {
  uint32_t best_x = x0, best_y = y0;
  for (uint32_t y = y0; y < y0 + side; y++)
    for (uint32_t x = x0; x < x0 + side; x++)
      if (rank[(size_t)y * from->width + x] > rank[(size_t)best_y * from->width + best_x]) {
        best_x = x;
        best_y = y;
      }
  memcpy(to, pixel_of(from, best_x, best_y), 3);
}

static void shrink_by_mean(uint8_t *to, const image *from, uint32_t x0, uint32_t y0, uint32_t side) {
  const uint8_t *colored = NULL;
  uint32_t sum = 0, greys = 0;
  for (uint32_t y = y0; y < y0 + side; y++)
    for (uint32_t x = x0; x < x0 + side; x++) {
      const uint8_t *pixel = pixel_of(from, x, y);
      if (is_grey(pixel)) {
        sum += pixel[0];
        greys++;
      } else if (!colored) {
        colored = pixel;
      }
    }
  if (colored && 2 * greys < side * side) {
    memcpy(to, colored, 3);
    return;
  }
  const uint32_t step = (sum * GREY_STEPS / greys + 127) / 255;
  memset(to, (int)(step * 255 / GREY_STEPS), 3);
}

void report_picture_shrink(image *out, const image *picture, const uint8_t *rank, uint32_t width) {
  uint32_t side = (picture->width + width - 1) / width;
  while (side > picture->height)
    side--;
  image_create(out, picture->width / side, picture->height / side);
  for (uint32_t y = 0; y < out->height; y++)
    for (uint32_t x = 0; x < out->width; x++) {
      uint8_t *to = out->pixels + 3 * ((size_t)y * out->width + x);
      if (rank)
        shrink_by_rank(to, picture, rank, x * side, y * side, side);
      else
        shrink_by_mean(to, picture, x * side, y * side, side);
    }
}

/* ---- PNG ---- */

/* Fills `indices`; false if there are more colours than a palette holds. */
static bool make_palette(struct spng_plte *palette, uint8_t *indices, const image *picture) {
  const size_t pixels = (size_t)picture->width * picture->height;
  uint32_t last = 0;
  for (size_t i = 0; i < pixels; i++) {
    const uint8_t *p = picture->pixels + 3 * i;
    const struct spng_plte_entry *at = &palette->entries[last];
    if (palette->n_entries == 0 || at->red != p[0] || at->green != p[1] || at->blue != p[2])
      for (last = 0; last < palette->n_entries; last++) {
        at = &palette->entries[last];
        if (at->red == p[0] && at->green == p[1] && at->blue == p[2])
          break;
      }
    if (last == 256)
      return false;
    if (last == palette->n_entries)
      palette->entries[palette->n_entries++] = (struct spng_plte_entry){.red = p[0], .green = p[1], .blue = p[2]};
    indices[i] = (uint8_t)last;
  }
  return true;
}

/* For the caller to free; NULL after a message. */
static void *encode(const image *picture, size_t *size) {
  const size_t pixels = (size_t)picture->width * picture->height;
  struct spng_plte palette = {0};
  uint8_t *indices = host_allocate(pixels, 1);
  const bool indexed = make_palette(&palette, indices, picture);
  struct spng_ihdr header = {.width = picture->width,
                             .height = picture->height,
                             .bit_depth = 8,
                             .color_type = indexed ? SPNG_COLOR_TYPE_INDEXED : SPNG_COLOR_TYPE_TRUECOLOR};
  spng_ctx *png = spng_ctx_new(SPNG_CTX_ENCODER);
  void *data = NULL;
  int error = png ? spng_set_option(png, SPNG_ENCODE_TO_BUFFER, 1) : SPNG_EMEM;
  if (!error)
    error = spng_set_option(png, SPNG_IMG_COMPRESSION_LEVEL, 9);
  if (!error)
    error = spng_set_ihdr(png, &header);
  if (!error && indexed)
    error = spng_set_plte(png, &palette);
  if (!error)
    error = spng_encode_image(png, indexed ? indices : picture->pixels, indexed ? pixels : 3 * pixels, SPNG_FMT_PNG,
                              SPNG_ENCODE_FINALIZE);
  if (!error)
    data = spng_get_png_buffer(png, size, &error);
  spng_ctx_free(png);
  free(indices);
  if (error)
    host_fail(HOST_BAD_INPUT, "cannot make a PNG: %s", spng_strerror(error));
  return data;
}

static char *base64(char *to, const uint8_t *data, size_t size) {
  static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (size_t i = 0; i < size; i += 3) {
    const size_t left = size - i;
    const uint32_t bits =
        (uint32_t)data[i] << 16 | (left > 1 ? (uint32_t)data[i + 1] << 8 : 0) | (left > 2 ? data[i + 2] : 0);
    *to++ = digits[bits >> 18];
    *to++ = digits[bits >> 12 & 63];
    *to++ = left > 1 ? digits[bits >> 6 & 63] : '=';
    *to++ = left > 2 ? digits[bits & 63] : '=';
  }
  return to;
}

char *report_picture_uri(const image *picture) {
  static const char start[] = "data:image/png;base64,";
  size_t size = 0;
  void *data = encode(picture, &size);
  if (!data)
    return NULL;
  char *uri = host_allocate(sizeof start + (size + 2) / 3 * 4, 1);
  memcpy(uri, start, sizeof start - 1);
  *base64(uri + sizeof start - 1, data, size) = '\0';
  free(data);
  return uri;
}
