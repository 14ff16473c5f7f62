/* rounding.c: how far floats put a surface off its place, and by how much receivers are moved for that. */
#include "plan/internal.h"

#include <math.h>

/*
 * A vertex's clip coordinates are floats, made by three of mad from a matrix's floats, and cut by the clipper where the
 * triangle reaches beyond the map. Every rounding is off by up to UNIT of what is rounded, which is as large as the
 * vertex lies far from the map's middle, or its mesh's own origin from either. Some six of them, evenly spread and
 * independent, make a plane miss its place by a quarter of UNIT in the root of the mean square, and by no more than one
 * UNIT in four deviations: along the light, and once for each unit of slope across it. A camera's depth holds the same
 * triangle with the same error, and what a receiver compares is off by both.
 *
 * That is nothing for a triangle of some metres, and as much as the configured bias for one of some ten thousand. What
 * is more than the bias covers, receivers are moved towards the light.
 */
#define UNIT 0x1p-24
#define UNITS 2.0

/* From here on a receiver gets less than a tenth of the light, and what it is off by is hardly seen. */
#define STEEPEST 10.0

/* Every configuration takes so much on itself, in texels. */
#define TEXELS 0.125

/* Depths of 32 bits, and the arithmetic with them, are off by this share of the map's range. */
#define RANGE_UNIT 0x1p-22

/*
 * Of 32 bits: at which they are off by an eighth of a texel. Of 16 bits: at which a step of theirs, half of which is
 * bias, is a texel. Clipped, casters before the range would be lost.
 */
double plan_longest_range(const plan_fit *fit, const csm_config *config) {
  const double texel = fmax(fit->texel[0], fit->texel[1]);
  if (config->pancaking == CSM_PANCAKING_CLIP)
    return INFINITY;
  return texel * (config->map_format == CSM_MAP_D16 ? 65535.0 : TEXELS / RANGE_UNIT);
}

/* ---- what the bias covers ---- */

/*
 * A surface that is large is a plane under the filter. It needs none of the constant, nor of what a receiver's plane has
 * for each unit of slope, but all of what one depth for the whole filter has.
 */
plan_rounding plan_rounding_begin(const plan_fit *fit, const csm_config *config) {
  const double texel = fmax(fit->texel[0], fit->texel[1]);
  const double sloped = config->bias_mode == CSM_BIAS_SLOPE ? 0.0 : 0.5 * config->bias_slope_texels;
  plan_rounding rounding = {
      .begin = fit->depth[0], .slope_max = config->bias_slope_max, .most = fit->depth[1] - fit->depth[0]};
  for (int i = 0; i < 2; ++i)
    rounding.middle[i] = fit->anchor[i] + (fit->origin[i] + fit->resolution / 2.0) * fit->texel[i];
  rounding.middle[2] = (fit->depth[0] + fit->depth[1]) / 2.0;
  rounding.covered[0] = texel * fmax(config->bias_constant_texels, TEXELS) + config->bias_constant_m;
  rounding.covered[1] = texel * fmax(sloped, TEXELS);
  rounding.least = fmin(rounding.covered[0], rounding.covered[1]) / (UNITS * UNIT);
  rounding.beyond = -rounding.covered[0];
  return rounding;
}

/* Metres by which a surface of that slope, with vertices so far away, is off by more than is covered. */
static double beyond(const plan_rounding *rounding, double away, double slope) {
  return UNITS * UNIT * away * (1.0 + slope) - rounding->covered[0] -
         rounding->covered[1] * fmin(slope, rounding->slope_max);
}

/* Of any slope. */
static double beyond_at_most(const plan_rounding *rounding, double away) {
  return fmax(beyond(rounding, away, 0.0), beyond(rounding, away, STEEPEST));
}

/* How far a place in the world lies from the slice's middle. */
static double point_away(const plan_rounding *rounding, const double basis[9], const double point[3]) {
  double square = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double apart = plan_dot(point, &basis[axis * 3]) - rounding->middle[axis];
    square += apart * apart;
  }
  return sqrt(square);
}

void plan_rounding_origin(plan_rounding *rounding, const double basis[9], const double origin[3]) {
  rounding->beyond = fmax(rounding->beyond, beyond_at_most(rounding, point_away(rounding, basis, origin)));
}

/* ---- what casters are off by ---- */

/*
 * The slope of what a box holds; negative: of any kind. A box is flat if it is no thicker than its vertices may be off.
 */
static double flat_slope(const plan_placed *box, const double basis[9], double away) {
  double thinnest = INFINITY, normal[3] = {0};
  for (int i = 0; i < 3; ++i) {
    const double square = plan_dot(box->axes[i], box->axes[i]);
    if (square >= thinnest)
      continue;
    thinnest = square;
    plan_cross(normal, box->axes[(i + 1) % 3], box->axes[(i + 2) % 3]);
  }
  const double thin = UNITS * UNIT * away;
  if (thinnest > thin * thin || !plan_normalize(normal))
    return -1.0;
  const double right = plan_dot(normal, &basis[0]), up = plan_dot(normal, &basis[3]);
  return fmin(hypot(right, up) / fmax(fabs(plan_dot(normal, &basis[6])), 1e-3), STEEPEST);
}

/* How far the stored positions lie from where they are counted from, once they are placed. */
static double stored_reach(const plan_instance *instance, const plan_bounds *bounds) {
  double square = 0.0;
  for (int column = 0; column < 3; ++column) {
    const double *t = &instance->transform[column];
    const double reach = fabs(bounds->center[column] - bounds->offset[column]) + bounds->extent[column];
    square += (t[0] * t[0] + t[4] * t[4] + t[8] * t[8]) * reach * reach;
  }
  return sqrt(square);
}

/* That, from the slice's middle. */
static double origin_away(const plan_rounding *rounding, const double basis[9], const plan_instance *instance,
                          const plan_bounds *bounds) {
  double origin[3];
  for (int i = 0; i < 3; ++i) {
    const double *row = &instance->transform[i * 4];
    origin[i] = plan_dot(row, bounds->offset) + row[3];
  }
  return point_away(rounding, basis, origin);
}

void plan_rounding_note(plan_rounding *rounding, const double basis[9], const plan_instance *instance,
                        const plan_bounds *bounds, double end) {
  if (end < rounding->begin) /* above all that the slice holds: it shades, and is not shaded there */
    return;
  const double away = origin_away(rounding, basis, instance, bounds) + stored_reach(instance, bounds);
  if (!(away > rounding->least))
    return;
  plan_placed box;
  plan_place(&box, instance, bounds);
  const double slope = flat_slope(&box, basis, away);
  rounding->beyond =
      fmax(rounding->beyond, slope < 0.0 ? beyond_at_most(rounding, away) : beyond(rounding, away, slope));
}

double plan_rounding_shift(const plan_rounding *rounding, double range) {
  return fmin(fmax(rounding->beyond + RANGE_UNIT * range, 0.0), rounding->most);
}
