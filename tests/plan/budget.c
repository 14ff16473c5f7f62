/* The controller of a budget, on machines that are made up; sides and memory by their own arithmetic. */
#include "support.h"

#include "plan/budget.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LATE = 4, SETTLING = 400 };

/* What takes so many milliseconds, `texels` of them at the finest step; measured some frames late, with noise. */
typedef struct machine {
  double fixed, texels, noise;
  double unsure; /* at the finest step */
  uint32_t steps[LATE];
  uint32_t frame, seed;
} machine;

static double noise(machine *m) {
  m->seed = m->seed * 1664525u + 1013904223u;
  return 1.0 + m->noise * ((m->seed >> 8) / 8388608.0 - 1.0);
}

static double share_of(uint32_t step) {
  return exp2(-0.5 * step);
}

static double true_ms(const machine *m, uint32_t step) {
  return m->fixed + m->texels * share_of(step);
}

/* A share of wrong pixels, by a share of unsure ones: what the finest step has, more by sides to the power of 0.95. */
static double true_wrong(const machine *m, uint32_t step) {
  return (0.053 * m->unsure + 0.32 * m->unsure * m->unsure) * pow(share_of(step), -0.475);
}

static double unsure_at(const machine *m, uint32_t step) {
  double unsure = 0.0;
  for (double digit = 0.5; digit > 1e-12; digit /= 2.0)
    unsure +=
        0.053 * (unsure + digit) + 0.32 * (unsure + digit) * (unsure + digit) <= true_wrong(m, step) ? digit : 0.0;
  return unsure;
}

static csm_config budget_config(uint32_t bits, double ms, double wrong) {
  csm_config config = default_config();
  config.budget = bits;
  config.budget_ms = ms;
  config.budget_wrong = wrong;
  return config;
}

/* Draws frames; returns how often the step changed. It never moves by more than one, or before it was looked at for a while. */
static uint32_t draw(plan_budget *budget, const csm_config *config, machine *m, uint32_t frames) {
  uint32_t changes = 0, since = LATE + PLAN_BUDGET_TAKEN;
  for (uint32_t i = 0; i < frames; ++i, ++m->frame, ++since) {
    const uint32_t seen = m->steps[m->frame % LATE], before = budget->step;

    const plan_budget_cost cost = m->frame < LATE
                                      ? (plan_budget_cost){-1.0, -1.0}
                                      : (plan_budget_cost){true_ms(m, seen) * noise(m), unsure_at(m, seen) * noise(m)};
    plan_budget_next(budget, config, &cost, LATE);
    m->steps[m->frame % LATE] = budget->step;
    if (budget->step == before)
      continue;
    assert_int_equal(abs((int)budget->step - (int)before), 1);
    assert_true(since >= PLAN_BUDGET_TAKEN);
    assert_true(changes == 0 || since >= LATE + PLAN_BUDGET_TAKEN);
    since = 0;
    ++changes;
  }
  return changes;
}

static void near(double value, double expected, double share) {
  if (!(fabs(value - expected) <= share * expected))
    fail_msg("%g, and %g is expected to %g", value, expected, share);
}

static void all_maps_get_coarser_alike(void **state) {
  (void)state;
  const uint32_t layouts[] = {CSM_LAYOUT_ARRAY, CSM_LAYOUT_ATLAS, CSM_LAYOUT_PAGES};
  for (uint32_t i = 0; i < 3; ++i)
    for (uint32_t step = 0; step < PLAN_BUDGET_STEPS; ++step) {
      csm_config config = default_config(), coarser;
      config.map_layout = layouts[i];
      config.resolution = 2000;
      config.resolutions[1] = 4096;
      plan_budget_coarser(&coarser, &config, step);
      const double unit = i == 2 ? 64.0 : 16.0;
      if (step == 0)
        assert_memory_equal(&coarser, &config, sizeof config);
      else
        assert_true(fmod(coarser.resolution, unit) == 0.0 && fmod(coarser.resolutions[1], unit) == 0.0);
      assert_true(fabs(coarser.resolution - 2000.0 / pow(2.0, step / 4.0)) <= unit / 2.0);
      assert_true(fabs(coarser.resolutions[1] - 4096.0 / pow(2.0, step / 4.0)) <= unit / 2.0);
      assert_int_equal(coarser.resolutions[0], 0);
      coarser.resolution = config.resolution;
      memcpy(coarser.resolutions, config.resolutions, sizeof coarser.resolutions);
      assert_memory_equal(&coarser, &config, sizeof config);
    }
  csm_config small = default_config();
  plan_budget budget;
  plan_budget_begin(&budget, &small, LATE);
  assert_int_equal(budget.last, PLAN_BUDGET_STEPS - 1);
  small.resolution = 128;
  small.filter = CSM_FILTER_PCF_N; /* wants more than 32 texels */
  small.filter_taps = 31;
  plan_budget_begin(&budget, &small, LATE);
  assert_true(budget.last > 0 && budget.last < PLAN_BUDGET_STEPS - 1);
}

