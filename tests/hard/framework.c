/* The hard cases' own tools, on made-up masks: a tool that sees nothing wrong would let every case hold. */
#include "base/linear.h"
#include "hard/cases.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

enum { WIDTH = 64, HEIGHT = 36, PIXELS = WIDTH * HEIGHT };

/* ---- figures ---- */

static void of_a_figure_the_worst_value_stays(void **state) {
  (void)state;
  hard_run run = {0};
  hard_figure_add(&run, 1.0, 2.0, "px", "acne");
  hard_figure_add(&run, 3.0, 4.5, "px", "acne"); /* farther from its own bound */
  assert_true(run.figure_count == 1 && run.figures[0].value == 1.0 && hard_run_holds(&run));
  hard_figure_add(&run, 3.0, 2.0, "px", "acne");
  hard_figure_add(&run, 0.0, 2.0, "px", "acne");
  assert_true(run.figure_count == 1 && run.figures[0].value == 3.0 && !hard_run_holds(&run));
  hard_run_close(&run);
}

static void what_is_no_number_does_not_hold(void **state) {
  (void)state;
  hard_run run = {0};
  hard_figure_add(&run, NAN, 2.0, "px", "acne of %d", 7);
  hard_figure_add(&run, 1.0, 2.0, "px", "acne of 7");
  assert_string_equal(run.figures[0].what, "acne of 7");
  assert_false(hard_run_holds(&run));
  hard_run_close(&run);
}

static void what_is_stated_may_be_anything(void **state) {
  (void)state;
  hard_run run = {0};
  hard_figure_add(&run, 5.0, INFINITY, "m", "how far");
  hard_figure_add(&run, 1e30, INFINITY, "m", "how far");
  hard_figure_add(&run, 7.0, INFINITY, "m", "how far");
  assert_true(run.figure_count == 1 && run.figures[0].value == 1e30 && hard_run_holds(&run));
  hard_run_close(&run);
}

/* ---- scenes ---- */

/* A quarter turn about y and a move, by numbers that leave nothing to rounding. */
static void scenes_move_as_one(void **state) {
  (void)state;
  const double rigid[16] = {0, 0, -1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 1024, -2, 8, 1};
  host_setup setup, still;
  hard_setup_begin(&setup, WIDTH, HEIGHT);
  hard_yard(&setup, false);
  hard_setup_begin(&still, WIDTH, HEIGHT);
  hard_yard(&still, false);
  hard_place(&setup, rigid);
  assert_true(setup.camera.position[0] == still.camera.position[2] + 1024.0);
  assert_true(setup.camera.position[1] == still.camera.position[1] - 2.0);
  assert_true(setup.camera.position[2] == 8.0 - still.camera.position[0]);
  assert_true(fabs(setup.light.direction[0] - still.light.direction[2]) < 1e-15);
  for (size_t i = 0; i < setup.scene.instance_count; i++) {
    double before[4], after[4], seen_before[4], seen_after[4];
    mat_transform(before, still.scene.instances[i].transform, (const double[3]){1.0, 2.0, 3.0}, 1.0);
    mat_transform(after, setup.scene.instances[i].transform, (const double[3]){1.0, 2.0, 3.0}, 1.0);
    mat_transform(seen_before, still.camera.view, before, 1.0);
    mat_transform(seen_after, setup.camera.view, after, 1.0);
    for (int k = 0; k < 3; k++)
      assert_true(fabs(seen_before[k] - seen_after[k]) < 1e-10);
  }
  setup_free(&setup);
  setup_free(&still);
}

/* ---- masks ---- */

/* A wall of 4 m before a ground, and the truth of it. Nothing of it asks for a device. */
typedef struct fixture {
  hard_run run;
  host_setup setup;
  hard_truth truth;
  float *mask;
} fixture;

