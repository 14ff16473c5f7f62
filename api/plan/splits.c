/* splits.c: where cascades end. */
#include "plan/internal.h"

#include <math.h>

/*
 * Zhang, Sun, Xu and Lun, "Parallel-Split Shadow Maps for Large-scale Virtual Environments" (2006): a blend of
 * logarithmic and uniform splits. An orthographic camera whose near plane is at or behind its origin has no logarithmic
 * splits, and needs none, for its pixels are equally large everywhere: it takes uniform ones.
 */
static double practical_split(double near, double end, double share, double lambda) {
  const double uniform = near + (end - near) * share;
  if (!(near > 0.0))
    return uniform;
  const double logarithmic = pow(near, 1.0 - share) * pow(end, share);
  return lambda * logarithmic + (1.0 - lambda) * uniform;
}

csm_result plan_splits(double *depths, const csm_config *config, const plan_camera *camera, const char **error) {
  const uint32_t count = config->cascade_count;
  const bool manual = config->split_mode == CSM_SPLIT_MANUAL;
  const double near = camera->near_depth;
  double end = fmin(config->shadow_distance, camera->far_depth);
  if (manual)
    end = fmin(end, config->split_distances[count - 1]);
  if (!(near < end))
    return plan_fail(error, CSM_ERROR_INVALID_CAMERA, "projection has its near plane at or beyond the end of shadows");

  /* Manual splits that the near plane, the far plane or the shadow distance overtakes keep a thin slice. */
  const double thin = (end - near) / 1024.0;
  depths[0] = near;
  depths[count] = end;
  for (uint32_t i = 1; i < count; ++i) {
    const double least = near + i * thin, most = end - (count - i) * thin;
    depths[i] = manual ? fmin(fmax(config->split_distances[i - 1], least), most)
                       : practical_split(near, end, (double)i / count, config->split_lambda);
  }
  for (uint32_t i = 0; i < count; ++i)
    if (!(depths[i] < depths[i + 1]))
      return plan_fail(error, CSM_ERROR_INVALID_CAMERA, "projection leaves no room for so many cascades");
  return CSM_SUCCESS;
}