/* Four square maps: 4 side² texels, twice for pages; moments of an evsm4 in floats are 16 bytes each. */
static void memory_is_the_most_that_fits(void **state) {
  (void)state;
  const struct {
    uint32_t layout, format, filter;
    double texel, unit;
  } kinds[] = {{CSM_LAYOUT_ARRAY, CSM_MAP_D32, CSM_FILTER_PCF_3X3, 4.0, 16.0},
               {CSM_LAYOUT_ARRAY, CSM_MAP_D16, CSM_FILTER_PCF_3X3, 2.0, 16.0},
               {CSM_LAYOUT_ATLAS, CSM_MAP_D32, CSM_FILTER_PCF_3X3, 4.0, 16.0},
               {CSM_LAYOUT_PAGES, CSM_MAP_D16, CSM_FILTER_PCF_3X3, 4.0, 64.0},
               {CSM_LAYOUT_ARRAY, CSM_MAP_D32, CSM_FILTER_EVSM4, 20.0, 16.0}};
  for (uint32_t i = 0; i < sizeof kinds / sizeof *kinds; ++i)
    for (double mib = 3.0; mib < 400.0; mib *= 1.37) {
      csm_config config = budget_config(CSM_BUDGET_MEMORY, 0.0, 0.0), chosen;
      config.map_layout = kinds[i].layout;
      config.map_format = kinds[i].format;
      config.filter = kinds[i].filter;
      config.budget_mib = mib;
      uint32_t expected = 0;
      for (; expected < PLAN_BUDGET_STEPS; ++expected) {
        const double side = kinds[i].unit * round(2048.0 / pow(2.0, expected / 4.0) / kinds[i].unit);
        if (4.0 * side * side * kinds[i].texel <= mib * 1048576.0)
          break;
      }
      assert_int_equal(plan_budget_fit(&config, 0), expected);
      const char *error = "";
      assert_int_equal(plan_config_check(&config, &error),
                       expected == PLAN_BUDGET_STEPS ? CSM_ERROR_INVALID_VALUE : CSM_SUCCESS);
      if (expected == PLAN_BUDGET_STEPS)
        continue;
      plan_budget_coarser(&chosen, &config, expected);
      assert_true(plan_budget_bytes(&chosen) <= mib * 1048576.0);
    }
}

/* A filter takes room at a map's border, so maps may not be as small as memory asks for. */
static void memory_leaves_room_for_the_filter(void **state) {
  (void)state;
  csm_config config = budget_config(CSM_BUDGET_MEMORY, 0.0, 0.0);
  config.resolution = 128;
  config.budget_mib = 0.01; /* maps of 16 texels take 0.004 */
  assert_in_range(plan_budget_fit(&config, 0), 1, PLAN_BUDGET_STEPS - 1);
  config.filter = CSM_FILTER_PCF_N;
  config.filter_taps = 31;
  assert_int_equal(plan_budget_fit(&config, 0), PLAN_BUDGET_STEPS);
}