static void open_wall(fixture *f) {
  mesh_builder b = {0};
  *f = (fixture){.run.worst.severity = -1.0};
  hard_setup_begin(&f->setup, WIDTH, HEIGHT);
  hard_ground(&b, (const double[3]){0.0, 0.0, 0.0}, 40.0, 1);
  hard_add(&f->setup, &b, "ground", NULL);
  builder_box(&b, (const double[3]){-2.0, 0.0, -8.0}, (const double[3]){2.0, 4.0, -7.0});
  hard_add(&f->setup, &b, "wall", NULL);
  hard_look(&f->setup, (const double[3]){0.0, 3.0, 6.0}, (const double[3]){0.0, 1.0, -6.0}, 60.0);
  f->run.setup = &f->setup;
  assert_int_equal(hard_cast(&f->run, &f->setup.camera, &f->setup.light, &f->truth), 0);
  f->mask = malloc(PIXELS * sizeof *f->mask);
  assert_non_null(f->mask);
  memcpy(f->mask, f->truth.visibility, PIXELS * sizeof *f->mask);
}

static void close_wall(fixture *f) {
  free(f->mask);
  hard_truth_free(&f->truth);
  hard_run_close(&f->run);
  setup_free(&f->setup);
}

static hard_count judge(fixture *f, double silhouette_px, double edge_px) {
  return hard_judge(&f->run, &f->truth, f->mask, (hard_margin){.silhouette_px = silhouette_px, .edge_px = edge_px});
}

/* The bottom row sees the ground, which is lit there. */
static void a_wrong_pixel_is_counted(void **state) {
  (void)state;
  fixture f;
  const size_t at = PIXELS - WIDTH / 2;
  open_wall(&f);
  hard_count count = judge(&f, 0.0, 0.0);
  assert_true(count.judged > PIXELS / 3 && count.lit > 0 && count.lit < count.judged);
  assert_true(count.false_dark == 0 && count.false_lit == 0 && count.rms == 0.0);
  assert_true(f.truth.visibility[at] == 1.0f);
  f.mask[at] = 0.0f;
  count = judge(&f, 2.0, 2.0);
  assert_true(count.false_dark == 1 && count.false_lit == 0);
  assert_true(fabs(count.rms - sqrt(1.0 / (double)count.judged)) < 1e-12);
  f.mask[at] = NAN;
  assert_true(judge(&f, 2.0, 2.0).false_dark == 1);
  for (size_t i = 0; i < PIXELS; i++)
    f.mask[i] = 1.0f;
  count = judge(&f, 0.0, 0.0);
  assert_true(count.false_lit == count.judged - count.lit && count.false_dark == 0);
  close_wall(&f);
}

/* A shadow that is a pixel larger is wrong at its edge alone, and a wall that is one wider at its silhouette. */
static void margins_leave_out_edges(void **state) {
  (void)state;
  fixture f;
  open_wall(&f);
  for (size_t i = 0; i + 1 < PIXELS; i++)
    f.mask[i] = f.truth.visibility[i + 1];
  assert_true(judge(&f, 0.0, 0.0).false_dark + judge(&f, 0.0, 0.0).false_lit > 0);
  const hard_count clear = judge(&f, 0.0, 2.0);
  assert_true(clear.false_dark == 0 && clear.false_lit == 0 && clear.judged > 0);
  /* The wall stands before the ground and the sky; nothing else has a silhouette but the ground's end. */
  size_t silhouettes = 0;
  for (size_t i = 0; i < PIXELS; i++)
    silhouettes += f.truth.silhouette_squares[i] == 0;
  assert_true(silhouettes > 20 && silhouettes < PIXELS / 4);
  /* Where the wall stands on the ground both join. */
  for (uint32_t y = 1; y < HEIGHT; y++) {
    const size_t at = (size_t)y * WIDTH + WIDTH / 2;
    const truth_surface *s = &f.truth.view.surfaces[at], *above = s - WIDTH;
    if (s->normal[1] > 0.9f && above->triangle != TRUTH_NOTHING && above->normal[2] > 0.9f)
      assert_true(f.truth.silhouette_squares[at] > 0);
  }
  close_wall(&f);
}

