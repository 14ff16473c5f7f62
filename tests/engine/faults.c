/* faults.c: each call of an engine's device that may fail does, and each allocation. */
#include "life.h"

static void every_call_may_fail(void **state) {
  (void)state;
  props props;
  rig *rig = rig_open(RIG_FAILING);
  props_open(&props, rig);
  live_with_faults(&props);
  props_close(&props);
  rig_close(rig);
}

/* What is drawn after a device was lost is what was drawn before it. */
static void lose_and_leave(props *props, const csm_config *config) {
  life life;
  life_open(&life, props);
  picture_free(&life.picture);
  life.picture = (picture){0};
  assert_int_equal(csm_cascades_configure(life.cascades, config), CSM_SUCCESS);
  assert_int_equal(life_render(&life), CSM_SUCCESS);
  assert_int_equal(life_resolve(&life), CSM_SUCCESS);
  assert_int_equal(life_finish(&life), CSM_SUCCESS);
  picture before = life.picture;
  life.picture = (picture){0};
  assert_int_equal(life_render(&life), CSM_SUCCESS);
  if (rig_lose()) {
    assert_int_equal(life_render(&life), CSM_ERROR_DEVICE_LOST);
    assert_int_equal(life_resolve_images(&life), CSM_ERROR_DEVICE_LOST);
    life_expect_lost(&life);
    rig_find();
    assert_int_equal(life_switch(&life), CSM_SUCCESS);
    assert_int_equal(life_render(&life), CSM_SUCCESS);
  }
  assert_int_equal(life_resolve(&life), CSM_SUCCESS);
  assert_int_equal(life_finish(&life), CSM_SUCCESS);
  picture_expect_equal(&before, &life.picture);
  picture_free(&before);
  life_end(&life);
}

/* A device that is lost between frames is told by the next, where an API can tell, and left by a switch; with moments and
   a history, too, of which nothing is left. */
static void a_lost_device_can_be_left(void **state) {
  (void)state;
  props props;
  csm_config config = life_config(2);
  rig *rig = rig_open(RIG_FAILING);
  props_open(&props, rig);
  lose_and_leave(&props, &config);
  config.filter = CSM_FILTER_EVSM4;
  config.moment_blur_texels = 3;
  config.moment_levels = 3;
  config.moment_sampling = CSM_SAMPLING_TRILINEAR;
  config.caster_set = CSM_CASTER_SET_VIEW;
  config.history = CSM_HISTORY_ON;
  lose_and_leave(&props, &config);
  config = life_config(2);
  config.filter = CSM_FILTER_EXACT;
  lose_and_leave(&props, &config);
  props_close(&props);
  rig_close(rig);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_lost_device_can_be_left),
      cmocka_unit_test(every_call_may_fail),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
