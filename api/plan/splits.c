/* splits.c: where cascades end. */
#include "plan/internal.h"

#include <math.h>

/*
 * Zhang, Sun, Xu and Lun, "Parallel-Split Shadow Maps for Large-scale Virtual Environments" (2006): a blend of
 * logarithmic and uniform splits. An orthographic camera's pixels are equally large everywhere, and it may lie far from
 * all that it sees, or behind it: its splits are uniform.
 */
static double practical_split(double near, double end, double share, double lambda) {
  const double uniform = near + (end - near) * share;
  if (lambda == 0.0)
    return uniform;
  const double logarithmic = pow(near, 1.0 - share) * pow(end, share);
  return lambda * logarithmic + (1.0 - lambda) * uniform;
}

/* The far end of a cascade that split_distances give. */
static double manual_split(const csm_config *config, uint32_t cascade, double near, double end) {
  const double given = config->split_distances[cascade];
  return config->split_mode == CSM_SPLIT_FRACTIONS ? near + (end - near) * given : given;
}

static double split_lambda(const csm_config *config, const plan_camera *camera) {
  return config->split_mode == CSM_SPLIT_UNIFORM       ? 0.0
         : camera->orthographic                        ? 0.0
         : config->split_mode == CSM_SPLIT_LOGARITHMIC ? 1.0
                                                       : config->split_lambda;
}

csm_result plan_splits(plan_depths *out, const plan_fit_frame *frame, const char **error) {
  const csm_config *config = frame->config;
  const uint32_t count = config->cascade_count;
  const bool manual = config->split_mode == CSM_SPLIT_MANUAL || config->split_mode == CSM_SPLIT_FRACTIONS;
  double near = frame->camera->near_depth;
  const double reach = fmin(config->shadow_distance, frame->camera->far_depth);
  double end = manual ? fmin(reach, manual_split(config, count - 1, near, reach)) : reach;
  out->none = !(near < end);
  out->shadow_end = end;
  if (out->none)
    return CSM_SUCCESS;
  if (frame->sample_count && !manual)
    plan_depth_samples_range(&near, &end, frame);

  /* Manual splits that the near plane, the far plane or the shadow distance overtakes keep a thin slice. */
  const double thin = (end - near) / 1024.0;
  const double from = config->split_near;
  const double spread = from > 0.0 && from > near && from < end ? from : near;
  double *depths = out->at;
  depths[0] = near;
  depths[count] = end;
  for (uint32_t i = 1; i < count; ++i) {
    const double least = near + i * thin, most = end - (count - i) * thin;
    depths[i] = manual ? fmin(fmax(manual_split(config, i - 1, near, reach), least), most)
                       : practical_split(spread, end, (double)i / count, split_lambda(config, frame->camera));
  }
  for (uint32_t i = 0; i < count; ++i)
    if (!(depths[i] < depths[i + 1]))
      return plan_fail(error, CSM_ERROR_INVALID_CAMERA, "projection leaves no room for so many cascades");
  return CSM_SUCCESS;
}
