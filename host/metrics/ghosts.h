/* metrics/ghosts.h: what a view's history gets wrong that one frame alone has right. */
#ifndef HOST_GHOSTS_H
#define HOST_GHOSTS_H

#include "metrics/metrics.h"

typedef struct ghosts {
  uint64_t pixels; /* of the set S */
  uint64_t wrong;  /* by more than a half, where the frame alone is not */
  double squares;  /* of the frames' own errors, summed */
} ghosts;

/* Adds a frame, with its kinds as metrics_measure tells them, and what its mask is without a history. */
void ghosts_add(ghosts *sum, const metrics_frame *frame, const uint8_t *kinds, const float *alone);
void ghosts_print(FILE *to, const ghosts *all, uint32_t count);
/* Adds "ghosts" (a share of S) and "rmse_alone" to an object. */
void ghosts_to_json(json_t *object, const ghosts *g);

#endif
