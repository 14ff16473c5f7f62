#include "abi/context.h"

#include <stdio.h>
#include <string.h>

static void copy_text(char *to, size_t size, const char *from) {
  snprintf(to, size, "%s", from ? from : "");
}

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
