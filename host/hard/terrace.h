/*
 * hard/terrace.h: a square terrace whose steps lie at every depth of a map's range, from next to its begin to next to
 * its end. Some are bare; over the others hangs a lid that only casts, of which the gap is another one for each, with
 * nothing behind it.
 */
#ifndef HOST_HARD_TERRACE_H
#define HOST_HARD_TERRACE_H

#include "hard/moment_scene.h"

enum { TERRACE_CELLS = 15, TERRACE_CELL_PIXELS = 16, TERRACE_PIXELS = TERRACE_CELLS * TERRACE_CELL_PIXELS };

/* The range begins at height `range`, in metres, and ends at 0. There is no bias, and bleeding stays. */
void terrace_make(host_setup *out, double range);
/* Once it is loaded: lids cast alone. */
int terrace_hide_lids(hard_run *run);

/* A pixel's step. Rows go from the light downwards. */
typedef struct terrace_step {
  double depth;    /* as a share of the range */
  double gap;      /* of its lid, likewise; 0: there is none */
  double place[3]; /* of the pixel, in the world */
} terrace_step;

/* False: within `reach` metres and a bit of another step. */
bool terrace_step_at(terrace_step *out, const host_setup *setup, uint32_t column, uint32_t row, double reach);

#endif