/* A step begins with what was expected of it, whatever the filter. */
static void a_step_begins_as_expected(void **state) {
  (void)state;
  const uint32_t filters[] = {CSM_FILTER_PCF_2X2, CSM_FILTER_PCF_3X3};
  for (uint32_t i = 0; i < 2; ++i) {
    csm_config config = budget_config(CSM_BUDGET_TIME | CSM_BUDGET_ERROR, 10.0, 1e-6);
    config.filter = filters[i];
    plan_budget budget;
    plan_budget_begin(&budget, &config, LATE);
    const plan_budget_cost cost = {20.0, 0.1};
    double wrong = 0.0, ms = 0.0;
    while (budget.step == 0) {
      wrong = plan_budget_wrong(&budget, &config, 1);
      ms = plan_budget_ms(&budget, &config, 1);
      plan_budget_next(&budget, &config, &cost, LATE);
    }
    assert_int_equal(budget.step, 1);
    /* nothing was known before the frame that made the choice */
    assert_true(wrong < 0.0 && ms < 0.0);
    const double finest = plan_budget_wrong(&budget, &config, 0), coarser = plan_budget_wrong(&budget, &config, 1);
    near(coarser, finest * pow(1728.0 / 2048.0, -0.95), 1e-9);
    near(plan_budget_ms(&budget, &config, 0), 20.0, 0.1);
    const double x = 0.1 * (i == 0 ? 2.0 / 0.667 : 1.0);
    near(finest, 0.053 * x + 0.32 * x * x, 1e-6);
  }
}

/* Whatever a machine's fixed part: the time is kept, and with a step finer less than a tenth would be left. */
static void time_is_kept_and_used(void **state) {
  (void)state;
  for (double fixed = 0.0; fixed < 10.0; fixed += 1.3)
    for (double target = 11.0; target < 34.0; target += 2.1) {
      const csm_config config = budget_config(CSM_BUDGET_TIME, target, 0.0);
      machine m = {.fixed = fixed, .texels = 20.0, .noise = 0.02, .seed = 5};
      plan_budget budget;
      plan_budget_begin(&budget, &config, LATE);
      draw(&budget, &config, &m, SETTLING);
      assert_true(true_ms(&m, budget.step) <= 1.02 * target);
      assert_true(budget.step == 0 || true_ms(&m, budget.step - 1) > 0.85 * target);
      assert_int_equal(plan_budget_missed(&budget, &config), 0);
      near(plan_budget_ms(&budget, &config, budget.step), true_ms(&m, budget.step), 0.05);
      near(plan_budget_ms(&budget, &config, 0), true_ms(&m, 0), 0.3);
    }
}

static void noise_moves_nothing(void **state) {
  (void)state;
  uint32_t changes = 0;
  for (uint32_t seed = 0; seed < 40; ++seed) {
    const csm_config config = budget_config(CSM_BUDGET_TIME, 8.0 + 0.3 * seed, 0.0);
    machine m = {.fixed = 3.0, .texels = 20.0, .noise = 0.1, .seed = seed};
    plan_budget budget;
    plan_budget_begin(&budget, &config, LATE);
    draw(&budget, &config, &m, SETTLING);
    const uint32_t more = draw(&budget, &config, &m, 2000);
    assert_in_range(more, 0, 6);
    changes += more;
  }
  assert_in_range(changes, 0, 40); /* of 80000 frames */
}

static void follows_what_changes(void **state) {
  (void)state;
  const csm_config config = budget_config(CSM_BUDGET_TIME, 16.0, 0.0);
  machine m = {.fixed = 3.0, .texels = 12.0, .noise = 0.03, .seed = 1};
  plan_budget budget;
  plan_budget_begin(&budget, &config, LATE);
  assert_int_equal(draw(&budget, &config, &m, SETTLING), 0);
  m.fixed = 6.0;
  m.texels = 24.0;
  draw(&budget, &config, &m, SETTLING);
  assert_true(budget.step > 0 && true_ms(&m, budget.step) <= 16.5);
  m.fixed = 3.0; /* half as much of both: so the finest maps, which were drawn long ago, take half as much, too */
  m.texels = 12.0;
  draw(&budget, &config, &m, 60);
  near(plan_budget_ms(&budget, &config, 0), true_ms(&m, 0), 0.15);
  m.texels = 10.0;
  draw(&budget, &config, &m, SETTLING);
  assert_int_equal(budget.step, 0);
}

