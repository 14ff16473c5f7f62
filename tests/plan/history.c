/* From a picture to the one before it: places, spans, planes and normals, against cameras and rays in doubles. */
#include "support.h"

#include "csm_history.h"
#include <math.h>
#include <string.h>

enum { pixels_wide = 640, pixels_high = 360, settings = 7 };

/* A camera, the one before it, and the constants. */
typedef struct passage_case {
  plan_frame frame;
  test_camera now_camera, past_camera;
  plan_past now, past;
  float rows[CSM_H_COUNT * 4];
} passage_case;

static plan_camera made_of(const test_camera *camera) {
  double view[16], projection[16];
  plan_camera made;
  const char *error = "";
  camera_matrices(camera, view, projection);
  assert_int_equal(plan_camera_make(&made, view, projection, camera_reversed(camera), &error), CSM_SUCCESS);
  return made;
}

static csm_config configured(void) {
  csm_config config = default_config();
  config.history = CSM_HISTORY_ON;
  config.history_frames = 8;
  config.history_depth = 0.02;
  config.history_normal_deg = 20.0;
  return config;
}

/* Moderate cameras a step apart, at either end of the world. */
static void make_case(passage_case *c, random_state *random, double world, bool normals) {
  const csm_config config = configured();
  double ahead[3];
  do
    c->now_camera = random_camera(random, world);
  while (c->now_camera.half_width > 3.0 * (c->now_camera.orthographic ? 50.0 : 1.0));
  c->now_camera.near = c->now_camera.orthographic ? -200.0 : 0.1;
  c->now_camera.far = 1000.0;
  c->now_camera.center[0] = c->now_camera.center[1] = 0.0;
  c->past_camera = c->now_camera;
  for (int k = 0; k < 3; ++k) {
    ahead[k] = c->now_camera.forward[k] + random_between(random, -0.05, 0.05);
    c->past_camera.eye[k] += random_between(random, -0.5, 0.5);
  }
  const double length = sqrt(ahead[0] * ahead[0] + ahead[1] * ahead[1] + ahead[2] * ahead[2]);
  for (int k = 0; k < 3; ++k)
    ahead[k] /= length;
  camera_look(&c->past_camera, ahead, 0.3);
  c->past_camera.center[0] = random_between(random, -1.0, 1.0) / pixels_wide; /* jittered by half a pixel */
  c->past_camera.half_height *= 1.01;                                         /* and zooming */
  c->frame = plan_empty(&config, &c->now_camera, (double[]){0.3, -1.0, 0.2});
  c->now = (plan_past){made_of(&c->now_camera), pixels_wide, pixels_high, c->frame.shadow_end, settings, 0};
  c->past = (plan_past){made_of(&c->past_camera), pixels_wide, pixels_high, c->frame.shadow_end, settings, 0};
  const uint32_t bytes =
      plan_write_history_constants(c->rows, &c->frame, &(plan_picture){.normals = normals, .unorm_normals = normals},
                                   &(plan_passage){.past = &c->past, .now = &c->now}, &config);
  assert_int_equal(bytes, sizeof c->rows);
}

/* A row times (x, y, depth, 1), and how far rounding of its floats may carry it. */
static double row_times(const float *row, const double place[3], double *rounding) {
  double sum = (double)row[3], size = fabs((double)row[3]);
  for (int k = 0; k < 3; ++k) {
    sum += (double)row[k] * place[k];
    size += fabs((double)row[k] * place[k]);
  }
  *rounding = size * 0x1p-23;
  return sum;
}

static double dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static double depth_of(const test_camera *camera, const double point[3]) {
  const double away[3] = {point[0] - camera->eye[0], point[1] - camera->eye[1], point[2] - camera->eye[2]};
  return dot(away, camera->forward);
}

