/* mask_programs.h: which program draws a mask. */
#ifndef TECHNIQUES_MASK_PROGRAMS_H
#define TECHNIQUES_MASK_PROGRAMS_H

#include "device/device.h"

/* Bytes of the constants that a mask's program sees: the cascades', and its camera's. */
enum { MASK_CASCADES_BLOCK = 1024, MASK_CAMERA_BLOCK = 256 };

/* What a program is made for. */
typedef struct mask_kind {
  uint32_t filter;  /* as in csm_config */
  uint32_t early;   /* large boxes look at their corners first */
  uint32_t plane;   /* texels are compared with the receiver's plane */
  uint32_t normals; /* the engine's */
  uint32_t shows;   /* something else than visibility, which knows none of the above */
} mask_kind;

mask_kind mask_kind_of(const csm_config *config, bool normals, bool shows);
/* The program for a kind, made if it is the device's first. */
csm_result mask_program(device *device, const mask_kind *kind, gpu_program **out);

#endif
