/*
 * bench/drawn_moments.h: moments that casters' pixel shaders write while a map is drawn, in bare Vulkan, against a bare
 * depth pass and csm's conversion of its depths.
 */
#ifndef HOST_BENCH_DRAWN_MOMENTS_H
#define HOST_BENCH_DRAWN_MOMENTS_H

#include "base/statistics.h"
#include "bench/floor.h"
#include "stage/stage.h"
#include <jansson.h>

/* Of one kind of moments. Milliseconds on the GPU. */
typedef struct bench_drawn {
  const char *name;
  uint32_t pairs;
  estimate depth;      /* clear and all maps, in bare Vulkan */
  estimate drawn;      /* with the moments */
  estimate made;       /* csm's conversion, without a blur */
  estimate to_made;    /* drawn / (depth + made) */
  estimate more_drawn; /* drawn / depth */
  estimate more_made;  /* (depth + made) / depth */
} bench_drawn;

/* Draws 4 maps of 1024 x 1024 each way in turn. The stage is Vulkan's, and keeps the configuration. 0, or a code after a
 * message. */
int bench_drawn_run(bench_drawn *out, stage *s, floor_moments moments, const char *device, uint32_t pairs);
void bench_drawn_print(FILE *to, const bench_drawn *drawn);
json_t *bench_drawn_to_json(const bench_drawn *drawn);

#endif
