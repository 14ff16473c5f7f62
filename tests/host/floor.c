/* The bare loop that bench compares csm with draws the same maps, to the bit, and, where it is told to, their moments. */
#include "base/host.h"
#include "bench/floor.h"
#include "bench/scene_plan.h"
#include "bench/shaders/drawn_moments.h"
#include "stage/stage.h"
#include <float.h>
#include <math.h>
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

typedef struct floor_test {
  host_options options;
  host_setup setup;
  bench_plan plan;
  floor_loop *loop;
} floor_test;

static void open_test(floor_test *t, floor_moments moments) {
  char error[512] = "", *words[] = {"csm-host", "bench", "--scene", "town", "--size", "64x64"};
  assert_int_equal(options_parse(&t->options, sizeof words / sizeof words[0], words), 0);
  assert_int_equal(setup_load(&t->setup, &t->options), 0);
  t->setup.config.resolution = side;
  add_difficulties(&t->setup.scene);
  assert_int_equal(bench_plan_make(&t->plan, &t->setup, (uint32_t)t->setup.scene.instance_count), 0);
  const floor_info info = {.scene = &t->setup.scene,
                           .frame = &t->plan.frame,
                           .plan_scene = &t->plan.scene,
                           .resolution = side,
                           .moments = moments};
  assert_int_equal(floor_open(&t->loop, &info, error, sizeof error), 0);
}

static void close_test(floor_test *t) {
  floor_close(t->loop);
  bench_plan_free(&t->plan);
  setup_free(&t->setup);
}

static void the_maps_are_the_same(void **state) {
  (void)state;
  floor_test t;
  stage s;
  open_test(&t, FLOOR_DEPTH);
  assert_int_equal(stage_open(&s, "vulkan", NULL), 0);
  assert_int_equal(stage_load(&s, &t.setup), 0);
  size_t drawn = 0;
  const size_t differing = count_differing(t.loop, &s, &drawn);
  assert_int_equal(differing, 0);
  assert_true(drawn > side * side / 10);
  stage_close(&s);
  close_test(&t);
}

/* What a depth's moments are, in doubles. */
static void moments_of(double out[4], float depth, floor_moments moments) {
  const double z = 2.0 * (double)depth - 1.0, grown = exp(DRAWN_EXPONENT * z),
               fallen = exp(-DRAWN_EXPONENT_NEGATIVE * z);
  if (moments == FLOOR_VSM)
    memcpy(out, (const double[4]){z, z * z}, sizeof(double[4]));
  else
    memcpy(out, (const double[4]){grown, grown * grown, -fallen, fallen * fallen}, sizeof(double[4]));
}

/* Every texel has the moments of its own depth, drawn or cleared. Vulkan lets exp(x) be off by 3 + 2 |x| units of the last
   place, and z by one, so a moment of exp(c z) by 3 + 2 c + c of them, and its square by twice that and its rounding. */
static void moments_are_those_of_the_depths(void **state) {
  (void)state;
  const size_t texels = (size_t)side * side;
  float *depths = host_allocate(texels, sizeof *depths), *read = host_allocate(texels * 4, sizeof *read);
  const struct {
    floor_moments moments;
    double share;
  } cases[] = {{FLOOR_VSM, 4.0 * FLT_EPSILON}, {FLOOR_EVSM4, (2.0 * (3.0 + 3.0 * DRAWN_EXPONENT) + 1.0) * FLT_EPSILON}};
  for (int i = 0; i < 2; i++) {
    floor_test t;
    size_t drawn = 0;
    open_test(&t, cases[i].moments);
    assert_true(floor_frame(t.loop) >= 0.0);
    for (uint32_t k = 0; k < t.setup.config.cascade_count; k++) {
      assert_true(floor_read(t.loop, k, depths) && floor_read_moments(t.loop, k, read));
      for (size_t at = 0; at < texels; at++) {
        double expected[4];
        moments_of(expected, depths[at], cases[i].moments);
        for (int m = 0; m < (int)cases[i].moments; m++) {
          const double scale = fmax(fabs(expected[m]), cases[i].moments == FLOOR_VSM ? 1.0 : 0.0);
          assert_true(fabs((double)read[at * cases[i].moments + m] - expected[m]) <= cases[i].share * scale);
        }
        drawn += depths[at] < 1.0f;
      }
    }
    assert_true(drawn > texels / 10);
    close_test(&t);
  }
  free(depths);
  free(read);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(the_maps_are_the_same),
                                     cmocka_unit_test(moments_are_those_of_the_depths)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
