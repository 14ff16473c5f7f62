#include "choose.h"

#include <ctype.h>
#include <stdio.h>

static bool contains(const char *name, const char *part) {
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

/* Higher is better, and 0 is none. */
static uint32_t rank_of(gpu_device_type type) {
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

bool choose_offer(choose_choice *choice, const choose_candidate *candidate) {
  choice->offered++;
  if (!contains(candidate->name, choice->part))
    return false;
  if (candidate->lacks) {
    snprintf(choice->lacking, sizeof choice->lacking, "; %s lacks %s", candidate->name, candidate->lacks);
    return false;
  }
  const uint32_t rank = rank_of(candidate->type);
  if (rank <= choice->rank)
    return false;
  choice->rank = rank;
  return true;
}

void choose_refusal(const choose_choice *choice, char *out, size_t size) {
  const char *part = choice->part;
  snprintf(out, size, "none of %u Vulkan devices fits%s%s%s%s", choice->offered, part ? " the name \"" : "",
           part ? part : "", part ? "\"" : "", choice->lacking);
}
