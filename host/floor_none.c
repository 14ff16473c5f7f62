/* floor_none.c: in place of floor.c in a build without Vulkan. */
#include "floor.h"
#include "host.h"
#include <stdio.h>

int floor_open(floor_loop **out, const floor_info *info, char *error, size_t error_size) {
  (void)info;
  *out = NULL;
  snprintf(error, error_size, "this csm-host was built without Vulkan");
  return HOST_NO_DEVICE;
}

double floor_frame(floor_loop *loop) {
  (void)loop;
  return -1.0;
}

void floor_close(floor_loop *loop) {
  (void)loop;
}
