/* traps_on.c: loaded before a program (LD_PRELOAD), lets floating-point exceptions trap in all of it. */
#include <fenv.h>

__attribute__((constructor)) static void begin(void) {
  feenableexcept(FE_DIVBYZERO | FE_INVALID | FE_OVERFLOW);
}