static void the_worst_is_pictured(void **state) {
  (void)state;
  fixture f;
  const size_t at = PIXELS - WIDTH / 2;
  open_wall(&f);
  judge(&f, 0.0, 0.0);
  f.mask[at] = 0.0f;
  judge(&f, 0.0, 0.0);
  const hard_worst *worst = &f.run.worst;
  assert_int_equal(worst->width, WIDTH);
  assert_true(worst->expected[at] == 1.0f && worst->drawn[at] == 0.0f && worst->severity >= 1.0);
  assert_true(isnan(worst->expected[0])); /* the sky is not judged */
  f.mask[at] = 1.0f;
  judge(&f, 0.0, 0.0);
  assert_true(worst->drawn[at] == 0.0f); /* what is better is not kept */
  close_wall(&f);
}

static void masks_are_compared(void **state) {
  (void)state;
  hard_run run = {.worst.severity = -1.0};
  float a[PIXELS] = {0}, b[PIXELS] = {0};
  const hard_picture expected = {.width = WIDTH, .height = HEIGHT, .mask = a};
  const hard_picture drawn = {.width = WIDTH, .height = HEIGHT, .mask = b};
  b[5] = 0.25f;
  b[6] = 0.5f;
  b[7] = NAN;
  hard_difference difference = hard_compare(&run, &expected, &drawn, 0.25);
  assert_int_equal(difference.pixels, 2);
  b[7] = 0.0f;
  difference = hard_compare(&run, &expected, &drawn, 0.25);
  assert_true(difference.pixels == 1 && difference.largest == 0.5);
  hard_run_close(&run);
}

/* Reversed and without a far plane, as the camera is, depth is the near plane's distance over the view depth. */
static void true_depths_are_the_cameras(void **state) {
  (void)state;
  fixture f;
  open_wall(&f);
  float *depth = hard_true_depth(&f.truth);
  for (uint32_t i = 0; i < PIXELS; i++) {
    const truth_surface *surface = &f.truth.view.surfaces[i];
    const double expected = surface->triangle == TRUTH_NOTHING ? 0.0 : 0.1 / surface->view_depth;
    assert_true(fabs(depth[i] - expected) <= 1e-6 * expected);
  }
  free(depth);
  close_wall(&f);
}

/* ---- the list ---- */

static void cases_are_chosen_by_name(void **state) {
  (void)state;
  const hard_case *chosen[OPTIONS_MAX_CASES];
  host_options options = {0};
  uint32_t count, all = 0;
  assert_int_equal(hard_cases_choose(chosen, &all, &options), 0);
  for (uint32_t i = 0; i < all; i++) {
    options.cases[0] = chosen[i]->name;
    options.case_count = 1;
    const hard_case *one[OPTIONS_MAX_CASES];
    assert_int_equal(hard_cases_choose(one, &count, &options), 0);
    assert_true(count == 1 && one[0] == chosen[i]); /* names are different ones */
    assert_true(chosen[i]->about && *chosen[i]->about && chosen[i]->run);
  }
  options.cases[0] = "none";
  assert_int_equal(hard_cases_choose(chosen, &count, &options), 0);
  assert_int_equal(count, 0);
  options.cases[0] = "nothing";
  assert_int_equal(hard_cases_choose(chosen, &count, &options), 2);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(of_a_figure_the_worst_value_stays),
      cmocka_unit_test(what_is_no_number_does_not_hold),
      cmocka_unit_test(what_is_stated_may_be_anything),
      cmocka_unit_test(scenes_move_as_one),
      cmocka_unit_test(a_wrong_pixel_is_counted),
      cmocka_unit_test(margins_leave_out_edges),
      cmocka_unit_test(the_worst_is_pictured),
      cmocka_unit_test(masks_are_compared),
      cmocka_unit_test(true_depths_are_the_cameras),
      cmocka_unit_test(cases_are_chosen_by_name),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
