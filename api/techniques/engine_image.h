/* engine_image.h: an engine's image, taken in for one recording. */
#ifndef TECHNIQUES_ENGINE_IMAGE_H
#define TECHNIQUES_ENGINE_IMAGE_H

#include "device/device.h"

/*
 * Takes an image of this size in until the frame that is about to be recorded is done; *out is NULL if `native` is.
 * Errors: those of gpu_image_import, and INVALID_VALUE (another size).
 */
csm_result engine_image_import(device *device, const void *native, uint32_t width, uint32_t height, const char *name,
                               gpu_image **out, bool *unorm);

#endif
