/*
 * views.c: pictures of one set of maps: each view has a mask, a camera depth and depth samples of its own, in a size of
 * its own, and none disturbs another.
 */
#include "outcome.h"

#include <stdlib.h>
#include <string.h>

typedef struct fixture {
  record record;
  csm_context *context;
  csm_cascades *cascades;
  csm_config config;
  support_scene scene;
} fixture;

static void setup_with(fixture *f, uint32_t flags) {
  memset(f, 0, sizeof *f);
  csm_create_info info = support_create_info(&f->record);
  info.flags |= flags;
  assert_int_equal(csm_create(&info, &f->context), CSM_SUCCESS);
  f->config = support_config();
  support_scene_make(&f->scene, f->context);
  assert_int_equal(csm_cascades_create(f->context, &f->config, &f->cascades), CSM_SUCCESS);
}

static void setup(fixture *f) {
  setup_with(f, 0);
}

static void teardown(fixture *f) {
  support_close(f->context, &f->record);
}

/* One picture: whose eye, and how large. */
typedef struct eye {
  csm_view *view;
  shot shot;
  uint32_t width, height;
  float *mask, *depth; /* as they should be */
} eye;

enum { EYES = 3 };

/* Two eyes that are a hand apart, and a small mirror that looks another way. */
static void make_eyes(fixture *f, eye eyes[EYES]) {
  static const uint32_t sizes[EYES][2] = {{160, 100}, {160, 100}, {33, 57}};
  for (int i = 0; i < EYES; ++i) {
    eyes[i] =
        (eye){.view = support_view(f->context), .shot = f->scene.shot, .width = sizes[i][0], .height = sizes[i][1]};
    eyes[i].shot.frame.instances = f->scene.instances;
  }
  eyes[1].shot.camera.view[12] -= 0.064;
  support_look_at(eyes[2].shot.camera.view, (const double[]){6, 3, 10}, (const double[]){-2, 0, -4});
}

static void resolve(fixture *f, eye *eye) {
  assert_int_equal(shot_resolve(&eye->shot, eye->view, f->cascades, eye->width, eye->height), CSM_SUCCESS);
}

/* What an eye sees alone. */
static void look_alone(fixture *f, eye *eye) {
  csm_view *alone = support_view(f->context);
  assert_int_equal(shot_resolve(&eye->shot, alone, f->cascades, eye->width, eye->height), CSM_SUCCESS);
  eye->mask = support_image(f->context, alone, CSM_READ_MASK, eye->width, eye->height);
  eye->depth = support_image(f->context, alone, CSM_READ_CAMERA_DEPTH, eye->width, eye->height);
  assert_int_equal(csm_view_destroy(alone), CSM_SUCCESS);
}

static void expect_alone(fixture *f, const eye *eye, const char *what) {
  const size_t size = (size_t)eye->width * eye->height * sizeof(float);
  float *mask = support_image(f->context, eye->view, CSM_READ_MASK, eye->width, eye->height);
  float *depth = support_image(f->context, eye->view, CSM_READ_CAMERA_DEPTH, eye->width, eye->height);
  if (memcmp(mask, eye->mask, size) || memcmp(depth, eye->depth, size))
    fail_msg("%s: another picture", what);
  free(mask);
  free(depth);
}

static void forget(eye eyes[EYES]) {
  for (int i = 0; i < EYES; ++i) {
    free(eyes[i].mask);
    free(eyes[i].depth);
  }
}

static void render(fixture *f, eye *eye) {
  assert_int_equal(csm_render_cascades(f->cascades, shot_frame(&eye->shot)), CSM_SUCCESS);
}

/* ---- several views of one set of maps ---- */

static void views_do_not_disturb_each_other(void **state) {
  (void)state;
  fixture f;
  eye eyes[EYES];
  setup(&f);
  make_eyes(&f, eyes);
  render(&f, &eyes[0]);
  for (int i = 0; i < EYES; ++i)
    look_alone(&f, &eyes[i]);
  if (strcmp(support_backend(), "null"))
    assert_memory_not_equal(eyes[0].depth, eyes[1].depth, 160 * 100 * sizeof(float));
  for (int frame = 0; frame < 4; ++frame) {
    render(&f, &eyes[0]);
    for (int i = 0; i < EYES; ++i)
      resolve(&f, &eyes[(i + frame) % EYES]);
    for (int i = 0; i < EYES; ++i)
      expect_alone(&f, &eyes[i], "one of three");
  }
  /* Images are made once: what a view holds does not change, and goes with it. */
  csm_view_stats stats[EYES];
  for (int i = 0; i < EYES; ++i) {
    stats[i] = (csm_view_stats){.struct_size = sizeof stats[i]};
    assert_int_equal(csm_get_view_stats(eyes[i].view, &stats[i]), CSM_SUCCESS);
    assert_true(stats[i].width == eyes[i].width && stats[i].height == eyes[i].height);
    assert_true(stats[i].bytes >= 5ull * eyes[i].width * eyes[i].height);
  }
  assert_true(stats[0].bytes == stats[1].bytes && stats[0].bytes >= stats[2].bytes);
  forget(eyes);
  teardown(&f);
}

