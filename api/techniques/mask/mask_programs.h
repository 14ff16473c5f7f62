/* mask_programs.h: which program draws a mask. */
#ifndef TECHNIQUES_MASK_PROGRAMS_H
#define TECHNIQUES_MASK_PROGRAMS_H

#include "device/device.h"

/* Bytes of the constants that a mask's program sees: the cascades' two blocks, and its camera's. */
enum { MASK_CASCADES_BLOCK = 1280, MASK_CAMERA_BLOCK = 256 };

/* What it is drawn into: visibility, and with a history how flat that is (csm_flatness). */
gpu_format mask_format(const csm_config *config, bool shows);
/* The program that a configuration's masks are drawn with; `shows` is a picture of something else than visibility. */
csm_result mask_program_create(gpu gpu, const csm_config *config, bool normals, bool shows, gpu_program **out);
/* The program for a configuration, made if it is the device's first. `normals`: the engine's. `shows`: something else
   than visibility. */
csm_result mask_program(device *device, const csm_config *config, bool normals, bool shows, gpu_program **out);

#endif
