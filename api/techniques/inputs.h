/* inputs.h: bindings that are written anew for each recording, and used again once theirs is done. */
#ifndef TECHNIQUES_INPUTS_H
#define TECHNIQUES_INPUTS_H

#include "device/device.h"

typedef struct input {
  retired retired;
  struct input *next;
  gpu_bindings *bindings;
  uint64_t serial; /* the frame that reads through them */
} input;

/* Of programs of one shape. */
typedef struct inputs {
  input *first;
} inputs;

/* Bindings that no recording in flight reads through; made if there are none. */
csm_result inputs_find(inputs *inputs, device *device, const gpu_bindings_info *reads, input **out);
/* For the recording that has begun; the input is taken until it is done. */
gpu_bindings *inputs_use(input *input, const device *device);
/* Retires all. */
void inputs_drop(inputs *inputs, device *device);

#endif
