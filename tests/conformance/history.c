/* history.c: masks that are accumulated: how many frames each pixel is the mean of, and when a view begins anew. */
#include "support.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 96, HEIGHT = 64, FRAMES = 5 };

typedef struct fixture {
  record record;
  csm_context *context;
  csm_cascades *cascades;
  csm_view *view;
  csm_config config;
  support_scene scene;
  uint32_t width, height;
} fixture;

static void setup(fixture *f) {
  memset(f, 0, sizeof *f);
  csm_create_info info = support_create_info(&f->record);
  info.flags |= CSM_CREATE_KEEP_GEOMETRY;
  assert_int_equal(csm_create(&info, &f->context), CSM_SUCCESS);
  f->config = support_config();
  f->config.history = CSM_HISTORY_ON;
  f->config.history_frames = FRAMES;
  f->width = WIDTH;
  f->height = HEIGHT;
  support_scene_make(&f->scene, f->context);
  assert_int_equal(csm_cascades_create(f->context, &f->config, &f->cascades), CSM_SUCCESS);
  f->view = support_view(f->context);
}

static void teardown(fixture *f) {
  support_close(f->context, &f->record);
}

static csm_result resolve(fixture *f, csm_view *view, uint32_t show) {
  f->scene.shot.frame.instances = f->scene.instances;
  const csm_mask_info info = {.struct_size = sizeof info,
                              .frame = shot_frame(&f->scene.shot),
                              .width = f->width,
                              .height = f->height,
                              .show = show};
  return csm_resolve_mask(view, f->cascades, &info);
}

static void render(fixture *f) {
  f->scene.shot.frame.instances = f->scene.instances;
  assert_int_equal(csm_render_cascades(f->cascades, shot_frame(&f->scene.shot)), CSM_SUCCESS);
}

/* A frame whose mask shows something; the caller frees it. */
static float *draw(fixture *f, uint32_t show) {
  render(f);
  assert_int_equal(resolve(f, f->view, show), CSM_SUCCESS);
  return support_image(f->context, f->view, CSM_READ_MASK, f->width, f->height);
}

static bool draws(void) {
  return strcmp(support_backend(), "null") != 0;
}

/* The frames of each pixel: how many have none, `count`, and others. */
typedef struct tally {
  uint32_t none, as_many, other;
} tally;

static tally count(fixture *f, uint32_t frames) {
  tally sum = {0};
  float *shown = draw(f, CSM_SHOW_HISTORY);
  for (uint32_t i = 0; i < f->width * f->height; ++i) {
    const uint32_t has = (uint32_t)(shown[i] * 255.0f + 0.5f);
    ++*(has == 0 ? &sum.none : has == frames ? &sum.as_many : &sum.other);
  }
  free(shown);
  return sum;
}

/* Every pixel with a surface is the mean of so many frames. */
static void expect_frames(fixture *f, uint32_t frames, const char *what) {
  const tally sum = count(f, frames);
  if (draws() && (sum.other || !sum.as_many))
    fail_msg("%s: %u pixels have %u frames, %u have others", what, sum.as_many, frames, sum.other);
}

static void a_still_view_gathers_frames(void **state) {
  (void)state;
  fixture f;
  setup(&f);
  for (uint32_t i = 1; i < 2 * FRAMES; ++i)
    expect_frames(&f, i < FRAMES ? i : FRAMES, "still");
  /* What shows something else lies between two frames, and counts for nothing. */
  free(draw(&f, CSM_SHOW_CASCADE));
  expect_frames(&f, FRAMES, "after a picture of cascades");
  teardown(&f);
}

/* A filter without a pattern is the same in every frame, and so is its mean. */
static void what_does_not_change_is_its_own_mean(void **state) {
  (void)state;
  fixture f;
  setup(&f);
  csm_view *alone = support_view(f.context);
  for (int i = 0; i < 3; ++i)
    free(draw(&f, CSM_SHOW_VISIBILITY));
  float *mean = draw(&f, CSM_SHOW_VISIBILITY);
  assert_int_equal(resolve(&f, alone, CSM_SHOW_VISIBILITY), CSM_SUCCESS);
  float *one = support_image(f.context, alone, CSM_READ_MASK, WIDTH, HEIGHT);
  assert_memory_equal(mean, one, WIDTH * HEIGHT * sizeof(float));
  free(mean);
  free(one);
  teardown(&f);
}

/* ---- at rest ---- */

enum { MIXED = 8 };

/* A scene that stays, with maps that are jittered and a pattern of few taps; masks of one frame alone, and their sum. */
typedef struct resting {
  fixture f;
  csm_scene *scene;
  csm_instance_id ids[SUPPORT_INSTANCES];
  csm_cascades *singles;
  csm_view *single;
  double sum[WIDTH * HEIGHT];
} resting;

