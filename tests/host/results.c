/* What csm-host writes, and what it calls equal. */
#include "base/statistics.h"
#include "stage/compare.h"
#include "stage/dump.h"
#include "support.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <cmocka.h>

/* ---- what is written ---- */

static void pfm_has_the_bottom_row_first(void **state) {
  (void)state;
  const float values[6] = {1, 2, 3, 4, 5, 6};
  const float expected[6] = {4, 5, 6, 1, 2, 3};
  static const char header[] = "Pf\n3 2\n-1.0\n";
  char path[64];
  size_t size;
  make_path(path, ".pfm");
  assert_int_equal(dump_pfm(values, 3, 2, path), 0);
  uint8_t *bytes = read_bytes(path, &size);
  assert_int_equal(size, sizeof header - 1 + sizeof values);
  assert_memory_equal(bytes, header, sizeof header - 1);
  assert_memory_equal(bytes + sizeof header - 1, expected, sizeof expected);
  free(bytes);
  unlink(path);
}

static void ply_holds_the_world(void **state) {
  (void)state;
  char path[64], ply[64];
  size_t size;
  scene s;
  make_path(path, ".gltf");
  make_path(ply, ".ply");
  write_text(path, triangle_gltf);
  assert_int_equal(scene_load(&s, path), 0);
  assert_int_equal(dump_ply(&s, ply), 0);
  uint8_t *bytes = read_bytes(ply, &size);
  const char *end = strstr((const char *)bytes, "end_header\n");
  assert_non_null(end);
  const uint8_t *body = (const uint8_t *)end + strlen("end_header\n");
  assert_int_equal(size - (size_t)(body - bytes), 3 * 24 + 14);
  double corners[9];
  memcpy(corners, body, sizeof corners);
  const double first[3] = {2, 3, 4};
  assert_memory_equal(corners, first, sizeof first);
  assert_int_equal(body[72], 3);
  free(bytes);
  scene_free(&s);
  unlink(path);
  unlink(ply);
}

/* ---- what is called equal ---- */

static void ulps_are_counted(void **state) {
  (void)state;
  const float a[4] = {0.5f, 0.0f, 1.0f, 0.25f};
  float b[4] = {0.5f, 0.0f, 1.0f, 0.25f};
  assert_int_equal(compare_depths(a, b, 4).differing, 0);
  b[0] = nextafterf(0.5f, 1.0f);
  b[2] = nextafterf(nextafterf(1.0f, 0.0f), 0.0f);
  const depth_difference difference = compare_depths(a, b, 4);
  assert_int_equal(difference.differing, 2);
  assert_int_equal(difference.max_ulp, 2);
}

typedef struct twin {
  host_setup setup;
  stage stages[2];
  stage_frame frames[2];
  float cascade_constants[2][4], setting_constants[2][4];
  float maps[2][16 * 16], masks[2][200 * 100], depths[2][200 * 100];
} twin;

static twin *make_twin(void) {
  twin *t = calloc(1, sizeof *t);
  t->setup.width = 200;
  t->setup.height = 100;
  for (int i = 0; i < 2; i++) {
    t->stages[i].setup = &t->setup;
    t->frames[i].binding.cascade_count = 1;
    t->frames[i].binding.resolutions[0] = 16;
    t->frames[i].binding.cascade_constants = t->cascade_constants[i];
    t->frames[i].binding.cascade_constants_size = sizeof t->cascade_constants[i];
    t->frames[i].binding.setting_constants = t->setting_constants[i];
    t->frames[i].binding.setting_constants_size = sizeof t->setting_constants[i];
    t->frames[i].maps[0] = t->maps[i];
    t->frames[i].mask = t->masks[i];
    t->frames[i].camera_depth = t->depths[i];
  }
  return t;
}

static agreement compare_twin(const twin *t) {
  agreement result;
  compare_frames(&result, &t->stages[0], &t->frames[0], &t->stages[1], &t->frames[1]);
  return result;
}

static void agreement_keeps_to_the_contract(void **state) {
  (void)state;
  twin *t = make_twin();
  assert_true(compare_twin(t).agrees);

  t->masks[1][0] = t->masks[1][1] = 1.0f; /* 2 of 20,000 are 0.01 % */
  t->masks[1][2] = 1.0f / 255.0f;
  assert_true(compare_twin(t).agrees);
  t->masks[1][3] = 2.0f / 255.0f;
  assert_false(compare_twin(t).agrees);
  assert_int_equal(compare_twin(t).mask_beyond, 3);
  t->masks[1][3] = 0.0f;

  t->maps[1][5] = nextafterf(0.0f, 1.0f);
  assert_false(compare_twin(t).agrees); /* one device: the same bits */
  snprintf(t->stages[1].device, sizeof t->stages[1].device, "another");
  assert_true(compare_twin(t).agrees);
  t->maps[1][5] = 1e-3f;
  assert_false(compare_twin(t).agrees);
  t->maps[1][5] = 0.0f;

  t->frames[1].stats.maps.plan_hash = 1;
  assert_false(compare_twin(t).agrees);
  t->frames[1].stats.maps.plan_hash = 0;
  t->cascade_constants[1][3] = 1e-30f;
  assert_false(compare_twin(t).agrees);
  t->cascade_constants[1][3] = 0.0f;
  t->setting_constants[1][0] = -0.0f;
  assert_false(compare_twin(t).agrees);
  t->setting_constants[1][0] = 0.0f;
  t->frames[1].binding.cascades[0].texel_size = 1e-300;
  assert_false(compare_twin(t).agrees);
  free(t);
}

/* The interval of 31 samples is that of the sign test: the 10th to the 22nd. */
static void medians_have_intervals(void **state) {
  (void)state;
  double samples[31];
  for (int i = 0; i < 31; i++)
    samples[i] = (i * 7) % 31 + 1;
  const estimate result = estimate_median(samples, 31);
  assert_true(result.median == 16.0 && result.low == 10.0 && result.high == 22.0);
  double few[2] = {3.0, 1.0};
  const estimate two = estimate_median(few, 2);
  assert_true(two.median == 2.0 && two.low == 1.0 && two.high == 3.0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(pfm_has_the_bottom_row_first),
      cmocka_unit_test(ply_holds_the_world),
      cmocka_unit_test(ulps_are_counted),
      cmocka_unit_test(agreement_keeps_to_the_contract),
      cmocka_unit_test(medians_have_intervals),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
