#include "bench/switching.h"
#include "base/host.h"
#include "stage/stage.h"
#include <stdlib.h>

static int switch_once(stage *s, const char *backend, const char *device, double *ms) {
  const int code = stage_switch(s, backend, device, ms);
  return code ? code : stage_render(s);
}

int bench_switch_run(bench_switch *out, const host_setup *setup, const char *device, uint32_t rounds) {
  double *samples[HOST_BACKENDS];
  stage s;
  *out = (bench_switch){.rounds = rounds};
  for (int i = 0; i < HOST_BACKENDS; i++)
    samples[i] = host_allocate(rounds, sizeof *samples[i]);
  int code = stage_open(&s, host_backend_names[0], device);
  if (code == 0)
    code = stage_load(&s, setup);
  for (uint32_t round = 0; round < rounds && code == 0; round++)
    for (int i = HOST_BACKENDS; i-- > 0 && code == 0;)
      code = switch_once(&s, host_backend_names[i], device, &samples[i][round]);
  for (int i = 0; i < HOST_BACKENDS; i++) {
    if (code == 0)
      out->switch_ms[i] = estimate_median(samples[i], rounds);
    free(samples[i]);
  }
  stage_close(&s);
  return code;
}
