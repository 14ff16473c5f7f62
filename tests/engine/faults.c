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

/* A device that is lost between frames is told by the next, where an API can tell, and left by a switch. */
static void a_lost_device_can_be_left(void **state) {
  (void)state;
  props props;
  life life;
  rig *rig = rig_open(RIG_FAILING);
  props_open(&props, rig);
  life_open(&life, &props);
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
