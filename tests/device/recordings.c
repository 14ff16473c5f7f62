/* Frames in flight: whose times are told, in which order, and what becomes of those that cannot be read. */
#include "device/device.h"

#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

enum { SLOTS = 3 };

/* A driver whose clock counts recordings. */
typedef struct driver {
  uint64_t clock, stamps[DEVICE_MAX_SLOTS];
  uint32_t slot, reads;
  csm_result refuses[DEVICE_MAX_SLOTS];
} driver;

static csm_result begin(gpu_device *self, const gpu_record_info *info) {
  driver *driver = (void *)self;
  driver->slot = info->slot;
  return CSM_SUCCESS;
}

static csm_result end(gpu_device *self) {
  driver *driver = (void *)self;
  driver->stamps[driver->slot] = ++driver->clock;
  return CSM_SUCCESS;
}

static csm_result wait_for(gpu_device *self, uint32_t slot) {
  (void)self;
  (void)slot;
  return CSM_SUCCESS;
}

static csm_result read(gpu_device *self, uint32_t slot, uint32_t first, uint32_t count, uint64_t *nanoseconds) {
  driver *driver = (void *)self;
  (void)first;
  ++driver->reads;
  for (uint32_t i = 0; i < count; ++i)
    nanoseconds[i] = driver->stamps[slot];
  return driver->refuses[slot];
}

typedef struct fixture {
  driver driver;
  gpu_backend api;
  host host;
  device device;
  uint64_t told; /* the last time */
  uint32_t count;
} fixture;

static void open(fixture *f, bool own) {
  *f = (fixture){.api = {.begin = begin, .end = end, .wait = wait_for, .timestamps = read}, .host = host_default()};
  f->device =
      (device){.host = &f->host, .gpu = {&f->api, (gpu_device *)(void *)&f->driver}, .own = own, .slot_count = SLOTS};
}

static void take(void *user, const uint64_t *nanoseconds, uint32_t count) {
  fixture *f = user;
  assert_int_equal(count, 1);
  f->told = nanoseconds[0];
  ++f->count;
}

static void record(fixture *f, uint64_t frame, bool timed) {
  ring_range range;
  uint32_t first;
  assert_int_equal(recording_prepare(&f->device, frame, 0, &range), CSM_SUCCESS);
  assert_int_equal(recording_begin(&f->device, NULL), CSM_SUCCESS);
  if (timed)
    assert_true(recording_expect_timing(&f->device, &(timing_sink){.take = take, .user = f}, 1, &first));
  assert_int_equal(recording_end(&f->device), CSM_SUCCESS);
}

/* Wherever the newest frame's slot is. */
static void the_newest_frame_is_told_last(void **state) {
  (void)state;
  for (int own = 0; own < 2; ++own)
    for (uint64_t first = 0; first < SLOTS; ++first) {
      fixture f;
      open(&f, own);
      for (uint64_t i = 1; i <= first + SLOTS; ++i) {
        record(&f, own ? 0 : i, true);
        if (i <= first)
          assert_int_equal(own ? recording_finish(&f.device) : recording_retire(&f.device, i), CSM_SUCCESS);
      }
      assert_int_equal(own ? recording_finish(&f.device) : recording_retire(&f.device, first + SLOTS), CSM_SUCCESS);
      assert_int_equal(f.count, first + SLOTS);
      assert_int_equal(f.told, first + SLOTS);
    }
}

/* One frame's error does not keep the others' times; a frame that measured nothing is none. */
static void an_error_is_that_of_one_frame(void **state) {
  (void)state;
  fixture f;
  open(&f, false);
  for (uint64_t i = 1; i <= SLOTS; ++i)
    record(&f, i, true);
  f.driver.refuses[1] = CSM_ERROR_DEVICE;
  f.driver.refuses[2] = CSM_ERROR_UNSUPPORTED;
  assert_int_equal(recording_retire(&f.device, SLOTS), CSM_ERROR_DEVICE);
  assert_int_equal(f.count, 1);
  assert_int_equal(f.device.done, SLOTS);
  assert_int_equal(recording_retire(&f.device, SLOTS), CSM_SUCCESS);
}

static void a_lost_device_is_not_asked(void **state) {
  (void)state;
  fixture f;
  open(&f, false);
  record(&f, 1, true);
  f.device.lost = true;
  f.driver.refuses[f.device.slot] = CSM_ERROR_DEVICE_LOST;
  assert_int_equal(recording_retire(&f.device, 1), CSM_SUCCESS);
  assert_int_equal(f.driver.reads, 0);
}

static uint32_t order[4], gone;

static void go(device *device, retired *self) {
  (void)device;
  order[gone++] = (uint32_t)(self->serial * 10);
}

/* What came first goes first. */
static void things_go_in_their_order(void **state) {
  (void)state;
  fixture f;
  retired things[4];
  open(&f, false);
  for (int i = 0; i < 4; ++i) {
    retire(&f.device, &things[i], go);
    things[i].serial = (uint64_t[]){1, 2, 3, 3}[i];
  }
  f.device.done = 2;
  retire_collect(&f.device);
  assert_true(gone == 2 && order[0] == 10 && order[1] == 20);
  assert_ptr_equal(f.device.retired, &things[2]);
  assert_ptr_equal(f.device.retired_last, &things[3]);
}

/* Constants are bound at 32 bits: a frame that would reach beyond is refused by name, and nothing is made for it. */
static void a_frame_has_four_gigabytes(void **state) {
  (void)state;
  fixture f;
  ring_range range;
  open(&f, true);
  assert_int_equal(recording_prepare(&f.device, 0, 1ull << 32, &range), CSM_ERROR_LIMIT_EXCEEDED);
  assert_non_null(strstr(f.host.error, "too many instances"));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_newest_frame_is_told_last), cmocka_unit_test(an_error_is_that_of_one_frame),
      cmocka_unit_test(a_lost_device_is_not_asked),    cmocka_unit_test(things_go_in_their_order),
      cmocka_unit_test(a_frame_has_four_gigabytes),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
