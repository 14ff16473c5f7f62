/* gpu_host.h: the memory callbacks that tests of gpu.h lend a device. */
#ifndef TEST_GPU_HOST_H
#define TEST_GPU_HOST_H

#include "csm/csm_base.h"
#include <stdlib.h>

static inline void *CSM_CALL test_allocate(void *user, size_t size, size_t alignment) {
  (void)user;
  return aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
}

static inline void CSM_CALL test_release(void *user, void *memory) {
  (void)user;
  free(memory);
}

#endif
