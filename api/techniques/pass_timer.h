/* pass_timer.h: what a technique's steps take on the GPU, as told by the last of its recordings that is done. */
#ifndef TECHNIQUES_PASS_TIMER_H
#define TECHNIQUES_PASS_TIMER_H

#include "techniques/technique.h"

enum { PASS_TIMER_STEPS = 1 + CSM_MAX_CASCADES };

/* Zeroed, nothing is measured. It lies where it is until it is dropped. */
typedef struct pass_timer {
  double ms[PASS_TIMER_STEPS];
  uint32_t measured;   /* steps */
  uint32_t next, left; /* of the recording on its way: the timestamp that ends the next step, and steps that are left */
} pass_timer;

/* The first of `steps` steps begins, in the order of what is recorded. */
void pass_timer_begin(pass_timer *timer, const technique_run *run, uint32_t steps);
/* A step ends, and the next one begins. */
void pass_timer_step(pass_timer *timer, const technique_run *run);
/* A recording goes without the steps: where it is measured, they are not, and what was is not of it. */
void pass_timer_skip(pass_timer *timer, const technique_run *run);
/* -1 if it is not measured. */
double pass_timer_ms(const pass_timer *timer, uint32_t step);
/* Forgets what was measured, and what the device is still measuring. */
void pass_timer_drop(pass_timer *timer, device *device);

#endif
