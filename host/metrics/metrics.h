/* metrics/metrics.h: how wrong a mask is, against the truth. docs/accuracy.md defines every number. */
#ifndef HOST_METRICS_H
#define HOST_METRICS_H

#include "truth/truth.h"
#include <jansson.h>
#include <stdio.h>

#define METRICS_EDGE_CAP_PX 16.0
#define METRICS_DEPTH_SHARE 0.01
#define METRICS_GRAZING_COSINE 0.02 /* up to which the light grazes a surface */

/* What a pixel is, in the order of drawing it over what lies below. */
typedef enum metrics_kind {
  METRICS_LEFT_OUT,     /* not measured */
  METRICS_GRAZING,      /* the light grazes it: measured apart */
  METRICS_RIGHT,        /* on the right side of one half */
  METRICS_FALSE_LIT,    /* lit, though in shadow, near a true edge */
  METRICS_LEAK,         /* the same, far from every true edge */
  METRICS_FALSE_SHADOW, /* shadowed, though lit, near a true edge */
  METRICS_ACNE          /* the same, far from every true edge */
} metrics_kind;

typedef struct metrics {
  uint64_t pixels; /* in the set S; every share is of it */
  double lit;      /* share that is lit, by the truth */
  double false_lit, false_shadow;
  double rmse, mean, mean_absolute; /* of visibility; mean: drawn less true, so that above 0 is too bright */
  double acne, leak;
  double edge_px;                                   /* negative: neither the truth nor the mask has an edge */
  uint64_t edge_true_px, edge_drawn_px;             /* length */
  uint64_t edge_true_alone_px, edge_drawn_alone_px; /* length farther than METRICS_EDGE_CAP_PX from the other's edges */
  uint64_t grazing_pixels;
  double grazing_false_lit, grazing_false_shadow; /* shares of the grazing pixels */
  uint64_t depth_pixels; /* that would be in S but for the camera's depth, which shows something else there */
} metrics;

/* One frame, as it was drawn and as it is. */
typedef struct metrics_frame {
  const truth_view *view;
  const scene_light *light;
  double shadow_distance;  /* the scene's */
  const float *visibility; /* true: truth_visibility up to that distance */
  const float *mask;       /* drawn */
  const float *view_depth; /* drawn, in metres; INFINITY where no surface was */
} metrics_frame;

/*
 * Measures a frame, and fills `kinds`, one for each pixel: the set S is those from METRICS_RIGHT on. 0; HOST_BAD_INPUT
 * after a message that says why nothing can be measured; HOST_DIFFER after one that the drawn depth is another than the
 * true one in more than METRICS_DEPTH_SHARE of the pixels that the light reaches: S would leave out the worst of them.
 */
int metrics_measure(metrics *out, const metrics_frame *frame, uint8_t *kinds);

/* The metrics of several frames as one: shares and means over all their pixels, counts summed. Precondition: count > 0.
 */
void metrics_pool(metrics *out, const metrics *frames, uint32_t count);

/* A table with a column for each of the names. */
void metrics_print(FILE *to, const metrics *all, const char *const *names, uint32_t count);
json_t *metrics_to_json(const metrics *m);

/* ---- parts ---- */

/* The fixed reference that acne and leak are measured with: four slices, each covered by 2048 texels. */
typedef struct metrics_reference {
  double far_depth[4], texel[4]; /* metres */
  double pixels_per_meter;       /* at w = 1 */
  double w_scale, w_offset;      /* w at a view depth */
} metrics_reference;
void metrics_reference_make(metrics_reference *out, const camera *from, uint32_t width, uint32_t height,
                            double shadow_distance);
/* A reference texel in pixels, at a view depth. */
double metrics_reference_texel_px(const metrics_reference *reference, double view_depth);
/* Radius of the least sphere around points. Precondition: 1 to 8 points. */
double metrics_sphere_radius(double (*points)[3], uint32_t count);

/*
 * The square of each grid point's distance to the nearest marked one, exactly; INT64_MAX where none is marked.
 */
void metrics_distances(const uint8_t *marked, uint32_t width, uint32_t height, int64_t *squares);

#endif
