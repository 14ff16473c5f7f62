/* alpha_mask.c: alpha-tested casters are where bilinear alpha mask, computed here in doubles, says that they are. */
#include "support.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { texels_u = 7, texels_v = 5, resolution = 512, margin_permille = 10 };

static const float positions[4][3] = {{-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}};
static const uint16_t indices[6] = {0, 2, 1, 0, 3, 2};

/* Beyond the texture on every side, so that wrapping shows; two floats that are not read between the pairs. */
static const float uvs[4][4] = {{-1.25f, -0.5f, 0, 0}, {2.5f, -0.5f, 0, 0}, {2.5f, 1.75f, 0, 0}, {-1.25f, 1.75f, 0, 0}};

typedef struct fixture {
  record record;
  csm_context *context;
  csm_cascades *cascades;
  csm_view *view;
  csm_config config;
  unsigned char texels[texels_v][8]; /* rows with a gap */
  csm_alpha_mask alpha_mask;
  csm_mesh leaf, ground;
} fixture;

static csm_alpha_mask_info alpha_mask_info(fixture *f, uint32_t wrap_u, uint32_t wrap_v) {
  return (csm_alpha_mask_info){.struct_size = sizeof(csm_alpha_mask_info),
                               .width = texels_u,
                               .height = texels_v,
                               .wrap_u = wrap_u,
                               .wrap_v = wrap_v,
                               .texels = f->texels[0],
                               .row_stride = sizeof f->texels[0]};
}

static csm_mesh_info leaf_info(const fixture *f, float cutoff) {
  return (csm_mesh_info){.struct_size = sizeof(csm_mesh_info),
                         .positions = positions,
                         .vertex_count = 4,
                         .indices = indices,
                         .index_count = 6,
                         .index_size = 2,
                         .alpha_mask = f->alpha_mask,
                         .uvs = uvs,
                         .uv_stride = sizeof uvs[0],
                         .alpha_cutoff = cutoff};
}

static void open_fixture(fixture *f, uint32_t wrap_u, uint32_t wrap_v, float cutoff) {
  memset(f, 0, sizeof *f);
  csm_create_info create = support_create_info(&f->record);
  create.flags |= CSM_CREATE_KEEP_GEOMETRY;
  assert_int_equal(csm_create(&create, &f->context), CSM_SUCCESS);
  for (int v = 0; v < texels_v; ++v)
    for (int u = 0; u < 8; ++u)
      f->texels[v][u] = (unsigned char)((u * 89 + v * 151 + u * v * 37) % 256);
  const csm_alpha_mask_info info = alpha_mask_info(f, wrap_u, wrap_v);
  assert_int_equal(csm_alpha_mask_create(f->context, &info, &f->alpha_mask), CSM_SUCCESS);
  const csm_mesh_info leaf = leaf_info(f, cutoff);
  assert_int_equal(csm_mesh_create(f->context, &leaf, &f->leaf), CSM_SUCCESS);
  f->view = support_view(f->context);
  f->ground = support_square(f->context);
  f->config = support_config();
  f->config.cascade_count = 1;
  f->config.resolution = resolution;
  f->config.shadow_distance = 20;
  assert_int_equal(csm_cascades_create(f->context, &f->config, &f->cascades), CSM_SUCCESS);
}

/* A leaf of 8 m a side three metres above the ground; turned over, so that it is seen from behind, if asked. */
static shot draw(fixture *f, csm_instance instances[2], bool turned) {
  instances[0] = support_instance(f->ground, 0, 0, 0, 30, 1, 30);
  instances[1] = support_instance(f->leaf, 0, 3, 0, 4, turned ? -1 : 1, 4);
  shot shot = shot_make(instances, 2);
  memcpy(shot.light.direction, (const double[]){0.1, -1, 0.2}, sizeof shot.light.direction);
  support_look_at(shot.camera.view, (const double[]){0, 9, 9}, (const double[]){0, 0, 0});
  support_perspective(shot.camera.projection, 60, 1, 0.5, 100);
  assert_int_equal(csm_render_cascades(f->cascades, shot_frame(&shot)), CSM_SUCCESS);
  return shot;
}

static double alpha_mask_at(const fixture *f, double u, double v, uint32_t wrap_u, uint32_t wrap_v) {
  const support_texture texture = {f->texels[0], texels_u, texels_v, sizeof f->texels[0], wrap_u, wrap_v};
  return support_alpha(&texture, u, v);
}

