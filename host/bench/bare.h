/* bench/bare.h: bare passes of a mask's size, and csm's 7 x 7 filter against the loop of 49 comparisons. */
#ifndef HOST_BENCH_BARE_H
#define HOST_BENCH_BARE_H

#include "bench/bare_mask.h"
#include "bench/scene_plan.h"
#include "stage/stage.h"
#include "base/statistics.h"
#include <jansson.h>

/* Opens the bare passes on what a stage draws with a configuration of D32 maps in an array. 0, or a code after a
 * message; *out is NULL then. */
int bench_bare_open(bare_mask **out, stage *s, const csm_config *config, const bench_plan *plan, const char *device);

typedef struct bench_bare {
  uint32_t pairs; /* 0: not measured */
  estimate ms[BARE_PASSES];
  estimate set_up_to_floor; /* csm's set-up to the least */
  estimate pcf_to_loop;     /* csm's 7 x 7 filter to the loop, one depth for all taps */
  uint32_t differing;       /* pixels of the two masks that differ, in 8 bits */
  uint32_t pixels, partial; /* of the mask; neither lit nor dark */
} bench_bare;

/* Draws every bare pass in turn. 0, or a code after a message. */
int bench_bare_run(bench_bare *out, stage *s, const csm_config *config, const bench_plan *plan, const char *device,
                   uint32_t pairs);
void bench_bare_print(FILE *to, const bench_bare *bare);
json_t *bench_bare_to_json(const bench_bare *bare);

#endif
