#include "abi/context.h"

#include <stdio.h>
#include <string.h>

static void copy_text(char *to, size_t size, const char *from) {
  snprintf(to, size, "%s", from ? from : "");
}

/* ---- what a device needs ---- */

/* A sentence of parts, cut where its room ends. */
typedef struct sentence {
  char *text;
  size_t size, used;
} sentence;

static void add(sentence *to, const char *separator, const char *words) {
  const size_t room = to->used < to->size ? to->size - to->used : 0;
  to->used += (size_t)snprintf(room ? to->text + to->used : NULL, room, "%s%s", to->used ? separator : "", words);
}

/* "features: depthClamp, depthBiasClamp"; nothing for an empty list. */
static void add_names(sentence *to, const char *what, const char *const *names) {
  for (uint32_t i = 0; names && names[i]; ++i) {
    if (i == 0)
      add(to, "; ", what);
    add(to, i ? ", " : " ", names[i]);
  }
}

/* One source for both: the text is made of the lists. */
static void tell_needs(char *text, size_t size, const gpu_needs *needs) {
  sentence out = {.text = text, .size = size};
  char version[64];
  if (needs->api_version) {
    snprintf(version, sizeof version, "Vulkan %u.%u (instance and device)", needs->api_version >> 22 & 0x7f,
             needs->api_version >> 12 & 0x3ff);
    add(&out, "; ", version);
  }
  if (needs->feature_level) {
    snprintf(version, sizeof version, "feature level %u_%u", needs->feature_level >> 12,
             needs->feature_level >> 8 & 0xf);
    add(&out, "; ", version);
  }
  add_names(&out, "instance extensions:", needs->instance_extensions);
  add_names(&out, "device extensions:", needs->device_extensions);
  add_names(&out, "features:", needs->features);
  for (uint32_t i = 0; needs->others && needs->others[i]; ++i)
    add(&out, "; ", needs->others[i]);
}

static void list_needs(csm_backend_info *out, const gpu_needs *required, const gpu_needs *optional) {
  static const char *const none[] = {NULL};
  const struct {
    const char *const **to, *const *from;
  } lists[] = {
      {&out->required_instance_extensions, required->instance_extensions},
      {&out->required_device_extensions, required->device_extensions},
      {&out->required_features, required->features},
      {&out->optional_instance_extensions, optional->instance_extensions},
      {&out->optional_device_extensions, optional->device_extensions},
      {&out->optional_features, optional->features},
  };
  for (size_t i = 0; i < sizeof lists / sizeof *lists; ++i)
    *lists[i].to = lists[i].from ? lists[i].from : none;
  out->required_api_version = required->api_version;
  out->required_feature_level = required->feature_level;
}

/* ---- backends ---- */

static void describe_backend(const char *name, csm_backend_info *out) {
  const host none = host_default();
  const gpu_host host = {.allocate = none.allocate, .release = none.release, .log = none.log};
  const gpu_open_info open = {.host = &host, .slots = 1, .error = out->error, .error_size = sizeof out->error};
  gpu_device_info device = {0};
  loader_library library = {0};
  copy_text(out->name, sizeof out->name, name);
  out->result = loader_open(&library, name, out->error, sizeof out->error);
  copy_text(out->path, sizeof out->path, library.path);
  if (!out->result)
    out->result = gpu_query(library.backend, &open, &device);
  if (!out->result) {
    loader_keep(&library); /* the names in the lists are its own */
    out->device_type = device.type;
    out->max_resolution = device.max_image_size;
    copy_text(out->device, sizeof out->device, device.name);
    copy_text(out->driver, sizeof out->driver, device.driver);
    tell_needs(out->required, sizeof out->required, &device.required);
    tell_needs(out->optional, sizeof out->optional, &device.optional);
  }
  list_needs(out, &device.required, &device.optional);
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
