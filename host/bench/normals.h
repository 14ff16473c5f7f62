/* bench/normals.h: what exact shadows cost where the engine hands over its normals, on a Vulkan device of an engine's. */
#ifndef HOST_BENCH_NORMALS_H
#define HOST_BENCH_NORMALS_H

#include "bench/rows.h"

typedef struct bench_normals {
  uint32_t pairs;                      /* 0: not measured */
  uint32_t pixels;                     /* that sent rays */
  estimate base_ms, exact_ms, to_base; /* the masks' passes: of pcf_3x3, and of exact with its rays */
  double most_bases;                   /* 0: not known */
} bench_normals;

/* Draws masks of both in turn. Leaves it empty where there is no such device. 0, or a code after a message. */
int bench_normals_run(bench_normals *out, const host_setup *setup, const host_options *options, uint32_t pairs);
void bench_normals_print(FILE *to, const bench_normals *normals);
json_t *bench_normals_to_json(const bench_normals *normals);

#endif