static void rest(resting *r) {
  fixture *f = &r->f;
  memset(r, 0, sizeof *r);
  setup(f);
  assert_int_equal(csm_scene_create(f->context, &r->scene), CSM_SUCCESS);
  const csm_scene_batch batch = {
      .struct_size = sizeof batch, .count = SUPPORT_INSTANCES, .ids = r->ids, .instances = f->scene.instances};
  assert_int_equal(csm_scene_add(r->scene, &batch), CSM_SUCCESS);
  f->config.filter = CSM_FILTER_VOGEL;
  f->config.filter_taps = 2;
  f->config.filter_radius_texels = 3.0;
  f->config.history_jitter = 1;
  f->config.history_frames = 1;
  assert_int_equal(csm_cascades_create(f->context, &f->config, &r->singles), CSM_SUCCESS);
  f->config.history_frames = 2 * MIXED;
  assert_int_equal(csm_cascades_configure(f->cascades, &f->config), CSM_SUCCESS);
  r->single = support_view(f->context);
}

/* A frame of the scene, whose mask the caller frees. */
static float *draw_resting(resting *r, csm_cascades *cascades, csm_view *view) {
  fixture *f = &r->f;
  csm_frame frame = *shot_frame(&f->scene.shot);
  frame.instances = NULL;
  frame.instance_count = 0;
  frame.scene = r->scene;
  const csm_mask_info info = {.struct_size = sizeof info, .frame = &frame, .width = WIDTH, .height = HEIGHT};
  assert_int_equal(csm_render_cascades(cascades, &frame), CSM_SUCCESS);
  assert_int_equal(csm_resolve_mask(view, cascades, &info), CSM_SUCCESS);
  return support_image(f->context, view, CSM_READ_MASK, WIDTH, HEIGHT);
}

/* How far the mask of so many frames is from the mean of them, at most; between two of them `move` aside. */
static double worst_of(uint32_t frames, double move) {
  resting r;
  double worst = 0.0;
  rest(&r);
  for (uint32_t i = 0; i < frames; ++i) {
    const csm_scene_batch batch = {
        .struct_size = sizeof batch, .count = 1, .ids = &r.ids[1], .matrices = r.f.scene.instances[1].transform};
    r.f.scene.instances[1].transform[12] += move;
    if (move != 0.0)
      assert_int_equal(csm_scene_move(r.scene, &batch), CSM_SUCCESS);
    float *single = draw_resting(&r, r.singles, r.single), *mixed = draw_resting(&r, r.f.cascades, r.f.view);
    for (uint32_t k = 0; k < WIDTH * HEIGHT; ++k)
      r.sum[k] += single[k];
    for (uint32_t k = 0; k < WIDTH * HEIGHT && i + 1 == frames; ++k)
      worst = fmax(worst, fabs(r.sum[k] / frames - mixed[k]));
    free(single);
    free(mixed);
  }
  assert_int_equal(csm_scene_destroy(r.scene), CSM_SUCCESS);
  teardown(&r.f);
  return worst;
}

/* Where nothing moves but the maps' places within a texel, a mask is the mean of its frames, whatever is around a pixel; the
   history's halves and the masks' 8 bits round. Where a caster moves, it is not. */
static void shadows_at_rest_are_plain_means(void **state) {
  (void)state;
  if (!draws())
    return;
  for (uint32_t frames = 2; frames <= MIXED; frames *= 2)
    assert_true(worst_of(frames, 0.0) <= 2.0 / 255.0);
  assert_true(worst_of(MIXED, 0.2) > 0.25);
}

static void a_camera_that_moves_keeps_what_it_still_sees(void **state) {
  (void)state;
  fixture f;
  setup(&f);
  for (int i = 0; i < 3; ++i)
    free(draw(&f, CSM_SHOW_VISIBILITY));
  f.scene.shot.camera.view[12] += 0.05;
  const tally sum = count(&f, 4);
  if (draws())
    assert_true(sum.as_many > 9 * sum.other);
  teardown(&f);
}

