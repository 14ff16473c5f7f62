/*
 * hard/moment_model.h: what filters on moments answer, in doubles, from their papers. It shares nothing with the
 * shaders. Depths are z = 2 d - 1, from -1 at the light's side of the map's range to 1.
 */
#ifndef HOST_HARD_MOMENT_MODEL_H
#define HOST_HARD_MOMENT_MODEL_H

#include "csm/csm.h"
#include <stdbool.h>

typedef struct moment_model {
  uint32_t filter;     /* CSM_FILTER_VSM, ESM, EVSM2, EVSM4 or MSM4 */
  double exponents[2]; /* of the positive and the negative warp */
  double deviation;    /* least standard deviation of z */
  double noise;        /* what is taken off a variance; of an exponential a share of the mean square */
  double bias;         /* MSM4: share of the depths that is taken to be spread out, at -1, 0 and 1 */
  double reduction;    /* of bleeding: what is below is 0, the rest is stretched */
  double power;        /* and raised to this */
  bool smoothstep;     /* a textbook's curve instead of a line */
} moment_model;

enum { MOMENT_CHANNELS = 4 };

/* How many moments a filter keeps. */
uint32_t moment_model_channels(const moment_model *model);
/* The moments of one depth. Those of many are their mean. */
void moment_model_warp(const moment_model *model, double z, double moments[MOMENT_CHANNELS]);
/* The share of light that comes to a receiver at z, at most, by the moments. */
double moment_model_visibility(const moment_model *model, const double moments[MOMENT_CHANNELS], double z);
/*
 * The least gap, in z, from which on a receiver below nothing but one level caster at `z` gets at most a share of the
 * light.
 */
double moment_model_least_gap(const moment_model *model, double z, double share);

/* To the nearest 16-bit float, halves to even; those beyond the largest are infinite. */
double half_of(double value);

#endif
