/* From where to where maps reach along the light, against brute force; and maps whose depth is reversed. */
#include "support.h"

#include <math.h>
#include <string.h>

enum { instances = 24, meshes = 4, receivers = 16 };

static double dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Depth along the light, in metres, of where a map's depth is a share. */
static double metres_at(const plan_frame *frame, uint32_t cascade, double share) {
  const csm_cascade_info *info = &frame->cascades[cascade].info;
  const double *along = &frame->basis[6];
  const double at_origin = shadow_depth(info, (double[3]){0}), at_one = shadow_depth(info, along);
  return (share - at_origin) / (at_one - at_origin);
}

typedef struct planned {
  plan_frame frame;
  test_camera camera;
  csm_config config;
  double low[3], high[3]; /* the scene's bounding box */
} planned;

static void bounding_box(planned *out, const plan_scene *scene) {
  for (int axis = 0; axis < 3; ++axis) {
    out->low[axis] = INFINITY;
    out->high[axis] = -INFINITY;
  }
  for (uint32_t i = 0; i < scene->slot_count; ++i)
    for (int corner = 0; corner < 8; ++corner) {
      double p[3];
      instance_point(scene, i, (double[]){corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1}, p);
      for (int axis = 0; axis < 3; ++axis) {
        out->low[axis] = fmin(out->low[axis], p[axis]);
        out->high[axis] = fmax(out->high[axis], p[axis]);
      }
    }
}

static void replan(planned *out, const test_scene *scene, const double light[3]) {
  double view[16], projection[16];
  const char *error = "";
  camera_matrices(&out->camera, view, projection);
  if (plan_made(&out->frame, &out->config, &(test_shot){view, projection, camera_reversed(&out->camera), light},
                &scene->scene, scene->memory, &error))
    fail_msg("%s", error);
}

static planned make(random_state *random, test_scene *scene, uint32_t depth_mode, double light[3]) {
  planned out = {.camera = random_camera(random, 100.0), .config = random_full_config(random)};
  out.config.depth_mode = depth_mode;
  out.config.map_reversed = 0;
  random_unit(random, light);
  scene_scatter(scene, random, out.camera.eye, random_scale(random, 1.0, 300.0));
  bounding_box(&out, &scene->scene);
  replan(&out, scene, light);
  return out;
}

/* What rounding a range's ends takes: of the world's size in doubles, and of the range. */
static double rounding(const planned *made, uint32_t cascade) {
  const csm_cascade_info *info = &made->frame.cascades[cascade].info;
  return 1e-12 * (1e3 + info->depth_range + fabs(info->far_depth));
}

/* Whether a map has a range as the mode says: of depths that 32 bits resolve, and not moved for casters' rounding. */
static bool is_plain(const planned *made, uint32_t cascade, double range) {
  const plan_cascade *map = &made->frame.cascades[cascade];
  return map->shift == 0.0 && (range <= 0x1p19 * map->info.texel_size || made->config.pancaking == CSM_PANCAKING_CLIP);
}

static void box_corner(const planned *made, int corner, double out[3]) {
  for (int axis = 0; axis < 3; ++axis)
    out[axis] = corner & (1 << axis) ? made->high[axis] : made->low[axis];
}

static void scene_is_the_box_of_all_instances(void **state) {
  (void)state;
  random_state random = {1};
  test_scene scene = scene_make(instances, meshes);
  uint32_t compared = 0;
  for (int i = 0; i < 1000; ++i) {
    double light[3], low = INFINITY, high = -INFINITY;
    const planned made = make(&random, &scene, CSM_DEPTH_SCENE, light);
    for (int corner = 0; corner < 8; ++corner) {
      double p[3];
      box_corner(&made, corner, p);
      low = fmin(low, dot(p, &made.frame.basis[6]));
      high = fmax(high, dot(p, &made.frame.basis[6]));
    }
    for (uint32_t c = 0; c < made.frame.cascade_count; ++c) {
      if (!is_plain(&made, c, high - low))
        continue;
      assert_near(metres_at(&made.frame, c, 0.0), low, rounding(&made, c));
      assert_near(metres_at(&made.frame, c, 1.0), high, rounding(&made, c));
      assert_near(made.frame.cascades[c].info.depth_range, high - low, rounding(&made, c));
      ++compared;
    }
  }
  assert_true(compared > 3000);
  scene_free(&scene);
}

/* ---- the part of a box over a map, by its corners: wherever three of the ten planes meet inside the others ---- */

typedef struct plane {
  double normal[3], offset; /* inside is dot + offset >= 0 */
} plane;

