/* maps.c: what the maps and the mask hold, against rays traced through the same triangles. */
#include "support.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { width = 192, height = 128 };

typedef struct drawn {
  record record;
  csm_context *context;
  csm_cascades *cascades;
  csm_view *view;
  csm_config config;
  support_scene scene;
  csm_binding binding;
} drawn;

static void draw(drawn *d, const csm_config *config) {
  memset(&d->record, 0, sizeof d->record);
  d->context = support_open(&d->record);
  d->view = support_view(d->context);
  d->config = *config;
  support_scene_make(&d->scene, d->context);
  assert_int_equal(csm_cascades_create(d->context, config, &d->cascades), CSM_SUCCESS);
  assert_int_equal(csm_render_cascades(d->cascades, shot_frame(&d->scene.shot)), CSM_SUCCESS);
  d->binding = (csm_binding){.struct_size = sizeof d->binding};
  assert_int_equal(csm_bind(d->cascades, &d->binding), CSM_SUCCESS);
}

static void resolve(drawn *d) {
  assert_int_equal(shot_resolve(&d->scene.shot, d->view, d->cascades, width, height), CSM_SUCCESS);
}

static void finish(drawn *d) {
  assert_int_equal(csm_cascades_destroy(d->cascades), CSM_SUCCESS);
  support_close(d->context, &d->record);
}

/* World position of a point in a cascade's texture coordinates and depth: the matrix is affine, so solve 3 by 3. */
static void from_shadow(const double m[16], const double uvz[3], double out[3]) {
  const double b[3] = {uvz[0] - m[12], uvz[1] - m[13], uvz[2] - m[14]};
  const double *c0 = m, *c1 = m + 4, *c2 = m + 8;
  const double det = c0[0] * (c1[1] * c2[2] - c2[1] * c1[2]) - c1[0] * (c0[1] * c2[2] - c2[1] * c0[2]) +
                     c2[0] * (c0[1] * c1[2] - c1[1] * c0[2]);
  out[0] = (b[0] * (c1[1] * c2[2] - c2[1] * c1[2]) - c1[0] * (b[1] * c2[2] - c2[1] * b[2]) +
            c2[0] * (b[1] * c1[2] - c1[1] * b[2])) /
           det;
  out[1] = (c0[0] * (b[1] * c2[2] - c2[1] * b[2]) - b[0] * (c0[1] * c2[2] - c2[1] * c0[2]) +
            c2[0] * (c0[1] * b[2] - b[1] * c0[2])) /
           det;
  out[2] = (c0[0] * (c1[1] * b[2] - b[1] * c1[2]) - c1[0] * (c0[1] * b[2] - b[1] * c0[2]) +
            b[0] * (c0[1] * c1[2] - c1[1] * c0[2])) /
           det;
}

static void check_map(const drawn *d, uint32_t cascade, double corners[][3][3], const float *map) {
  const csm_cascade_info *info = &d->binding.cascades[cascade];
  const uint32_t side = d->config.resolution;
  uint32_t hits = 0, empty = 0;
  for (uint32_t y = 1; y < side; y += 3) {
    for (uint32_t x = 1; x < side; x += 3) {
      /* Far before the map, so that casters before its near plane are met too: those are clamped to it. */
      const double uvz[3] = {(x + 0.5) / side, (y + 0.5) / side, -20};
      const double ahead[3] = {uvz[0], uvz[1], -19};
      double origin[3], next[3], edge;
      from_shadow(info->world_to_shadow, uvz, origin);
      from_shadow(info->world_to_shadow, ahead, next);
      const double direction[3] = {next[0] - origin[0], next[1] - origin[1], next[2] - origin[2]};
      const double t = support_trace(corners, SUPPORT_TRIANGLES, origin, direction, &edge);
      if (edge < 0.02)
        continue;
      const double expected = t < 0 ? 1 : fmin(fmax(t - 20, 0), 1);
      assert_float_equal(map[y * side + x], expected, 2e-6);
      hits += t >= 0;
      empty += t < 0;
    }
  }
  assert_true(hits > 100);
  if (cascade + 1 == d->config.cascade_count)
    assert_true(empty > 100);
}