/* Where a camera sees a point: x and y in pixels, and the depth in its buffer. */
static void place_of(const test_camera *camera, const double point[3], double out[3]) {
  const double away[3] = {point[0] - camera->eye[0], point[1] - camera->eye[1], point[2] - camera->eye[2]};
  const double depth = dot(away, camera->forward), scale = camera->orthographic ? 1.0 : 1.0 / depth;
  const double x = camera->center[0] + dot(away, camera->right) * scale / camera->half_width;
  const double y = camera->center[1] + dot(away, camera->up) * scale / camera->half_height;
  const double n = camera->near, f = camera->far;
  const double share = camera->orthographic ? (depth - n) / (f - n) : f / (f - n) * (1.0 - n / depth);
  out[0] = (x + 1.0) * 0.5 * pixels_wide;
  out[1] = (1.0 - y) * 0.5 * pixels_high;
  out[2] = camera->reversed ? 1.0 - share : share;
}

/* The point of a plane that a camera sees at a pixel. */
static void point_at(const test_camera *camera, const double pixel[2], const double on[3], const double normal[3],
                     double out[3]) {
  double near[3], far[3];
  const double x = 2.0 * pixel[0] / pixels_wide - 1.0, y = 1.0 - 2.0 * pixel[1] / pixels_high;
  camera_point(camera, x, y, 1.0, near);
  camera_point(camera, x, y, 2.0, far);
  const double way[3] = {far[0] - near[0], far[1] - near[1], far[2] - near[2]};
  const double away[3] = {on[0] - near[0], on[1] - near[1], on[2] - near[2]};
  const double t = dot(away, normal) / dot(way, normal);
  for (int k = 0; k < 3; ++k)
    out[k] = near[k] + t * way[k];
}

/* The span's scale is a power of two, so that nothing is lost by it. */
static double span_at(const passage_case *c, double depth) {
  int exponent;
  const bool linear = c->now_camera.orthographic;
  (void)frexp(linear ? c->now_camera.half_height : c->frame.shadow_end, &exponent);
  return linear ? depth * ldexp(1.0, -exponent) : ldexp(1.0, exponent) / depth;
}

static double span_of_past(const passage_case *c, double depth) {
  int exponent;
  (void)frexp(c->past_camera.half_height, &exponent);
  return c->past_camera.orthographic ? depth * ldexp(1.0, -exponent) : span_at(c, depth);
}

static void a_point_is_found_where_it_was(void **state) {
  (void)state;
  random_state random = {1};
  for (int i = 0; i < 4000; ++i) {
    passage_case c;
    const double world = i % 2 ? 1e6 : 10.0;
    make_case(&c, &random, world, false);
    double point[3], now[3], past[3], rounding[5], row[5];
    camera_point(&c.now_camera, random_between(&random, -1.0, 1.0), random_between(&random, -1.0, 1.0),
                 random_scale(&random, 2.0, 300.0), point);
    place_of(&c.now_camera, point, now);
    place_of(&c.past_camera, point, past);
    if (!c.past_camera.orthographic && depth_of(&c.past_camera, point) < 0.5)
      continue;
    for (uint32_t k = 0; k < 4; ++k)
      row[k] = row_times(&c.rows[(CSM_H_PLACE + k) * 4], now, &rounding[k]);
    row[4] = row_times(&c.rows[CSM_H_OWN * 4], now, &rounding[4]);
    const double inverse = 1.0 / row[3], loss = rounding[3] * fabs(inverse) + 1e-15 * world;
    assert_true(row[3] > 0.0);
    for (int k = 0; k < 2; ++k)
      assert_near(row[k] * inverse, past[k],
                  rounding[k] * fabs(inverse) + fabs(past[k]) * loss + 1e-13 * world * pixels_wide);
    const double span = span_of_past(&c, depth_of(&c.past_camera, point));
    assert_near(row[2] * inverse, span, rounding[2] * fabs(inverse) + fabs(span) * (loss + 1e-13 * world));
    const double own = span_at(&c, depth_of(&c.now_camera, point));
    assert_near(row[4], own, rounding[4] + fabs(own) * 1e-13 * world);
  }
}

