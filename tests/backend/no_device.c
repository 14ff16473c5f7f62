/*
 * no_device.c: a machine without a Vulkan driver, which the environment makes of this one (VK_DRIVER_FILES). Every
 * backend gives the same named answer, says why, and can be asked again.
 */
#include "csm/csm.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

static const char *const backends[] = {
#ifdef WITH_VULKAN
    "vulkan",
#endif
#ifdef WITH_D3D12
    "d3d12",
#endif
};
enum { BACKENDS = sizeof backends / sizeof backends[0] };

static void CSM_CALL count_error(void *user, int32_t level, const char *message) {
  *(uint32_t *)user += level == CSM_LOG_ERROR && message[0];
}

static void creation_says_no_device(void **state) {
  (void)state;
  for (int round = 0; round < 2; round++)
    for (uint32_t i = 0; i < BACKENDS; i++) {
      char text[256] = "";
      uint32_t errors = 0;
      const csm_create_info info = {.struct_size = sizeof info,
                                    .version = CSM_VERSION,
                                    .backend = backends[i],
                                    .log = count_error,
                                    .user = &errors,
                                    .error = text,
                                    .error_size = sizeof text};
      csm_context *context = (csm_context *)&info;
      assert_int_equal(csm_create(&info, &context), CSM_ERROR_NO_DEVICE);
      assert_null(context);
      assert_int_equal(errors, 1);
      assert_non_null(strstr(text, "Vulkan driver"));
    }
}

static void a_query_says_no_device(void **state) {
  (void)state;
  uint32_t count = 0, found = 0;
  assert_int_equal(csm_query_backends(&count, NULL), CSM_SUCCESS);
  assert_in_range(count, 1, 8);
  csm_backend_info infos[8] = {{.struct_size = sizeof infos[0]}};
  assert_int_equal(csm_query_backends(&count, infos), CSM_SUCCESS);
  for (uint32_t i = 0; i < count; i++)
    for (uint32_t k = 0; k < BACKENDS; k++)
      if (strcmp(infos[i].name, backends[k]) == 0) {
        assert_int_equal(infos[i].result, CSM_ERROR_NO_DEVICE);
        assert_non_null(strstr(infos[i].error, "Vulkan driver"));
        assert_true(infos[i].path[0] && !infos[i].device[0]);
        found++;
      }
  assert_int_equal(found, BACKENDS);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(creation_says_no_device),
      cmocka_unit_test(a_query_says_no_device),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