/* A view goes on from one set of cascades to another. */
static void a_view_may_change_its_cascades(void **state) {
  (void)state;
  fixture f;
  csm_cascades *second;
  setup(&f);
  csm_config other = f.config;
  other.cascade_count = 1;
  other.resolution = 64;
  assert_int_equal(csm_cascades_create(f.context, &other, &second), CSM_SUCCESS);
  csm_view *shared = support_view(f.context), *own[2] = {support_view(f.context), support_view(f.context)};
  for (int i = 0; i < 4; ++i) {
    csm_cascades *cascades = i % 2 ? second : f.cascades;
    shot shot = f.scene.shot;
    shot.frame.instances = f.scene.instances;
    outcome expected = outcome_draw(f.context, cascades, own[i % 2], &shot);
    outcome drawn = outcome_draw(f.context, cascades, shared, &shot);
    outcome_expect_same(&expected, &drawn, "a shared view");
    outcome_free(&expected);
  }
  assert_int_equal(csm_cascades_destroy(second), CSM_SUCCESS); /* its last mask is there still */
  free(support_image(f.context, shared, CSM_READ_MASK, OUTCOME_WIDTH, OUTCOME_HEIGHT));
  teardown(&f);
}

/* ---- lives ---- */

/* Views come and go while frames that use them are in flight. */
static void views_may_go_at_any_time(void **state) {
  (void)state;
  fixture f;
  eye eyes[EYES];
  setup(&f);
  make_eyes(&f, eyes);
  render(&f, &eyes[0]);
  for (int i = 0; i < EYES; ++i)
    look_alone(&f, &eyes[i]);
  for (int frame = 0; frame < 12; ++frame) {
    eye brief = eyes[frame % EYES];
    brief.view = support_view(f.context);
    render(&f, &eyes[0]);
    resolve(&f, &brief);
    resolve(&f, &eyes[(frame + 1) % EYES]);
    assert_int_equal(csm_view_destroy(brief.view), CSM_SUCCESS);
    if (frame % 3 == 2)
      expect_alone(&f, &eyes[(frame + 1) % EYES], "beside views that went");
  }
  const int64_t blocks = f.record.blocks;
  for (int i = 0; i < EYES; ++i)
    assert_int_equal(csm_view_destroy(eyes[i].view), CSM_SUCCESS);
  csm_stats stats = {.struct_size = sizeof stats}; /* waits */
  assert_int_equal(csm_get_stats(f.cascades, &stats), CSM_SUCCESS);
  render(&f, &eyes[0]); /* what waited for frames goes with the next */
  assert_true(f.record.blocks < blocks);
  forget(eyes);
  teardown(&f);
}

static void a_switch_takes_views_along(void **state) {
  (void)state;
  const char *mine = support_backend();
  const char *other = !strcmp(mine, "vulkan") ? "d3d12" : !strcmp(mine, "d3d12") ? "vulkan" : mine;
  fixture f;
  eye eyes[EYES];
  setup_with(&f, CSM_CREATE_KEEP_GEOMETRY);
  make_eyes(&f, eyes);
  render(&f, &eyes[0]);
  for (int i = 0; i < EYES; ++i)
    look_alone(&f, &eyes[i]);
  for (int round = 0; round < 3; ++round) {
    for (int i = 0; i < EYES - (round == 1); ++i) /* one of them rests for a while */
      resolve(&f, &eyes[i]);
    csm_create_info info = support_create_info(&f.record);
    info.backend = round % 2 ? mine : other;
    assert_int_equal(csm_switch_backend(f.context, &info), CSM_SUCCESS);
    csm_view_stats stats = {.struct_size = sizeof stats};
    csm_binding binding = {.struct_size = sizeof binding, .view = eyes[0].view};
    render(&f, &eyes[0]);
    assert_int_equal(csm_get_view_stats(eyes[0].view, &stats), CSM_SUCCESS);
    assert_true(stats.bytes == 0); /* nothing of the old device is left */
    assert_int_equal(csm_bind(f.cascades, &binding), CSM_SUCCESS);
    assert_true(binding.native_mask == 0);
    for (int i = 0; i < EYES; ++i)
      resolve(&f, &eyes[i]);
    for (int i = 0; i < EYES; ++i)
      expect_alone(&f, &eyes[i], "after a switch");
    assert_int_equal(csm_bind(f.cascades, &binding), CSM_SUCCESS);
    assert_true(binding.native_mask != 0 || !strcmp(mine, "null"));
  }
  forget(eyes);
  teardown(&f);
}

