#include "cascades.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { default_slots = 3 };

static void *CSM_CALL default_allocate(void *user, size_t size, size_t alignment) {
  (void)user;
  return aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
}

static void CSM_CALL default_release(void *user, void *memory) {
  (void)user;
  free(memory);
}

static void CSM_CALL default_log(void *user, int32_t level, const char *message) {
  (void)user;
  (void)level;
  (void)message;
}

/* Says why a creation failed while there is no context that could keep it. */
static csm_result refuse(const csm_create_info *info, csm_result result, const char *text) {
  if (info->error && info->error_size)
    snprintf(info->error, info->error_size, "%s", text);
  if (info->log)
    info->log(info->user, CSM_LOG_ERROR, text);
  return result;
}

static csm_result check_create_info(const csm_create_info *info) {
  if (!info->backend)
    return refuse(info, CSM_ERROR_NULL_POINTER, "csm_create_info: backend is NULL");
  if (info->flags & ~(uint32_t)CSM_CREATE_VALIDATE)
    return refuse(info, CSM_ERROR_INVALID_VALUE, "csm_create_info: unknown flags");
  if (info->version >> 22 != CSM_VERSION_MAJOR)
    return refuse(info, CSM_ERROR_INVALID_VALUE, "csm_create_info: version is not CSM_VERSION of this major version");
  if (info->frame_slots > CONTEXT_MAX_SLOTS)
    return refuse(info, CSM_ERROR_INVALID_VALUE, "csm_create_info: frame_slots is above 8");
  if (!info->allocate != !info->release)
    return refuse(info, CSM_ERROR_INVALID_VALUE, "csm_create_info: allocate and release come together or not at all");
  if (info->vulkan || info->d3d12)
    return refuse(info, CSM_ERROR_UNSUPPORTED, "csm_create_info: an engine's device is not taken in this version");
  return CSM_SUCCESS;
}

static csm_result open_device(csm_context *context, const csm_create_info *info) {
  csm_result result = loader_open(&context->library, info->backend, context->error, sizeof context->error);
  if (result)
    return result;
  context->gpu.api = context->library.backend;
  const gpu_open_info open = {
      .host = &context->host,
      .device_name = info->device,
      .validate = info->flags & CSM_CREATE_VALIDATE,
      .slots = context->slot_count,
      .error = context->error,
      .error_size = sizeof context->error,
  };
  result = context->gpu.api->open(&open, &context->gpu.device);
  if (result)
    return result;
  context->gpu.api->describe(context->gpu.device, &context->info);
  return CSM_SUCCESS;
}

static csm_result make_programs(csm_context *context) {
  csm_result result = context_check(context, cascade_depth_program(context->gpu, &context->cascade_program),
                                    "the cascade depth program");
  for (int reversed = 0; reversed < 2 && !result; ++reversed)
    result = context_check(context, camera_depth_program(context->gpu, reversed, &context->camera_programs[reversed]),
                           "a camera depth program");
  for (uint32_t filter = 0; filter < CONTEXT_FILTERS && !result; ++filter)
    result =
        context_check(context, mask_program(context->gpu, filter, &context->mask_programs[filter]), "a mask program");
  return result;
}

csm_result CSM_CALL csm_create(const csm_create_info *in, csm_context **out) {
  if (out)
    *out = NULL;
  csm_create_info info;
  csm_result result = struct_read(&info, sizeof info, in);
  if (result)
    return result;
  if (!out)
    return refuse(&info, CSM_ERROR_NULL_POINTER, "context is NULL");
  result = check_create_info(&info);
  if (result)
    return result;

  const csm_allocate_function allocate = info.allocate ? info.allocate : default_allocate;
  csm_context *context = allocate(info.user, sizeof *context, 64);
  if (!context)
    return refuse(&info, CSM_ERROR_OUT_OF_MEMORY, "out of memory");
  memset(context, 0, sizeof *context);
  context->allocate = allocate;
  context->release = info.allocate ? info.release : default_release;
  context->log = info.log ? info.log : default_log;
  context->user = info.user;
  context->host = (gpu_host){
      .user = context->user, .allocate = context->allocate, .release = context->release, .log = context->log};
  context->memory_limit = info.memory_limit;
  context->slot_count = info.frame_slots ? info.frame_slots : default_slots;
  result = open_device(context, &info);
  if (!result)
    result = make_programs(context);
  if (result) {
    refuse(&info, result, context->error[0] ? context->error : csm_result_name(result));
    csm_destroy(context);
    return result;
  }
  *out = context;
  return CSM_SUCCESS;
}

