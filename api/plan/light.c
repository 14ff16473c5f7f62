/* light.c: light space, an orthonormal basis for every direction of light. */
#include "plan/internal.h"

/*
 * A basis that is carried from a fixed pole to the light's direction by the shortest rotation, so that it changes
 * smoothly with the light. No basis can be smooth for every direction; this one turns over only at the pole's opposite,
 * (0.4379, 0.6471, 0.6241) roughly: light that travels upwards and off every axis, whichever axis is up.
 * The rotation of a vector across the pole is its reflection about pole + direction (Frisvad, "Building an Orthonormal
 * Basis from a 3D Unit Vector", 2012, turned to another pole), which stays orthogonal however short that sum is.
 */
csm_result plan_light_basis(double basis[9], const double direction[3], const char **error) {
  double pole[3] = {-0.4379, -0.6471, -0.6241};
  double across[3] = {0.8256, -0.5642, 0.0057};
  double along[3] = {direction[0], direction[1], direction[2]};
  if (!plan_finite(direction, 3))
    return plan_fail(error, CSM_ERROR_NOT_FINITE, "light_direction is not finite");
  if (!plan_normalize(along))
    return plan_fail(error, CSM_ERROR_INVALID_LIGHT, "light_direction is zero");

  (void)plan_normalize(pole);
  double half[3], right[3], up[3];
  for (int i = 0; i < 3; ++i)
    half[i] = pole[i] + along[i];
  const double square = plan_dot(half, half);
  const double reflect = square > 0.0 ? 2.0 * plan_dot(half, across) / square : 0.0;
  for (int i = 0; i < 3; ++i)
    right[i] = across[i] - reflect * half[i];
  /* Twice: the first pass takes out what `across` has of the pole, and the rounding of a short `half`. */
  for (int pass = 0; pass < 2; ++pass) {
    const double excess = plan_dot(right, along);
    for (int i = 0; i < 3; ++i)
      right[i] -= excess * along[i];
    (void)plan_normalize(right);
  }
  plan_cross(up, right, along);
  (void)plan_normalize(up);
  for (int i = 0; i < 3; ++i) {
    basis[i] = right[i];
    basis[3 + i] = up[i];
    basis[6 + i] = along[i];
  }
  return CSM_SUCCESS;
}