static void planes_of(plane out[10], const planned *made, uint32_t cascade) {
  const plan_cascade *map = &made->frame.cascades[cascade];
  for (int i = 0; i < 6; ++i) {
    out[i] = (plane){{0}, i & 1 ? made->high[i / 2] : -made->low[i / 2]};
    out[i].normal[i / 2] = i & 1 ? -1.0 : 1.0;
  }
  for (int i = 0; i < 4; ++i) {
    const int axis = i / 2;
    const double sign = i & 1 ? -1.0 : 1.0, edge = map->origin_texels[axis] + (i & 1 ? map->resolution : 0);
    for (int k = 0; k < 3; ++k)
      out[6 + i].normal[k] = sign * made->frame.basis[axis * 3 + k];
    out[6 + i].offset = -sign * edge * map->texel[axis];
  }
}

static bool meet(double out[3], const plane *a, const plane *b, const plane *c) {
  const plane *const p[3] = {a, b, c};
  double sum[3] = {0}, determinant = 0.0;
  for (int i = 0; i < 3; ++i) {
    const double *m = p[(i + 1) % 3]->normal, *n = p[(i + 2) % 3]->normal;
    double cross[3];
    for (int k = 0; k < 3; ++k) {
      cross[k] = m[(k + 1) % 3] * n[(k + 2) % 3] - m[(k + 2) % 3] * n[(k + 1) % 3];
      sum[k] -= p[i]->offset * cross[k];
    }
    determinant = dot(p[i]->normal, cross);
  }
  for (int k = 0; k < 3; ++k)
    out[k] = sum[k] / determinant;
  return fabs(determinant) > 1e-4;
}

static bool depths_over_the_map(double range[2], const planned *made, uint32_t cascade) {
  plane planes[10];
  planes_of(planes, made, cascade);
  range[0] = INFINITY;
  range[1] = -INFINITY;
  for (int a = 0; a < 10; ++a)
    for (int b = 0; b < a; ++b)
      for (int c = 0; c < b; ++c) {
        double p[3];
        bool inside = meet(p, &planes[a], &planes[b], &planes[c]);
        for (int k = 0; k < 10 && inside; ++k)
          inside = k == a || k == b || k == c || dot(planes[k].normal, p) + planes[k].offset >= 0.0;
        if (inside) {
          range[0] = fmin(range[0], dot(p, &made->frame.basis[6]));
          range[1] = fmax(range[1], dot(p, &made->frame.basis[6]));
        }
      }
  return range[0] < range[1];
}

static void clipped_scene_is_what_of_the_box_lies_over_the_map(void **state) {
  (void)state;
  random_state random = {2};
  test_scene scene = scene_make(instances, meshes);
  uint32_t narrower = 0, compared = 0;
  for (int i = 0; i < 600; ++i) {
    double light[3], range[2];
    planned made = make(&random, &scene, CSM_DEPTH_SCENE_CLIPPED, light);
    made.config.pancaking = CSM_PANCAKING_CLIP; /* so that no caster may lie before the range */
    replan(&made, &scene, light);
    bool skewed = true; /* three planes then meet in a point that doubles hold */
    for (int k = 0; k < 9; ++k)
      skewed = skewed && fabs(made.frame.basis[k]) > 0.05;
    for (uint32_t c = 0; c < made.frame.cascade_count && skewed; ++c) {
      if (!depths_over_the_map(range, &made, c) || !is_plain(&made, c, range[1] - range[0]))
        continue;
      const double allowed = 1e3 * rounding(&made, c);
      assert_near(metres_at(&made.frame, c, 0.0), range[0], allowed);
      assert_near(metres_at(&made.frame, c, 1.0), range[1], allowed);
      ++compared;
    }
    for (uint32_t c = 0; c < made.frame.cascade_count; ++c)
      for (int k = 0; k < 100; ++k) {
        double p[3], at[3];
        for (int axis = 0; axis < 3; ++axis)
          p[axis] = random_between(&random, made.low[axis], made.high[axis]);
        transform_point(made.frame.cascades[c].info.world_to_shadow, p, at);
        if (fmin(at[0], at[1]) >= 0.0 && fmax(at[0], at[1]) <= 1.0)
          assert_true(at[2] >= -1e-9 && at[2] <= 1.0 + 1e-9);
      }
    const double clipped = made.frame.cascades[0].info.depth_range;
    made.config.depth_mode = CSM_DEPTH_SCENE;
    replan(&made, &scene, light);
    narrower += clipped < 0.9 * made.frame.cascades[0].info.depth_range;
  }
  assert_true(narrower > 50 && compared > 300);
  scene_free(&scene);
}

