/* rig.c: what rigs of both APIs share. */
#include "rig.h"

uint32_t rig_texel_bytes(rig_format format) {
  switch (format) {
  case RIG_RGBA_FLOAT_32:
    return 16;
  case RIG_RGBA_FLOAT_16:
  case RIG_RGBA_SNORM_16:
  case RIG_RGBA_UNORM_16:
  case RIG_RG_FLOAT_32:
    return 8;
  case RIG_DEPTH_32:
  case RIG_RG_FLOAT_16:
  case RIG_RGBA_UNORM_8:
    return 4;
  }
  return 0;
}