static void what_no_step_keeps_is_told(void **state) {
  (void)state;
  const csm_config config = budget_config(CSM_BUDGET_TIME, 4.0, 0.0);
  machine m = {.fixed = 5.0, .texels = 20.0, .noise = 0.02, .seed = 1};
  plan_budget budget;
  plan_budget_begin(&budget, &config, LATE);
  assert_int_equal(plan_budget_missed(&budget, &config), 0); /* nothing is known */
  assert_true(plan_budget_ms(&budget, &config, 0) < 0.0);
  draw(&budget, &config, &m, SETTLING);
  assert_int_equal(budget.step, PLAN_BUDGET_STEPS - 1);
  assert_int_equal(plan_budget_missed(&budget, &config), CSM_BUDGET_TIME);
}

/* Rays take what coarser maps leave to them: then no maps are fast enough, and the finest are the fastest. */
static void coarser_maps_that_take_longer_are_left(void **state) {
  (void)state;
  csm_config config = budget_config(CSM_BUDGET_TIME, 12.0, 0.0);
  config.filter = CSM_FILTER_EXACT;
  machine m = {.fixed = 40.0, .texels = -20.0, .noise = 0.02, .seed = 7};
  plan_budget budget;
  plan_budget_begin(&budget, &config, LATE);
  uint32_t coarsest = 0, coarse = 0;
  for (uint32_t i = 0; i < 2000; ++i) {
    draw(&budget, &config, &m, 1);
    coarsest = budget.step > coarsest ? budget.step : coarsest;
    coarse += budget.step > 0;
  }
  assert_in_range(coarsest, 1, 3);
  assert_true(coarse < 400);
  assert_int_equal(plan_budget_missed(&budget, &config), CSM_BUDGET_TIME);
}

/* The coarsest maps that are good enough, and no others. */
static void error_is_kept_and_used(void **state) {
  (void)state;
  for (double target = 0.0035; target < 0.02; target *= 1.3) {
    const csm_config config = budget_config(CSM_BUDGET_ERROR, 0.0, target);
    machine m = {.unsure = 0.045, .noise = 0.02, .seed = 3};
    plan_budget budget;
    plan_budget_begin(&budget, &config, LATE);
    draw(&budget, &config, &m, SETTLING);
    const double wrong = plan_budget_wrong(&budget, &config, budget.step);
    near(wrong, true_wrong(&m, budget.step), 0.05);
    assert_true(true_wrong(&m, budget.step) <= 1.02 * target);
    assert_true(budget.step == budget.last || true_wrong(&m, budget.step + 1) > 0.85 * target);
    assert_int_equal(draw(&budget, &config, &m, 2000), 0);
    near(plan_budget_wrong(&budget, &config, 4), true_wrong(&m, 4), 0.05);
  }
}

/* What csm-host measure found in town, valley and oaks: shares of unsure pixels, and of wrong ones. */
static void wrong_pixels_are_predicted(void **state) {
  (void)state;
  const struct {
    uint32_t filter;
    double unsure, wrong;
  } found[] = {{CSM_FILTER_PCF_3X3, 0.0454, 0.00271}, {CSM_FILTER_PCF_3X3, 0.1114, 0.00998},
               {CSM_FILTER_PCF_3X3, 0.2456, 0.03232}, {CSM_FILTER_PCF_2X2, 0.0145, 0.00294},
               {CSM_FILTER_PCF_3X3, 0.4048, 0.06587}, {CSM_FILTER_PCF_3X3, 0.5011, 0.12477},
               {CSM_FILTER_PCF_2X2, 0.0539, 0.01693}};
  for (size_t i = 0; i < sizeof found / sizeof *found; ++i) {
    csm_config config = budget_config(CSM_BUDGET_ERROR, 0.0, 1e-6); /* the finest maps miss it, and stay */
    config.filter = found[i].filter;
    plan_budget budget;
    plan_budget_begin(&budget, &config, LATE);
    const plan_budget_cost cost = {-1.0, found[i].unsure};
    for (uint32_t k = 0; k < 100; ++k)
      plan_budget_next(&budget, &config, &cost, LATE);
    assert_int_equal(budget.step, 0);
    near(plan_budget_wrong(&budget, &config, 0), found[i].wrong, 0.2);
  }
}