/* Without a scene over the map there is the slice. */
static void a_map_without_a_scene_takes_its_slice(void **state) {
  (void)state;
  const test_camera camera = plain_camera();
  csm_config config = default_config();
  config.depth_mode = CSM_DEPTH_SLICE;
  const plan_frame slice = plan_empty(&config, &camera, (double[]){0.3, -1.0, 0.2});
  config.depth_mode = CSM_DEPTH_SCENE;
  const plan_frame empty = plan_empty(&config, &camera, (double[]){0.3, -1.0, 0.2});
  assert_memory_equal(&slice.cascades, &empty.cascades, sizeof slice.cascades);

  test_scene scene = scene_make(1, 1);
  for (int i = 0; i < 3; ++i)
    scene.instances[0].transform[i * 5] = scene.meshes[0].extent[i] = 1.0;
  scene.instances[0].transform[3] = 1e4; /* beside all maps */
  double view[16], projection[16];
  const char *error = "";
  plan_frame beside;
  camera_matrices(&camera, view, projection);
  config.depth_mode = CSM_DEPTH_SCENE_CLIPPED;
  assert_int_equal(plan_made(&beside, &config,
                             &(test_shot){view, projection, camera_reversed(&camera), (double[]){0.3, -1.0, 0.2}},
                             &scene.scene, scene.memory, &error),
                   CSM_SUCCESS);
  for (uint32_t c = 0; c < 4; ++c)
    assert_memory_equal(&slice.cascades[c].info, &beside.cascades[c].info, sizeof slice.cascades[c].info);
  scene_free(&scene);
}

/* The slice's sphere, and so much before it. */
static void slice_keeps_the_caster_distance_exactly(void **state) {
  (void)state;
  random_state random = {3};
  uint32_t compared = 0;
  for (int i = 0; i < 1000; ++i) {
    const test_camera camera = random_camera(&random, 10.0);
    csm_config config = random_full_config(&random);
    config.depth_mode = CSM_DEPTH_SLICE;
    config.fit_mode = CSM_FIT_MINIMUM_SPHERE;
    config.snap_mode = CSM_SNAP_OFF;
    config.snap_power = 0;
    const plan_frame frame = plan_empty(&config, &camera, (double[]){0.3, -1.0, 0.2});
    for (uint32_t c = 0; c < frame.cascade_count; ++c) {
      const plan_cascade *cascade = &frame.cascades[c];
      const double padding = plan_filter_radius_texels(&config) + ceil(config.bias_normal_texels) + 0.5;
      const double diameter = cascade->info.texel_size * (cascade->resolution - 2.0 * padding);
      if (diameter + config.caster_distance > 0x1p19 * cascade->info.texel_size)
        continue;
      ++compared;
      assert_near(cascade->info.depth_range, diameter + config.caster_distance, 1e-9 * cascade->info.depth_range);
    }
  }
  assert_true(compared > 2000);
}

/* Whatever casts, receivers of the slice have a depth, also moved; and so have casters up to the configured distance. */
static void receivers_and_casters_lie_in_the_range(void **state) {
  (void)state;
  random_state random = {4};
  test_scene scene = scene_make(instances, meshes);
  for (int i = 0; i < 1500; ++i) {
    double light[3];
    const planned made = make(&random, &scene, i % 2 ? CSM_DEPTH_CASTERS : CSM_DEPTH_SLICE, light);
    for (uint32_t c = 0; c < made.frame.cascade_count; ++c) {
      const csm_cascade_info *info = &made.frame.cascades[c].info;
      double nearest = INFINITY;
      const double least = rounding(&made, c) / info->depth_range;
      for (int k = 0; k < receivers; ++k) {
        double p[3];
        slice_point(&random, &made.camera, info, p);
        const double depth = shadow_depth(info, p);
        assert_true(depth - made.frame.cascades[c].shift / info->depth_range >= -least && depth <= 1.0 + least);
        nearest = fmin(nearest, depth);
      }
      const plan_list *list = &made.frame.windows[c].list;
      for (uint32_t k = 0; k < list->instance_count; ++k) {
        double p[3];
        for (int axis = 0; axis < 3; ++axis)
          p[axis] = random_between(&random, -1.0, 1.0);
        instance_point(&scene.scene, list->instances[k], p, p);
        const double depth = shadow_depth(info, p), before = (nearest - depth) * info->depth_range;
        if (before < made.config.caster_distance && (1.0 - depth) * info->depth_range < 0x1p19 * info->texel_size &&
            depth <= 1.0 && made.config.depth_mode == CSM_DEPTH_CASTERS)
          assert_true(depth >= -least);
      }
    }
  }
  scene_free(&scene);
}

/* The lists' memory is the next plan's too, so what is to be compared is counted before. */
static void count_listed(uint32_t listed[CSM_MAX_CASCADES], const plan_frame *frame) {
  for (uint32_t c = 0; c < frame->cascade_count; ++c)
    listed[c] = frame->windows[c].list.instance_count;
}

