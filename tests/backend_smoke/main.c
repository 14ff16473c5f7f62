/*
 * main.c: one backend alone, through gpu.h, against results known by analysis.
 *
 *   backend_smoke BACKEND [DEVICE]
 *
 * BACKEND is a backend's library. Exits with 0 if all holds, with 1 and a list of what does not otherwise, with 3
 * without a device.
 */
#include "smoke.h"

#include <dlfcn.h>
#include <stdlib.h>
#include <string.h>

/* ---- the host's side ---- */

static void *CSM_CALL count_allocate(void *user, size_t size, size_t alignment) {
  ((smoke *)user)->live_allocations++;
  void *memory = aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  return memory ? memset(memory, 0xcd, size) : NULL;
}

static void CSM_CALL count_release(void *user, void *memory) {
  ((smoke *)user)->live_allocations--;
  free(memory);
}

static void CSM_CALL count_message(void *user, int32_t level, const char *message) {
  if (level <= CSM_LOG_WARNING)
    ((smoke *)user)->messages++;
  fprintf(stderr, "log %d: %s\n", level, message);
}

/* ---- opening ---- */

static void test_refusals(smoke *s) {
  char error[256] = "";
  gpu_device *device = NULL;
  gpu_open_info info = {
      .host = &s->host, .device_name = "no such device", .slots = SLOTS, .error = error, .error_size = sizeof error};
  csm_result result = s->gpu->open(&info, &device);
  CHECK(s, result == CSM_ERROR_NO_DEVICE && !device && error[0], "an unknown name: %d", result);
  error[0] = 0;
  info.device_name = NULL;
  info.native = &(uint32_t){0};
  result = s->gpu->open(&info, &device);
  CHECK(s, result == CSM_ERROR_STRUCT_SIZE && !device && error[0], "an engine's device without struct_size: %d",
        result);
}

static void check_info(smoke *s, const gpu_open_info *open) {
  gpu_device_info info, queried;
  memset(&info, 0, sizeof info);
  memset(&queried, 0, sizeof queried);
  s->gpu->describe(s->device, &info);
  CHECK(s, s->gpu->query(open, &queried) == CSM_SUCCESS, "query");
  CHECK(s, strcmp(info.name, queried.name) == 0 && info.max_image_size == queried.max_image_size, "%s, %s", info.name,
        queried.name);
  CHECK(s, !memcmp(&info.can, &queried.can, sizeof info.can), "a device that can something else when it is open");
  s->can = info.can;
  CHECK(s, info.name[0] && info.driver[0], "texts");
  CHECK(s, info.max_image_size >= 4096 && info.max_image_layers >= 256, "%u, %u", info.max_image_size,
        info.max_image_layers);
  CHECK(s, info.max_allocation_size >= 1 << 27 && info.max_allocation_size <= info.memory_size, "%llu of %llu",
        (unsigned long long)info.max_allocation_size, (unsigned long long)info.memory_size);
  CHECK(s, info.can.max_buffers >= 4 && info.can.max_texels_size >= 1 << 20, "%u buffers", info.can.max_buffers);
  CHECK(s, info.max_buffer_size >= 1 << 27, "%llu", (unsigned long long)info.max_buffer_size);
  printf("%s: %s; %s; images to %u, %u layers; allocations to %.2f GiB of %.2f\n", s->gpu->name, info.name, info.driver,
         info.max_image_size, info.max_image_layers, (double)info.max_allocation_size / (1 << 30),
         (double)info.memory_size / (1 << 30));
}

static bool load(smoke *s, const char *path) {
  void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
  void *symbol = library ? dlsym(library, GPU_HANDSHAKE_SYMBOL) : NULL;
  CHECK(s, symbol, "%s", dlerror());
  if (!symbol)
    return false;
  gpu_handshake_function handshake;
  memcpy(&handshake, &symbol, sizeof symbol);
  gpu_handshake hello = {.front_oldest = GPU_INTERFACE_VERSION + 1, .front_newest = GPU_INTERFACE_VERSION + 2};
  handshake(&hello);
  CHECK(s, !hello.backend && hello.backend_oldest <= hello.backend_newest, "no common version");
  hello = (gpu_handshake){.front_oldest = GPU_INTERFACE_VERSION, .front_newest = GPU_INTERFACE_VERSION};
  handshake(&hello);
  CHECK(s, hello.backend, "versions %u to %u", hello.backend_oldest, hello.backend_newest);
  s->gpu = hello.backend;
  return hello.backend;
}

static void (*const tests[])(smoke *) = {test_frames,
                                         test_culling,
                                         test_clamping,
                                         test_slope,
                                         test_bias,
                                         test_areas,
                                         test_d16,
                                         test_native,
                                         test_clears,
                                         test_compares,
                                         test_pairs,
                                         test_memory,
                                         test_copies,
                                         test_regions,
                                         test_updates,
                                         test_levels,
                                         test_level_copies,
                                         test_layer_views,
                                         test_loads,
                                         test_depth_loads,
                                         test_always,
                                         test_both_targets,
                                         test_samplers,
                                         test_many_bindings,
                                         test_attributes,
                                         test_buffers,
                                         test_atomics,
                                         test_stored_images,
                                         test_pixel_stores,
                                         test_pixel_images,
                                         test_fetched_vertices,
                                         test_indirect};

/* With 3 where there is no device. */
static int run(smoke *s, gpu_open_info *info) {
  smoke_open(s, info);
  const csm_result result = s->gpu->open(info, &s->device);
  if (result != CSM_SUCCESS) {
    fprintf(stderr, "open: %d: %s\n", result, info->error);
    return result == CSM_ERROR_NO_DEVICE ? 3 : 1;
  }
  s->g = (gpu){s->gpu, s->device};
  check_info(s, info);
  CHECK(s, smoke_wait(s, 2) == CSM_SUCCESS, "a slot that was never used");
  make_objects(s);
  if (s->failures)
    return 1;
  for (size_t i = 0; i < sizeof tests / sizeof *tests; i++)
    tests[i](s);
  free_objects(s);
  s->gpu->close(s->device);
  smoke_close(s);
  return 0;
}

int main(int count, char **arguments) {
  if (count < 2) {
    fprintf(stderr, "usage: backend_smoke BACKEND [DEVICE]\n");
    return 2;
  }
  smoke s = {0};
  s.host = (gpu_host){.user = &s, .allocate = count_allocate, .release = count_release, .log = count_message};
  if (!load(&s, arguments[1]))
    return 1;
  char error[256] = "";
  gpu_open_info info = {.host = &s.host,
                        .device_name = count > 2 ? arguments[2] : NULL,
                        .validate = true,
                        .names = true,
                        .slots = SLOTS,
                        .error = error,
                        .error_size = sizeof error};
  const int failed = run(&s, &info);
  if (failed)
    return failed;
  CHECK(&s, s.messages == 0, "%u messages", s.messages);
  test_refusals(&s);
  CHECK(&s, s.live_allocations == 0, "%lld allocations are left", (long long)s.live_allocations);
  printf("%u failures\n", s.failures);
  return s.failures != 0;
}
