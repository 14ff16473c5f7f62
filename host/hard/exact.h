/*
 * hard/exact.h: what the cases of filter exact share: a picture in which rays decide where maps do not, and one in which
 * a ray decides each pixel, both against the truth.
 */
#ifndef HOST_HARD_EXACT_H
#define HOST_HARD_EXACT_H

#include "hard/hard.h"

/* Who decides: maps where their texels agree, or rays alone. */
enum { EXACT_MAPS, EXACT_RAYS, EXACT_WAYS };
extern const char *const exact_ways[EXACT_WAYS];

void exact_set(csm_config *config, int way);

/* What is judged: outside of the margins nothing may be wrong. What the light grazes is stated. */
typedef struct exact_asked {
  const char *what;
  hard_margin margin;
  bool closed; /* all is dark, whatever the truth says; and maybe nothing is turned to the light */
} exact_asked;

/*
 * Draws what is loaded, by the setup's configuration but for the filter, for its camera and a light, in both ways, and
 * adds the figures of what is wrong. *truth, which may hold an earlier one or zeros, gets what it was judged by.
 */
int exact_judge(hard_run *run, const scene_light *light, const exact_asked *asked, hard_truth *truth);
/* The same for a setup that is not loaded, with its own light. */
int exact_judge_setup(hard_run *run, const host_setup *setup, const exact_asked *asked);

#endif
