#include "techniques/passes.h"
#include "private/opacity.h"

#include <string.h>

void alpha_mask_write(void *out, const csm_alpha_mask_info *info, float cutoff) {
  float block[ALPHA_MASK_BLOCK / sizeof(float)] = {0};
  float *size = &block[OPACITY_SIZE * 4], *wrap = &block[OPACITY_WRAP * 4];
  size[0] = (float)info->width;
  size[1] = (float)info->height;
  size[2] = cutoff;
  wrap[0] = (float)info->wrap_u;
  wrap[1] = (float)info->wrap_v;
  memcpy(out, block, sizeof block);
}

gpu_bindings_info alpha_mask_inputs(const gpu_program *program, gpu_buffer *constants, gpu_image *texture) {
  return (gpu_bindings_info){.name = "alpha_mask", .program = program, .constants = {constants}, .textures = {texture}};
}
