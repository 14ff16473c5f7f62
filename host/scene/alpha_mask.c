#include "scene/scene.h"
#include <math.h>
#include <stddef.h>

static uint32_t wrap(double texel, uint32_t size, scene_wrap mode) {
  if (mode == SCENE_WRAP_CLAMP)
    return (uint32_t)fmin(fmax(texel, 0.0), size - 1.0);
  const double period = mode == SCENE_WRAP_MIRROR ? 2.0 * size : (double)size;
  const double rest = fmod(texel, period), within = rest < 0.0 ? rest + period : rest; /* exact, however far away */
  return (uint32_t)(within < size ? within : period - 1.0 - within);
}

static double texel_at(const scene_alpha_mask *o, double x, double y) {
  const uint32_t column = wrap(x, o->width, o->wrap[0]), row = wrap(y, o->height, o->wrap[1]);
  return o->alpha[(size_t)row * o->width + column] / 255.0;
}

double scene_alpha_mask_at(const scene_alpha_mask *o, const double uv[2]) {
  const double x = uv[0] * o->width - 0.5, y = uv[1] * o->height - 0.5;
  if (!isfinite(x) || !isfinite(y)) /* nowhere on the texture */
    return 0.0;
  const double left = floor(x), top = floor(y), right_share = x - left, low_share = y - top;
  const double upper = (1.0 - right_share) * texel_at(o, left, top) + right_share * texel_at(o, left + 1.0, top);
  const double lower =
      (1.0 - right_share) * texel_at(o, left, top + 1.0) + right_share * texel_at(o, left + 1.0, top + 1.0);
  return (1.0 - low_share) * upper + low_share * lower;
}

const scene_alpha_mask *scene_cut_out(const scene *s, const scene_mesh *mesh) {
  const scene_material *material = &s->materials[mesh->material];
  const bool cut =
      material->alpha_tested && material->alpha_mask.alpha && mesh->uvs && material->alpha_mask.cutoff > 0.0;
  return cut ? &material->alpha_mask : NULL;
}
