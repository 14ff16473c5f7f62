/*
 * bench/bare_mask.h: full-screen passes of a mask's size in bare Vulkan, on maps and a camera's depth that csm drew.
 * `csm-host bench` measures masks against them.
 */
#ifndef HOST_BARE_MASK_H
#define HOST_BARE_MASK_H

#include <stddef.h>
#include <stdint.h>

typedef struct bare_mask bare_mask;

typedef enum bare_pass {
  BARE_FLOOR,   /* loads the depth, rebuilds the position, writes 1 */
  BARE_SET_UP,  /* all that csm's mask does for one tap, but the tap */
  BARE_LOOP_49, /* 49 bilinear comparisons a texel apart */
  BARE_PCF_7X7, /* csm's own shader of that filter */
  BARE_PASSES
} bare_pass;

typedef struct bare_mask_info {
  uint32_t width, height, resolution, cascade_count;
  const float *camera_depth; /* top row first */
  float *const *maps;        /* likewise, one for each cascade */
  const float *cascades;     /* the block CSM_C_* of csm_constants.h */
  const float *camera;       /* and CSM_M_* */
  const char *device;        /* part of a device's name, or NULL */
} bare_mask_info;

/* Opens a device and uploads all. 0 or HOST_NO_DEVICE; `error` gets a text then, and *out is NULL. */
int bare_mask_open(bare_mask **out, const bare_mask_info *info, char *error, size_t error_size);

/* Draws, and waits: milliseconds on the GPU, or a negative number. */
double bare_mask_draw(bare_mask *mask, bare_pass pass);

/* What was drawn last: width * height visibilities in 8 bits, top row first, until the next draw. */
const uint8_t *bare_mask_pixels(const bare_mask *mask);

/* NULL is allowed. */
void bare_mask_close(bare_mask *mask);

#endif