static void maps_hold_the_nearest_casters(void **state) {
  (void)state;
  drawn d;
  const csm_config config = support_config();
  draw(&d, &config);
  double corners[SUPPORT_TRIANGLES][3][3];
  support_triangles(&d.scene, corners);
  for (uint32_t cascade = 0; cascade < config.cascade_count; ++cascade) {
    float *map = support_map(d.context, d.cascades, cascade, config.resolution);
    check_map(&d, cascade, corners, map);
    free(map);
  }
  finish(&d);
}

/* A caster far before the near plane is clamped to it, and still there. */
static void nearer_casters_are_not_lost(void **state) {
  (void)state;
  drawn d;
  csm_config config = support_config();
  config.caster_distance = 0;
  draw(&d, &config);
  double corners[SUPPORT_TRIANGLES][3][3];
  support_triangles(&d.scene, corners);
  uint32_t clamped = 0;
  for (uint32_t cascade = 0; cascade < config.cascade_count; ++cascade) {
    float *map = support_map(d.context, d.cascades, cascade, config.resolution);
    check_map(&d, cascade, corners, map);
    for (uint32_t i = 0; i < config.resolution * config.resolution; ++i)
      clamped += map[i] == 0;
    free(map);
  }
  assert_true(clamped > 50);
  finish(&d);
}

/* The ray through a pixel's centre, from the eye. */
static void pixel_ray(const shot *shot, uint32_t x, uint32_t y, double origin[3], double direction[3]) {
  const double *v = shot->camera.view, *p = shot->camera.projection;
  const double ndc_x = (x + 0.5) / width * 2 - 1, ndc_y = 1 - (y + 0.5) / height * 2;
  const double local[3] = {ndc_x / p[0], ndc_y / p[5], -1};
  for (int i = 0; i < 3; ++i) {
    direction[i] = v[i * 4] * local[0] + v[i * 4 + 1] * local[1] + v[i * 4 + 2] * local[2];
    origin[i] = -(v[i * 4] * v[12] + v[i * 4 + 1] * v[13] + v[i * 4 + 2] * v[14]);
  }
}

static void check_mask(const drawn *d, const float *mask, const float *depth) {
  double corners[SUPPORT_TRIANGLES][3][3];
  support_triangles(&d->scene, corners);
  const shot *shot = &d->scene.shot;
  uint32_t lit = 0, dark = 0, wrong = 0, sky = 0;
  for (uint32_t y = 0; y < height; ++y) {
    for (uint32_t x = 0; x < width; ++x) {
      double origin[3], direction[3], edge, light_edge;
      pixel_ray(shot, x, y, origin, direction);
      const double t = support_trace(corners, SUPPORT_TRIANGLES, origin, direction, &edge);
      const float value = mask[y * width + x];
      if (t < 0 && edge == 1) {
        assert_true(value == 1 && depth[y * width + x] == 0);
        ++sky;
      }
      if (t < 0 || edge < 0.02 || t > 55)
        continue;
      const double *p = shot->camera.projection;
      assert_float_equal(depth[y * width + x], (p[10] * -t + p[14]) / t, 1e-6);
      double surface[3], to_light[3];
      for (int i = 0; i < 3; ++i) {
        to_light[i] = -shot->light.direction[i];
        surface[i] = origin[i] + direction[i] * t * (1 - 1e-6);
      }
      /* Only points well inside light or shadow: rays to the light from a texel and more around agree. */
      const double shift = 1.0;
      int shadowed = 0;
      bool near_edge = false;
      for (int around = 0; around < 9; ++around) {
        const double beside[3] = {surface[0] + shift * (around % 3 - 1), surface[1],
                                  surface[2] + shift * (around / 3 - 1)};
        shadowed += support_trace(corners, SUPPORT_TRIANGLES, beside, to_light, &light_edge) >= 0;
        near_edge |= light_edge < 0.02;
      }
      if (near_edge || (shadowed != 0 && shadowed != 9) || surface[1] > 0.01)
        continue;
      lit += !shadowed;
      dark += shadowed != 0;
      wrong += value != (shadowed ? 0.0f : 1.0f);
    }
  }
  assert_true(lit > 2000 && dark > 100 && sky > 100);
  assert_int_equal(wrong, 0);
}

