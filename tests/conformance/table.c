/*
 * table.c: every option of the configuration alone, and every pair of levels of two options that csm takes, drawn by
 * both backends: plans and maps equal in every bit, masks as design says. The cases are made from what
 * csm_config_describe says, so a field that is added is in the table.
 *
 *   table [CASES]
 *
 * With CASES, so many chosen at random instead, which hold combinations of three and more, with larger maps and masks.
 */
#include "covering.h"
#include "sides.h"
#include "telling.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static uint64_t random_cases; /* from the command line; 0: the table */

/* ---- what csm takes ---- */

typedef struct judge {
  record record;
  csm_context *context;
} judge;

static bool csm_takes(void *user, const csm_config *config) {
  judge *j = user;
  csm_cascades *cascades;
  const csm_result result = csm_cascades_create(j->context, config, &cascades);
  if (result && result != CSM_ERROR_INVALID_VALUE)
    fail_msg("%s: %s", csm_result_name(result), csm_last_error(j->context));
  assert_int_equal(csm_cascades_destroy(cascades), CSM_SUCCESS);
  return !result;
}

/* ---- drawing ---- */

typedef struct drawer {
  side side;
  telling scene;
} drawer;

static void open_drawer(drawer *d, const char *backend) {
  side_open(&d->side, backend);
  telling_make(&d->scene, d->side.context);
  support_keep_programs(d->side.context);
}

static bool is_soft(const csm_config *config) {
  return config->filter == CSM_FILTER_PCSS || config->filter == CSM_FILTER_VSSM ||
         config->filter == CSM_FILTER_BACKPROJECTION || config->filter == CSM_FILTER_EXACT_SOFT;
}

/* The picture of the last step's penumbrae, once its mask has been read. */
static void show_penumbrae(drawer *d, uint32_t camera, uint32_t width, uint32_t height) {
  shot shot = telling_shot(&d->scene, camera, TELLING_STEPS - 1, (double)width / height);
  const csm_mask_info info = {.struct_size = sizeof info,
                              .frame = shot_frame(&shot),
                              .width = width,
                              .height = height,
                              .show = CSM_SHOW_PENUMBRA};
  assert_int_equal(csm_resolve_mask(d->side.view, d->side.cascades, &info), CSM_SUCCESS);
}

/* A frame before, so that what is carried on from one frame to the next has something to begin with. */
static void draw(drawer *d, const csm_config *config, uint32_t camera, uint32_t width, uint32_t height) {
  csm_cascades **cascades = &d->side.cascades;
  assert_int_equal(csm_cascades_create(d->side.context, config, cascades), CSM_SUCCESS);
  for (uint32_t step = 0; step < TELLING_STEPS; ++step) {
    shot shot = telling_shot(&d->scene, camera, step, (double)width / height);
    assert_int_equal(csm_render_cascades(*cascades, shot_frame(&shot)), CSM_SUCCESS);
    assert_int_equal(shot_resolve(&shot, d->side.view, *cascades, width, height), CSM_SUCCESS);
    csm_stats stats = {.struct_size = sizeof stats}; /* waits, so that both have seen the same frames done */
    assert_int_equal(csm_get_stats(*cascades, &stats), CSM_SUCCESS);
  }
}

typedef struct worst {
  float difference;
  uint32_t pixels, worst_case;
  uint32_t without_shadows; /* cases whose mask tells nothing */
} worst;

static void draw_case(drawer drawers[2], const csm_config *config, uint32_t index, worst *worst) {
  const uint32_t width = random_cases ? 640 : 128, height = random_cases ? 360 : 72;
  for (int i = 0; i < 2; ++i)
    draw(&drawers[i], config, index, width, height);
  sides_same_plan(&drawers[0].side, &drawers[1].side);
  const sides_difference mask = sides_same_images(&drawers[0].side, &drawers[1].side, config, width, height);
  if (mask.largest > worst->difference) {
    worst->difference = mask.largest;
    worst->worst_case = index;
  }
  worst->pixels = mask.texels > worst->pixels ? mask.texels : worst->pixels;
  worst->without_shadows += mask.lit < 0.05 || mask.shaded < 0.005;
  if (is_soft(config)) {
    for (int i = 0; i < 2; ++i)
      show_penumbrae(&drawers[i], index, width, height);
    const sides_image shown = {CSM_READ_MASK, 0, width, height};
    assert_int_equal(sides_compare(&drawers[0].side, &drawers[1].side, &shown, 0).texels, 0);
  }
  for (int i = 0; i < 2; ++i) {
    assert_int_equal(csm_cascades_destroy(drawers[i].side.cascades), CSM_SUCCESS);
    assert_int_equal(drawers[i].side.record.warnings + drawers[i].side.record.errors, 0);
  }
}

static double seconds(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static covering table;
static const covering_case *current;

/* Says which case it was that an assertion failed in. */
static int name_case(void **state) {
  (void)state;
  if (current) {
    char text[2048];
    covering_text(&table, current, text, sizeof text);
    fprintf(stderr, "in the case %s\n", text);
  }
  return 0;
}

static void draw_table(void) {
  drawer drawers[2];
  open_drawer(&drawers[0], "vulkan");
  open_drawer(&drawers[1], "d3d12");
  worst worst = {0};
  const uint64_t count = random_cases ? random_cases : table.case_count;
  const double begin = seconds();
  for (uint64_t i = 0; i < count; ++i) {
    const covering_case chosen = random_cases ? covering_random(&table, i) : table.cases[i];
    current = &chosen;
    csm_config config = covering_config(&table, &chosen);
    for (int k = 0; random_cases && k < CSM_MAX_CASCADES; ++k)
      config.resolutions[k] *= 3;
    config.resolution *= random_cases ? 3 : 1;
    draw_case(drawers, &config, (uint32_t)i, &worst);
    current = NULL;
  }
  printf("%lu cases drawn in %.0f s; masks differ by %g at most (case %u), by more than 1/255 in %u pixels at most; %u "
         "masks are without shadows\n",
         (unsigned long)count, seconds() - begin, (double)worst.difference, worst.worst_case, worst.pixels,
         worst.without_shadows);
  assert_true(random_cases || worst.without_shadows * 4 < count);
  side_close(&drawers[0].side);
  side_close(&drawers[1].side);
}

static void every_pair_agrees(void **state) {
  (void)state;
  judge judge = {.record = {.backend = "null", .quiet = true, .allocations_left = -1}};
  const double begin = seconds();
  judge.context = support_open_with(&judge.record, CSM_CREATE_RAYS);
  table.takes = csm_takes;
  table.user = &judge;
  covering_options(&table);
  if (!random_cases) {
    covering_make(&table);
    printf("%u options, %u levels, %lu pairs of levels in %u cases, made in %.1f s; %lu pairs cannot be combined\n",
           table.option_count, table.level_count, (unsigned long)(table.pairs - table.impossible), table.case_count,
           seconds() - begin, (unsigned long)table.impossible);
  }
  draw_table();
  support_close(judge.context, &judge.record);
}

int main(int argc, char **argv) {
  random_cases = argc > 1 ? strtoul(argv[1], NULL, 10) : 0;
  setvbuf(stdout, NULL, _IOLBF, 0);
  const struct CMUnitTest tests[] = {cmocka_unit_test_teardown(every_pair_agrees, name_case)};
  return cmocka_run_group_tests_name("table", tests, NULL, NULL);
}
