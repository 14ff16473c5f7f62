/* bench/switching.h: how long a context takes to move from one backend to the other. */
#ifndef HOST_BENCH_SWITCH_H
#define HOST_BENCH_SWITCH_H

#include "base/statistics.h"
#include "setup/options.h"

typedef struct bench_switch {
  estimate switch_ms[HOST_BACKENDS]; /* to each backend */
  uint32_t rounds;
} bench_switch;

/* Moves the setup's scene there and back `rounds` times, drawing in between. 0, or a code after a message. */
int bench_switch_run(bench_switch *out, const host_setup *setup, const char *device, uint32_t rounds);

#endif
