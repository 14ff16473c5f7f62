/* metrics/flicker.h: what changes from one frame to the next though it should not. */
#ifndef HOST_FLICKER_H
#define HOST_FLICKER_H

#include "metrics/metrics.h"

/* World points that two frames both see. */
typedef struct flicker {
  uint64_t points;   /* in the same cascade in both */
  uint64_t changed;  /* of them: by more than 1/255, where the truth does not change so */
  uint64_t crossing; /* points whose cascade changes: told apart */
  uint64_t crossing_changed;
} flicker;

/* The points that the first frame sees, and what both frames make of them. */
typedef struct flicker_pair {
  const truth_view *view; /* of the first frame */
  const uint8_t *kinds;   /* of the first frame, as metrics_measure left them: points of S count */
  const uint8_t *seen;    /* by the second frame too: truth_seen */
  const camera *second;   /* the second frame's camera */
  const scene_light *second_light;
  double shadow_distance;     /* the scene's */
  const float *cascades[2];   /* CSM_SHOW_CASCADE of each frame's maps, at these points */
  const float *visibility[2]; /* true, with each frame's light */
  const float *masks[2];      /* drawn, from each frame's maps, at these very points */
} flicker_pair;

/* Adds a pair of frames to *sum. */
void flicker_add(flicker *sum, const flicker_pair *pair);

/* Adds `flicker` and what belongs to it to the metrics' object. */
void flicker_to_json(json_t *metrics, const flicker *f);
/* Lines of metrics_print's table. */
void flicker_print(FILE *to, const flicker *all, uint32_t count);

#endif
