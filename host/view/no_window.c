/* view_none.c: a host that was built without SDL2. */
#include "base/host.h"
#include "view/view.h"

int view_command(const host_options *options) {
  (void)options;
  return host_fail(HOST_BAD_INPUT,
                   "view: this csm-host was built without SDL2; install libsdl2-dev and build it again");
}