static void mask_agrees_with_rays(void **state) {
  (void)state;
  for (uint32_t filter = CSM_FILTER_PCF_2X2; filter <= CSM_FILTER_PCF_3X3; ++filter) {
    drawn d;
    csm_config config = support_config();
    config.filter = filter;
    config.resolution = 1024;
    draw(&d, &config);
    resolve(&d);
    float *mask = support_image(d.context, d.view, CSM_READ_MASK, width, height);
    float *depth = support_image(d.context, d.view, CSM_READ_CAMERA_DEPTH, width, height);
    check_mask(&d, mask, depth);
    free(mask);
    free(depth);
    finish(&d);
  }
}

/* What lies before the near plane is not seen, though it casts. */
static void the_camera_clips_at_its_near_plane(void **state) {
  (void)state;
  drawn d;
  const csm_config config = support_config();
  draw(&d, &config);
  resolve(&d);
  float *before = support_image(d.context, d.view, CSM_READ_CAMERA_DEPTH, width, height);
  const double eye[3] = {-4, 6, 12}, ahead[3] = {0, 0, -4};
  csm_instance *box = &d.scene.instances[5];
  for (int i = 0; i < 3; ++i) {
    box->transform[i * 5] = 0.05;
    box->transform[12 + i] = eye[i] + (ahead[i] - eye[i]) * 0.003;
  }
  resolve(&d);
  float *after = support_image(d.context, d.view, CSM_READ_CAMERA_DEPTH, width, height);
  for (uint32_t i = 0; i < width * height; ++i)
    assert_true(after[i] <= before[i]);
  free(before);
  free(after);
  finish(&d);
}

static bool same(const float *a, const float *b, size_t count) {
  return !memcmp(a, b, count * sizeof *a);
}

/* Many frames in flight, meshes destroyed and made meanwhile, sizes and settings changing: the picture is that of a
   fresh context. */
static void frames_in_flight_do_not_disturb_each_other(void **state) {
  (void)state;
  drawn fresh, busy;
  const csm_config config = support_config();
  draw(&fresh, &config);
  resolve(&fresh);
  draw(&busy, &config);
  csm_config other = config;
  other.cascade_count = 8;
  other.resolution = 64;
  other.filter = CSM_FILTER_PCF_2X2;
  for (int i = 0; i < 12; ++i) {
    shot moved = busy.scene.shot;
    moved.camera.view[12] += i;
    const csm_mesh extra = support_box(busy.context, 2);
    csm_instance instances[2] = {busy.scene.instances[0], support_instance(extra, 0, 2, 0, 1, 2, 1)};
    moved.frame.instances = instances;
    moved.frame.instance_count = 2;
    assert_int_equal(csm_cascades_configure(busy.cascades, i % 2 ? &other : &config), CSM_SUCCESS);
    assert_int_equal(csm_render_cascades(busy.cascades, shot_frame(&moved)), CSM_SUCCESS);
    assert_int_equal(shot_resolve(&moved, busy.view, busy.cascades, width - (uint32_t)i % 3, height), CSM_SUCCESS);
    assert_int_equal(csm_mesh_destroy(busy.context, extra), CSM_SUCCESS);
  }
  assert_int_equal(csm_cascades_configure(busy.cascades, &config), CSM_SUCCESS);
  assert_int_equal(csm_render_cascades(busy.cascades, shot_frame(&busy.scene.shot)), CSM_SUCCESS);
  resolve(&busy);
  for (uint32_t cascade = 0; cascade < config.cascade_count; ++cascade) {
    float *a = support_map(fresh.context, fresh.cascades, cascade, 256);
    float *b = support_map(busy.context, busy.cascades, cascade, 256);
    assert_true(same(a, b, 256 * 256));
    free(a);
    free(b);
  }
  float *a = support_image(fresh.context, fresh.view, CSM_READ_MASK, width, height);
  float *b = support_image(busy.context, busy.view, CSM_READ_MASK, width, height);
  assert_true(same(a, b, width * height));
  free(a);
  free(b);
  finish(&fresh);
  finish(&busy);
}

