/* alpha_images.h: alpha masks on a device, and what meshes that are cut out by them read. */
#ifndef DEVICE_ALPHA_IMAGES_H
#define DEVICE_ALPHA_IMAGES_H

#include "device/device.h"

enum { ALPHA_MASK_BLOCK = 256 };

/* Makes room for images in `capacity` places. */
csm_result alpha_images_reserve(device *device, uint32_t capacity);
/* Makes a checked one below the capacity; its texels wait in staging. */
csm_result alpha_images_add(device *device, uint32_t index, const csm_alpha_mask_info *info);
/* Frees it once the GPU is done with it. */
void alpha_images_remove(device *device, uint32_t index);
gpu_image *alpha_images_texture(const device *device, uint32_t index);
/* Where its texels begin in the pool of trees: one a byte, row by row. Precondition: meshes get trees. */
uint32_t alpha_images_row(const device *device, uint32_t index);

/* Writes the constants of an alpha-tested mesh: ALPHA_MASK_BLOCK bytes. */
void alpha_mask_write(void *out, const csm_alpha_mask_info *info, float cutoff);
/* Bindings of such a mesh, good for every program that draws it: constants from the buffer's beginning, and a texture.
 */
csm_result alpha_mask_bindings(device *device, gpu_buffer *constants, gpu_image *texture, gpu_bindings **out);

#endif
