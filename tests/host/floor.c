/* The bare loop that bench compares csm with draws the same maps, to the bit. */
#include "base/host.h"
#include "bench/floor.h"
#include "bench/scene_plan.h"
#include "stage/stage.h"
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

enum { side = 512 };

/* Texels of all maps that differ; *drawn gets how many hold a caster. */
static size_t count_differing(floor_loop *loop, stage *s, size_t *drawn) {
  const size_t texels = (size_t)side * side;
  float *bare = host_allocate(texels, sizeof *bare);
  stage_frame frame;
  stage_stats stats;
  size_t differing = 0;
  assert_true(floor_frame(loop) >= 0.0);
  assert_int_equal(stage_draw(s, &stats), 0);
  assert_int_equal(stage_read(s, true, &frame), 0);
  for (uint32_t k = 0; k < frame.binding.cascade_count; k++) {
    assert_true(floor_read(loop, k, bare));
    for (size_t i = 0; i < texels; i++) {
      differing += memcmp(&bare[i], &frame.maps[k][i], sizeof bare[i]) != 0;
      *drawn += bare[i] < 1.0f;
    }
  }
  stage_frame_free(&frame);
  free(bare);
  return differing;
}

/* A large leaf over the town, which an alpha mask cuts out, and a mirrored instance of the town's first mesh. */
static void add_difficulties(scene *s) {
  static const float corners[] = {-40, 30, -40, -40, 30, 40, 40, 30, 40, 40, 35, -40}, uvs[] = {0, 0, 0, 3, 3, 3, 3, 0};
  static const uint16_t indices[] = {0, 1, 2, 0, 2, 3};
  enum { texels = 16 * 16 };
  scene_material leaf = {.alpha_tested = true, .alpha_mask = {.width = 16, .height = 16, .cutoff = 0.5}};
  leaf.alpha_mask.alpha = host_allocate(texels, 1);
  for (uint32_t i = 0; i < texels; i++)
    leaf.alpha_mask.alpha[i] = (uint8_t)(i * 2654435761u >> 24);
  scene_mesh mesh = {.material = scene_add_material(s, &leaf), .vertex_count = 4, .index_count = 6, .index_size = 2};
  mesh.positions = memcpy(host_allocate(1, sizeof corners), corners, sizeof corners);
  mesh.uvs = memcpy(host_allocate(1, sizeof uvs), uvs, sizeof uvs);
  mesh.indices = memcpy(host_allocate(1, sizeof indices), indices, sizeof indices);
  const double here[16] = {[0] = 1, [5] = 1, [10] = 1, [15] = 1},
               mirrored[16] = {[0] = -1, [5] = 1, [10] = 1, [15] = 1};
  scene_add_instance(s, scene_add_mesh(s, &mesh), here);
  scene_add_instance(s, s->instances[0].mesh, mirrored);
}

static void the_maps_are_the_same(void **state) {
  (void)state;
  host_options options;
  host_setup setup;
  bench_plan plan;
  stage s;
  floor_loop *loop = NULL;
  char error[512] = "", *words[] = {"csm-host", "bench", "--scene", "town", "--size", "64x64"};
  assert_int_equal(options_parse(&options, sizeof words / sizeof words[0], words), 0);
  assert_int_equal(setup_load(&setup, &options), 0);
  setup.config.resolution = side;
  add_difficulties(&setup.scene);
  assert_int_equal(bench_plan_make(&plan, &setup, (uint32_t)setup.scene.instance_count), 0);
  assert_int_equal(stage_open(&s, "vulkan", NULL), 0);
  assert_int_equal(stage_load(&s, &setup), 0);
  const floor_info info = {.scene = &setup.scene, .frame = &plan.frame, .plan_scene = &plan.scene, .resolution = side};
  assert_int_equal(floor_open(&loop, &info, error, sizeof error), 0);
  size_t drawn = 0;
  const size_t differing = count_differing(loop, &s, &drawn);
  assert_int_equal(differing, 0);
  assert_true(drawn > side * side / 10);
  floor_close(loop);
  stage_close(&s);
  bench_plan_free(&plan);
  setup_free(&setup);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(the_maps_are_the_same)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
