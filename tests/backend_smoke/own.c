/* own.c: smoke tests on a device that the backend opens. */
#include "smoke.h"

void smoke_open(smoke *s, gpu_open_info *info) {
  (void)s, (void)info;
}

void *smoke_begin(smoke *s) {
  (void)s;
  return NULL;
}

void smoke_end(smoke *s) {
  (void)s;
}

csm_result smoke_wait(smoke *s, uint32_t slot) {
  return gpu_wait(s->g, slot);
}

void smoke_close(smoke *s) {
  (void)s;
}
