/* The fixed texels that tell an error of resolution from self-shadowing and leaks. */
#include "base/linear.h"
#include "metrics/metrics.h"
#include <math.h>
#include <string.h>

#define SLICES 4
#define LAMBDA 0.75
#define RESOLUTION 2048.0

/* ---- least sphere ---- */

/* The sphere through 2 to 4 points whose middle lies in their span. False: they are not independent. */
static bool sphere_through(double center[3], double (*points)[3], const uint32_t *chosen, uint32_t count) {
  double rows[3][3], gram[16], inverse[16], sum[4];
  mat_identity(gram);
  for (uint32_t i = 0; i + 1 < count; i++)
    vec_subtract(rows[i], points[chosen[i + 1]], points[chosen[0]]);
  double half[3] = {0};
  for (uint32_t i = 0; i + 1 < count; i++) {
    half[i] = 0.5 * vec_dot(rows[i], rows[i]);
    for (uint32_t j = 0; j + 1 < count; j++)
      gram[j * 4 + i] = vec_dot(rows[i], rows[j]);
  }
  if (!mat_invert(inverse, gram))
    return false;
  mat_transform(sum, inverse, half, 0.0);
  memcpy(center, points[chosen[0]], 3 * sizeof(double));
  for (uint32_t i = 0; i + 1 < count; i++)
    for (int axis = 0; axis < 3; axis++)
      center[axis] += sum[i] * rows[i][axis];
  return all_finite(center, 3);
}

static double distance_between(const double a[3], const double b[3]) {
  double between[3];
  vec_subtract(between, a, b);
  return vec_length(between);
}

/* The radius of a sphere about `center` that holds every point. */
static double radius_about(const double center[3], double (*points)[3], uint32_t count) {
  double radius = 0.0;
  for (uint32_t i = 0; i < count; i++)
    radius = fmax(radius, distance_between(center, points[i]));
  return radius;
}

/* The least sphere touches 2 to 4 of the points, so one of their choices is it; the others are larger. */
double metrics_sphere_radius(double (*points)[3], uint32_t count) {
  double best = count > 1 ? INFINITY : 0.0;
  for (uint32_t bits = 0; bits < 1u << count; bits++) {
    uint32_t chosen[8], chosen_count = 0;
    double center[3];
    for (uint32_t i = 0; i < count; i++)
      if (bits >> i & 1)
        chosen[chosen_count++] = i;
    if (chosen_count >= 2 && chosen_count <= 4 && sphere_through(center, points, chosen, chosen_count))
      best = fmin(best, radius_about(center, points, count));
  }
  return best;
}

/* ---- slices ---- */

static double practical_split(double near, double far, int slice) {
  const double share = (double)slice / SLICES, uniform = near + (far - near) * share;
  return near > 0.0 ? LAMBDA * near * pow(far / near, share) + (1.0 - LAMBDA) * uniform : uniform;
}

void metrics_reference_make(metrics_reference *out, const camera *from, uint32_t width, uint32_t height,
                            double shadow_distance) {
  const double *p = from->projection, near = from->near_depth;
  camera_rays rays;
  camera_rays_make(&rays, from, width, height);
  for (int slice = 0; slice < SLICES; slice++) {
    double corners[8][3];
    camera_slice(&rays, from, practical_split(near, shadow_distance, slice),
                 practical_split(near, shadow_distance, slice + 1), corners);
    out->far_depth[slice] = practical_split(near, shadow_distance, slice + 1);
    out->texel[slice] = 2.0 * metrics_sphere_radius(corners, 8) / RESOLUTION;
  }
  out->w_scale = fabs(p[11]);
  out->w_offset = p[15];
  out->pixels_per_meter = 0.5 * sqrt(width * vec_length((const double[3]){p[0], p[4], 0.0}) * height *
                                     vec_length((const double[3]){p[1], p[5], 0.0}));
}

double metrics_reference_texel_px(const metrics_reference *reference, double view_depth) {
  int slice = 0;
  while (slice < SLICES - 1 && view_depth > reference->far_depth[slice])
    slice++;
  return reference->texel[slice] * reference->pixels_per_meter /
         (reference->w_scale * view_depth + reference->w_offset);
}
