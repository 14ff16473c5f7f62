#include "measure/error_picture.h"
#include <math.h>
#include <string.h>

static void set_grey(float color[3], float grey) {
  color[0] = color[1] = color[2] = grey;
}

/* Sun and sky on white; the sky itself is blue. */
static void lit_color(float color[3], const truth_surface *surface, const scene_light *light, float visibility) {
  static const float sky[3] = {0.35f, 0.5f, 0.75f};
  if (surface->triangle == TRUTH_NOTHING) {
    memcpy(color, sky, sizeof sky);
    return;
  }
  const float sun = 0.75f * visibility * (float)fmax(truth_facing(surface, light), 0.0);
  const float ambient = 0.07f + 0.05f * surface->normal[1];
  set_grey(color, 0.02f + sun + ambient);
}

void measure_picture_lit(image *out, const truth_view *view, const scene_light *light, const float *visibility) {
  image_create(out, view->width, view->height);
  for (uint32_t y = 0; y < view->height; y++)
    for (uint32_t x = 0; x < view->width; x++) {
      const size_t pixel = (size_t)y * view->width + x;
      float color[3];
      lit_color(color, &view->surfaces[pixel], light, visibility[pixel]);
      image_set(out, x, y, color);
    }
}

static const float unmeasured[][3] = {
    [METRICS_LEFT_OUT] = {0.10f, 0.12f, 0.17f}, [METRICS_GRAZING] = {0.16f, 0.12f, 0.07f}};

void measure_picture_visibility(image *out, const metrics_frame *frame, const uint8_t *kinds, const float *visibility) {
  static const float sky[3] = {0.35f, 0.5f, 0.75f};
  image_create(out, frame->view->width, frame->view->height);
  for (uint32_t y = 0; y < frame->view->height; y++)
    for (uint32_t x = 0; x < frame->view->width; x++) {
      const size_t pixel = (size_t)y * frame->view->width + x;
      float color[3];
      if (kinds[pixel] >= METRICS_RIGHT)
        set_grey(color, visibility[pixel]);
      else if (frame->view->surfaces[pixel].triangle == TRUTH_NOTHING)
        memcpy(color, sky, sizeof color);
      else
        memcpy(color, unmeasured[kinds[pixel]], sizeof color);
      image_set(out, x, y, color);
    }
}

/* A step of grey, or of a colour: a picture with few of them is small. */
static void difference_color(float color[3], float truly, float drawn) {
  static const float middle = 0.3f, bright[3] = {1.0f, 0.45f, 0.0f}, dark[3] = {0.0f, 0.55f, 1.0f};
  const float difference = drawn - truly, size = fminf(4.0f * fabsf(difference), 1.0f);
  if (fabsf(difference) < 1.0f / 64.0f) {
    set_grey(color, 0.12f + 0.5f * truly);
    return;
  }
  const float step = ceilf(16.0f * size) / 16.0f;
  for (int i = 0; i < 3; i++)
    color[i] = middle + step * ((difference > 0.0f ? bright : dark)[i] - middle);
}

void measure_picture_difference(image *out, const metrics_frame *frame, const uint8_t *kinds) {
  image_create(out, frame->view->width, frame->view->height);
  for (uint32_t y = 0; y < frame->view->height; y++)
    for (uint32_t x = 0; x < frame->view->width; x++) {
      const size_t pixel = (size_t)y * frame->view->width + x;
      float color[3];
      if (kinds[pixel] >= METRICS_RIGHT)
        difference_color(color, frame->visibility[pixel], frame->mask[pixel]);
      else
        memcpy(color, unmeasured[kinds[pixel]], sizeof color);
      image_set(out, x, y, color);
    }
}

void measure_picture_errors(image *out, const metrics_frame *frame, const uint8_t *kinds) {
  static const float colors[][3] = {
      [METRICS_FALSE_LIT] = {1.0f, 0.45f, 0.0f},
      [METRICS_LEAK] = {1.0f, 0.0f, 0.0f},
      [METRICS_FALSE_SHADOW] = {0.0f, 0.55f, 1.0f},
      [METRICS_ACNE] = {0.05f, 0.0f, 1.0f},
  };
  image_create(out, frame->view->width, frame->view->height);
  for (uint32_t y = 0; y < frame->view->height; y++)
    for (uint32_t x = 0; x < frame->view->width; x++) {
      const size_t pixel = (size_t)y * frame->view->width + x;
      float color[3];
      if (kinds[pixel] == METRICS_RIGHT)
        set_grey(color, 0.12f + 0.5f * frame->visibility[pixel]);
      else if (kinds[pixel] < METRICS_RIGHT)
        memcpy(color, unmeasured[kinds[pixel]], sizeof color);
      else
        memcpy(color, colors[kinds[pixel]], sizeof color);
      image_set(out, x, y, color);
    }
}
