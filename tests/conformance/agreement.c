/* agreement.c: two backends draw the same random scenes: plans and maps equal in every bit, masks as design says. */
#include "sides.h"

#include <string.h>

enum { width = 320, height = 200, boxes = 300, scenes = 24 };

/* Numbers that are the same on every machine and run. */
static double uniform(uint64_t *state, double low, double high) {
  *state = *state * 6364136223846793005ull + 1442695040888963407ull;
  return low + (high - low) * (double)(*state >> 11) / (double)(1ull << 53);
}

/* A box of any orientation, size and shear, in a flat landscape about `centre`. */
static void random_transform(uint64_t *state, const double centre[3], double out[16]) {
  for (int i = 0; i < 12; ++i)
    out[i] = i % 4 == 3 ? 0 : uniform(state, -1.5, 1.5);
  for (int i = 0; i < 3; ++i)
    out[i * 5] += out[i * 5] < 0 ? -0.5 : 0.5;
  out[12] = centre[0] + uniform(state, -60, 60);
  out[13] = centre[1] + uniform(state, 0, 12);
  out[14] = centre[2] + uniform(state, -60, 60);
  out[15] = 1;
}

typedef struct random_scene {
  csm_config config;
  shot shot;
  uint32_t shape[boxes + 1];
  double transforms[boxes + 1][16];
} random_scene;

static void make_scene(random_scene *out, uint64_t seed) {
  uint64_t state = seed * 7919 + 1;
  const double away = seed % 3 == 2 ? 1e6 : 0;
  const double centre[3] = {away, 0, -away / 3};
  out->config = (csm_config){.struct_size = sizeof out->config};
  assert_int_equal(csm_config_default(&out->config), CSM_SUCCESS);
  out->config.cascade_count = 1 + (uint32_t)(seed % 8);
  out->config.resolution = (const uint32_t[]){256, 333, 512, 1024}[seed % 4];
  out->config.filter = seed % 5 == 4 ? CSM_FILTER_EXACT : (uint32_t)(seed / 2 % 2);
  out->config.shadow_distance = uniform(&state, 40, 160);
  out->config.bias_normal_texels = seed % 5 == 4 ? 1.5 : 0;
  out->shot = shot_make(NULL, 0);
  for (int i = 0; i < 3; ++i)
    out->shot.light.direction[i] = uniform(&state, -1, i == 1 ? -0.1 : 1);
  const double eye[3] = {centre[0] + uniform(&state, -30, 30), centre[1] + uniform(&state, 2, 25),
                         centre[2] + uniform(&state, -30, 30)};
  const double target[3] = {centre[0], centre[1] + 2, centre[2] + 0.5};
  support_look_at(out->shot.camera.view, eye, target);
  support_perspective(out->shot.camera.projection, uniform(&state, 25, 90), (double)width / height, 0.2,
                      seed % 2 ? 0 : 400);
  for (uint32_t i = 0; i <= boxes; ++i) {
    out->shape[i] = i < boxes;
    random_transform(&state, centre, out->transforms[i]);
  }
  const double ground[16] = {80, 0, 0, 0, 0, 1, 0, 0, 0, 0, 80, 0, centre[0], centre[1], centre[2], 1};
  memcpy(out->transforms[boxes], ground, sizeof ground);
}

static shot place(const side *side, const random_scene *scene, csm_instance instances[boxes + 1]) {
  shot shot = scene->shot;
  for (uint32_t i = 0; i <= boxes; ++i) {
    instances[i] = support_instance(side->meshes[scene->shape[i]], 0, 0, 0, 1, 1, 1);
    memcpy(instances[i].transform, scene->transforms[i], sizeof scene->transforms[i]);
  }
  shot.frame.instances = instances;
  shot.frame.instance_count = boxes + 1;
  return shot;
}

static void draw(side *side, const random_scene *scene) {
  csm_instance instances[boxes + 1];
  shot shot = place(side, scene, instances);
  assert_int_equal(csm_cascades_create(side->context, &scene->config, &side->cascades), CSM_SUCCESS);
  assert_int_equal(csm_render_cascades(side->cascades, shot_frame(&shot)), CSM_SUCCESS);
}

static void resolve(side *side, const random_scene *scene, uint32_t show) {
  csm_instance instances[boxes + 1];
  shot shot = place(side, scene, instances);
  const csm_mask_info mask = {
      .struct_size = sizeof mask, .frame = shot_frame(&shot), .width = width, .height = height, .show = show};
  assert_int_equal(csm_resolve_mask(side->view, side->cascades, &mask), CSM_SUCCESS);
}

static void backends_agree(void **state) {
  (void)state;
  side a, b;
  side_open(&a, "vulkan");
  side_open(&b, "d3d12");
  for (uint64_t seed = 0; seed < scenes; ++seed) {
    random_scene scene;
    make_scene(&scene, seed);
    draw(&a, &scene);
    draw(&b, &scene);
    resolve(&a, &scene, CSM_SHOW_VISIBILITY);
    resolve(&b, &scene, CSM_SHOW_VISIBILITY);
    sides_same_plan(&a, &b);
    sides_same_images(&a, &b, &scene.config, width, height);
    for (uint32_t show = CSM_SHOW_CASCADE; show <= CSM_SHOW_DENSITY; ++show) {
      resolve(&a, &scene, show);
      resolve(&b, &scene, show);
      const sides_image mask = {CSM_READ_MASK, 0, width, height};
      assert_int_equal(sides_compare(&a, &b, &mask, 0).texels, 0);
    }
    assert_int_equal(csm_cascades_destroy(a.cascades), CSM_SUCCESS);
    assert_int_equal(csm_cascades_destroy(b.cascades), CSM_SUCCESS);
  }
  side_close(&a);
  side_close(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(backends_agree)};
  return cmocka_run_group_tests_name("agreement", tests, NULL, NULL);
}
