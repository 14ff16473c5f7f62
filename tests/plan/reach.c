/*
 * What lies far away, or is large: triangles whose vertices floats put off their place, scenes of any size along the
 * light, and orthographic cameras far from what they see.
 */
#include "support.h"

#include "csm_constants.h"
#include <math.h>
#include <string.h>

static double dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static plan_frame_info info_of(const csm_config *config, const double matrices[2][16], const double light[3],
                               const plan_scene *scene) {
  return (plan_frame_info){
      .config = config, .view = matrices[0], .projection = matrices[1], .light = light, .scene = scene};
}

static plan_frame plan_scene_of(const plan_frame_info *info, const test_scene *scene) {
  plan_frame frame;
  const char *error = "";
  if (plan_traced(&frame, info, scene->memory, &error))
    fail_msg("%s", error);
  return frame;
}

/* ---- large triangles ---- */

/* A level square of so many metres to each side, whose own origin is stored so far away; the camera is at its middle. */
static test_scene level_square(float half, float stored_at, double turn) {
  test_scene scene = scene_make(1, 1);
  plan_bounds_in_place(&scene.meshes[0], (float[]){stored_at - half, 0, -half}, (float[]){stored_at + half, 0, half});
  double *t = scene.instances[0].transform;
  const double c = cos(turn), s = sin(turn);
  const double rows[12] = {c, 0, s, -c * stored_at, 0, 1, 0, 0, -s, 0, c, s * stored_at};
  memcpy(t, rows, sizeof rows);
  scene_place(&scene);
  return scene;
}

/* Where a vertex comes out in clip space: as the vertex shader computes it, in floats. */
static void draw_vertex(double out[3], const float rows[12], const float p[3]) {
  for (int row = 0; row < 3; ++row) {
    const float *r = &rows[row * 4];
    out[row] = fmaf(p[0], r[0], fmaf(p[1], r[1], fmaf(p[2], r[2], r[3])));
  }
}

/* The depth at a place of the plane through three points. */
static double plane_depth(const double corners[3][3], double x, double y) {
  double a[3], b[3];
  for (int i = 0; i < 3; ++i) {
    a[i] = corners[1][i] - corners[0][i];
    b[i] = corners[2][i] - corners[0][i];
  }
  const double nx = a[1] * b[2] - a[2] * b[1], ny = a[2] * b[0] - a[0] * b[2], nz = a[0] * b[1] - a[1] * b[0];
  return corners[0][2] - (nx * (x - corners[0][0]) + ny * (y - corners[0][1])) / nz;
}

/*
 * A receiver on a level plane, compared with what the plane's own triangle draws there. It is moved towards the light by
 * the shift, and by the bias of its slope. Half of what it is moved by for rounding is for this, and half for what the
 * camera's depth is off by. Returns by how much it is clear, in metres.
 */
static double clearance(const plan_frame *frame, const csm_config *config, uint32_t c, const test_scene *scene,
                        const float corners[3][3]) {
  const plan_cascade *map = &frame->cascades[c];
  const double *along = &frame->basis[6], range = map->info.depth_range;
  const double slope = hypot(along[0], along[2]) / fabs(along[1]);
  float rows[12];
  double drawn[3][3], at[3];
  plan_write_window_matrices(rows, frame, c, &scene->scene);
  for (int i = 0; i < 3; ++i)
    draw_vertex(drawn[i], rows, corners[i]);
  transform_point(map->info.world_to_shadow, (double[]){frame->camera.position[0], 0.0, frame->camera.position[2]}, at);
  const double error = (at[2] - plane_depth((const double(*)[3])drawn, 2.0 * at[0] - 1.0, 1.0 - 2.0 * at[1])) * range;
  const double bias = map->info.texel_size * 0.5 * (config->bias_constant_texels * 2.0 + slope);
  return (map->shift + bias) / 2.0 - error;
}

