#include "maps.h"

void maps_make(test_maps *maps, const csm_config *config, const double light[3]) {
  const test_camera camera = plain_camera();
  const char *error = "";
  maps->config = *config;
  maps->config.resolution = maps_side;
  if (plan_config_check(&maps->config, &error))
    fail_msg("%s", error);
  maps->frame = plan_empty(&maps->config, &camera, light);
  (void)plan_write_constants((float *)&maps->constants, &maps->frame, &maps->config);
  for (int i = 0; i < CSM_MAX_CASCADES * maps_side * maps_side; ++i)
    (&maps->depths[0][0][0])[i] = config->map_reversed ? 0.0f : 1.0f;
  maps_bind(maps);
}

void maps_draw_plane(test_maps *maps, const double normal[3], const double point[3], double nearer) {
  for (uint32_t c = 0; c < maps->frame.cascade_count; ++c) {
    const csm_cascade_info *info = &maps->frame.cascades[c].info;
    const double shift = nearer / info->depth_range * (maps->config.map_reversed ? -1.0 : 1.0);
    double back[16];
    assert_true(plan_invert(back, info->world_to_shadow));
    for (int y = 0; y < maps_side; ++y)
      for (int x = 0; x < maps_side; ++x) {
        const double u = (x + 0.5) / maps_side, v = (y + 0.5) / maps_side;
        double at_0[3], at_1[3], away_0 = 0.0, away_1 = 0.0;
        transform_point(back, (double[]){u, v, 0.0}, at_0);
        transform_point(back, (double[]){u, v, 1.0}, at_1);
        for (int k = 0; k < 3; ++k) {
          away_0 += normal[k] * (at_0[k] - point[k]);
          away_1 += normal[k] * (at_1[k] - point[k]);
        }
        maps->depths[c][y][x] = (float)(away_0 / (away_0 - away_1) - shift);
      }
  }
  maps_bind(maps);
}

void maps_bind(const test_maps *maps) {
  sampler_bind((const float *)&maps->constants, &maps->depths[0][0][0], maps_side, maps_side,
               maps->frame.cascade_count);
}

float maps_visibility(const double position[3], const double normal[3]) {
  const float p[3] = {(float)position[0], (float)position[1], (float)position[2]};
  const float n[3] = {(float)normal[0], (float)normal[1], (float)normal[2]};
  return sampler_visibility(p, n, -p[2]);
}
