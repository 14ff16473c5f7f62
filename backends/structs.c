#include "structs.h"

#include <string.h>

/* No later version of a struct grows by more: a larger size is garbage, and its tail must not be read. */
enum { largest_tail = 4096 };

csm_result struct_check(uint32_t size, const void *in) {
  if (!in)
    return CSM_ERROR_NULL_POINTER;
  uint32_t given;
  memcpy(&given, in, sizeof given);
  if (given < sizeof given || given % 4 || given > size + largest_tail)
    return CSM_ERROR_STRUCT_SIZE;
  const unsigned char *bytes = in;
  for (uint32_t i = size; i < given; ++i)
    if (bytes[i])
      return CSM_ERROR_STRUCT_SIZE;
  return CSM_SUCCESS;
}

csm_result struct_read(void *out, uint32_t size, const void *in) {
  const csm_result result = struct_check(size, in);
  if (result)
    return result;
  uint32_t given;
  memcpy(&given, in, sizeof given);
  const uint32_t common = given < size ? given : size;
  memcpy(out, in, common);
  memset((unsigned char *)out + common, 0, size - common);
  return CSM_SUCCESS;
}

void struct_write(void *out, uint32_t size, const void *from) {
  uint32_t given;
  memcpy(&given, out, sizeof given);
  const uint32_t common = given < size ? given : size;
  if (common > sizeof given)
    memcpy((unsigned char *)out + sizeof given, (const unsigned char *)from + sizeof given, common - sizeof given);
}
