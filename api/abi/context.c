#include "abi/cascades.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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

gpu_host default_host(void) {
  return (gpu_host){.allocate = default_allocate, .release = default_release, .log = default_log};
}

/* Leaves the text of a creation that failed where the caller finds it. */
static csm_result refuse(const csm_create_info *info, csm_result result, const char *text) {
  if (info->error && info->error_size)
    snprintf(info->error, info->error_size, "%s", text);
  return result;
}

static csm_result check_info(const csm_create_info *info, const char **text) {
  *text = !info->backend                             ? "csm_create_info: backend is NULL"
          : info->version >> 22 != CSM_VERSION_MAJOR ? "csm_create_info: version is of another major version of csm"
          : info->frame_slots > DEVICE_MAX_SLOTS     ? "csm_create_info: frame_slots is above 8"
          : !info->allocate != !info->release        ? "csm_create_info: allocate and release come together"
          : info->vulkan && info->d3d12              ? "csm_create_info: both vulkan and d3d12 are given"
          : info->flags & ~(uint32_t)(CSM_CREATE_VALIDATE | CSM_CREATE_KEEP_GEOMETRY) ? "csm_create_info: unknown flags"
                                                                                      : NULL;
  return !*text ? CSM_SUCCESS : info->backend ? CSM_ERROR_INVALID_VALUE : CSM_ERROR_NULL_POINTER;
}

/* A context without a device. */
static csm_context *allocate_context(const csm_create_info *info) {
  const csm_allocate_function allocate = info->allocate ? info->allocate : default_allocate;
  csm_context *context = allocate(info->user, sizeof *context, 64);
  if (!context)
    return NULL;
  memset(context, 0, sizeof *context);
  context->allocate = allocate;
  context->release = info->allocate ? info->release : default_release;
  context->log = info->log ? info->log : default_log;
  context->supply = info->supply;
  context->budget = info->budget;
  context->user = info->user;
  context->alpha_masks.handles.kind = 1;
  context->keep_geometry = info->flags & CSM_CREATE_KEEP_GEOMETRY;
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
    return refuse(&info, CSM_ERROR_NULL_POINTER, "context is NULL");
  result = check_info(&info, &text);
  if (result) {
    if (info.log)
      info.log(info.user, CSM_LOG_ERROR, text);
    return refuse(&info, result, text);
  }
  csm_context *context = allocate_context(&info);
  if (!context)
    return refuse(&info, CSM_ERROR_OUT_OF_MEMORY, "out of memory");
  result = device_open(context, &info, &context->device);
  if (result) {
    refuse(&info, result, context->error);
    csm_destroy(context);
    return result;
  }
  *out = context;
  return CSM_SUCCESS;
}

static void close_former(csm_context *context, uint64_t frame) {
  device **link = &context->former;
  while (*link) {
    device *former = *link;
    if (former->serial <= frame) {
      *link = former->next;
      device_close(former);
    } else {
      link = &former->next;
    }
  }
}

void CSM_CALL csm_destroy(csm_context *context) {
  if (!context)
    return;
  if (context->device) {
    recording_finish(context->device);
    while (context->cascades)
      cascades_destroy_now(context->cascades);
    device_close(context->device);
  }
  close_former(context, UINT64_MAX);
  meshes_destroy(context);
  alpha_masks_destroy(context);
  context_release(context, context->scratch);
  context_release(context, context);
}

csm_result CSM_CALL csm_retire(csm_context *context, uint64_t frame) {
  if (!context)
    return CSM_ERROR_NULL_POINTER;
  const bool switched = context->former;
  close_former(context, frame);
  if (context->device->own && switched)
    return CSM_SUCCESS;
  if (context->device->own)
    return context_fail(context, CSM_ERROR_UNSUPPORTED, "frames are retired on an engine's device only");
  return recording_retire(context->device, frame);
}

/* ---- switching ---- */

/* Maps and programs on the new device for all cascades, in the order of the context's list. */
static csm_result make_all_resources(csm_context *context, device *fresh, cascade_resources **out) {
  uint32_t count = 0;
  for (const csm_cascades *c = context->cascades; c; c = c->next)
    ++count;
  cascade_resources *resources = context_allocate(context, (count + 1) * sizeof *resources);
  if (!resources)
    return CSM_ERROR_OUT_OF_MEMORY;
  csm_result result = CSM_SUCCESS;
  uint32_t made = 0;
  for (const csm_cascades *c = context->cascades; c && !result; c = c->next) {
    result = resources_create(fresh, &c->config, NULL, &resources[made]);
    made += !result;
  }
  if (result) {
    while (made)
      resources_free(fresh, &resources[--made]);
    context_release(context, resources);
    return result;
  }
  *out = resources;
  return CSM_SUCCESS;
}

/* From here on nothing can fail. */
static void change_device(csm_context *context, device *fresh, const cascade_resources *resources) {
  device *old = context->device;
  for (csm_cascades *c = context->cascades; c; c = c->next)
    cascades_move(c, old, resources++);
  context->device = fresh;
  if (old->own || old->lost) {
    device_close(old);
  } else {
    old->next = context->former;
    context->former = old;
  }
}

csm_result CSM_CALL csm_switch_backend(csm_context *context, const csm_create_info *in) {
  if (!context)
    return CSM_ERROR_NULL_POINTER;
  csm_create_info info;
  const char *text;
  device *fresh;
  cascade_resources *resources;
  csm_result result = context_check_struct(context, struct_read(&info, sizeof info, in), "csm_create_info");
  if (result)
    return result;
  result = check_info(&info, &text);
  result = result ? context_fail(context, result, "%s", text) : device_open(context, &info, &fresh);
  if (result)
    return refuse(&info, result, context->error);
  result = alpha_masks_move(context, fresh);
  if (!result)
    result = meshes_move(context, fresh);
  if (!result)
    result = make_all_resources(context, fresh, &resources);
  if (result) {
    device_close(fresh);
    return refuse(&info, result, context->error);
  }
  change_device(context, fresh, resources);
  context_release(context, resources);
  return CSM_SUCCESS;
}
