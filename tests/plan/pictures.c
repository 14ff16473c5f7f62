#include "pictures.h"

#include <math.h>
#include <string.h>

const double picture_light[3] = {0.3, -1.0, 0.2};

void pixel_clip(int column, int row, double out[2]) {
  out[0] = 2.0 * (column + 0.5) / width - 1.0;
  out[1] = 1.0 - 2.0 * (row + 0.5) / height;
}

static void plan_camera_of(plan_camera *out, const test_camera *camera) {
  double view[16], projection[16];
  const char *error = "";
  camera_matrices(camera, view, projection);
  if (plan_camera_make(out, view, projection, camera_reversed(camera), &error))
    fail_msg("%s", error);
}

static float buffer_depth(const test_camera *camera, const double p[16], double depth) {
  const double z = camera->left_handed ? depth : -depth;
  return (float)((p[10] * z + p[14]) / (p[11] * z + p[15]));
}

/* Where a depth of the buffer's lies: a float at the far end of a range is off by metres. */
static double back_from(const test_camera *camera, const double p[16], double buffer) {
  const double z = (p[14] - buffer * p[15]) / (buffer * p[11] - p[10]);
  return camera->left_handed ? z : -z;
}

void take(picture *out, const test_camera *camera, depth_field *field) {
  double view[16], projection[16];
  memset(out, 0, sizeof *out);
  out->camera = *camera;
  camera_matrices(camera, view, projection);
  for (int i = 0; i < rows * columns; ++i) {
    out->tiles[i][0] = INFINITY;
    out->tiles[i][1] = -INFINITY;
  }
  for (int row = 0; row < height; ++row)
    for (int column = 0; column < width; ++column) {
      double clip[2];
      pixel_clip(column, row, clip);
      const double seen = field(camera, clip[0], clip[1]);
      out->depths[row][column] = -INFINITY;
      if (!(seen >= camera->near && seen <= camera->far))
        continue;
      const float depth = buffer_depth(camera, projection, seen);
      float *tile = out->tiles[row / tile_px * columns + column / tile_px];
      tile[0] = fminf(tile[0], depth);
      tile[1] = fmaxf(tile[1], depth);
      out->depths[row][column] = back_from(camera, projection, depth);
    }
  plan_camera_of(&out->samples.camera, camera);
  out->samples.width = width;
  out->samples.height = height;
  out->samples.tile_px = tile_px;
  out->samples.columns = columns;
  out->samples.rows = rows;
  out->samples.depths = (const float(*)[2])out->tiles;
}

/* ---- scenes ---- */

static double plane_depth(const test_camera *camera, double x, double y, const double normal[3], double offset) {
  double near[3], far[3], at_near = -offset, at_far = -offset;
  camera_point(camera, x, y, 1.0, near);
  camera_point(camera, x, y, 2.0, far);
  for (int k = 0; k < 3; ++k) {
    at_near += normal[k] * near[k];
    at_far += normal[k] * far[k];
  }
  const double depth = 1.0 + at_near / (at_near - at_far);
  return depth > 0.0 ? depth : INFINITY;
}

/* A ground two metres below the origin and a wall 40 metres away, or the ground alone, up to the horizon. */
double ground_and_wall(const test_camera *camera, double x, double y) {
  return fmin(plane_depth(camera, x, y, (double[]){0, 1, 0}, -2.0),
              plane_depth(camera, x, y, (double[]){0, 0, 1}, -40.0));
}

double ground(const test_camera *camera, double x, double y) {
  return plane_depth(camera, x, y, (double[]){0, 1, 0}, -2.0);
}

double nothing(const test_camera *camera, double x, double y) {
  (void)camera, (void)x, (void)y;
  return -INFINITY;
}

/* ---- plans ---- */

plan_frame plan_with(const csm_config *config, const test_camera *camera, const picture *seen,
                     const plan_history *before) {
  const plan_scene empty = {0};
  double view[16], projection[16];
  const char *error = "";
  plan_frame frame;
  camera_matrices(camera, view, projection);
  const plan_frame_info info = {.config = config,
                                .view = view,
                                .projection = projection,
                                .light = picture_light,
                                .scene = &empty,
                                .before = before,
                                .reversed = camera_reversed(camera),
                                .samples = seen ? &seen->samples : NULL,
                                .sample_count = seen ? 1 : 0};
  if (plan_traced(&frame, &info, NULL, &error))
    fail_msg("%s", error);
  return frame;
}

csm_config sampled_config(uint32_t distribution) {
  csm_config config = default_config();
  config.depth_samples = distribution;
  config.shadow_distance = 1000.0;
  return config;
}

double end_of(const plan_frame *frame) {
  return frame->cascades[frame->cascade_count - 1].info.far_depth;
}

void check_point(const csm_config *config, const plan_frame *frame, const double p[3], double depth) {
  const double first = frame->cascades[0].info.near_depth, rounding = 1e-9 * fabs(depth);
  if (!(depth >= first - rounding && depth <= end_of(frame) + rounding))
    fail_msg("%.9g is not in %.9g to %.9g", depth, first, end_of(frame));
  uint32_t c = 0;
  while (c + 1 < frame->cascade_count && depth > frame->cascades[c].info.far_depth)
    ++c;
  const plan_cascade *cascade = &frame->cascades[c];
  const double border = (double)plan_filter_radius_texels(config) / cascade->resolution;
  double at[3];
  transform_point(cascade->info.world_to_shadow, p, at);
  for (int axis = 0; axis < 2; ++axis)
    if (!(at[axis] >= border && at[axis] <= 1.0 - border))
      fail_msg("cascade %u, depth %g: %.9g outside of its map", c, depth, at[axis]);
}

void check_covered(const csm_config *config, const plan_frame *frame, const picture *now) {
  const plan_frame unfitted = plan_with(config, &now->camera, NULL, NULL);
  for (int row = 0; row < height; ++row)
    for (int column = 0; column < width; ++column) {
      const double depth = now->depths[row][column];
      double clip[2], p[3];
      if (!(depth > -INFINITY) || depth > end_of(&unfitted))
        continue;
      pixel_clip(column, row, clip);
      camera_point(&now->camera, clip[0], clip[1], depth, p);
      check_point(config, frame, p, depth);
    }
}