static void an_empty_scene_is_lit(void **state) {
  (void)state;
  drawn d;
  const csm_config config = support_config();
  draw(&d, &config);
  d.scene.shot.frame.instance_count = 0;
  d.scene.shot.frame.instances = NULL;
  assert_int_equal(csm_render_cascades(d.cascades, shot_frame(&d.scene.shot)), CSM_SUCCESS);
  resolve(&d);
  float *mask = support_image(d.context, d.view, CSM_READ_MASK, width, height);
  float *map = support_map(d.context, d.cascades, 1, config.resolution);
  for (uint32_t i = 0; i < width * height; ++i)
    assert_true(mask[i] == 1);
  for (uint32_t i = 0; i < config.resolution * config.resolution; ++i)
    assert_true(map[i] == 1);
  free(mask);
  free(map);
  finish(&d);
}

static void stats_count_and_measure(void **state) {
  (void)state;
  drawn d;
  const csm_config config = support_config();
  draw(&d, &config);
  csm_stats stats = {.struct_size = sizeof stats};
  assert_int_equal(csm_get_stats(d.cascades, &stats), CSM_SUCCESS);
  assert_true(stats.cascades[0].gpu_ms < 0);
  csm_view_stats view = {.struct_size = sizeof view};
  assert_int_equal(csm_get_view_stats(d.view, &view), CSM_SUCCESS);
  assert_true(view.mask_gpu_ms < 0 && view.width == 0 && view.bytes == 0);
  d.scene.shot.frame.flags = CSM_FRAME_TIMESTAMPS;
  assert_int_equal(csm_render_cascades(d.cascades, shot_frame(&d.scene.shot)), CSM_SUCCESS);
  resolve(&d);
  assert_int_equal(csm_get_stats(d.cascades, &stats), CSM_SUCCESS);
  assert_int_equal(stats.cascade_count, config.cascade_count);
  for (uint32_t i = 0; i < config.cascade_count; ++i) {
    const csm_cascade_stats *cascade = &stats.cascades[i];
    assert_int_equal(cascade->casters_drawn + cascade->casters_culled, SUPPORT_INSTANCES);
    assert_true(cascade->casters_drawn > 0 && cascade->triangles_drawn >= cascade->casters_drawn * 2);
    assert_true(cascade->gpu_ms >= 0);
  }
  assert_true(stats.clear_gpu_ms >= 0);
  assert_int_equal(csm_get_view_stats(d.view, &view), CSM_SUCCESS);
  assert_true(view.camera_depth_gpu_ms > 0 && view.mask_gpu_ms > 0);
  assert_true(view.width == width && view.height == height && view.bytes >= 5ull * width * height);
  assert_int_equal(stats.instances, SUPPORT_INSTANCES);
  assert_true(stats.map_bytes >= 3ull * 256 * 256 * 4 && stats.geometry_bytes > 0 && stats.plan_hash);
  finish(&d);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(maps_hold_the_nearest_casters),
      cmocka_unit_test(nearer_casters_are_not_lost),
      cmocka_unit_test(mask_agrees_with_rays),
      cmocka_unit_test(the_camera_clips_at_its_near_plane),
      cmocka_unit_test(frames_in_flight_do_not_disturb_each_other),
      cmocka_unit_test(an_empty_scene_is_lit),
      cmocka_unit_test(stats_count_and_measure),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
