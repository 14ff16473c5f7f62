/* mask_programs.h: which program draws a mask. */
#ifndef TECHNIQUES_MASK_PROGRAMS_H
#define TECHNIQUES_MASK_PROGRAMS_H

#include "device/device.h"

/* Bytes of the constants that a mask's program sees: the cascades' two blocks, and its camera's. */
enum { MASK_CASCADES_BLOCK = 1280, MASK_CAMERA_BLOCK = 256 };

/* What it is drawn into: visibility, and with a history how flat that is (csm_flatness). */
gpu_format mask_format(const csm_config *config, uint32_t show);
/* The program that a configuration's masks are drawn with. `normals`: the engine's. `show`: CSM_SHOW_*, of which all but
   visibility and the penumbra are one program's. */
csm_result mask_program_create(gpu gpu, const csm_config *config, bool normals, uint32_t show, gpu_program **out);
/* The same, made if it is the device's first. */
csm_result mask_program(device *device, const csm_config *config, bool normals, uint32_t show, gpu_program **out);
/* Whether it reads ranges. */
bool mask_reads_ranges(const csm_config *config, uint32_t show);
/* Whether it reads moments. */
bool mask_reads_moments(const csm_config *config, uint32_t show);

#endif
