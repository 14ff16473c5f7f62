/* The light over time: in steps, and carried on from the frame before. */
#include "support.h"

#include <math.h>
#include <string.h>

static double dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static double angle_between(const double a[3], const double b[3]) {
  const double cross[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  return atan2(sqrt(dot(cross, cross)), dot(a, b));
}

/* A light's basis does not depend on the fit, and this one is found the quickest. */
static csm_config light_config(void) {
  csm_config config = default_config();
  config.fit_mode = CSM_FIT_CASCADE;
  return config;
}

static plan_frame plan_after(const csm_config *config, const double light[3], const plan_history *before) {
  const test_camera camera = plain_camera();
  const plan_scene nothing = {0};
  double view[16], projection[16];
  const char *error = "";
  plan_frame frame;
  camera_matrices(&camera, view, projection);
  const plan_frame_info info = {
      .config = config, .view = view, .projection = projection, .light = light, .scene = &nothing, .before = before};
  if (plan_traced(&frame, &info, NULL, &error))
    fail_msg("%s", error);
  return frame;
}

/* Turned about a unit axis at right angles to it. */
static void turn(double out[3], const double v[3], const double axis[3], double angle) {
  for (int k = 0; k < 3; ++k) {
    const double across = axis[(k + 1) % 3] * v[(k + 2) % 3] - axis[(k + 2) % 3] * v[(k + 1) % 3];
    out[k] = cos(angle) * v[k] + sin(angle) * across;
  }
}

static void check_orthonormal(const double basis[9], double tolerance) {
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b)
      assert_near(dot(&basis[a * 3], &basis[b * 3]), a == b, tolerance);
    const int b = (a + 1) % 3, c = (a + 2) % 3; /* right = along x up */
    assert_near(basis[6 + b] * basis[3 + c] - basis[6 + c] * basis[3 + b], basis[a], tolerance);
  }
}

static void a_step_holds_the_light(void **state) {
  (void)state;
  random_state random = {1};
  for (int i = 0; i < 3000; ++i) {
    csm_config config = light_config();
    config.light_roll = (uint32_t)i % 2;
    config.light_step_texels = random_scale(&random, 4.0, 16.0);
    const double step = config.light_step_texels / config.resolution;
    double first[3], frame_axes[9], moved[3];
    const char *error = "";
    random_unit(&random, first);
    assert_int_equal(plan_light_basis(frame_axes, first, &error), CSM_SUCCESS);
    const plan_frame then = plan_after(&config, first, NULL);
    turn(moved, &then.basis[6], frame_axes, step * random_between(&random, 0.0, 0.999));
    const plan_frame held = plan_after(&config, moved, &then.history);
    assert_memory_equal(held.basis, then.basis, sizeof then.basis);
    assert_memory_equal(held.history.basis, then.basis, sizeof then.basis);

    turn(moved, &then.basis[6], frame_axes, step * random_scale(&random, 1.001, 100.0));
    const plan_frame beyond = plan_after(&config, moved, &held.history);
    double exact[9];
    assert_int_equal(plan_light_basis(exact, moved, &error), CSM_SUCCESS);
    for (int k = 0; k < 3; ++k)
      assert_true(beyond.basis[6 + k] == exact[6 + k]);
    if (config.light_roll == CSM_LIGHT_ROLL_FIXED)
      assert_memory_equal(beyond.basis, exact, sizeof exact);
  }
}

/* A step's shift: what lies a map's width away moves by no more texels than configured, in no map. */
static void a_step_shifts_no_map_farther_than_it_says(void **state) {
  (void)state;
  csm_config config = light_config();
  config.light_step_texels = 2.0;
  config.resolution = 1024;
  config.resolutions[1] = 4096;
  config.resolutions[5] = 16384; /* of no cascade */
  const double first[3] = {0.3, -1.0, 0.2};
  const plan_frame then = plan_after(&config, first, NULL);
  double moved[3], held = 0.0;
  for (double texels = 0.05; texels < 40.0; texels += 0.05) {
    turn(moved, &then.basis[6], then.basis, texels / 4096.0);
    const plan_frame now = plan_after(&config, moved, &then.history);
    if (memcmp(now.basis, then.basis, sizeof then.basis) == 0)
      held = texels;
  }
  assert_near(held, 2.0, 0.06);
}

