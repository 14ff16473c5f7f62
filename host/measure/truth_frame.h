/* measure/truth_frame.h: the truth of one picture: what the camera sees, and how much of the sun each pixel sees. */
#ifndef HOST_TRUTH_FRAME_H
#define HOST_TRUTH_FRAME_H

#include "metrics/metrics.h"
#include "stage/stage.h"
#include "truth/store.h"

typedef struct truth_frame {
  truth_view view;
  float *visibility;
  truth_convergence convergence;
} truth_frame;

/*
 * Casts it, or finds it in the store. `setup` must live as long as the frame. 0, or a code after a message, also where
 * the camera is inside a wall; truth_frame_free is always allowed.
 */
int truth_frame_cast(truth_frame *out, truth_store *store, const host_setup *setup, uint32_t sun_samples);
void truth_frame_free(truth_frame *frame);

/* What a backend drew, to be measured against it. */
metrics_frame truth_frame_against(const truth_frame *truth, const host_setup *setup, const stage_frame *drawn);

#endif
