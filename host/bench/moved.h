/* bench/moved.h: a frame of maps in which some of many instances have moved, with the trees of rays and without. */
#ifndef HOST_BENCH_MOVED_H
#define HOST_BENCH_MOVED_H

#include "bench/scene_plan.h"
#include "stage/stage.h"
#include <jansson.h>
#include <stdio.h>

enum { MOVED_PLAIN, MOVED_RAYS, MOVED_SIDES };

typedef struct bench_moved {
  uint32_t rounds, instances, moved;
  estimate frame_ms[MOVED_SIDES];   /* wall-clock: moved, drawn and waited for */
  estimate call_ms[MOVED_SIDES];    /* CPU: csm_render_cascades */
  estimate frame_ratio, call_ratio; /* with trees / without */
  estimate tree_ms;                 /* of a frame: the instances' tree */
  double first_tree_ms;             /* when all of them were new */
} bench_moved;

/*
 * Draws `many`'s instances on two devices of the stage's backend in turn: one whose context makes trees, with filter exact,
 * and one whose does not, with pcf_3x3. 0, or a code after a message.
 */
int bench_moved_run(bench_moved *out, const stage *s, const bench_plan *many, const char *device, uint32_t pairs);
void bench_moved_print(FILE *to, const bench_moved *moved);
json_t *bench_moved_to_json(const bench_moved *moved);

#endif
