#include "abi/cascades.h"
#include "abi/view.h"
#include "device/clock.h"

#include <stdio.h>

csm_result create_info_refuse(const csm_create_info *info, csm_result result, const char *text) {
  if (info->error && info->error_size)
    snprintf(info->error, info->error_size, "%s", text);
  return result;
}

csm_result create_info_check(const csm_create_info *info, const char **text) {
  const uint32_t known = CSM_CREATE_VALIDATE | CSM_CREATE_KEEP_GEOMETRY | CSM_CREATE_RAYS | CSM_CREATE_NAMES;
  *text = !info->backend                             ? "csm_create_info: backend is NULL"
          : info->version >> 22 != CSM_VERSION_MAJOR ? "csm_create_info: version is of another major version of csm"
          : info->frame_slots > DEVICE_MAX_SLOTS     ? "csm_create_info: frame_slots is above 8"
          : !info->allocate != !info->release        ? "csm_create_info: allocate and release come together"
          : info->vulkan && info->d3d12              ? "csm_create_info: both vulkan and d3d12 are given"
          : info->flags & ~known                     ? "csm_create_info: unknown flags"
                                                     : NULL;
  return !*text ? CSM_SUCCESS : info->backend ? CSM_ERROR_INVALID_VALUE : CSM_ERROR_NULL_POINTER;
}

/* An engine's device belongs to one API. */
static bool wrong_api(const csm_create_info *info, gpu_api api) {
  return (info->vulkan && api != GPU_API_VULKAN) || (info->d3d12 && api != GPU_API_D3D12);
}

csm_result context_open(csm_context *context, const csm_create_info *info, opened **out) {
  host *host = &context->host;
  char text[sizeof host->error] = "";
  opened *fresh = host_allocate(host, sizeof *fresh);
  if (!fresh)
    return CSM_ERROR_OUT_OF_MEMORY;
  csm_result result = loader_open(&fresh->library, info->backend, text, sizeof text);
  if (result)
    host_fail(host, result, "%s", text);
  else if (wrong_api(info, fresh->library.backend->api))
    result = host_fail(host, CSM_ERROR_UNSUPPORTED, "csm_create_info: backend %s takes no %s", info->backend,
                       info->vulkan ? "csm_vulkan_device" : "csm_d3d12_device");
  if (!result)
    result = device_open(&(device_open_info){.host = host,
                                             .backend = fresh->library.backend,
                                             .device_name = info->device,
                                             .validate = info->flags & CSM_CREATE_VALIDATE,
                                             .names = info->flags & CSM_CREATE_NAMES,
                                             .native = info->vulkan ? (const void *)info->vulkan : info->d3d12,
                                             .memory_limit = info->memory_limit,
                                             .slots = info->frame_slots,
                                             .trees = context->assets.trees},
                         &fresh->device);
  if (result) {
    context_close(context, fresh);
    return result;
  }
  *out = fresh;
  return CSM_SUCCESS;
}

void context_close(csm_context *context, opened *opened) {
  if (opened->device)
    device_close(opened->device);
  loader_close(&opened->library);
  host_release(&context->host, opened);
}

/* A context without a device. */
static csm_context *allocate_context(const csm_create_info *info) {
  host own = info->allocate ? (host){.allocate = info->allocate, .release = info->release} : host_default();
  own.log = info->log ? info->log : host_default().log;
  own.budget = info->budget;
  own.user = info->user;
  csm_context *context = host_allocate(&own, sizeof *context);
  if (!context)
    return NULL;
  context->host = own;
  assets_begin(&context->assets, &context->host, handles_key(context, (uint64_t)(clock_ms() * 1e6)));
  context->assets.supply = info->supply;
  context->assets.keep_geometry = info->flags & CSM_CREATE_KEEP_GEOMETRY;
  context->assets.trees = info->flags & CSM_CREATE_RAYS;
  return context;
}

csm_result CSM_CALL csm_create(const csm_create_info *in, csm_context **out) {
  if (out)
    *out = NULL;
  csm_create_info info;
  const char *text;
  csm_result result = struct_read(&info, sizeof info, in);
  if (result)
    return result;
  if (!out)
    return create_info_refuse(&info, CSM_ERROR_NULL_POINTER, "context is NULL");
  result = create_info_check(&info, &text);
  if (result) {
    if (info.log)
      info.log(info.user, CSM_LOG_ERROR, text);
    return create_info_refuse(&info, result, text);
  }
  csm_context *context = allocate_context(&info);
  if (!context)
    return create_info_refuse(&info, CSM_ERROR_OUT_OF_MEMORY, "out of memory");
  result = context_open(context, &info, &context->opened);
  if (result) {
    create_info_refuse(&info, result, context->host.error);
    csm_destroy(context);
    return result;
  }
  context->assets.device = context->opened->device;
  *out = context;
  return CSM_SUCCESS;
}

static void close_former(csm_context *context, uint64_t frame) {
  opened **link = &context->former;
  while (*link) {
    opened *former = *link;
    if (former->device->serial <= frame) {
      *link = former->next;
      context_close(context, former);
    } else {
      link = &former->next;
    }
  }
}

void CSM_CALL csm_destroy(csm_context *context) {
  if (!context)
    return;
  while (context->cascades)
    csm_cascades_destroy(context->cascades);
  while (context->views)
    csm_view_destroy(context->views);
  if (context->opened)
    context_close(context, context->opened);
  close_former(context, UINT64_MAX);
  instances_end(&context->list, NULL);
  assets_end(&context->assets);
  host_release(&context->host, context->view_memory.at);
  const host last = context->host;
  last.release(last.user, context);
}

csm_result CSM_CALL csm_retire(csm_context *context, uint64_t frame) {
  if (!context)
    return CSM_ERROR_NULL_POINTER;
  device *device = context_device(context);
  const bool switched = context->former;
  close_former(context, frame);
  if (device->own && switched)
    return CSM_SUCCESS;
  if (device->own)
    return host_fail(&context->host, CSM_ERROR_UNSUPPORTED, "frames are retired on an engine's device only");
  return recording_retire(device, frame);
}