static void check_map(const fixture *f, const float *map, uint32_t wrap_u, uint32_t wrap_v, double cutoff) {
  csm_binding binding = {.struct_size = sizeof binding};
  assert_int_equal(csm_bind(f->cascades, &binding), CSM_SUCCESS);
  const double *m = binding.cascades[0].world_to_shadow;
  uint32_t solid = 0, clear = 0, wrong = 0;
  for (int i = 0; i < 400; ++i) {
    for (int k = 0; k < 400; ++k) {
      /* The texel that a point of the leaf falls into, and back to the leaf's point at that texel's centre. */
      const double point[3] = {(i + 0.5) / 50 - 4, 3, (k + 0.5) / 50 - 4};
      double at[3];
      support_apply(m, point, at);
      const int x = (int)floor(at[0] * resolution), y = (int)floor(at[1] * resolution);
      const double du = (x + 0.5) / resolution - at[0], dv = (y + 0.5) / resolution - at[1];
      /* On the plane y = 3 only x and z vary: solve two by two. */
      const double det = m[0] * m[9] - m[8] * m[1];
      const double px = point[0] + (du * m[9] - m[8] * dv) / det, pz = point[2] + (m[0] * dv - m[1] * du) / det;
      const double s = (px + 4) / 8, t = (pz + 4) / 8;
      if (s < 0.01 || s > 0.99 || t < 0.01 || t > 0.99)
        continue;
      const double alpha = alpha_mask_at(f, -1.25 + 3.75 * s, -0.5 + 2.25 * t, wrap_u, wrap_v);
      if (fabs(alpha - cutoff) < margin_permille * 1e-3)
        continue;
      const double depth = m[2] * px + m[6] * 3 + m[10] * pz + m[14];
      const bool drawn = fabs(map[y * resolution + x] - depth) < 1e-4;
      wrong += drawn != (alpha > cutoff);
      solid += alpha > cutoff;
      clear += alpha < cutoff;
    }
  }
  assert_true(solid > 10000 && clear > 10000);
  assert_int_equal(wrong, 0);
}

static void casters_are_cut_out(void **state) {
  (void)state;
  for (uint32_t mode = 0; mode < 9; ++mode) {
    const uint32_t wrap_u = mode % 3, wrap_v = mode / 3;
    const float cutoff = mode % 2 ? 0.5f : 0.35f;
    fixture f;
    csm_instance instances[2];
    open_fixture(&f, wrap_u, wrap_v, cutoff);
    draw(&f, instances, mode == 4); /* from both sides */
    float *map = support_map(f.context, f.cascades, 0, resolution);
    check_map(&f, map, wrap_u, wrap_v, cutoff);
    free(map);
    support_close(f.context, &f.record);
  }
}

/* The camera sees the ground through the holes: the pre-pass cuts out as the maps do. */
static void the_camera_sees_through(void **state) {
  (void)state;
  enum { side = 256 };
  fixture f;
  csm_instance instances[2];
  open_fixture(&f, CSM_WRAP_REPEAT, CSM_WRAP_MIRROR, 0.5f);
  shot shot = draw(&f, instances, false);
  assert_int_equal(shot_resolve(&shot, f.view, f.cascades, side, side), CSM_SUCCESS);
  float *depth = support_image(f.context, f.view, CSM_READ_CAMERA_DEPTH, side, side);
  uint32_t solid = 0, clear = 0, wrong = 0;
  for (int i = 0; i < 300; ++i)
    for (int k = 0; k < 300; ++k) {
      const double point[3] = {(i + 0.5) / 300 * 7.8 - 3.9, 3, (k + 0.5) / 300 * 7.8 - 3.9};
      double local[3], clip[3];
      support_apply(shot.camera.view, point, local);
      const double w = support_apply(shot.camera.projection, local, clip);
      const int x = (int)floor((clip[0] / w + 1) / 2 * side), y = (int)floor((1 - clip[1] / w) / 2 * side);
      const double alpha = alpha_mask_at(&f, -1.25 + 3.75 * (point[0] + 4) / 8, -0.5 + 2.25 * (point[2] + 4) / 8,
                                         CSM_WRAP_REPEAT, CSM_WRAP_MIRROR);
      /* A point is up to a pixel from the centre that was sampled: look away from edges. */
      if (fabs(alpha - 0.5) < 0.25 || x < 0 || y < 0 || x >= side || y >= side)
        continue;
      const bool drawn = fabs(depth[y * side + x] - clip[2] / w) < 1e-3 * fabs(clip[2] / w) + 2e-4;
      wrong += drawn != (alpha > 0.5);
      solid += alpha > 0.5;
      clear += alpha < 0.5;
    }
  free(depth);
  assert_true(solid > 3000 && clear > 3000);
  assert_true(wrong <= (solid + clear) / 200);
  support_close(f.context, &f.record);
}

static void expect(const fixture *f, csm_result result, csm_result expected) {
  if (result != expected)
    fail_msg("%s, not %s", csm_result_name(result), csm_result_name(expected));
  assert_true(strlen(csm_last_error(f->context)) > 0);
}

