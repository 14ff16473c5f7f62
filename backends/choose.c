#include "choose.h"

#include <ctype.h>
#include <stddef.h>

bool choose_fits(const char *name, const char *part) {
  if (!part)
    return true;
  for (;; name++) {
    size_t i = 0;
    while (part[i] && tolower((unsigned char)name[i]) == tolower((unsigned char)part[i]))
      i++;
    if (!part[i])
      return true;
    if (!*name)
      return false;
  }
}

uint32_t choose_rank(gpu_device_type type) {
  switch (type) {
  case GPU_DEVICE_DISCRETE:
    return 5;
  case GPU_DEVICE_INTEGRATED:
    return 4;
  case GPU_DEVICE_VIRTUAL:
    return 3;
  case GPU_DEVICE_CPU:
    return 2;
  case GPU_DEVICE_OTHER:
    break;
  }
  return 1;
}
