#include "context.h"

#include <stdio.h>
#include <string.h>

enum { default_slots = 3, copied_stride = 12 };

/* An engine's device belongs to one API. */
static bool wrong_api(const csm_create_info *info, const char *backend) {
  return (info->vulkan && strcmp(backend, "vulkan")) || (info->d3d12 && strcmp(backend, "d3d12"));
}

/* Opening reports its texts into a buffer, not through the log: the caller decides what becomes of them. */
static csm_result open_backend(device *device, const csm_create_info *info) {
  char text[sizeof device->context->error] = "";
  csm_result result = loader_open(&device->library, info->backend, text, sizeof text);
  if (!result && wrong_api(info, device->library.backend->name)) {
    snprintf(text, sizeof text, "csm_create_info: the engine's device is not one of backend %s", info->backend);
    result = CSM_ERROR_UNSUPPORTED;
  }
  if (!result) {
    device->gpu.api = device->library.backend;
    const gpu_open_info open = {
        .host = &device->host,
        .device_name = info->device,
        .validate = info->flags & CSM_CREATE_VALIDATE,
        .slots = device->slot_count,
        .native = info->vulkan ? (const void *)info->vulkan : info->d3d12,
        .error = text,
        .error_size = sizeof text,
    };
    result = device->gpu.api->open(&open, &device->gpu.device);
  }
  if (result)
    return context_fail(device->context, result, "%s", text[0] ? text : csm_result_name(result));
  device->gpu.api->describe(device->gpu.device, &device->info);
  return CSM_SUCCESS;
}

static void programs_free(device *device, uint32_t index) {
  const pass_gpu gpu = device->gpu;
  for (int reversed = 0; reversed < 2; ++reversed) {
    gpu.api->program_destroy(gpu.device, device->programs.camera[reversed][index]);
    device->programs.camera[reversed][index] = NULL;
  }
  for (caster_programs *casters = device->casters; casters; casters = casters->next)
    caster_programs_remove_shape(device, casters, index);
}

csm_result device_programs(device *device, pass_vertices vertices, uint32_t *index) {
  depth_programs *programs = &device->programs;
  for (*index = 0; *index < programs->count; ++*index)
    if (programs->vertices[*index].stride == vertices.stride &&
        programs->vertices[*index].uv_stride == vertices.uv_stride)
      return CSM_SUCCESS;
  if (*index == DEVICE_MAX_SHAPES)
    return context_fail(device->context, CSM_ERROR_LIMIT_EXCEEDED, "meshes have more than %d shapes of vertices",
                        DEVICE_MAX_SHAPES);
  programs->vertices[*index] = vertices;
  csm_result result = CSM_SUCCESS;
  for (int reversed = 0; reversed < 2 && !result; ++reversed)
    result =
        device_check(device, camera_depth_program(device->gpu, reversed, vertices, &programs->camera[reversed][*index]),
                     "a camera depth program");
  for (caster_programs *casters = device->casters; casters && !result; casters = casters->next)
    result = caster_programs_add_shape(device, casters, *index);
  if (result) {
    programs_free(device, *index);
    return result;
  }
  ++programs->count;
  return CSM_SUCCESS;
}

gpu_program *device_mask_program(const device *device, uint64_t key) {
  for (uint32_t i = 0; i < device->mask_count; ++i)
    if (device->masks[i].key == key)
      return device->masks[i].program;
  return NULL;
}

static csm_result make_mask_program(device *device, uint64_t key, bool normals) {
  if (device_mask_program(device, key))
    return CSM_SUCCESS;
  mask_entry *entry = &device->masks[device->mask_count];
  const csm_result result = device_check(device, mask_program(device->gpu, key, normals, &entry->program), "a mask program");
  if (result)
    return result;
  entry->key = key;
  ++device->mask_count;
  return CSM_SUCCESS;
}

csm_result device_view_program(device *device) {
  return make_mask_program(device, MASK_VIEW_KEY, false);
}

csm_result device_mask_programs(device *device, const csm_config *config) {
  csm_result result = CSM_SUCCESS;
  for (int normals = 0; normals < 2 && !result; ++normals)
    result = make_mask_program(device, mask_key(config, normals, CSM_VIEW_SHADOW), normals);
  for (int coarse = 0; coarse < 2 && !result && config->depth_samples != CSM_DEPTH_SAMPLES_OFF; ++coarse)
    if (!device->tiles_programs[coarse])
      result = device_check(device, depth_tiles_program(device->gpu, coarse, &device->tiles_programs[coarse]),
                            "a depth tiles program");
  return result;
}

/* Of copied opaque meshes, so that there is always one. */
static csm_result make_programs(device *device) {
  uint32_t first;
  return device_programs(device, (pass_vertices){.stride = copied_stride}, &first);
}

csm_result device_open(csm_context *context, const csm_create_info *info, device **out) {
  *out = NULL;
  device *fresh = context_allocate(context, sizeof *fresh);
  if (!fresh)
    return CSM_ERROR_OUT_OF_MEMORY;
  fresh->context = context;
  fresh->host = (gpu_host){
      .user = context->user, .allocate = context->allocate, .release = context->release, .log = context->log};
  fresh->own = !info->vulkan && !info->d3d12;
  fresh->memory_limit = info->memory_limit;
  fresh->slot_count = info->frame_slots ? info->frame_slots : default_slots;
  csm_result result = open_backend(fresh, info);
  if (!result)
    result = make_programs(fresh);
  if (result) {
    device_close(fresh);
    return result;
  }
  *out = fresh;
  return CSM_SUCCESS;
}

static void destroy_objects(device *device) {
  const pass_gpu gpu = device->gpu;
  for (uint32_t slot = 0; slot < device->slot_count && device->own; ++slot)
    gpu.api->wait(gpu.device, slot);
  device->done = UINT64_MAX;
  retire_collect(device);
  geometry_destroy(device);
  alpha_mask_destroy(device);
  recording_destroy(device);
  caster_programs_destroy(device);
  for (uint32_t i = 0; i < device->programs.count; ++i)
    programs_free(device, i);
  for (uint32_t i = 0; i < device->mask_count; ++i)
    gpu.api->program_destroy(gpu.device, device->masks[i].program);
  for (int coarse = 0; coarse < 2; ++coarse)
    gpu.api->program_destroy(gpu.device, device->tiles_programs[coarse]);
  gpu.api->close(gpu.device);
}

void device_close(device *device) {
  if (device->gpu.device)
    destroy_objects(device);
  loader_close(&device->library);
  context_release(device->context, device);
}
