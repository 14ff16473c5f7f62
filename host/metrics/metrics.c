#include "metrics/metrics.h"
#include "base/host.h"
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define DEPTH_TOLERANCE 1e-3 /* share of the view depth that the camera's depth may be off */
#define NEAR_EDGE_PX 2.0
#define NEAR_EDGE_TEXELS 1.5

/* ---- the set S ---- */

static metrics_kind kind_of(const metrics_frame *frame, size_t pixel, bool *depth_differs) {
  const truth_surface *surface = &frame->view->surfaces[pixel];
  *depth_differs = false;
  if (surface->triangle == TRUTH_NOTHING || !(surface->view_depth <= frame->shadow_distance))
    return METRICS_LEFT_OUT;
  const double facing = truth_facing(surface, frame->light);
  if (!(facing > 0.0))
    return METRICS_LEFT_OUT;
  const double off = fabs(frame->view_depth[pixel] - surface->view_depth);
  *depth_differs = !(off <= DEPTH_TOLERANCE * fabs(surface->view_depth));
  if (*depth_differs)
    return METRICS_LEFT_OUT;
  return facing > METRICS_GRAZING_COSINE ? METRICS_RIGHT : METRICS_GRAZING;
}

static void choose(metrics *out, const metrics_frame *frame, uint8_t *kinds) {
  for (size_t pixel = 0; pixel < (size_t)frame->view->width * frame->view->height; pixel++) {
    bool depth_differs;
    const metrics_kind kind = kind_of(frame, pixel, &depth_differs);
    kinds[pixel] = (uint8_t)kind;
    out->pixels += kind == METRICS_RIGHT;
    out->grazing_pixels += kind == METRICS_GRAZING;
    out->depth_pixels += depth_differs;
  }
}

/* What was drawn in another place than it is looks right wherever it is looked for: it is left out. */
static int check_depth(const metrics *m) {
  const uint64_t asked = m->pixels + m->grazing_pixels + m->depth_pixels;
  if ((double)m->depth_pixels <= METRICS_DEPTH_SHARE * (double)asked)
    return 0;
  return host_fail(HOST_DIFFER,
                   "depth_pixels: the depth that was drawn differs from the truth in %" PRIu64 " of the %" PRIu64
                   " pixels that the light reaches, %.2f %%; figures without more than %g %% of them say nothing",
                   m->depth_pixels, asked, 100.0 * (double)m->depth_pixels / (double)asked,
                   100.0 * METRICS_DEPTH_SHARE);
}

/* Why nothing is left: the first thing that no pixel has. */
static int tell_empty(const metrics_frame *frame) {
  uint64_t seen = 0, near = 0;
  for (size_t i = 0; i < (size_t)frame->view->width * frame->view->height; i++) {
    const truth_surface *surface = &frame->view->surfaces[i];
    seen += surface->triangle != TRUTH_NOTHING;
    near += surface->triangle != TRUTH_NOTHING && surface->view_depth <= frame->shadow_distance;
  }
  if (seen == 0)
    return host_fail(HOST_BAD_INPUT, "nothing to measure: the camera sees no surface");
  if (near == 0)
    return host_fail(HOST_BAD_INPUT, "nothing to measure: no surface lies within the shadow distance, %g m",
                     frame->shadow_distance);
  return host_fail(HOST_BAD_INPUT, "nothing to measure: every surface that the camera sees is turned away from the "
                                   "light, or grazed by it");
}

/* ---- edges ---- */

/*
 * Edges lie between neighbouring pixels of S, one lit and one shadowed. They are marked on a grid of half pixels, whose
 * even points are the pixels' centres.
 */
typedef struct edges {
  uint32_t width, height;
  uint8_t *marked;
  int64_t *squares; /* of the distance to the nearest edge, in half pixels */
  uint64_t length;
} edges;

static bool is_lit(float visibility) {
  return visibility >= 0.5f;
}

static bool differ(const uint8_t *kinds, const float *visibility, size_t a, size_t b) {
  return kinds[a] == METRICS_RIGHT && kinds[b] == METRICS_RIGHT && is_lit(visibility[a]) != is_lit(visibility[b]);
}

