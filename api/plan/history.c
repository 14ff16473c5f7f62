/*
 * history.c: how a pixel finds what a view's earlier mask had of the same surface.
 *
 * A plane's clip depth is linear across a picture, and so is its span: 1 / view depth of a perspective camera, the view
 * depth of an orthographic one. So a history holds spans, and a surface's plane tells the span of each pixel around the
 * place where the surface was.
 */
#include "plan/internal.h"

#include "csm_history.h"
#include <math.h>
#include <string.h>

/* Spans are kept in halves: a rounding of 2^-11 of themselves here, and as much there; below 2^-14, 2^-25 of 1. */
#define SPAN_SHARE 0x1p-10
#define SPAN_STEP 0x1p-24
/* Normals are kept in 64 x 64 directions: these are off by up to so many degrees. */
#define NORMAL_ROUNDING_DEG 2.5

bool plan_past_counts(const plan_past *past, const plan_past *now) {
  return past->settings && past->settings == now->settings && past->width == now->width &&
         past->height == now->height && past->camera.orthographic == now->camera.orthographic;
}

/* Half of an orthographic picture's height, in metres. */
static double half_height(const plan_camera *camera) {
  return 1.0 / hypot(camera->projection[1], camera->projection[5]);
}

/* The least power of two above a number, so that a product with it is exact. */
static double power_above(double value) {
  int exponent;
  (void)frexp(value, &exponent);
  return ldexp(1.0, exponent);
}

/*
 * What spans are multiplied with: a half holds 2^-24 to 65504. Of a perspective camera the span is 1 where shadows end, and
 * of an orthographic one half of the picture's height.
 */
static double span_scale(const plan_camera *camera, double shadow_end) {
  return camera->orthographic ? 1.0 / power_above(half_height(camera)) : power_above(shadow_end);
}

/* A pixel's span times w, of a camera that may be another than the pixel's. */
static void span_row(double row[4], const plan_past *of, const plan_frame *frame, const double to_relative[16]) {
  const plan_camera *camera = &of->camera;
  const double scale = span_scale(camera, of->shadow_end);
  for (int k = 0; k < 4; ++k) {
    double depth = 0.0;
    for (int i = 0; i < 3; ++i)
      depth += camera->forward[i] *
               (to_relative[k * 4 + i] + (frame->origin[i] - camera->position[i]) * to_relative[k * 4 + 3]);
    row[k] = scale * (camera->orthographic ? depth : to_relative[k * 4 + 3]);
  }
}

static void put_row(float *out, uint32_t index, const double row[4]) {
  for (int k = 0; k < 4; ++k)
    out[index * 4 + (uint32_t)k] = plan_float(row[k]);
}

/* CSM_H_PLACE, CSM_H_PLANE and CSM_H_OWN. */
static void put_places(float *out, const plan_frame *frame, const plan_past *past, const plan_past *now) {
  double to_relative[16], to_past[16], places[16], back[16], span[4], own[4];
  plan_pixels_to_relative(to_relative, frame, &now->camera, now->width, now->height);
  plan_relative_to_pixels(to_past, frame, &past->camera, past->width, past->height);
  plan_multiply(places, to_past, to_relative);
  span_row(span, past, frame, to_relative);
  span_row(own, now, frame, to_relative);
  for (int k = 0; k < 4; ++k)
    places[k * 4 + 2] = span[k];
  for (uint32_t i = 0; i < 4; ++i)
    put_row(out, CSM_H_PLACE + i, (const double[4]){places[i], places[4 + i], places[8 + i], places[12 + i]});
  /* A plane goes there by the transpose of the inverse, whose columns are its rows. */
  if (!plan_invert(back, places))
    memset(back, 0, sizeof back);
  for (uint32_t i = 0; i < 3; ++i)
    put_row(out, CSM_H_PLANE + i, &back[i * 4]);
  put_row(out, CSM_H_OWN, own);
}

