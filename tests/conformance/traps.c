/*
 * traps.c: an engine's debug build lets floating-point exceptions trap: an ordinary frame raises none. On the null
 * backend, since drivers' own threads and libraries are not csm's to answer for.
 */
#include "telling.h"

#include <fenv.h>
#include <math.h>

enum { TRAPPED = FE_DIVBYZERO | FE_INVALID | FE_OVERFLOW };

typedef struct fixture {
  record record;
  csm_context *context;
  csm_view *view;
  telling telling;
} fixture;

enum { CAMERAS = 2 * TELLING_CAMERAS };

/* The second half of the cameras turns the picture by 90 degrees, as for a display that stands upright. */
static shot take_shot(const telling *telling, uint32_t camera, uint32_t step) {
  shot shot = telling_shot(telling, camera, step, 1.5);
  double *p = shot.camera.projection;
  for (int column = 0; column < 4 && camera >= TELLING_CAMERAS; ++column, p += 4) {
    const double x = p[0];
    p[0] = p[1];
    p[1] = -x;
  }
  return shot;
}

/* Every call of a frame, with these settings, while exceptions trap; and those that make and change things. */
static void draw_trapped(fixture *f, const csm_config *config, uint32_t camera) {
  csm_cascades *cascades;
  csm_scene *scene;
  csm_instance_id ids[TELLING_INSTANCES];
  assert_int_equal(feenableexcept(TRAPPED) & TRAPPED, 0);
  assert_int_equal(csm_cascades_create(f->context, config, &cascades), CSM_SUCCESS);
  assert_int_equal(csm_scene_create(f->context, &scene), CSM_SUCCESS);
  assert_int_equal(csm_scene_add(scene, &(csm_scene_batch){.struct_size = sizeof(csm_scene_batch),
                                                           .count = TELLING_INSTANCES,
                                                           .ids = ids,
                                                           .instances = f->telling.instances}),
                   CSM_SUCCESS);
  for (uint32_t step = 0; step < 3; ++step) {
    fedisableexcept(TRAPPED); /* the test's own sums are its own */
    shot shot = take_shot(&f->telling, camera, step);
    if (step == 2) {
      shot.frame.instances = NULL;
      shot.frame.instance_count = 0;
      shot.frame.scene = scene;
    }
    feclearexcept(FE_ALL_EXCEPT);
    feenableexcept(TRAPPED);
    const csm_result rendered = csm_render_cascades(cascades, shot_frame(&shot));
    const csm_result resolved = shot_resolve(&shot, f->view, cascades, 96, 64);
    csm_binding binding = {.struct_size = sizeof binding};
    const csm_result bound = csm_bind(cascades, &binding);
    assert_true(!rendered && !resolved && !bound);
  }
  assert_int_equal(csm_scene_destroy(scene), CSM_SUCCESS);
  assert_int_equal(csm_cascades_destroy(cascades), CSM_SUCCESS);
  fedisableexcept(TRAPPED);
}

static void an_ordinary_frame_raises_no_exceptions(void **state) {
  (void)state;
  fixture f = {0};
  f.context = support_open_with(&f.record, CSM_CREATE_RAYS);
  f.view = support_view(f.context);
  telling_make(&f.telling, f.context);
  csm_preset_info preset = {.struct_size = sizeof preset};
  for (uint32_t i = 0; csm_config_preset_describe(i, &preset) == CSM_SUCCESS; ++i)
    for (uint32_t camera = 0; camera < CAMERAS; ++camera) {
      csm_config config = {.struct_size = sizeof config};
      assert_int_equal(csm_config_preset(preset.name, &config), CSM_SUCCESS);
      config.resolution = 256; /* soft filters keep 65 texels at a border then */
      config.soft_radius_max_texels = fmin(config.soft_radius_max_texels, 64.0);
      for (int k = 0; k < CSM_MAX_CASCADES; ++k)
        config.resolutions[k] = 0;
      draw_trapped(&f, &config, camera);
    }
  support_close(f.context, &f.record);
}

/* The test's traps are real: a sum that is none ends in a signal, which is looked for by its flag here. */
static void an_exception_would_be_seen(void **state) {
  (void)state;
  volatile double zero = 0, none = 0;
  feclearexcept(FE_ALL_EXCEPT);
  none = none / zero;
  assert_true(fetestexcept(FE_INVALID));
  feclearexcept(FE_ALL_EXCEPT);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(an_ordinary_frame_raises_no_exceptions),
      cmocka_unit_test(an_exception_would_be_seen),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