static void other_pictures_begin_anew(void **state) {
  (void)state;
  fixture f;
  setup(&f);
  for (int i = 0; i < 3; ++i)
    free(draw(&f, CSM_SHOW_VISIBILITY));
  f.width -= 5;
  expect_frames(&f, 1, "another size");
  expect_frames(&f, 2, "the same size");
  f.config.filter = CSM_FILTER_PCF_2X2;
  assert_int_equal(csm_cascades_configure(f.cascades, &f.config), CSM_SUCCESS);
  expect_frames(&f, 1, "other settings");
  expect_frames(&f, 2, "the same settings");
  csm_cascades *first = f.cascades;
  assert_int_equal(csm_cascades_create(f.context, &f.config, &f.cascades), CSM_SUCCESS);
  expect_frames(&f, 1, "other cascades");
  assert_int_equal(csm_cascades_destroy(first), CSM_SUCCESS);
  expect_frames(&f, 2, "the same cascades");
  const csm_create_info info = support_create_info(&f.record);
  assert_int_equal(csm_switch_backend(f.context, &info), CSM_SUCCESS);
  expect_frames(&f, 1, "another device");
  expect_frames(&f, 2, "the same device");
  teardown(&f);
}

/* From behind the boxes nothing is seen that was seen before. */
static void a_cut_begins_anew(void **state) {
  (void)state;
  fixture f;
  setup(&f);
  for (int i = 0; i < 3; ++i)
    free(draw(&f, CSM_SHOW_VISIBILITY));
  for (int i = 0; i < SUPPORT_INSTANCES; ++i)
    f.scene.instances[i].transform[13] += 100.0;
  f.scene.shot.camera.view[12] = 0;
  support_look_at(f.scene.shot.camera.view, (const double[]){6, 103, 10}, (const double[]){-2, 100, -4});
  expect_frames(&f, 1, "elsewhere");
  teardown(&f);
}

static csm_view_stats stats_of(csm_view *view) {
  csm_view_stats stats = {.struct_size = sizeof stats};
  assert_int_equal(csm_get_view_stats(view, &stats), CSM_SUCCESS);
  return stats;
}

static csm_binding bound(fixture *f) {
  csm_binding binding = {.struct_size = sizeof binding, .view = f->view};
  assert_int_equal(csm_bind(f->cascades, &binding), CSM_SUCCESS);
  return binding;
}

/* The mask stays the same image from frame to frame, and what a history takes goes with it. */
static void a_history_is_told_of(void **state) {
  (void)state;
  fixture f;
  setup(&f);
  free(draw(&f, CSM_SHOW_VISIBILITY));
  const csm_binding first = bound(&f);
  free(draw(&f, CSM_SHOW_VISIBILITY));
  const csm_binding second = bound(&f);
  assert_true((first.native_mask || !draws()) && first.native_mask == second.native_mask);
  /* Two of four halves, the mask, and two numbers of 16 bits of the frame alone; the camera's depth besides */
  const csm_view_stats on = stats_of(f.view);
  assert_true(on.history_bytes >= 21u * WIDTH * HEIGHT && on.bytes >= on.history_bytes + 4u * WIDTH * HEIGHT);
  f.config.history = CSM_HISTORY_OFF;
  assert_int_equal(csm_cascades_configure(f.cascades, &f.config), CSM_SUCCESS);
  free(draw(&f, CSM_SHOW_VISIBILITY));
  const csm_view_stats off = stats_of(f.view);
  assert_true(off.history_bytes == 0 && off.history_gpu_ms < 0);
  assert_true(off.bytes >= on.bytes - on.history_bytes + WIDTH * HEIGHT && off.bytes < on.bytes);
  assert_true(bound(&f).native_mask != second.native_mask || !draws());
  teardown(&f);
}

static void what_cannot_be_is_refused(void **state) {
  (void)state;
  fixture f;
  setup(&f);
  render(&f);
  f.record.quiet = true;
  const csm_mask_info moving = {
      .struct_size = sizeof moving, .frame = shot_frame(&f.scene.shot), .width = WIDTH, .height = HEIGHT, .motion = &f};
  assert_int_equal(csm_resolve_mask(f.view, f.cascades, &moving), CSM_ERROR_UNSUPPORTED);
  f.config.history = CSM_HISTORY_OFF;
  assert_int_equal(csm_cascades_configure(f.cascades, &f.config), CSM_SUCCESS);
  render(&f);
  assert_int_equal(resolve(&f, f.view, CSM_SHOW_HISTORY), CSM_ERROR_INVALID_VALUE);
  teardown(&f);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_still_view_gathers_frames),
      cmocka_unit_test(what_does_not_change_is_its_own_mean),
      cmocka_unit_test(shadows_at_rest_are_plain_means),
      cmocka_unit_test(a_camera_that_moves_keeps_what_it_still_sees),
      cmocka_unit_test(other_pictures_begin_anew),
      cmocka_unit_test(a_cut_begins_anew),
      cmocka_unit_test(a_history_is_told_of),
      cmocka_unit_test(what_cannot_be_is_refused),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