static void time_goes_before_error(void **state) {
  (void)state;
  const csm_config config = budget_config(CSM_BUDGET_TIME | CSM_BUDGET_ERROR, 9.0, 0.003);
  machine m = {.fixed = 3.0, .texels = 20.0, .unsure = 0.045, .noise = 0.02, .seed = 3};
  plan_budget budget;
  plan_budget_begin(&budget, &config, LATE);
  draw(&budget, &config, &m, SETTLING);
  assert_true(true_ms(&m, budget.step) <= 9.2 && true_ms(&m, budget.step - 1) > 7.6);
  assert_int_equal(plan_budget_missed(&budget, &config), CSM_BUDGET_ERROR);
  m.unsure = 0.02; /* now coarser maps suffice, though there is time for finer ones */
  m.texels = 5.0;
  draw(&budget, &config, &m, SETTLING);
  assert_true(true_ms(&m, budget.step - 1) < 8.0);
  assert_true(true_wrong(&m, budget.step + 1) > 0.85 * 0.003 || budget.step == budget.last);
  assert_int_equal(plan_budget_missed(&budget, &config), 0);
}

static void what_is_not_known_moves_nothing(void **state) {
  (void)state;
  const csm_config config = budget_config(CSM_BUDGET_TIME | CSM_BUDGET_ERROR, 0.1, 0.5);
  const plan_budget_cost costs[] = {{-1.0, 0.001}, {100.0, -1.0}, {-1.0, -1.0}};
  plan_budget budget;
  plan_budget_begin(&budget, &config, LATE);
  for (uint32_t i = 0; i < 300; ++i)
    plan_budget_next(&budget, &config, &costs[i % 3], LATE);
  assert_int_equal(budget.step, 0);
  assert_true(plan_budget_ms(&budget, &config, 0) < 0.0 && plan_budget_wrong(&budget, &config, 0) < 0.0);
}

/* Times are another's; the step stays, and is chosen anew from what the new device takes. */
static void another_device_keeps_the_step(void **state) {
  (void)state;
  const csm_config config = budget_config(CSM_BUDGET_TIME, 9.0, 0.0);
  machine slow = {.fixed = 3.0, .texels = 20.0, .noise = 0.02, .seed = 3}, fast = {.texels = 5.0, .seed = 1};
  plan_budget budget;
  plan_budget_begin(&budget, &config, LATE);
  draw(&budget, &config, &slow, SETTLING);
  const uint32_t step = budget.step;
  plan_budget_forget(&budget, LATE);
  assert_int_equal(budget.step, step);
  assert_true(step > 0 && plan_budget_ms(&budget, &config, 0) < 0.0);
  draw(&budget, &config, &fast, SETTLING);
  assert_int_equal(budget.step, 0);
  near(plan_budget_ms(&budget, &config, 0), 5.0, 0.01);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(all_maps_get_coarser_alike),
      cmocka_unit_test(memory_is_the_most_that_fits),
      cmocka_unit_test(memory_leaves_room_for_the_filter),
      cmocka_unit_test(a_step_begins_as_expected),
      cmocka_unit_test(time_is_kept_and_used),
      cmocka_unit_test(noise_moves_nothing),
      cmocka_unit_test(follows_what_changes),
      cmocka_unit_test(what_no_step_keeps_is_told),
      cmocka_unit_test(coarser_maps_that_take_longer_are_left),
      cmocka_unit_test(error_is_kept_and_used),
      cmocka_unit_test(wrong_pixels_are_predicted),
      cmocka_unit_test(time_goes_before_error),
      cmocka_unit_test(what_is_not_known_moves_nothing),
      cmocka_unit_test(another_device_keeps_the_step),
  };
  return cmocka_run_group_tests_name("plan-budget", tests, NULL, NULL);
}