/* One that turns by less than can be seen in a frame: 7 * 4 / 255 texels, with the default filter of 2 texels' reach. */
static void a_short_step_leaves_a_slow_light_alone(void **state) {
  (void)state;
  const double first[3] = {0.3, -1.0, 0.2}, seen = 28.0 / 255.0;
  for (int i = 0; i < 4; ++i) {
    csm_config config = light_config();
    config.light_step_texels = i < 2 ? 1.0 : 20.0 * seen * 1.001;
    const plan_frame then = plan_after(&config, first, NULL);
    double moved[3];
    turn(moved, &then.basis[6], then.basis, (i % 2 ? 1.01 : 0.99) * seen / config.resolution);
    const plan_frame now = plan_after(&config, moved, &then.history);
    const bool rests = memcmp(now.basis, then.basis, sizeof then.basis) == 0;
    assert_true(rests == (i > 0));
    /* One that has come to rest stays as it was drawn, though it was fast before. */
    const plan_frame later = plan_after(&config, moved, &now.history);
    assert_memory_equal(later.basis, now.basis, sizeof now.basis);
  }
}

/* A light that creeps is drawn with directions a step apart, never more than one away from its own. */
static void a_creeping_light_is_followed(void **state) {
  (void)state;
  csm_config config = light_config();
  config.light_step_texels = 4.0;
  const double step = config.light_step_texels / config.resolution, axis[3] = {0.0, 0.0, 1.0};
  plan_history history = {0};
  uint32_t changes = 0;
  double last[3] = {0};
  for (int i = 0; i < 1000; ++i) {
    double light[3];
    turn(light, (double[]){1.0, 0.0, 0.0}, axis, i * step / 10.0);
    const plan_frame frame = plan_after(&config, light, &history);
    assert_true(angle_between(&frame.basis[6], light) <= step * (1.0 + 1e-9));
    changes += memcmp(last, &frame.basis[6], sizeof last) != 0;
    memcpy(last, &frame.basis[6], sizeof last);
    history = frame.history;
  }
  assert_in_range(changes, 90, 101);
}

/* Whole days and nights: up over the zenith or beside it, through the horizon, and back below. */
static void carried_maps_turn_no_more_than_their_light(void **state) {
  (void)state;
  csm_config config = light_config();
  config.light_roll = CSM_LIGHT_ROLL_CARRIED;
  random_state random = {2};
  for (int path = 0; path < 24; ++path) {
    /* Through both axes' poles, through the pole of the fixed basis and its opposite, and anywhere */
    double rise[3] = {1.0, 0.0, 0.0}, axis[3] = {0.0, 0.0, 1.0};
    if (path == 1)
      axis[1] = 1.0, axis[2] = 0.0;
    if (path >= 2) {
      double basis[9];
      const char *error = "";
      random_unit(&random, rise);
      if (path < 8)
        memcpy(rise, (double[]){0.4379, 0.6471, 0.6241}, sizeof rise);
      assert_int_equal(plan_light_basis(basis, rise, &error), CSM_SUCCESS);
      turn(axis, basis, &basis[6], random_between(&random, 0.0, 2.0 * M_PI));
      memcpy(rise, &basis[6], sizeof rise);
    }
    plan_history history = {0};
    plan_frame last = {0};
    double began[3] = {0};
    const int steps = path % 2 ? 1440 : 360;
    for (int i = 0; i <= 2 * steps; ++i) {
      double light[3];
      turn(light, rise, axis, i * 2.0 * M_PI / steps);
      const plan_frame frame = plan_after(&config, light, &history);
      check_orthonormal(frame.basis, 1e-12);
      if (i)
        for (int row = 0; row < 2; ++row)
          assert_true(angle_between(&frame.basis[row * 3], &last.basis[row * 3]) <=
                      angle_between(&frame.basis[6], &last.basis[6]) + 1e-12);
      else
        memcpy(began, frame.basis, sizeof began);
      history = frame.history;
      last = frame;
    }
    /* The light has gone round in a plane, so nothing is left of the way */
    assert_true(angle_between(began, last.basis) < 1e-9);
  }
}

