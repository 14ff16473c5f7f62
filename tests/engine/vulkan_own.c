/*
 * vulkan_own.c: faults and a memory budget on devices that csm opens by itself, which Vulkan alone lets be tried: its
 * library is opened by name, and hands out the test's functions instead. The budget on an engine's device, too.
 */
#include "life.h"
#include "rig_vulkan.h"
#include "rig_vulkan_faults.h"

#include <dlfcn.h>
#include <string.h>

/* Takes the place of the C library's. */
void *dlopen(const char *name, int flags);
void *dlopen(const char *name, int flags) {
  void *const symbol = dlsym(RTLD_NEXT, "dlopen");
  void *(*real)(const char *, int);
  memcpy(&real, &symbol, sizeof real);
  return real(name && !strcmp(name, "libvulkan.so.1") ? FAKE_VULKAN : name, flags);
}

static void every_call_may_fail_on_an_own_device(void **state) {
  (void)state;
  props props;
  props_open(&props, NULL);
  live_with_faults(&props);
  props_close(&props);
}

/* ---- a budget ---- */

static void keep_a_budget(props *props) {
  enum { MEBIBYTE = 1 << 20 };
  life life;
  faults.tells_budget = true;
  faults.budget = 160 * (uint64_t)MEBIBYTE;
  faults.used = 40 * (uint64_t)MEBIBYTE;
  faults.most = 0;
  life_open(&life, props);
  csm_config wanted = life_config(4);
  wanted.resolution = 2048; /* 64 MiB */
  assert_int_equal(csm_cascades_configure(life.cascades, &wanted), CSM_SUCCESS);
  csm_cascades *more = NULL;
  assert_int_equal(csm_cascades_create(life.context, &wanted, &more), CSM_ERROR_LIMIT_EXCEEDED);
  assert_non_null(strstr(csm_last_error(life.context), "budget"));
  assert_null(more);
  assert_int_equal(life_render(&life), CSM_SUCCESS);
  assert_int_equal(life_resolve(&life), CSM_SUCCESS);
  faults.used = 0; /* others have gone */
  assert_int_equal(csm_cascades_create(life.context, &wanted, &more), CSM_SUCCESS);
  faults.used = 200 * (uint64_t)MEBIBYTE; /* others take more than there is */
  csm_cascades *none = NULL;
  const csm_config small = life_config(1);
  assert_int_equal(csm_cascades_create(life.context, &small, &none), CSM_ERROR_LIMIT_EXCEEDED);
  assert_true(faults.most <= 160 * (uint64_t)MEBIBYTE);
  life_end(&life);
  faults.tells_budget = false;
}

static void a_budget_is_kept_on_an_engines_device(void **state) {
  (void)state;
  static const char *const extensions[] = {"VK_KHR_maintenance9", VK_EXT_MEMORY_BUDGET_EXTENSION_NAME};
  props props;
  rig *rig = rig_open(RIG_FAILING);
  rig->native.extensions = extensions;
  rig->native.extension_count = 2;
  props_open(&props, rig);
  keep_a_budget(&props);
  props_close(&props);
  rig_close(rig);
}

static void a_budget_is_kept_on_an_own_device(void **state) {
  (void)state;
  props props;
  props_open(&props, NULL);
  keep_a_budget(&props);
  props_close(&props);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_budget_is_kept_on_an_engines_device),
      cmocka_unit_test(a_budget_is_kept_on_an_own_device),
      cmocka_unit_test(every_call_may_fail_on_an_own_device),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