/* What becomes of casters before the near plane is the rasteriser's matter: a range that is resolved is the same. */
static void clipping_casters_changes_no_range(void **state) {
  (void)state;
  random_state random = {5};
  test_scene scene = scene_make(instances, meshes);
  for (int i = 0; i < 400; ++i) {
    double light[3];
    planned made = make(&random, &scene, (uint32_t)i % (CSM_DEPTH_SCENE_CLIPPED + 1), light);
    const plan_frame clamped = made.frame;
    uint32_t listed[CSM_MAX_CASCADES];
    count_listed(listed, &clamped);
    made.config.pancaking = CSM_PANCAKING_CLIP;
    replan(&made, &scene, light);
    for (uint32_t c = 0; c < clamped.cascade_count; ++c) {
      const csm_cascade_info *info = &made.frame.cascades[c].info;
      if (info->depth_range > 0x1p19 * info->texel_size)
        continue;
      assert_memory_equal(info, &clamped.cascades[c].info, sizeof clamped.cascades[c].info);
      assert_int_equal(made.frame.windows[c].list.instance_count, listed[c]);
    }
  }
  scene_free(&scene);
}

/* ---- reversed ---- */

static void check_reversed(random_state *random, const plan_frame *plain, const plan_frame *reversed, uint32_t c) {
  double clip[2][16], planes[2][5][4];
  plan_cascade_volume(plain, c, clip[0], planes[0]);
  plan_cascade_volume(reversed, c, clip[1], planes[1]);
  for (int k = 0; k < receivers; ++k) {
    double p[3], a[3], b[3];
    for (int axis = 0; axis < 3; ++axis)
      p[axis] = plain->camera.position[axis] + random_between(random, -1000.0, 1000.0);
    const double size =
        fmin(plain->cascades[c].info.depth_range, plain->cascades[c].info.texel_size * plain->cascades[c].resolution);
    const double allowed = 1e-12 * (1.0 + 2e3 / size);
    for (int matrix = 0; matrix < 2; ++matrix) {
      transform_point(matrix ? clip[0] : plain->cascades[c].info.world_to_shadow, p, a);
      transform_point(matrix ? clip[1] : reversed->cascades[c].info.world_to_shadow, p, b);
      assert_near(b[0], a[0], allowed);
      assert_near(b[1], a[1], allowed);
      assert_near(b[2], 1.0 - a[2], allowed);
    }
    /* Inside of the five planes is over the map and before its end */
    double texture[3];
    transform_point(plain->cascades[c].info.world_to_shadow, p, texture);
    const double sides[5] = {2.0 * texture[0], 2.0 - 2.0 * texture[0], 2.0 - 2.0 * texture[1], 2.0 * texture[1],
                             1.0 - texture[2]};
    for (int plane = 0; plane < 5; ++plane)
      for (int which = 0; which < 2; ++which)
        assert_near(dot(planes[which][plane], p) + planes[which][plane][3], sides[plane], 4.0 * allowed);
  }
}

static void reversed_maps_hold_one_minus_the_depth(void **state) {
  (void)state;
  random_state random = {6};
  test_scene scene = scene_make(instances, meshes);
  for (int i = 0; i < 1000; ++i) {
    double light[3];
    planned made = make(&random, &scene, (uint32_t)i % (CSM_DEPTH_SCENE_CLIPPED + 1), light);
    const plan_frame plain = made.frame;
    uint32_t listed[CSM_MAX_CASCADES];
    count_listed(listed, &plain);
    made.config.map_reversed = 1;
    replan(&made, &scene, light);
    for (uint32_t c = 0; c < plain.cascade_count; ++c) {
      const plan_cascade *a = &plain.cascades[c], *b = &made.frame.cascades[c];
      assert_true(a->info.texel_size == b->info.texel_size && a->info.depth_range == b->info.depth_range);
      assert_memory_equal(a->texel, b->texel, sizeof a->texel);
      assert_memory_equal(a->origin_texels, b->origin_texels, sizeof a->origin_texels);
      assert_int_equal(listed[c], made.frame.windows[c].list.instance_count);
      check_reversed(&random, &plain, &made.frame, c);
    }
  }
  scene_free(&scene);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(scene_is_the_box_of_all_instances),
      cmocka_unit_test(clipped_scene_is_what_of_the_box_lies_over_the_map),
      cmocka_unit_test(a_map_without_a_scene_takes_its_slice),
      cmocka_unit_test(slice_keeps_the_caster_distance_exactly),
      cmocka_unit_test(receivers_and_casters_lie_in_the_range),
      cmocka_unit_test(clipping_casters_changes_no_range),
      cmocka_unit_test(reversed_maps_hold_one_minus_the_depth),
  };
  return cmocka_run_group_tests_name("plan-depths", tests, NULL, NULL);
}
