/* bench/pages.h: frames of maps of pages, which are kept, against the same frames drawn whole. */
#ifndef HOST_BENCH_PAGES_H
#define HOST_BENCH_PAGES_H

#include "base/statistics.h"
#include "stage/stage.h"
#include <jansson.h>
#include <stdio.h>

enum { PAGES_CASES = 8 };

/* What happens from frame to frame. */
typedef struct bench_pages_case {
  const char *name;
  estimate whole_ms, pages_ms, ratio; /* wall-clock: planned, recorded, drawn and waited for */
  double worst;                       /* the largest of the ratios to the median of whole maps */
  double plan_ms;                     /* CPU: median */
  double pages, valid, triangles; /* of a frame, on average: pages drawn, and valid, of all maps, and triangles drawn */
  double whole_triangles;         /* of whole maps */
} bench_pages_case;

typedef struct bench_pages {
  const char *backend;
  uint32_t frames;
  bench_pages_case cases[PAGES_CASES];
} bench_pages;

/* Draws a stage's scene on two devices of its backend in turn. 0, or a code after a message. */
int bench_pages_run(bench_pages *out, const stage *s, const char *device, uint32_t frames);
void bench_pages_print(FILE *to, const bench_pages *pages);
json_t *bench_pages_to_json(const bench_pages *pages);

#endif