/* ---- what a view saw ---- */

/* Where the last of three cascades ends, after frames that every view saw. */
static double settle(fixture *f, csm_cascades *cascades, eye *eyes, uint32_t mask, int frames) {
  csm_binding binding = {.struct_size = sizeof binding};
  for (int frame = 0; frame < frames; ++frame) {
    assert_int_equal(csm_render_cascades(cascades, shot_frame(&eyes[0].shot)), CSM_SUCCESS);
    for (uint32_t i = 0; i < EYES; ++i)
      if (mask >> i & 1)
        assert_int_equal(shot_resolve(&eyes[i].shot, eyes[i].view, cascades, eyes[i].width, eyes[i].height),
                         CSM_SUCCESS);
    csm_stats stats = {.struct_size = sizeof stats};
    assert_int_equal(csm_get_stats(cascades, &stats), CSM_SUCCESS);
  }
  assert_int_equal(csm_render_cascades(cascades, shot_frame(&eyes[0].shot)), CSM_SUCCESS);
  assert_int_equal(csm_bind(cascades, &binding), CSM_SUCCESS);
  (void)f;
  return binding.cascades[2].far_depth;
}

/* Cascades are fitted to what all views see that look where they do: a far look by one eye is not forgotten for the
   other's near one. A mirror neither fits them nor keeps them from being fitted. */
static void cascades_fit_what_all_views_saw(void **state) {
  (void)state;
  if (!strcmp(support_backend(), "null")) /* sees nothing */
    return;
  fixture f;
  eye eyes[EYES];
  csm_cascades *cascades;
  setup(&f);
  make_eyes(&f, eyes);
  csm_config config = f.config;
  config.shadow_distance = 1000;
  config.depth_samples = CSM_DEPTH_SAMPLES_SPLITS;
  support_look_at(eyes[0].shot.camera.view, (const double[]){0, 3, 2}, (const double[]){0, 0, -0.5}); /* down */
  eyes[1].shot.camera = eyes[0].shot.camera;
  support_look_at(eyes[1].shot.camera.view, (const double[]){0, 3.3, 2}, (const double[]){0, 0.55, -0.5}); /* farther */
  double ends[5];
  const uint32_t masks[5] = {1, 4, 5, 3, 0};
  for (int i = 0; i < 5; ++i) {
    assert_int_equal(csm_cascades_create(f.context, &config, &cascades), CSM_SUCCESS);
    ends[i] = settle(&f, cascades, eyes, masks[i], 6);
    assert_int_equal(csm_cascades_destroy(cascades), CSM_SUCCESS);
  }
  assert_true(ends[0] < 20);
  assert_true(ends[1] == ends[4] && ends[4] > 100);
  assert_true(ends[2] == ends[0]);
  assert_true(ends[3] > ends[0] && ends[3] < ends[4] / 2);
  teardown(&f);
}

/* A resolve of another size that fails leaves what the view saw: the next frame is fitted as if it had not been. */
static void a_failed_resolve_keeps_depth_samples(void **state) {
  (void)state;
  if (!strcmp(support_backend(), "null"))
    return;
  fixture f;
  eye eyes[EYES];
  csm_cascades *cascades;
  setup(&f);
  make_eyes(&f, eyes);
  csm_config config = f.config;
  config.shadow_distance = 1000;
  config.depth_samples = CSM_DEPTH_SAMPLES_SPLITS;
  assert_int_equal(csm_cascades_create(f.context, &config, &cascades), CSM_SUCCESS);
  const double settled = settle(&f, cascades, eyes, 1, 6);
  assert_true(settled < 100);
  f.record.quiet = true;
  csm_result result;
  int64_t failures = 0;
  do {
    f.record.allocations_left = failures++;
    result = shot_resolve(&eyes[0].shot, eyes[0].view, cascades, 48, 48);
    f.record.allocations_left = -1;
    if (result) {
      assert_true(settle(&f, cascades, eyes, 0, 0) == settled);
      assert_true(settle(&f, cascades, eyes, 1, 1) == settled);
    }
  } while (result);
  assert_true(failures > 3);
  teardown(&f);
}