/* CSM_H_NORMAL: axis by axis of the world, on the viewer's side. */
static void put_normals(float *out, const plan_frame *frame, const plan_past *now, const plan_picture *picture) {
  const double viewer = now->camera.reversed ? -1.0 : 1.0;
  const double decode = picture->unorm_normals ? 2.0 : 1.0, middle = picture->unorm_normals ? -1.0 : 0.0;
  double to_pixels[16];
  plan_relative_to_pixels(to_pixels, frame, &now->camera, now->width, now->height);
  for (uint32_t axis = 0; axis < 3; ++axis) {
    double row[4] = {0.0, 0.0, 0.0, middle};
    row[axis] = decode;
    for (uint32_t k = 0; k < 4 && !picture->normals; ++k)
      row[k] = viewer * to_pixels[axis * 4 + k];
    put_row(out, CSM_H_NORMAL + axis, row);
  }
}

/* Of how many samples a pattern's mask is; each tap of a search is four texels. */
static double pattern_samples(const csm_config *config) {
  if (config->filter == CSM_FILTER_EXACT_SOFT)
    return config->ray_taps;
  return plan_is_soft(config) ? fmin(config->soft_taps, config->soft_search_taps * 4.0)
                              : fmin(plan_filter_taps(config), 64.0);
}

/*
 * The most that a mask's noise may be: that of so many comparisons that are right as often as wrong. What has no pattern has
 * noise where maps are jittered alone: then of the comparisons of a square.
 */
static double most_noise(const csm_config *config) {
  const double side = plan_filter_reach_texels(config) + 1.0;
  const bool pattern = config->filter == CSM_FILTER_POISSON || config->filter == CSM_FILTER_VOGEL ||
                       config->filter == CSM_FILTER_PCSS || config->filter == CSM_FILTER_BACKPROJECTION ||
                       config->filter == CSM_FILTER_EXACT_SOFT;
  if (!pattern)
    return plan_jitter_room(config) > 0.0 ? 0.5 / side : 0.0;
  return 0.5 / sqrt(pattern_samples(config));
}

uint32_t plan_write_history_constants(float *out, const plan_frame *frame, const plan_picture *picture,
                                      const plan_passage *passage, const csm_config *config) {
  const plan_past *now = passage->now;
  const double width = now->width, height = now->height, radians = acos(-1.0) / 180.0;
  const double angle = fmin(config->history_normal_deg + 2.0 * NORMAL_ROUNDING_DEG, 180.0);
  const bool linear = now->camera.orthographic;
  const double scale = span_scale(&passage->past->camera, passage->past->shadow_end);
  const double more = linear ? config->history_depth * half_height(&now->camera) * scale : 0.0;
  put_places(out, frame, passage->past, now);
  put_normals(out, frame, now, picture);
  put_row(out, CSM_H_SIZE, (const double[4]){width, height, 1.0 / width, 1.0 / height});
  put_row(out, CSM_H_LIMITS,
          (const double[4]){(linear ? 0.0 : config->history_depth) + SPAN_SHARE, more + SPAN_STEP, cos(angle * radians),
                            config->history_frames});
  put_row(out, CSM_H_CLEAR,
          (const double[4]){plan_clear_depth(&now->camera), picture->show == CSM_SHOW_HISTORY,
                            now->changes && passage->past->changes == now->changes, passage->phase});
  put_row(out, CSM_H_NOISE, (const double[4]){most_noise(config), 0.0, 0.0, 0.0});
  return CSM_H_COUNT * 4 * sizeof(float);
}

/* The radical inverse in base 2 (van der Corput): of 2^n frames in a row, each 2^-n of a turn gets one. */
double plan_history_phase(uint32_t frame) {
  double phase = 0.0;
  for (uint32_t bit = 0; bit < 6; ++bit)
    phase += frame >> bit & 1u ? ldexp(0.5, -(int)bit) : 0.0;
  return phase;
}

/* Of the plastic number: however many frames lie in a row, they lie evenly in a square (Roberts 2018). */
void plan_history_jitter(double out[2], uint32_t frame) {
  static const double steps[2] = {0.7548776662466927, 0.5698402909980532};
  for (int i = 0; i < 2; ++i) {
    const double place = frame * steps[i];
    out[i] = place - floor(place) - 0.5;
  }
}

void plan_write_phase(float *out, double phase, const csm_config *config) {
  out[CSM_S_SOFT_MORE * 4 + 3] = plan_float((plan_jitter_room(config) > 0.0 ? 3.0 : 1.0) + phase);
}