static void edges_find(edges *out, const truth_view *view, const uint8_t *kinds, const float *visibility) {
  *out = (edges){.width = 2 * view->width - 1, .height = 2 * view->height - 1};
  out->marked = host_allocate((size_t)out->width * out->height, sizeof *out->marked);
  out->squares = host_allocate((size_t)out->width * out->height, sizeof *out->squares);
  for (uint32_t y = 0; y < view->height; y++)
    for (uint32_t x = 0; x < view->width; x++) {
      const size_t pixel = (size_t)y * view->width + x, at = 2 * (size_t)y * out->width + 2 * x;
      const bool right = x + 1 < view->width && differ(kinds, visibility, pixel, pixel + 1);
      const bool below = y + 1 < view->height && differ(kinds, visibility, pixel, pixel + view->width);
      if (right)
        out->marked[at + 1] = 1;
      if (below)
        out->marked[at + out->width] = 1;
      out->length += (uint64_t)right + below;
    }
  metrics_distances(out->marked, out->width, out->height, out->squares);
}

static void edges_free(edges *e) {
  free(e->marked);
  free(e->squares);
}

static double edge_distance_px(const edges *e, size_t at) {
  return e->squares[at] == INT64_MAX ? INFINITY : 0.5 * sqrt((double)e->squares[at]);
}

/* The mean distance from one mask's edges to the other's. *alone gets the length of those that have none in reach. */
static double mean_distance_px(const edges *from, const edges *to, uint64_t *alone) {
  double sum = 0.0;
  *alone = 0;
  for (size_t at = 0; at < (size_t)from->width * from->height; at++) {
    if (!from->marked[at])
      continue;
    const double distance = edge_distance_px(to, at);
    sum += fmin(distance, METRICS_EDGE_CAP_PX);
    *alone += distance > METRICS_EDGE_CAP_PX;
  }
  return sum / (double)from->length;
}

static void compare_edges(metrics *out, const edges *is, const edges *drawn) {
  out->edge_true_px = is->length;
  out->edge_drawn_px = drawn->length;
  out->edge_px = -1.0;
  const double forth = is->length ? mean_distance_px(is, drawn, &out->edge_true_alone_px) : -1.0;
  const double back = drawn->length ? mean_distance_px(drawn, is, &out->edge_drawn_alone_px) : -1.0;
  if (forth >= 0.0 && back >= 0.0)
    out->edge_px = 0.5 * (forth + back);
  else if (forth >= 0.0 || back >= 0.0)
    out->edge_px = METRICS_EDGE_CAP_PX;
}

/* ---- shares ---- */

static void refine(metrics *out, const metrics_frame *frame, const edges *is, uint8_t *kinds) {
  const truth_view *view = frame->view;
  metrics_reference reference;
  uint64_t acne = 0, leak = 0;
  metrics_reference_make(&reference, view->camera, view->width, view->height, frame->shadow_distance);
  for (uint32_t y = 0; y < view->height; y++)
    for (uint32_t x = 0; x < view->width; x++) {
      const size_t pixel = (size_t)y * view->width + x;
      const bool lit = is_lit(frame->visibility[pixel]);
      if (kinds[pixel] != METRICS_RIGHT || lit == is_lit(frame->mask[pixel]))
        continue;
      const double texel = metrics_reference_texel_px(&reference, view->surfaces[pixel].view_depth);
      const double distance = edge_distance_px(is, 2 * (size_t)y * is->width + 2 * x);
      const bool far = distance > NEAR_EDGE_PX && distance > NEAR_EDGE_TEXELS * texel;
      kinds[pixel] = (uint8_t)(lit   ? far ? METRICS_ACNE : METRICS_FALSE_SHADOW
                               : far ? METRICS_LEAK
                                     : METRICS_FALSE_LIT);
      acne += lit && far;
      leak += !lit && far;
    }
  out->acne = (double)acne / (double)out->pixels;
  out->leak = (double)leak / (double)out->pixels;
}

typedef struct sums {
  uint64_t count, lit, false_lit, false_shadow;
  double square, difference, absolute;
} sums;

static sums sum_over(const metrics_frame *frame, const uint8_t *kinds, metrics_kind kind) {
  sums s = {0};
  for (size_t i = 0; i < (size_t)frame->view->width * frame->view->height; i++) {
    if (kinds[i] != kind)
      continue;
    const bool lit = is_lit(frame->visibility[i]), drawn = is_lit(frame->mask[i]);
    const double difference = (double)frame->mask[i] - frame->visibility[i];
    s.count++;
    s.lit += lit;
    s.false_lit += drawn && !lit;
    s.false_shadow += lit && !drawn;
    s.square += difference * difference;
    s.difference += difference;
    s.absolute += fabs(difference);
  }
  return s;
}

