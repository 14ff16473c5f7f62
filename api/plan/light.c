/* light.c: light space, an orthonormal basis for every direction of light. */
#include "plan/internal.h"

#include <math.h>
#include <string.h>

/*
 * The basis that the shortest rotation from one direction of light to another makes of `right`, which is at right
 * angles to the first. The rotation of such a vector is its reflection about the directions' sum (Frisvad, "Building an
 * Orthonormal Basis from a 3D Unit Vector", 2012, turned to another pole), which stays orthogonal however short that
 * is.
 */
static void carry(double basis[9], const double from[3], const double across[3], const double along[3]) {
  double half[3], right[3], up[3];
  for (int i = 0; i < 3; ++i)
    half[i] = from[i] + along[i];
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
}

/*
 * Carried from a fixed pole, so that the basis changes smoothly with the light. No basis can be smooth for every
 * direction; this one turns over only at the pole's opposite, (0.4379, 0.6471, 0.6241) roughly: light that travels
 * upwards and off every axis, whichever axis is up.
 */
csm_result plan_light_basis(double basis[9], const double direction[3], const char **error) {
  double pole[3] = {-0.4379, -0.6471, -0.6241};
  const double across[3] = {0.8256, -0.5642, 0.0057};
  double along[3] = {direction[0], direction[1], direction[2]};
  if (!plan_finite(direction, 3))
    return plan_fail(error, CSM_ERROR_NOT_FINITE, "direction is not finite");
  if (!plan_normalize(along))
    return plan_fail(error, CSM_ERROR_INVALID_LIGHT, "direction is zero");
  (void)plan_normalize(pole);
  carry(basis, pole, across, along);
  return CSM_SUCCESS;
}

/* Of unit vectors; exact for small angles, where the cosine alone says nothing. */
static double angle_between(const double a[3], const double b[3]) {
  double cross[3];
  plan_cross(cross, a, b);
  return atan2(sqrt(plan_dot(cross, cross)), plan_dot(a, b));
}

/* Of the cascades' maps, for it is the one that a step shifts by the most texels. */
static double largest_resolution(const csm_config *config) {
  uint32_t largest = 0;
  for (uint32_t i = 0; i < config->cascade_count; ++i)
    largest = plan_resolution(config, i) > largest ? plan_resolution(config, i) : largest;
  return largest;
}

/*
 * "Common Techniques to Improve Shadow Depth Maps" (Microsoft), Moving the light in texel-sized increments: as long as
 * the light has not gone a whole step from the direction that maps were drawn with, they keep it. An angle of n texels
 * over a map's width is n / resolution.
 *
 * A small step can do harm. Light that turns so little in a frame that hardly any receiver's filter sees a 255th of
 * difference changes no more than the texels that a silhouette crosses, and a step gathers up what would never have
 * been seen. So a slow light moves freely, unless a step is long enough to pay for that too. It pays where it is more
 * than about 14 times as long as the least turn that is seen; 20 leaves room (docs/accuracy.md).
 */
#define RECEIVERS_AWAY 7.0 /* a map's width, over how far from its anchor, along the light, receivers lie */
#define STEP_PAYS 20.0

static bool light_rests(const csm_config *config, const double along[3], const plan_history *before) {
  const double texels = largest_resolution(config), step = config->light_step_texels;
  if (!(texels * angle_between(&before->basis[6], along) < step))
    return false;
  const double seen = RECEIVERS_AWAY * 2.0 * plan_filter_reach_texels(config) / 255.0;
  return step >= STEP_PAYS * seen || memcmp(before->light, along, sizeof before->light) == 0 ||
         texels * angle_between(before->light, along) >= seen;
}

csm_result plan_light_make(double basis[9], double light[3], const plan_frame_info *info, const char **error) {
  const plan_history *before = info->before;
  const csm_result result = plan_light_basis(basis, info->light, error);
  if (result)
    return result;
  memcpy(light, &basis[6], 3 * sizeof *light);
  if (!before || !before->has_light)
    return CSM_SUCCESS;
  if (light_rests(info->config, light, before))
    memcpy(basis, before->basis, sizeof before->basis);
  else if (info->config->light_roll == CSM_LIGHT_ROLL_CARRIED)
    carry(basis, &before->basis[6], before->basis, light);
  return CSM_SUCCESS;
}