static void receivers_stay_clear_of_large_triangles(void **state) {
  (void)state;
  random_state random = {1};
  uint32_t needed = 0;
  for (int i = 0; i < 4000; ++i) {
    const float half = (float)random_scale(&random, 1e3, 3e5);
    test_scene scene = level_square(half, i % 4 ? 0.0f : half * 4.0f, random_between(&random, 0.0, 7.0));
    const float at = i % 4 ? 0.0f : half * 4.0f;
    const float corners[3][3] = {{at - half, 0, -half}, {at + half, 0, -half}, {at + half, 0, half}};
    test_camera camera = plain_camera();
    camera_look(&camera, (double[]){0.0, -0.6, -0.8}, 0.0);
    camera.eye[1] = 3.0;
    csm_config config = default_config();
    config.shadow_distance = random_scale(&random, 60.0, 400.0);
    const double slope = random_between(&random, 0.0, 5.0), azimuth = random_between(&random, 0.0, 7.0);
    double matrices[2][16];
    const double light[3] = {slope * cos(azimuth), -1.0, slope * sin(azimuth)};
    camera_matrices(&camera, matrices[0], matrices[1]);
    const plan_frame_info info = info_of(&config, (const double(*)[16])matrices, light, &scene.scene);
    const plan_frame frame = plan_scene_of(&info, &scene);
    for (uint32_t c = 0; c < frame.cascade_count; ++c) {
      const double clear = clearance(&frame, &config, c, &scene, corners);
      if (!(clear >= 0.0))
        fail_msg("half %g, slope %g, cascade %u: %g m too near, of a shift of %g", half, slope, c, -clear,
                 frame.cascades[c].shift);
      needed += clear < frame.cascades[c].shift / 2.0;
    }
    scene_free(&scene);
  }
  assert_true(needed > 100); /* without the shift they would not */
}

/* Nothing is moved in a scene of common size: there, the bias covers what floats are off by. */
static void nothing_moves_where_the_bias_suffices(void **state) {
  (void)state;
  random_state random = {2};
  test_scene scene = scene_make(40, 5);
  for (int i = 0; i < 500; ++i) {
    test_camera camera = plain_camera();
    const csm_config config = default_config();
    double matrices[2][16], light[3];
    random_unit(&random, light);
    camera_look(&camera, light, 1.0);
    random_unit(&random, light);
    scene_scatter(&scene, &random, camera.eye, 500.0);
    camera_matrices(&camera, matrices[0], matrices[1]);
    plan_frame_info info = info_of(&config, (const double(*)[16])matrices, light, &scene.scene);
    info.reversed = camera_reversed(&camera);
    const plan_frame frame = plan_scene_of(&info, &scene);
    for (uint32_t c = 0; c < frame.cascade_count; ++c)
      assert_true(frame.cascades[c].shift == 0.0);
  }
  scene_free(&scene);
}

/* What shaders read is moved, towards the light; what world_to_shadow says is not. */
static void only_what_shaders_read_is_moved(void **state) {
  (void)state;
  test_scene scene = level_square(1e6f, 0.0f, 0.3);
  test_camera camera = plain_camera();
  camera.eye[1] = 3.0;
  double matrices[2][16];
  camera_matrices(&camera, matrices[0], matrices[1]);
  for (uint32_t reversed = 0; reversed < 2; ++reversed) {
    csm_config config = default_config();
    config.map_reversed = reversed;
    const plan_frame_info info =
        info_of(&config, (const double(*)[16])matrices, (double[]){1.0, -1.0, 0.3}, &scene.scene);
    const plan_frame frame = plan_scene_of(&info, &scene);
    csm_constants constants;
    plan_write_constants((float *)&constants, &frame, &config);
    for (uint32_t c = 0; c < frame.cascade_count; ++c) {
      const plan_cascade *map = &frame.cascades[c];
      /* Its corners are 1.41e6 m away, which nothing else comes near to; along a slope of 1.044 */
      const double slope = hypot(1.0, 0.3), texel = map->info.texel_size;
      const double off = 2.0 * 0x1p-24 * 1e6 * sqrt(2.0) * (1.0 + slope), covered = 0.5 * texel * (1.0 + slope);
      assert_near(map->shift, off - covered, 0.005 * off);
      const double moved = constants.cascades.offsets[c][2] - shadow_depth(&map->info, frame.origin);
      const double expected = (reversed ? 1.0 : -1.0) * map->shift / map->info.depth_range;
      assert_near(moved, expected, 1e-6);
    }
  }
  scene_free(&scene);
}