/* Which a fixed roll cannot: somewhere it turns over, and there alone is what a carried one is for. */
static void fixed_maps_turn_over_somewhere(void **state) {
  (void)state;
  const csm_config config = light_config();
  double most = 0.0, last[3] = {0};
  for (int i = 0; i <= 720; ++i) {
    double light[3];
    turn(light, (double[]){0.43800775, 0.64725997, 0.62425355}, (double[]){0.82818, -0.56045, 0.0}, i * M_PI / 360.0);
    const plan_frame frame = plan_after(&config, light, NULL);
    if (i)
      most = fmax(most, angle_between(frame.basis, last));
    memcpy(last, frame.basis, sizeof last);
  }
  assert_true(most > 1.0);
}

static void a_fixed_roll_follows_from_the_direction_alone(void **state) {
  (void)state;
  random_state random = {3};
  const csm_config config = light_config();
  plan_history history = {0};
  for (int i = 0; i < 2000; ++i) {
    double light[3];
    random_unit(&random, light);
    const plan_frame after = plan_after(&config, light, &history), alone = plan_after(&config, light, NULL);
    assert_memory_equal(after.basis, alone.basis, sizeof after.basis);
    history = after.history;
  }
}

/* Light that turns right around, and light that stays. */
static void a_carried_roll_stands_any_turn(void **state) {
  (void)state;
  random_state random = {4};
  csm_config config = light_config();
  config.light_roll = CSM_LIGHT_ROLL_CARRIED;
  for (int i = 0; i < 3000; ++i) {
    double light[3];
    random_unit(&random, light);
    const plan_frame first = plan_after(&config, light, NULL);
    const double away = i % 3 ? random_scale(&random, 1e-17, 1e-3) : 0.0, sign = i % 2 ? -1.0 : 1.0;
    for (int k = 0; k < 3; ++k)
      light[k] = sign * first.basis[6 + k] + away * random_between(&random, -1.0, 1.0);
    const plan_frame second = plan_after(&config, light, &first.history);
    check_orthonormal(second.basis, 1e-12);
    assert_true(angle_between(&second.basis[6], light) < 1e-12);
  }
  plan_history history = plan_after(&config, (double[]){0.3, -1.0, 0.2}, NULL).history;
  double began[9];
  memcpy(began, history.basis, sizeof began);
  for (int i = 0; i < 10000; ++i)
    history = plan_after(&config, (double[]){0.3, -1.0, 0.2}, &history).history;
  for (int k = 0; k < 9; ++k)
    assert_near(history.basis[k], began[k], 1e-12);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_step_holds_the_light),
      cmocka_unit_test(a_step_shifts_no_map_farther_than_it_says),
      cmocka_unit_test(a_short_step_leaves_a_slow_light_alone),
      cmocka_unit_test(a_creeping_light_is_followed),
      cmocka_unit_test(carried_maps_turn_no_more_than_their_light),
      cmocka_unit_test(fixed_maps_turn_over_somewhere),
      cmocka_unit_test(a_fixed_roll_follows_from_the_direction_alone),
      cmocka_unit_test(a_carried_roll_stands_any_turn),
  };
  return cmocka_run_group_tests_name("plan-sun", tests, NULL, NULL);
}