int metrics_measure(metrics *out, const metrics_frame *frame, uint8_t *kinds) {
  *out = (metrics){0};
  choose(out, frame, kinds);
  const int code = check_depth(out);
  if (code || out->pixels == 0)
    return code ? code : tell_empty(frame);
  const sums s = sum_over(frame, kinds, METRICS_RIGHT), grazing = sum_over(frame, kinds, METRICS_GRAZING);
  const double share = 1.0 / (double)s.count;
  out->lit = (double)s.lit * share;
  out->false_lit = (double)s.false_lit * share;
  out->false_shadow = (double)s.false_shadow * share;
  out->rmse = sqrt(s.square * share);
  out->mean = s.difference * share;
  out->mean_absolute = s.absolute * share;
  if (grazing.count) {
    out->grazing_false_lit = (double)grazing.false_lit / (double)grazing.count;
    out->grazing_false_shadow = (double)grazing.false_shadow / (double)grazing.count;
  }
  edges is, drawn;
  edges_find(&is, frame->view, kinds, frame->visibility);
  edges_find(&drawn, frame->view, kinds, frame->mask);
  compare_edges(out, &is, &drawn);
  refine(out, frame, &is, kinds);
  edges_free(&is);
  edges_free(&drawn);
  return 0;
}

/* ---- several frames ---- */

static double weighted(double sum, double value, uint64_t weight) {
  return sum + value * (double)weight;
}

static void pool_edges(metrics *out, const metrics *frames, uint32_t count) {
  double sum = 0.0;
  uint64_t length = 0;
  for (uint32_t i = 0; i < count; i++) {
    const metrics *m = &frames[i];
    out->edge_true_px += m->edge_true_px;
    out->edge_drawn_px += m->edge_drawn_px;
    out->edge_true_alone_px += m->edge_true_alone_px;
    out->edge_drawn_alone_px += m->edge_drawn_alone_px;
    if (m->edge_px >= 0.0) {
      sum = weighted(sum, m->edge_px, m->edge_true_px + m->edge_drawn_px);
      length += m->edge_true_px + m->edge_drawn_px;
    }
  }
  out->edge_px = length ? sum / (double)length : -1.0;
}

void metrics_pool(metrics *out, const metrics *frames, uint32_t count) {
  *out = (metrics){0};
  pool_edges(out, frames, count);
  double square = 0.0;
  for (uint32_t i = 0; i < count; i++) {
    const metrics *m = &frames[i];
    out->lit = weighted(out->lit, m->lit, m->pixels);
    out->false_lit = weighted(out->false_lit, m->false_lit, m->pixels);
    out->false_shadow = weighted(out->false_shadow, m->false_shadow, m->pixels);
    out->mean = weighted(out->mean, m->mean, m->pixels);
    out->mean_absolute = weighted(out->mean_absolute, m->mean_absolute, m->pixels);
    out->acne = weighted(out->acne, m->acne, m->pixels);
    out->leak = weighted(out->leak, m->leak, m->pixels);
    square = weighted(square, m->rmse * m->rmse, m->pixels);
    out->grazing_false_lit = weighted(out->grazing_false_lit, m->grazing_false_lit, m->grazing_pixels);
    out->grazing_false_shadow = weighted(out->grazing_false_shadow, m->grazing_false_shadow, m->grazing_pixels);
    out->pixels += m->pixels;
    out->grazing_pixels += m->grazing_pixels;
    out->depth_pixels += m->depth_pixels;
  }
  const double share = 1.0 / (double)out->pixels;
  double *const means[] = {&out->lit,           &out->false_lit, &out->false_shadow, &out->mean,
                           &out->mean_absolute, &out->acne,      &out->leak};
  for (size_t i = 0; i < sizeof means / sizeof means[0]; i++)
    *means[i] *= share;
  out->rmse = sqrt(square * share);
  if (out->grazing_pixels) {
    out->grazing_false_lit /= (double)out->grazing_pixels;
    out->grazing_false_shadow /= (double)out->grazing_pixels;
  }
}