/* Shaders' positions are relative to the frame's origin. One far away costs precision, of surfaces of any slope. */
static void receivers_far_from_the_origin_are_moved(void **state) {
  (void)state;
  test_camera camera = plain_camera();
  double matrices[2][16];
  const csm_config config = default_config();
  const plan_scene nothing = {0};
  camera_matrices(&camera, matrices[0], matrices[1]);
  plan_frame_info info = info_of(&config, (const double(*)[16])matrices, (double[]){0.3, -1.0, 0.2}, &nothing);
  const double origins[3][3] = {{0}, {1e3, 0, 0}, {0, 6e5, 8e5}};
  for (int i = 0; i < 3; ++i) {
    plan_frame frame;
    const char *error = "";
    info.origin = origins[i];
    assert_int_equal(plan_traced(&frame, &info, NULL, &error), CSM_SUCCESS);
    for (uint32_t c = 0; c < frame.cascade_count; ++c) {
      const double off = 2.0 * 0x1p-24 * 1e6, covered = 0.5 * frame.cascades[c].info.texel_size;
      const double expected = i == 2 ? 11.0 * (off - covered) : 0.0; /* slope 10, and the depth itself */
      assert_near(frame.cascades[c].shift, expected, 0.001 * expected);
    }
  }
}

/* ---- scenes of any size along the light ---- */

static void no_range_is_longer_than_its_format_resolves(void **state) {
  (void)state;
  random_state random = {3};
  test_scene scene = scene_make(3, 1);
  for (int k = 0; k < 3; ++k)
    scene.meshes[0].extent[k] = 1.0;
  for (int i = 0; i < 2000; ++i) {
    test_camera camera = random_camera(&random, 100.0);
    camera.orthographic = false;
    camera.near = random_scale(&random, 0.01, 10.0);
    camera.far = INFINITY;
    csm_config config = default_config();
    config.depth_mode = (uint32_t)i % (CSM_DEPTH_SCENE_CLIPPED + 1);
    config.map_format = random_below(&random, 2);
    config.caster_distance = random_scale(&random, 1.0, 1e6);
    double light[3], matrices[2][16];
    random_unit(&random, light);
    const double away = random_scale(&random, 1e2, 1e29);
    for (uint32_t slot = 0; slot < 3; ++slot)
      for (int k = 0; k < 3; ++k) {
        double *t = scene.instances[slot].transform;
        t[k * 5] = 1.0;
        t[k * 4 + 3] = camera.eye[k] + (slot == 0 ? 0.0 : slot == 1 ? -away : away) * light[k];
      }
    scene_place(&scene);
    camera_matrices(&camera, matrices[0], matrices[1]);
    plan_frame_info info = info_of(&config, (const double(*)[16])matrices, light, &scene.scene);
    info.reversed = camera_reversed(&camera);
    const plan_frame frame = plan_scene_of(&info, &scene);
    for (uint32_t c = 0; c < frame.cascade_count; ++c) {
      const csm_cascade_info *map = &frame.cascades[c].info;
      const double most = map->texel_size * (config.map_format == CSM_MAP_D16 ? 65535.0 : 0x1p19);
      /* A slice's length takes a step more where ranges are counted in steps. */
      assert_true(map->depth_range <= most * 1.001);
      double receiver[3];
      slice_point(&random, &camera, map, receiver);
      const double depth = shadow_depth(map, receiver);
      const bool far_scene = config.depth_mode == CSM_DEPTH_SCENE && away > 1e9;
      if (config.depth_mode < CSM_DEPTH_SCENE || far_scene)
        assert_true(depth >= -1e-9 && depth <= 1.0 + 1e-9);
    }
    /* What is towards the light is drawn all the same, however far away. */
    const plan_list *last = &frame.windows[frame.window_count - 1].list;
    bool above = false;
    for (uint32_t k = 0; k < last->instance_count; ++k)
      above |= last->instances[k] == 1;
    double at[3];
    transform_point(frame.cascades[frame.cascade_count - 1].info.world_to_shadow, camera.eye, at);
    const bool over = at[0] > 0.0 && at[0] < 1.0 && at[1] > 0.0 && at[1] < 1.0;
    if (over && away < 1e12) /* farther away, doubles do not tell which column it is in */
      assert_true(above);
  }
  scene_free(&scene);
}

