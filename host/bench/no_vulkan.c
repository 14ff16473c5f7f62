/* In place of floor.c, bare_mask.c and engine.c in a build without Vulkan. */
#include "base/host.h"
#include "bench/bare_mask.h"
#include "bench/engine.h"
#include "bench/floor.h"
#include <stdio.h>

int floor_open(floor_loop **out, const floor_info *info, char *error, size_t error_size) {
  (void)info;
  *out = NULL;
  snprintf(error, error_size, "this csm-host was built without Vulkan");
  return HOST_NO_DEVICE;
}

double floor_frame(floor_loop *loop) {
  (void)loop;
  return -1.0;
}

void floor_close(floor_loop *loop) {
  (void)loop;
}

/* Never called without a floor. */
int bench_engine_run(bench_engine *out, const host_setup *setup, const bench_plan *many, const char *device,
                     uint32_t rounds) {
  (void)setup;
  (void)many;
  (void)device;
  (void)rounds;
  *out = (bench_engine){0};
  return host_fail(HOST_NO_DEVICE, "this csm-host was built without Vulkan");
}

double floor_gpu_ms(const floor_loop *loop) {
  (void)loop;
  return -1.0;
}

/* Without Vulkan there are no bare passes either. */
int bare_mask_open(bare_mask **out, const bare_mask_info *info, char *error, size_t error_size) {
  (void)info;
  *out = NULL;
  snprintf(error, error_size, "this csm-host was built without Vulkan");
  return HOST_NO_DEVICE;
}

double bare_mask_draw(bare_mask *mask, bare_pass pass) {
  (void)mask;
  (void)pass;
  return -1.0;
}

const uint8_t *bare_mask_pixels(const bare_mask *mask) {
  (void)mask;
  return NULL;
}

void bare_mask_close(bare_mask *mask) {
  (void)mask;
}
