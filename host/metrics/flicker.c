#include "metrics/flicker.h"
#include "base/linear.h"
#include "stage/compare.h"
#include <inttypes.h>
#include <math.h>

#define TRUTH_TOLERANCE (1.0f / 255.0f)

/* The view depth of a pixel's point for the other camera. */
typedef struct second_depth {
  camera_rays rays;
  const camera *first;
  double forward[3], offset; /* of the second: depth = forward . (point from the first's origin) + offset */
} second_depth;

static void second_depth_make(second_depth *out, const flicker_pair *pair) {
  camera_rays other;
  double between[3];
  out->first = pair->view->camera;
  camera_rays_make(&out->rays, out->first, pair->view->width, pair->view->height);
  camera_rays_make(&other, pair->second, pair->view->width, pair->view->height);
  vec_subtract(between, out->rays.unview + 12, other.unview + 12);
  for (int i = 0; i < 3; i++)
    out->forward[i] = pair->second->forward[i];
  out->offset = vec_dot(between, out->forward);
}

static double second_depth_at(const second_depth *d, uint32_t column, uint32_t row, double first_depth) {
  double point[3];
  camera_point(&d->rays, d->first, camera_pixel_x(&d->rays, column), camera_pixel_y(&d->rays, row), first_depth, point);
  return vec_dot(point, d->forward) + d->offset;
}

static void add_point(flicker *sum, const flicker_pair *pair, size_t pixel) {
  const bool changed = fabsf(pair->masks[1][pixel] - pair->masks[0][pixel]) > compare_mask_tolerance;
  const bool truly = fabsf(pair->visibility[1][pixel] - pair->visibility[0][pixel]) > TRUTH_TOLERANCE;
  const bool same = pair->cascades[0][pixel] == pair->cascades[1][pixel];
  sum->points += same;
  sum->crossing += !same;
  sum->changed += same && changed && !truly;
  sum->crossing_changed += !same && changed && !truly;
}

void flicker_add(flicker *sum, const flicker_pair *pair) {
  const truth_view *view = pair->view;
  second_depth second;
  second_depth_make(&second, pair);
  for (uint32_t row = 0; row < view->height; row++)
    for (uint32_t column = 0; column < view->width; column++) {
      const size_t pixel = (size_t)row * view->width + column;
      const truth_surface *surface = &view->surfaces[pixel];
      if (pair->kinds[pixel] < METRICS_RIGHT || !pair->seen[pixel] ||
          !(truth_facing(surface, pair->second_light) > METRICS_GRAZING_COSINE))
        continue;
      const double depth = second_depth_at(&second, column, row, surface->view_depth);
      const bool shadowed = pair->cascades[0][pixel] > 0.0f && pair->cascades[1][pixel] > 0.0f;
      if (shadowed && depth <= pair->shadow_distance)
        add_point(sum, pair, pixel);
    }
}

static double share(uint64_t part, uint64_t whole) {
  return whole ? (double)part / (double)whole : -1.0;
}

static json_t *share_to_json(uint64_t part, uint64_t whole) {
  return whole ? json_real(share(part, whole)) : json_null();
}

void flicker_to_json(json_t *metrics, const flicker *f) {
  json_object_set_new(metrics, "flicker", share_to_json(f->changed, f->points));
  json_object_set_new(metrics, "flicker_points", json_integer((json_int_t)f->points));
  json_object_set_new(metrics, "crossing", share_to_json(f->crossing, f->points + f->crossing));
  json_object_set_new(metrics, "crossing_flicker", share_to_json(f->crossing_changed, f->crossing));
}

static void print_share(FILE *to, double value) {
  if (value < 0.0)
    fprintf(to, " %15s", "no points");
  else
    fprintf(to, " %12.4f %%", 100.0 * value);
}

void flicker_print(FILE *to, const flicker *all, uint32_t count) {
  fprintf(to, "  %-20s  %-34s", "flicker", "points that change, and should not");
  for (uint32_t i = 0; i < count; i++)
    print_share(to, share(all[i].changed, all[i].points));
  fprintf(to, "\n  %-20s  %-34s", "crossing", "points whose cascade changes");
  for (uint32_t i = 0; i < count; i++)
    print_share(to, share(all[i].crossing, all[i].points + all[i].crossing));
  fprintf(to, "\n  %-20s  %-34s", "crossing_flicker", "of them: that change");
  for (uint32_t i = 0; i < count; i++)
    print_share(to, share(all[i].crossing_changed, all[i].crossing));
  fputc('\n', to);
}
