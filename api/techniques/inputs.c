#include "techniques/inputs.h"

static void input_free(device *device, retired *self) {
  gpu_bindings_destroy(device->gpu, ((input *)self)->bindings);
  host_release(device->host, self);
}

csm_result inputs_find(inputs *inputs, device *device, const gpu_bindings_info *reads, input **out) {
  input *found = inputs->first;
  while (found && found->serial > device->done)
    found = found->next;
  if (found) {
    gpu_bindings_write(device->gpu, found->bindings, reads);
  } else {
    found = host_allocate(device->host, sizeof *found);
    if (!found)
      return CSM_ERROR_OUT_OF_MEMORY;
    const csm_result result =
        device_check(device, gpu_bindings_create(device->gpu, reads, &found->bindings), reads->name);
    if (result) {
      host_release(device->host, found);
      return result;
    }
    found->next = inputs->first;
    inputs->first = found;
  }
  *out = found;
  return CSM_SUCCESS;
}

gpu_bindings *inputs_use(input *input, const device *device) {
  input->serial = device->serial;
  return input->bindings;
}

void inputs_drop(inputs *inputs, device *device) {
  while (inputs->first) {
    input *first = inputs->first;
    inputs->first = first->next;
    retire(device, &first->retired, input_free);
  }
}
