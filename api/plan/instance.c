/* instance.c: what a plan needs to know of an instance and its mesh, found when they change. */
#include "plan/internal.h"

#include <math.h>

/* ---- meshes ---- */

void plan_bounds_in_place(plan_bounds *out, const float low[3], const float high[3]) {
  *out = (plan_bounds){0};
  for (int axis = 0; axis < 3; ++axis) {
    out->center[axis] = ((double)low[axis] + high[axis]) / 2.0;
    out->extent[axis] = ((double)high[axis] - low[axis]) / 2.0;
  }
}

/*
 * The difference of two floats is exact where neither is more than twice the other (Sterbenz, "Floating-Point
 * Computation", 1974). Where the middle is over three times the half extent away from 0, every position is from 2/3 to
 * 4/3 of it, which leaves enough for the middle's own rounding.
 */
static bool far_along(const plan_bounds *bounds, int axis) {
  const double share = 3.0;
  return fabs(bounds->center[axis] - bounds->offset[axis]) > share * bounds->extent[axis];
}

bool plan_bounds_far(const plan_bounds *bounds) {
  return far_along(bounds, 0) || far_along(bounds, 1) || far_along(bounds, 2);
}

void plan_bounds_make(plan_bounds *out, const float low[3], const float high[3]) {
  plan_bounds_in_place(out, low, high);
  for (int axis = 0; axis < 3; ++axis)
    if (far_along(out, axis))
      out->offset[axis] = (float)out->center[axis];
}

/* ---- transforms ---- */

/* Columns as long as 1; one of next to no length becomes 0. */
static void unit_columns(double out[3][3], const double transform[12]) {
  const double least = 1e-60; /* whose square is still a normal number */
  for (int column = 0; column < 3; ++column) {
    const double v[3] = {transform[column], transform[4 + column], transform[8 + column]};
    const double length = sqrt(plan_dot(v, v)), scale = length > least ? 1.0 / length : 0.0;
    for (int row = 0; row < 3; ++row)
      out[column][row] = v[row] * scale;
  }
}

/* Whether all columns lie along one line: what they span has no area. */
static bool spans_no_area(const double columns[3][3]) {
  const double dependent = 1e-12;
  for (int i = 0; i < 3; ++i) {
    double cross[3];
    plan_cross(cross, columns[i], columns[(i + 1) % 3]);
    if (plan_dot(cross, cross) > dependent * dependent)
      return false;
  }
  return true;
}

csm_result plan_instance_check(plan_instance *instance) {
  const double dependent = 1e-12;
  if (!plan_within(instance->transform, 12, PLAN_LARGEST))
    return plan_finite(instance->transform, 12) ? CSM_ERROR_INVALID_MATRIX : CSM_ERROR_NOT_FINITE;
  double columns[3][3], cross[3];
  unit_columns(columns, instance->transform);
  plan_cross(cross, columns[0], columns[1]);
  const double volume = plan_dot(cross, columns[2]);
  instance->mirrored = volume < 0.0;
  instance->flags &= ~(uint32_t)PLAN_DEGENERATE;
  if (fabs(volume) <= dependent && spans_no_area((const double(*)[3])columns))
    instance->flags |= PLAN_DEGENERATE;
  return CSM_SUCCESS;
}

void plan_instance_box(plan_box *out, const plan_instance *instance, const plan_bounds *bounds) {
  plan_placed placed;
  plan_place(&placed, instance, bounds);
  for (int axis = 0; axis < 3; ++axis) {
    const double reach = fabs(placed.axes[0][axis]) + fabs(placed.axes[1][axis]) + fabs(placed.axes[2][axis]);
    out->low[axis] = placed.center[axis] - reach;
    out->high[axis] = placed.center[axis] + reach;
  }
}
