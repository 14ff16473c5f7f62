#include "app.h"
#include <spng.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

void app_parse(app_options *out, int count, char **arguments) {
  *out = (app_options){.csm = "libcsm.so.1", .out = "mini.png"};
  for (int i = 1; i < count; i++) {
    const bool has_value = i + 1 < count;
    if (strcmp(arguments[i], "--validate") == 0)
      out->validate = true;
    else if (strcmp(arguments[i], "--csm") == 0 && has_value)
      out->csm = arguments[++i];
    else if (strcmp(arguments[i], "--out") == 0 && has_value)
      out->out = arguments[++i];
    else
      app_fail(APP_BAD_INPUT, "usage: %s [--validate] [--out FILE.png] [--csm LIBRARY]", arguments[0]);
  }
}

void app_fail(int code, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  vfprintf(stderr, format, arguments);
  va_end(arguments);
  fputc('\n', stderr);
  exit(code);
}

void *app_allocate(size_t count, size_t size) {
  void *memory = calloc(count, size);
  if (!memory)
    app_fail(APP_FAILED, "out of memory");
  return memory;
}

double app_now_ms(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec * 1e3 + (double)now.tv_nsec * 1e-6;
}

static int ascending(const void *a, const void *b) {
  const double left = *(const double *)a, right = *(const double *)b;
  return (left > right) - (left < right);
}

double app_median(double *values, uint32_t count) {
  qsort(values, count, sizeof *values, ascending);
  return values[count / 2];
}

void app_write_png(const char *path, const uint8_t *pixels, uint32_t width, uint32_t height) {
  uint8_t *rgb = app_allocate((size_t)width * height, 3);
  for (size_t i = 0; i < (size_t)width * height; i++)
    memcpy(rgb + 3 * i, pixels + 4 * i, 3);
  FILE *file = fopen(path, "wb");
  spng_ctx *png = spng_ctx_new(SPNG_CTX_ENCODER);
  struct spng_ihdr header = {.width = width, .height = height, .bit_depth = 8, .color_type = SPNG_COLOR_TYPE_TRUECOLOR};
  bool written = file && png && spng_set_png_file(png, file) == 0 && spng_set_ihdr(png, &header) == 0 &&
                 spng_encode_image(png, rgb, (size_t)width * height * 3, SPNG_FMT_PNG, SPNG_ENCODE_FINALIZE) == 0;
  written = file && fclose(file) == 0 && written;
  spng_ctx_free(png);
  free(rgb);
  if (!written)
    app_fail(APP_FAILED, "the picture cannot be written: %s", path);
}
