/* A device's programs by key: each once, the counted ones gone with their last user, once the GPU is done with it. */
#include "device/device.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* What a driver would be asked for. */
typedef struct driver {
  uint32_t made, destroyed;
  csm_result refuses;
} driver;

static csm_result create(gpu_device *self, const gpu_program_info *info, gpu_program **out) {
  driver *driver = (void *)self;
  (void)info;
  *out = driver->refuses ? NULL : malloc(1);
  driver->made += !driver->refuses;
  return driver->refuses;
}

static void destroy(gpu_device *self, gpu_program *program) {
  driver *driver = (void *)self;
  driver->destroyed += program != NULL;
  free(program);
}

typedef struct fixture {
  driver driver;
  gpu_backend api;
  host host;
  device device;
} fixture;

static void begin(fixture *f) {
  *f = (fixture){.api = {.program_create = create, .program_destroy = destroy}, .host = host_default()};
  f->device = (device){.host = &f->host, .gpu = {&f->api, (gpu_device *)(void *)&f->driver}, .serial = 1};
}

static void end(fixture *f) {
  f->device.done = UINT64_MAX;
  retire_collect(&f->device);
  programs_destroy(&f->device);
  assert_int_equal(f->driver.destroyed, f->driver.made);
}

static csm_result make(gpu gpu, const void *about, gpu_program **out) {
  (void)about;
  return gpu_program_create(gpu, &(gpu_program_info){.name = "one"}, out);
}

static csm_result make_other(gpu gpu, const void *about, gpu_program **out) {
  (void)about;
  return gpu_program_create(gpu, &(gpu_program_info){.name = "another"}, out);
}

static program_key key_of(const uint64_t *number) {
  return (program_key){.make = make, .name = "a program", .about = number, .size = sizeof *number};
}

static gpu_program *found(fixture *f, uint64_t number) {
  const program_key key = key_of(&number);
  gpu_program *program = NULL;
  assert_int_equal(programs_find(&f->device, &key, &program), CSM_SUCCESS);
  return program;
}

static gpu_program *taken(fixture *f, uint64_t number) {
  const program_key key = key_of(&number);
  gpu_program *program = NULL;
  assert_int_equal(programs_take(&f->device, &key, &program), CSM_SUCCESS);
  return program;
}

static void one_program_for_a_key(void **state) {
  (void)state;
  fixture f;
  begin(&f);
  gpu_program *programs[1000];
  for (uint64_t i = 0; i < 1000; ++i)
    programs[i] = found(&f, i * 0x9e3779b97f4a7c15u);
  for (uint64_t i = 0; i < 1000; ++i)
    assert_ptr_equal(found(&f, i * 0x9e3779b97f4a7c15u), programs[i]);
  assert_int_equal(f.driver.made, 1000);
  end(&f);
}

static void the_maker_belongs_to_the_key(void **state) {
  (void)state;
  fixture f;
  begin(&f);
  const uint64_t number = 7;
  program_key key = key_of(&number);
  gpu_program *one, *another, *bare;
  assert_int_equal(programs_find(&f.device, &key, &one), CSM_SUCCESS);
  key.make = make_other;
  assert_int_equal(programs_find(&f.device, &key, &another), CSM_SUCCESS);
  assert_ptr_not_equal(one, another);
  assert_int_equal(programs_find(&f.device, &(program_key){.make = make, .name = "bare"}, &bare), CSM_SUCCESS);
  assert_ptr_not_equal(one, bare);
  end(&f);
}

static void the_last_user_takes_it_along(void **state) {
  (void)state;
  fixture f;
  begin(&f);
  gpu_program *program = taken(&f, 3);
  assert_ptr_equal(taken(&f, 3), program);
  programs_give_back(&f.device, program);
  assert_ptr_equal(taken(&f, 3), program);
  programs_give_back(&f.device, program);
  programs_give_back(&f.device, program);
  retire_collect(&f.device);
  assert_int_equal(f.driver.destroyed, 0); /* a frame in flight may draw with it */
  f.device.done = 1;
  retire_collect(&f.device);
  assert_int_equal(f.driver.destroyed, 1);
  (void)taken(&f, 3);
  assert_int_equal(f.driver.made, 2);
  programs_give_back(&f.device, NULL);
  end(&f);
}

static void what_was_found_stays(void **state) {
  (void)state;
  fixture f;
  begin(&f);
  gpu_program *program = found(&f, 5);
  assert_ptr_equal(taken(&f, 5), program);
  programs_give_back(&f.device, program);
  assert_ptr_equal(found(&f, 5), program);
  assert_int_equal(f.driver.made, 1);
  end(&f);
}

/* Whatever goes, the others are found: searches never stop at a gap. */
static void gaps_close(void **state) {
  (void)state;
  enum { count = 200 };
  fixture f;
  begin(&f);
  gpu_program *programs[count];
  for (uint64_t i = 0; i < count; ++i)
    programs[i] = taken(&f, i);
  uint32_t random = 1;
  for (uint32_t round = 0; round < 2000; ++round) {
    random = random * 1664525u + 1013904223u;
    const uint64_t i = (random >> 8) % count;
    programs_give_back(&f.device, programs[i]);
    const uint32_t made = f.driver.made;
    for (uint64_t k = 0; k < count; k += 7)
      if (k != i) {
        assert_ptr_equal(taken(&f, k), programs[k]);
        programs_give_back(&f.device, programs[k]);
      }
    assert_int_equal(f.driver.made, made);
    programs[i] = taken(&f, i);
    assert_int_equal(f.driver.made, made + 1);
  }
  end(&f);
}

static void a_refusal_leaves_nothing(void **state) {
  (void)state;
  fixture f;
  begin(&f);
  const uint64_t number = 9;
  const program_key key = key_of(&number);
  gpu_program *program = NULL;
  f.driver.refuses = CSM_ERROR_UNSUPPORTED;
  assert_int_equal(programs_find(&f.device, &key, &program), CSM_ERROR_UNSUPPORTED);
  assert_non_null(strstr(f.host.error, "a program"));
  assert_null(program);
  f.driver.refuses = CSM_SUCCESS;
  assert_int_equal(programs_find(&f.device, &key, &program), CSM_SUCCESS);
  assert_int_equal(f.driver.made, 1);
  f.driver.refuses = CSM_ERROR_DEVICE_LOST;
  const uint64_t next = 10;
  const program_key lost = key_of(&next);
  assert_int_equal(programs_take(&f.device, &lost, &program), CSM_ERROR_DEVICE_LOST);
  assert_true(f.device.lost);
  end(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(one_program_for_a_key),
      cmocka_unit_test(the_maker_belongs_to_the_key),
      cmocka_unit_test(the_last_user_takes_it_along),
      cmocka_unit_test(what_was_found_stays),
      cmocka_unit_test(gaps_close),
      cmocka_unit_test(a_refusal_leaves_nothing),
  };
  return cmocka_run_group_tests_name("device-programs", tests, NULL, NULL);
}
