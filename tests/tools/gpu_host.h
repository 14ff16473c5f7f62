/* gpu_host.h: the memory callbacks that tests lend csm, or a device: memory is neither zero when it comes nor what it was
 * when it has gone. */
#ifndef TEST_GPU_HOST_H
#define TEST_GPU_HOST_H

#include "csm/csm_base.h"
#include <malloc.h>
#include <stdlib.h>
#include <string.h>

static inline void *CSM_CALL test_allocate(void *user, size_t size, size_t alignment) {
  (void)user;
  void *memory = aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  if (memory)
    memset(memory, 0xa5, size);
  return memory;
}

static inline void CSM_CALL test_release(void *user, void *memory) {
  (void)user;
  if (memory)
    memset(memory, 0x5a, malloc_usable_size(memory));
  free(memory);
}

#endif