/* The span around the place where a plane was, and its normal. */
static void a_plane_lies_there_as_it_did(void **state) {
  (void)state;
  random_state random = {2};
  uint32_t compared = 0;
  for (int i = 0; i < 4000; ++i) {
    passage_case c;
    make_case(&c, &random, 100.0, false);
    double point[3], normal[3], now[3], past[3], next[2][3];
    random_unit(&random, normal);
    camera_point(&c.now_camera, random_between(&random, -0.9, 0.9), random_between(&random, -0.9, 0.9),
                 random_scale(&random, 2.0, 100.0), point);
    double way[3] = {point[0] - c.now_camera.eye[0], point[1] - c.now_camera.eye[1], point[2] - c.now_camera.eye[2]};
    if (c.now_camera.orthographic)
      memcpy(way, c.now_camera.forward, sizeof way);
    const double cosine = -dot(normal, way) / sqrt(dot(way, way));
    if (fabs(cosine) < 0.3)
      continue; /* seen so flatly, the pixels around may lie behind the camera */
    place_of(&c.now_camera, point, now);
    place_of(&c.past_camera, point, past);
    for (int k = 0; k < 2; ++k) {
      double there[3];
      point_at(&c.now_camera, (const double[2]){now[0] + (k == 0), now[1] + (k == 1)}, point, normal, there);
      place_of(&c.now_camera, there, next[k]);
    }
    const double steps[2] = {next[0][2] - now[2], next[1][2] - now[2]};
    /* A plane on screen is (step right, step down, -1, depth at pixel 0) */
    const double origin = now[2] - steps[0] * now[0] - steps[1] * now[1];
    double plane[3], found[3];
    for (uint32_t k = 0; k < 3; ++k) {
      const float *p = &c.rows[(CSM_H_PLANE + k) * 4], *n = &c.rows[(CSM_H_NORMAL + k) * 4];
      plane[k] = steps[0] * (double)p[0] + steps[1] * (double)p[1] + origin * (double)p[3] - (double)p[2];
      found[k] = steps[0] * (double)n[0] + steps[1] * (double)n[1] + origin * (double)n[3] - (double)n[2];
    }
    double there[3];
    const double pixel[2] = {past[0] + 1.5, past[1] - 0.5};
    point_at(&c.past_camera, pixel, point, normal, there);
    const double before = span_of_past(&c, depth_of(&c.past_camera, point));
    const double expected = span_of_past(&c, depth_of(&c.past_camera, there));
    assert_near(before - (1.5 * plane[0] - 0.5 * plane[1]) / plane[2], expected,
                1e-3 * fabs(expected - before) + 1e-4 * fabs(before));
    const double length = sqrt(dot(found, found)), side = cosine > 0.0 ? 1.0 : -1.0;
    assert_true(side * dot(found, normal) > 0.999 * length);
    ++compared;
  }
  assert_true(compared > 1000);
}

static void an_engines_normals_are_the_worlds(void **state) {
  (void)state;
  random_state random = {3};
  passage_case c;
  make_case(&c, &random, 10.0, true);
  for (uint32_t k = 0; k < 3; ++k)
    for (uint32_t i = 0; i < 4; ++i)
      assert_true(c.rows[(CSM_H_NORMAL + k) * 4 + i] == (i == 3 ? -1.0f : i == k ? 2.0f : 0.0f));
}

static void only_the_same_picture_goes_on(void **state) {
  (void)state;
  random_state random = {4};
  passage_case c;
  do
    make_case(&c, &random, 10.0, false);
  while (c.now_camera.orthographic);
  assert_true(plan_past_counts(&c.past, &c.now));
  const plan_past none = {0};
  plan_past other = c.past;
  assert_false(plan_past_counts(&none, &c.now));
  other.settings = settings + 1;
  assert_false(plan_past_counts(&other, &c.now));
  other = c.past;
  other.width -= 1;
  assert_false(plan_past_counts(&other, &c.now));
  other = c.past;
  other.height += 1;
  assert_false(plan_past_counts(&other, &c.now));
  other = c.past;
  other.camera.orthographic = true;
  assert_false(plan_past_counts(&other, &c.now));
}

