#include "device/device.h"

#include "device/alpha_images.h"
#include "device/geometry.h"

#include <stdio.h>

enum { default_slots = 3, copied_stride = 12 };

csm_result device_check(device *device, csm_result result, const char *what) {
  device->lost |= result == CSM_ERROR_DEVICE_LOST;
  if (result)
    host_fail(device->host, result, "%s: %s", what, device->said[0] ? device->said : csm_result_name(result));
  device->said[0] = 0;
  return result;
}

/* ---- what the backend is lent ---- */

static void *CSM_CALL lend_memory(void *user, size_t size, size_t alignment) {
  const host *host = ((const device *)user)->host;
  return host->allocate(host->user, size, alignment);
}

static void CSM_CALL take_memory_back(void *user, void *memory) {
  const host *host = ((const device *)user)->host;
  host->release(host->user, memory);
}

static void CSM_CALL hear(void *user, int32_t level, const char *message) {
  device *device = user;
  if (level == CSM_LOG_ERROR)
    snprintf(device->said, sizeof device->said, "%s", message);
  device->host->log(device->host->user, level, message);
}

csm_result device_shape(device *device, mesh_vertices vertices, uint32_t *index) {
  device_shapes *shapes = &device->shapes;
  for (*index = 0; *index < shapes->count; ++*index)
    if (shapes->vertices[*index].stride == vertices.stride && shapes->vertices[*index].uv_stride == vertices.uv_stride)
      return CSM_SUCCESS;
  if (*index == DEVICE_MAX_SHAPES)
    return host_fail(device->host, CSM_ERROR_LIMIT_EXCEEDED, "meshes have more than %d pairs of strides",
                     DEVICE_MAX_SHAPES);
  shapes->vertices[shapes->count++] = vertices;
  return CSM_SUCCESS;
}

/* Opening reports its texts into a buffer, not through the log: the caller decides what becomes of them. */
static csm_result open_backend(device *device, const device_open_info *info) {
  char text[sizeof device->host->error] = "";
  const gpu_open_info open = {
      .host = &device->lent,
      .device_name = info->device_name,
      .validate = info->validate,
      .names = info->names,
      .slots = device->slot_count,
      .native = info->native,
      .error = text,
      .error_size = sizeof text,
  };
  const csm_result result = gpu_open(info->backend, &open, &device->gpu);
  if (result)
    return host_fail(device->host, result, "%s", text[0] ? text : csm_result_name(result));
  gpu_describe(device->gpu, &device->info);
  return CSM_SUCCESS;
}

csm_result device_open(const device_open_info *info, device **out) {
  host *host = info->host;
  *out = NULL;
  device *fresh = host_allocate(host, sizeof *fresh);
  if (!fresh)
    return CSM_ERROR_OUT_OF_MEMORY;
  fresh->host = host;
  fresh->lent = (gpu_host){.user = fresh, .allocate = lend_memory, .release = take_memory_back, .log = hear};
  fresh->own = !info->native;
  fresh->memory_limit = info->memory_limit;
  fresh->trees.wanted = info->trees;
  fresh->slot_count = info->slots ? info->slots : default_slots;
  fresh->shapes = (device_shapes){.count = 1, .vertices = {{.stride = copied_stride}}};
  const csm_result result = open_backend(fresh, info);
  if (result) {
    host_release(host, fresh);
    return result;
  }
  *out = fresh;
  return CSM_SUCCESS;
}

void device_close(device *device) {
  for (uint32_t slot = 0; slot < device->slot_count && device->own; ++slot)
    (void)gpu_wait(device->gpu, slot); /* a lost device is done as well */
  device->done = UINT64_MAX;
  retire_collect(device);
  alpha_images_destroy(device); /* what of them waits among the uploads goes first */
  geometry_destroy(device);
  tree_pool_destroy(device);
  ring_destroy(device);
  programs_destroy(device);
  gpu_close(device->gpu);
  host_release(device->host, device);
}