static void close_device(csm_context *context) {
  const pass_gpu gpu = context->gpu;
  for (uint32_t slot = 0; slot < context->slot_count; ++slot)
    gpu.api->wait(gpu.device, slot);
  while (context->cascades)
    cascades_destroy_now(context->cascades);
  retire_collect(context, UINT64_MAX);
  geometry_destroy(context);
  recording_destroy(context);
  gpu.api->program_destroy(gpu.device, context->cascade_program);
  for (int i = 0; i < 2; ++i)
    gpu.api->program_destroy(gpu.device, context->camera_programs[i]);
  for (int i = 0; i < CONTEXT_FILTERS; ++i)
    gpu.api->program_destroy(gpu.device, context->mask_programs[i]);
  gpu.api->close(gpu.device);
}

void CSM_CALL csm_destroy(csm_context *context) {
  if (!context)
    return;
  if (context->gpu.device)
    close_device(context);
  loader_close(&context->library);
  context_release(context, context->scratch);
  context_release(context, context);
}

csm_result CSM_CALL csm_switch_backend(csm_context *context, const csm_create_info *info) {
  (void)info;
  return context ? context_fail(context, CSM_ERROR_UNSUPPORTED, "switching backends is not in this version")
                 : CSM_ERROR_NULL_POINTER;
}

csm_result CSM_CALL csm_retire(csm_context *context, uint64_t frame) {
  (void)frame;
  return context ? context_fail(context, CSM_ERROR_UNSUPPORTED, "frames are retired on an engine's device only")
                 : CSM_ERROR_NULL_POINTER;
}

/* ---- what is installed ---- */

static void copy_text(char *to, size_t size, const char *from) {
  snprintf(to, size, "%s", from ? from : "");
}

static void describe_backend(const char *name, csm_backend_info *out) {
  const gpu_host host = {.allocate = default_allocate, .release = default_release, .log = default_log};
  const gpu_open_info open = {.host = &host, .slots = 1, .error = out->error, .error_size = sizeof out->error};
  gpu_device_info device = {0};
  loader_library library = {0};
  copy_text(out->name, sizeof out->name, name);
  out->result = loader_open(&library, name, out->error, sizeof out->error);
  copy_text(out->path, sizeof out->path, library.path);
  if (!out->result)
    out->result = library.backend->query(&open, &device);
  if (!out->result) {
    out->device_type = device.type;
    out->max_resolution = device.max_image_size;
    copy_text(out->device, sizeof out->device, device.name);
    copy_text(out->driver, sizeof out->driver, device.driver);
    copy_text(out->required, sizeof out->required, device.required);
    copy_text(out->optional, sizeof out->optional, device.optional);
  }
  loader_close(&library);
}

csm_result CSM_CALL csm_query_backends(uint32_t *count, csm_backend_info *infos) {
  static const char *const names[] = {"vulkan", "d3d12"};
  const uint32_t known = sizeof names / sizeof names[0];
  if (!count)
    return CSM_ERROR_NULL_POINTER;
  const uint32_t room = infos ? *count : 0;
  uint32_t stride = 0;
  for (uint32_t i = 0; i < known && i < room; ++i) {
    char *element = (char *)infos + (size_t)i * stride;
    if (i)
      memcpy(element, &stride, sizeof stride);
    const csm_result result = i ? CSM_SUCCESS : struct_check(sizeof *infos, element);
    if (result)
      return result;
    memcpy(&stride, element, sizeof stride);
    csm_backend_info info = {.struct_size = sizeof info};
    describe_backend(names[i], &info);
    struct_write(element, sizeof info, &info);
  }
  *count = known;
  return CSM_SUCCESS;
}