/* A view that shows no picture of the cascades any more does not keep what it saw in their way. */
static void a_view_that_rests_is_left_out(void **state) {
  (void)state;
  if (!strcmp(support_backend(), "null"))
    return;
  fixture f;
  eye eyes[EYES];
  setup(&f);
  make_eyes(&f, eyes);
  f.config.shadow_distance = 1000;
  f.config.depth_samples = CSM_DEPTH_SAMPLES_SPLITS;
  assert_int_equal(csm_cascades_configure(f.cascades, &f.config), CSM_SUCCESS);
  const double unfitted = settle(&f, f.cascades, eyes, 0, 0);
  assert_true(settle(&f, f.cascades, eyes, 3, 6) < unfitted / 2);
  support_look_at(eyes[0].shot.camera.view, (const double[]){0, 3, 2}, (const double[]){0, 0, -0.5}); /* a cut */
  assert_true(settle(&f, f.cascades, eyes, 1, 3) == unfitted);
  assert_true(settle(&f, f.cascades, eyes, 1, 30) < 20);
  teardown(&f);
}

/* What was seen before depth samples were turned off is not used when they are on again, and its images go. */
static void a_setting_that_ends_forgets_what_was_seen(void **state) {
  (void)state;
  if (!strcmp(support_backend(), "null"))
    return;
  fixture f;
  eye eyes[EYES];
  setup(&f);
  make_eyes(&f, eyes);
  csm_view_stats stats = {.struct_size = sizeof stats};
  f.config.shadow_distance = 1000;
  f.config.depth_samples = CSM_DEPTH_SAMPLES_SPLITS;
  assert_int_equal(csm_cascades_configure(f.cascades, &f.config), CSM_SUCCESS);
  const double unfitted = settle(&f, f.cascades, eyes, 0, 0);
  assert_true(settle(&f, f.cascades, eyes, 1, 6) < unfitted / 2);
  assert_int_equal(csm_get_view_stats(eyes[0].view, &stats), CSM_SUCCESS);
  const uint64_t bytes = stats.bytes;
  f.config.depth_samples = CSM_DEPTH_SAMPLES_OFF;
  assert_int_equal(csm_cascades_configure(f.cascades, &f.config), CSM_SUCCESS);
  assert_int_equal(csm_get_view_stats(eyes[0].view, &stats), CSM_SUCCESS);
  assert_true(stats.bytes < bytes);
  f.config.depth_samples = CSM_DEPTH_SAMPLES_SPLITS;
  assert_int_equal(csm_cascades_configure(f.cascades, &f.config), CSM_SUCCESS);
  assert_true(settle(&f, f.cascades, eyes, 1, 0) == unfitted);
  teardown(&f);
}

/* The first frame after a switch is fitted to what was seen on the device before: the splits do not jump. */
static void a_switch_keeps_depth_samples(void **state) {
  (void)state;
  if (!strcmp(support_backend(), "null"))
    return;
  fixture f;
  eye eyes[EYES];
  setup_with(&f, CSM_CREATE_KEEP_GEOMETRY);
  make_eyes(&f, eyes);
  f.config.shadow_distance = 1000;
  f.config.depth_samples = CSM_DEPTH_SAMPLES_SPLITS;
  assert_int_equal(csm_cascades_configure(f.cascades, &f.config), CSM_SUCCESS);
  const double unfitted = settle(&f, f.cascades, eyes, 0, 1), settled = settle(&f, f.cascades, eyes, 1, 6);
  assert_true(settled < unfitted / 2);
  csm_create_info info = support_create_info(&f.record);
  assert_int_equal(csm_switch_backend(f.context, &info), CSM_SUCCESS);
  assert_true(settle(&f, f.cascades, eyes, 0, 0) == settled);
  teardown(&f);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(views_do_not_disturb_each_other), cmocka_unit_test(a_view_may_change_its_cascades),
      cmocka_unit_test(views_may_go_at_any_time),        cmocka_unit_test(a_switch_takes_views_along),
      cmocka_unit_test(cascades_fit_what_all_views_saw), cmocka_unit_test(a_failed_resolve_keeps_depth_samples),
      cmocka_unit_test(a_view_that_rests_is_left_out),   cmocka_unit_test(a_setting_that_ends_forgets_what_was_seen),
      cmocka_unit_test(a_switch_keeps_depth_samples),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
