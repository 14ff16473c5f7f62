/* What fails on the engine's device of the hard cases is told, as on csm's own: no exit code comes without its reason. */
#include "base/host.h"
#include "hard/engine.h"
#include "stage/stage.h"
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <cmocka.h>

/* Sets what is refused, with what is printed meanwhile in `told`. */
static int restart_badly(hard_engine *engine, const csm_config *config, char *told, size_t size) {
  FILE *file = tmpfile();
  assert_non_null(file);
  const int kept = dup(STDERR_FILENO);
  dup2(fileno(file), STDERR_FILENO);
  const int code = stage_restart(hard_engine_stage(engine), config);
  dup2(kept, STDERR_FILENO);
  close(kept);
  rewind(file);
  told[fread(told, 1, size - 1, file)] = '\0';
  fclose(file);
  return code;
}

static void a_refusal_is_told(void **state) {
  (void)state;
  host_options options;
  host_setup setup;
  hard_engine *engine = NULL;
  char told[1024], *words[] = {"csm-host", "hard", "--backend", "vulkan"};
  assert_int_equal(options_parse(&options, sizeof words / sizeof words[0], words), 0);
  hard_setup_begin(&setup, 64, 36);
  hard_yard(&setup, true);
  assert_int_equal(hard_engine_open(&engine, &setup, &options, false), 0);
  csm_config config = setup.config;
  config.cascade_count = CSM_MAX_CASCADES + 1;
  assert_int_equal(restart_badly(engine, &config, told, sizeof told), HOST_BAD_INPUT);
  assert_non_null(strstr(told, "cascade_count"));
  hard_engine_close(engine);
  setup_free(&setup);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(a_refusal_is_told)};
  return cmocka_run_group_tests_name("hard engine", tests, NULL, NULL);
}