/* ---- orthographic cameras ---- */

enum { casters = 12 };

/* One that looks at the origin from so far away, and sees `half` metres to each side. */
static test_camera far_camera(random_state *random, double away, double half) {
  test_camera camera = plain_camera();
  double forward[3];
  random_unit(random, forward);
  camera_look(&camera, forward, random_between(random, 0.0, 6.0));
  camera.orthographic = true;
  camera.reversed = random_below(random, 2);
  camera.half_width = half;
  camera.half_height = half * 9.0 / 16.0;
  camera.near = 0.1;
  camera.far = 2.0 * away;
  for (int i = 0; i < 3; ++i)
    camera.eye[i] = -away * forward[i];
  return camera;
}

static void gather(test_scene *scene, random_state *random, double size) {
  for (int k = 0; k < 3; ++k)
    scene->meshes[0].extent[k] = 1.0;
  for (uint32_t i = 0; i < scene->scene.slot_count; ++i)
    for (int k = 0; k < 3; ++k) {
      scene->instances[i].transform[k * 5] = random_between(random, 0.01, 0.2) * size;
      scene->instances[i].transform[k * 4 + 3] = random_between(random, -size, size);
    }
  scene_place(scene);
}

/* Width of all casters across the light, from their corners. */
static double width_of(const test_scene *scene, const double basis[9]) {
  double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
  for (uint32_t i = 0; i < scene->scene.slot_count; ++i)
    for (int corner = 0; corner < 8; ++corner) {
      double p[3];
      instance_point(&scene->scene, i, (double[]){corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1}, p);
      for (int axis = 0; axis < 2; ++axis) {
        low[axis] = fmin(low[axis], dot(p, &basis[axis * 3]));
        high[axis] = fmax(high[axis], dot(p, &basis[axis * 3]));
      }
    }
  return fmax(high[0] - low[0], high[1] - low[1]);
}

/* What lies in the shadow of a caster, in the view, is held by the map of its slice, with its filter. */
static void check_shadows_are_held(random_state *random, const plan_frame *frame, const csm_config *config,
                                   const test_scene *scene, const test_camera *camera) {
  const double border = ((config->filter == CSM_FILTER_PCF_3X3 ? 2.0 : 1.0)) / config->resolution;
  for (int k = 0; k < 40; ++k) {
    double p[3], seen[3], at[3];
    for (int axis = 0; axis < 3; ++axis)
      p[axis] = random_between(random, -1.0, 1.0);
    instance_point(&scene->scene, random_below(random, casters), p, p);
    const double down = random_scale(random, 0.01, 2.0 * camera->half_width);
    double depth = 0.0, right = 0.0, up = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
      p[axis] += down * frame->basis[6 + axis];
      seen[axis] = p[axis] - camera->eye[axis];
      depth += seen[axis] * camera->forward[axis];
      right += seen[axis] * camera->right[axis];
      up += seen[axis] * camera->up[axis];
    }
    if (fabs(right) > camera->half_width || fabs(up) > camera->half_height)
      continue;
    for (uint32_t c = 0; c < frame->cascade_count; ++c) {
      const csm_cascade_info *map = &frame->cascades[c].info;
      if (depth < map->near_depth || depth > map->far_depth)
        continue;
      transform_point(map->world_to_shadow, p, at);
      assert_true(at[0] >= border && at[0] <= 1.0 - border && at[1] >= border && at[1] <= 1.0 - border);
      assert_true(at[2] >= 0.0 && at[2] <= 1.0);
    }
  }
}

