/* outcome.h: what a frame comes to: a plan, maps, a mask, and the camera's depth. */
#ifndef OUTCOME_H
#define OUTCOME_H

#include "support.h"

enum { OUTCOME_WIDTH = 96, OUTCOME_HEIGHT = 64 };

typedef struct outcome {
  uint64_t plan_hash;
  uint32_t cascades, resolutions[CSM_MAX_CASCADES];
  float *maps[CSM_MAX_CASCADES];
  float *mask, *depth;
} outcome;

/* Renders and resolves the shot, and reads what came of it. */
outcome outcome_draw(csm_context *context, csm_cascades *cascades, csm_view *view, shot *shot);
void outcome_free(outcome *outcome);

bool outcome_same_maps(const outcome *a, const outcome *b);
bool outcome_same_mask(const outcome *a, const outcome *b);
bool outcome_same_depth(const outcome *a, const outcome *b);
/* Asserts that all three are the same, bit for bit; `b` is freed. */
void outcome_expect_same(const outcome *a, outcome *b, const char *what);

#endif
