/* stage/compare.h: whether two backends drew the same. */
#ifndef HOST_COMPARE_H
#define HOST_COMPARE_H

#include "stage/stage.h"
#include <jansson.h>

typedef struct depth_difference {
  uint64_t differing; /* texels */
  uint32_t max_ulp;   /* units in the last place of D32 */
} depth_difference;

typedef struct agreement {
  bool plans_equal;     /* plan hashes, and every number and byte of the bindings */
  uint32_t allowed_ulp; /* 0 where one rasteriser runs both */
  uint32_t cascade_count;
  depth_difference maps[CSM_MAX_CASCADES];
  depth_difference camera_depth;
  uint64_t mask_pixels; /* of the mask */
  uint64_t mask_beyond; /* that differ by more than 1/255 */
  float mask_largest;   /* the largest difference */
  bool has_views;       /* both frames have some */
  bool has_view[STAGE_VIEWS];
  uint64_t views[STAGE_VIEWS]; /* pixels that differ at all */
  bool casters_equal;
  bool depth_agrees, mask_agrees, views_agree;
  bool agrees;
} agreement;

/* The largest difference of two masks' pixels that still agrees: 1/255, and what rounding adds. */
extern const float compare_mask_tolerance;
/* The share of pixels that may differ by more. */
extern const double compare_mask_share;

/* Both frames are of the same setup. */
void compare_frames(agreement *out, const stage *a, const stage_frame *frame_a, const stage *b,
                    const stage_frame *frame_b);
depth_difference compare_depths(const float *a, const float *b, size_t count);

void agreement_print(FILE *to, const agreement *result, const char *name_a, const char *name_b);
json_t *agreement_to_json(const agreement *result);

#endif