static void misuse_is_named(void **state) {
  (void)state;
  fixture f;
  open_fixture(&f, 0, 0, 0.5f);
  f.record.quiet = true;
  csm_alpha_mask alpha_mask = 1;
  csm_alpha_mask_info info = alpha_mask_info(&f, 0, 0);
  assert_int_equal(csm_alpha_mask_create(NULL, &info, &alpha_mask), CSM_ERROR_NULL_POINTER);
  assert_int_equal(csm_alpha_mask_destroy(NULL, 1), CSM_ERROR_NULL_POINTER);
  expect(&f, csm_alpha_mask_create(f.context, NULL, &alpha_mask), CSM_ERROR_NULL_POINTER);
  expect(&f, csm_alpha_mask_create(f.context, &info, NULL), CSM_ERROR_NULL_POINTER);
  info.texels = NULL;
  expect(&f, csm_alpha_mask_create(f.context, &info, &alpha_mask), CSM_ERROR_NULL_POINTER);
  assert_true(alpha_mask == 0);
  info = alpha_mask_info(&f, 3, 0);
  expect(&f, csm_alpha_mask_create(f.context, &info, &alpha_mask), CSM_ERROR_INVALID_VALUE);
  info = alpha_mask_info(&f, 0, 0), info.width = 0;
  expect(&f, csm_alpha_mask_create(f.context, &info, &alpha_mask), CSM_ERROR_INVALID_VALUE);
  info = alpha_mask_info(&f, 0, 0), info.row_stride = 3;
  expect(&f, csm_alpha_mask_create(f.context, &info, &alpha_mask), CSM_ERROR_INVALID_VALUE);
  info = alpha_mask_info(&f, 0, 0), info.struct_size = 0;
  expect(&f, csm_alpha_mask_create(f.context, &info, &alpha_mask), CSM_ERROR_STRUCT_SIZE);
  expect(&f, csm_alpha_mask_destroy(f.context, 77), CSM_ERROR_INVALID_HANDLE);
  expect(&f, csm_alpha_mask_destroy(f.context, f.alpha_mask), CSM_ERROR_INVALID_STATE);

  csm_mesh mesh;
  csm_mesh_info leaf = leaf_info(&f, 0);
  expect(&f, csm_mesh_create(f.context, &leaf, &mesh), CSM_ERROR_INVALID_VALUE);
  leaf = leaf_info(&f, NAN);
  expect(&f, csm_mesh_create(f.context, &leaf, &mesh), CSM_ERROR_NOT_FINITE);
  leaf = leaf_info(&f, 0.5f), leaf.uvs = NULL;
  expect(&f, csm_mesh_create(f.context, &leaf, &mesh), CSM_ERROR_NULL_POINTER);
  leaf = leaf_info(&f, 0.5f), leaf.uv_stride = 4;
  expect(&f, csm_mesh_create(f.context, &leaf, &mesh), CSM_ERROR_INVALID_VALUE);
  leaf = leaf_info(&f, 0.5f), leaf.alpha_mask ^= 1ull << 33;
  expect(&f, csm_mesh_create(f.context, &leaf, &mesh), CSM_ERROR_INVALID_HANDLE);

  expect(&f, csm_mesh_destroy(f.context, f.alpha_mask), CSM_ERROR_INVALID_HANDLE); /* of the other kind */
  expect(&f, csm_alpha_mask_destroy(f.context, f.leaf), CSM_ERROR_INVALID_HANDLE);
  assert_int_equal(csm_mesh_destroy(f.context, f.leaf), CSM_SUCCESS);
  assert_int_equal(csm_alpha_mask_destroy(f.context, f.alpha_mask), CSM_SUCCESS);
  expect(&f, csm_alpha_mask_destroy(f.context, f.alpha_mask), CSM_ERROR_INVALID_HANDLE);
  support_close(f.context, &f.record);
}

static void a_switch_keeps_the_holes(void **state) {
  (void)state;
  fixture f;
  csm_instance instances[2];
  open_fixture(&f, CSM_WRAP_MIRROR, CSM_WRAP_CLAMP, 0.5f);
  draw(&f, instances, false);
  csm_create_info info = support_create_info(&f.record);
  info.backend = !strcmp(support_backend(), "vulkan") ? "d3d12" : "vulkan";
  assert_int_equal(csm_switch_backend(f.context, &info), CSM_SUCCESS);
  draw(&f, instances, false);
  float *map = support_map(f.context, f.cascades, 0, resolution);
  check_map(&f, map, CSM_WRAP_MIRROR, CSM_WRAP_CLAMP, 0.5);
  free(map);
  support_close(f.context, &f.record);
}

/* Each alpha-tested mesh has bindings of its own: thousands of them can be there, and can come again. */
static void many_meshes_may_be_cut_out(void **state) {
  (void)state;
  enum { MESHES = 3000 };
  static csm_mesh meshes[MESHES];
  fixture f;
  open_fixture(&f, 0, 0, 0.5f);
  const csm_mesh_info leaf = leaf_info(&f, 0.5f);
  for (int round = 0; round < 2; ++round) {
    for (int i = 0; i < MESHES; ++i)
      assert_int_equal(csm_mesh_create(f.context, &leaf, &meshes[i]), CSM_SUCCESS);
    for (int i = 0; i < MESHES; ++i)
      assert_int_equal(csm_mesh_destroy(f.context, meshes[i]), CSM_SUCCESS);
  }
  support_close(f.context, &f.record);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(casters_are_cut_out),        cmocka_unit_test(the_camera_sees_through),
      cmocka_unit_test(many_meshes_may_be_cut_out), cmocka_unit_test(misuse_is_named),
      cmocka_unit_test(a_switch_keeps_the_holes),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