/* However many frames lie in a row: each part of the circle gets its share of them. */
static void phases_are_even(void **state) {
  (void)state;
  assert_true(plan_history_phase(0) == 0.0);
  for (uint32_t count = 1; count <= 64; count *= 2)
    for (uint32_t first = 0; first < 200; ++first) {
      uint64_t taken = 0;
      for (uint32_t k = 0; k < count; ++k) {
        const double phase = plan_history_phase(first + k);
        assert_true(phase >= 0.0 && phase < 1.0);
        taken |= (uint64_t)1 << (uint32_t)(phase * count);
      }
      assert_true(taken == (count == 64 ? UINT64_MAX : ((uint64_t)1 << count) - 1));
    }
}

/* Of 8 to 64 frames in a row, each half of a texel along either axis gets its share but for three at most. */
static void jitters_are_even(void **state) {
  (void)state;
  for (uint32_t count = 8; count <= 64; count *= 2)
    for (uint32_t first = 0; first < 200; ++first) {
      uint32_t below[2] = {0, 0};
      for (uint32_t k = 0; k < count; ++k) {
        double at[2];
        plan_history_jitter(at, first + k);
        for (int axis = 0; axis < 2; ++axis) {
          assert_true(at[axis] >= -0.5 && at[axis] < 0.5);
          below[axis] += at[axis] < 0.0;
        }
      }
      for (int axis = 0; axis < 2; ++axis)
        assert_true(below[axis] + 3 >= count / 2 && below[axis] <= count / 2 + 3);
    }
}

/* Noise is at most that of so many comparisons; without a pattern or jitter there is none. */
static void noise_falls_with_taps(void **state) {
  (void)state;
  random_state random = {5};
  passage_case c;
  make_case(&c, &random, 10.0, false);
  static const struct {
    uint32_t filter, taps, jitter;
    double noise;
  } rows[] = {{CSM_FILTER_PCF_3X3, 1, 0, 0.0},
              {CSM_FILTER_PCSS, 1, 0, 0.5},
              {CSM_FILTER_PCSS, 16, 0, 0.125},
              {CSM_FILTER_POISSON, 1, 0, 0.125}};
  for (size_t i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
    csm_config config = configured();
    config.filter = rows[i].filter;
    config.soft_taps = rows[i].taps;
    config.soft_search_taps = 16;
    plan_write_history_constants(c.rows, &c.frame, &(plan_picture){.show = CSM_SHOW_VISIBILITY},
                                 &(plan_passage){.past = &c.past, .now = &c.now}, &config);
    assert_true(c.rows[CSM_H_NOISE * 4] == (float)rows[i].noise);
  }
  csm_config config = configured();
  config.filter = CSM_FILTER_PCF_3X3;
  config.history_jitter = 1;
  plan_write_history_constants(c.rows, &c.frame, &(plan_picture){.show = CSM_SHOW_VISIBILITY},
                               &(plan_passage){.past = &c.past, .now = &c.now}, &config);
  assert_true(c.rows[CSM_H_NOISE * 4] > 0.0f && c.rows[CSM_H_NOISE * 4] < 0.5f);
}

/* Shadows rest where as much has changed now as then, and that is known. */
static void rest_is_told(void **state) {
  (void)state;
  random_state random = {6};
  passage_case c;
  make_case(&c, &random, 10.0, false);
  const csm_config config = configured();
  static const uint64_t changes[][3] = {{0, 0, 0}, {3, 3, 1}, {3, 4, 0}};
  for (size_t i = 0; i < sizeof changes / sizeof changes[0]; ++i) {
    c.past.changes = changes[i][0];
    c.now.changes = changes[i][1];
    plan_write_history_constants(c.rows, &c.frame, &(plan_picture){.show = CSM_SHOW_VISIBILITY},
                                 &(plan_passage){.past = &c.past, .now = &c.now}, &config);
    assert_true(c.rows[CSM_H_CLEAR * 4 + 2] == (float)changes[i][2]);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_point_is_found_where_it_was),
      cmocka_unit_test(a_plane_lies_there_as_it_did),
      cmocka_unit_test(an_engines_normals_are_the_worlds),
      cmocka_unit_test(only_the_same_picture_goes_on),
      cmocka_unit_test(phases_are_even),
      cmocka_unit_test(jitters_are_even),
      cmocka_unit_test(noise_falls_with_taps),
      cmocka_unit_test(rest_is_told),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