static void far_orthographic_cameras_have_maps_as_wide_as_what_casts(void **state) {
  (void)state;
  random_state random = {4};
  test_scene scene = scene_make(casters, 1);
  for (int i = 0; i < 1500; ++i) {
    const double half = random_scale(&random, 2.0, 100.0), away = random_scale(&random, 100.0, 1e5) * half;
    const test_camera camera = far_camera(&random, away, half);
    csm_config config = default_config();
    config.shadow_distance = 2.0 * away;
    config.fit_mode = random_below(&random, CSM_FIT_SCENE_SQUARE + 1);
    gather(&scene, &random, half * random_between(&random, 0.2, 0.9));
    double matrices[2][16], light[3];
    random_unit(&random, light);
    camera_matrices(&camera, matrices[0], matrices[1]);
    plan_frame_info info = info_of(&config, (const double(*)[16])matrices, light, &scene.scene);
    info.reversed = camera_reversed(&camera);
    const plan_frame frame = plan_scene_of(&info, &scene);
    /* A step of a quarter of an octave, and the border's texels; those of the rounding of doubles far away. */
    const double width = width_of(&scene, frame.basis);
    const double most = fmax(width * exp2(0.25) / (config.resolution - 16.0), 0x1p-39 * away);
    for (uint32_t c = 0; c < frame.cascade_count; ++c)
      assert_true(frame.cascades[c].info.texel_size <= most);
    check_shadows_are_held(&random, &frame, &config, &scene, &camera);
  }
  scene_free(&scene);
}

/* A caster as wide as a step, and one next to nothing far from the world's origin. */
static void widths_leave_room_for_filters_and_for_doubles(void **state) {
  (void)state;
  random_state random = {7};
  test_scene scene = scene_make(1, 1);
  test_camera camera = far_camera(&random, 3000.0, 40.0);
  csm_config config = default_config();
  config.resolution = 256;
  config.shadow_distance = 6000.0;
  config.filter = CSM_FILTER_PCF_7X7;
  double matrices[2][16], light[3] = {0.0, -1.0, 0.0}, basis[9];
  const char *error = "";
  assert_int_equal(plan_light_basis(basis, light, &error), CSM_SUCCESS);
  for (int far = 0; far < 2; ++far) {
    double half = 1.0;
    for (int pass = 0; pass < 2; ++pass) { /* sized by its width across the light */
      for (int k = 0; k < 3; ++k) {
        scene.meshes[0].extent[k] = half;
        scene.instances[0].transform[k * 5] = 1.0;
      }
      half = (far ? 1e-12 : 16.0 * (1.0 - 1e-12)) / width_of(&scene, basis);
    }
    for (int k = 0; k < 3; ++k) {
      scene.instances[0].transform[k * 4 + 3] = far ? 1e7 : 0.0;
      camera.eye[k] += far ? 1e7 : 0.0;
    }
    scene_place(&scene);
    camera_matrices(&camera, matrices[0], matrices[1]);
    plan_frame_info info = info_of(&config, (const double(*)[16])matrices, light, &scene.scene);
    info.reversed = camera_reversed(&camera);
    const plan_frame frame = plan_scene_of(&info, &scene); /* which doubles hold */
    const double border = 4.0 / 256.0;                     /* of seven taps, and bilinear */
    for (int i = 0; i < 8; ++i) {
      double corner[3], at[3];
      instance_point(&scene.scene, 0, (double[]){i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1}, corner);
      transform_point(frame.cascades[0].info.world_to_shadow, corner, at);
      /* What lies beside it by the filter's reach, and so is partly dark, is held with its filter too. */
      assert_true(fmin(at[0], at[1]) >= 2.0 * border && fmax(at[0], at[1]) <= 1.0 - 2.0 * border);
    }
    assert_true(frame.cascades[0].info.texel_size < (far ? 1e-3 : 17.0 / 240.0));
    assert_true(frame.cascades[0].info.texel_size > 1e3 * (nextafter(1e7, INFINITY) - 1e7) * far);
  }
  scene_free(&scene);
}

