#include "techniques/pass_timer.h"

static void take(void *user, const uint64_t *nanoseconds, uint32_t count) {
  pass_timer *timer = user;
  timer->measured = count - 1;
  for (uint32_t i = 0; i + 1 < count; ++i)
    timer->ms[i] = (double)(nanoseconds[i + 1] - nanoseconds[i]) * 1e-6;
}

void pass_timer_begin(pass_timer *timer, const technique_run *run, uint32_t steps) {
  const timing_sink sink = {.take = take, .user = timer};
  uint32_t first = 0;
  timer->left = 0;
  if (!run->timestamps || !recording_expect_timing(run->device, &sink, 1 + steps, &first))
    return;
  gpu_timestamp(run->device->gpu, first);
  timer->next = first + 1;
  timer->left = steps;
}

void pass_timer_step(pass_timer *timer, const technique_run *run) {
  if (timer->left == 0)
    return;
  gpu_timestamp(run->device->gpu, timer->next++);
  --timer->left;
}

double pass_timer_ms(const pass_timer *timer, uint32_t step) {
  return step < timer->measured ? timer->ms[step] : -1;
}

void pass_timer_skip(pass_timer *timer, const technique_run *run) {
  if (run->timestamps)
    pass_timer_drop(timer, run->device);
}

void pass_timer_drop(pass_timer *timer, device *device) {
  recording_forget_timing(device, timer);
  *timer = (pass_timer){0};
}