/* Where not every caster is known, or what no map holds is dark, maps hold their slices. */
static void maps_hold_their_slices_where_they_must(void **state) {
  (void)state;
  random_state random = {5};
  test_scene scene = scene_make(casters, 1);
  const test_camera camera = far_camera(&random, 3000.0, 12.0);
  gather(&scene, &random, 10.0);
  csm_config config = default_config();
  config.shadow_distance = 6000.0;
  double matrices[2][16], light[3] = {1.0, -1.0, 0.3};
  camera_matrices(&camera, matrices[0], matrices[1]);
  plan_frame_info info = info_of(&config, (const double(*)[16])matrices, light, &scene.scene);
  info.reversed = camera_reversed(&camera);
  const double narrow = plan_scene_of(&info, &scene).cascades[0].info.texel_size;
  info.others_cast = true;
  const double others = plan_scene_of(&info, &scene).cascades[0].info.texel_size;
  info.others_cast = false;
  config.out_of_range = CSM_OUT_OF_RANGE_DARK;
  const double dark = plan_scene_of(&info, &scene).cascades[0].info.texel_size;
  config.out_of_range = CSM_OUT_OF_RANGE_FADED;
  config.fade_share = 0.1;
  assert_true(plan_scene_of(&info, &scene).cascades[0].info.texel_size == narrow);
  const double slice = plan_empty(&config, &camera, light).cascades[0].info.texel_size; /* without casters */
  assert_true(narrow < slice / 40.0 && others == slice && dark == slice);
  scene_free(&scene);
}

/* Widths grow at once, and shrink when they have been too wide for a while; casters that move a little change nothing. */
static void widths_wait_before_they_shrink(void **state) {
  (void)state;
  random_state random = {6};
  test_scene scene = scene_make(1, 1);
  const test_camera camera = far_camera(&random, 3000.0, 12.0);
  csm_config config = default_config();
  config.shadow_distance = 6000.0;
  double matrices[2][16], light[3] = {0.0, -1.0, 0.0};
  camera_matrices(&camera, matrices[0], matrices[1]);
  plan_frame_info info = info_of(&config, (const double(*)[16])matrices, light, &scene.scene);
  info.reversed = camera_reversed(&camera);
  plan_history history = {0};
  info.before = &history;
  const double halves[] = {4.0, 3.9, 8.0, 4.0};
  double texels[4][40];
  for (int size = 0; size < 4; ++size)
    for (int i = 0; i < 40; ++i) {
      for (int k = 0; k < 3; ++k) {
        scene.meshes[0].extent[k] = halves[size];
        scene.instances[0].transform[k * 5] = 1.0;
        scene.instances[0].transform[k * 4 + 3] = random_between(&random, -0.5, 0.5);
      }
      scene_place(&scene);
      const plan_frame frame = plan_scene_of(&info, &scene);
      history = frame.history;
      texels[size][i] = frame.cascades[0].info.texel_size;
    }
  for (int i = 1; i < 40; ++i)
    assert_true(texels[0][i] == texels[0][0] && texels[1][i] == texels[0][0] && texels[2][i] == texels[2][0]);
  assert_true(texels[2][0] > 1.9 * texels[1][39]);
  assert_true(texels[3][0] == texels[2][0] && texels[3][10] == texels[2][0]);
  assert_true(texels[3][39] == texels[0][0]);
  scene_free(&scene);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(receivers_stay_clear_of_large_triangles),
      cmocka_unit_test(nothing_moves_where_the_bias_suffices),
      cmocka_unit_test(only_what_shaders_read_is_moved),
      cmocka_unit_test(receivers_far_from_the_origin_are_moved),
      cmocka_unit_test(no_range_is_longer_than_its_format_resolves),
      cmocka_unit_test(far_orthographic_cameras_have_maps_as_wide_as_what_casts),
      cmocka_unit_test(widths_leave_room_for_filters_and_for_doubles),
      cmocka_unit_test(maps_hold_their_slices_where_they_must),
      cmocka_unit_test(widths_wait_before_they_shrink),
  };
  return cmocka_run_group_tests_name("plan-reach", tests, NULL, NULL);
}
