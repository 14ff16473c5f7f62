#include "report/judge.h"
#include "base/host.h"
#include <math.h>
#include <stdlib.h>

typedef struct ranked {
  double ms, error;
  uint32_t index;
} ranked;

static int compare_ranked(const void *a, const void *b) {
  const ranked *x = a, *y = b;
  if (x->ms != y->ms)
    return x->ms < y->ms ? -1 : 1;
  return (x->error > y->error) - (x->error < y->error);
}

static void find_front(report_verdict *out, const report_score *scores, uint32_t count) {
  ranked *order = host_allocate(count, sizeof *order);
  double least = INFINITY;
  out->front = host_allocate(count, sizeof *out->front);
  for (uint32_t i = 0; i < count; i++)
    order[i] = (ranked){.ms = scores[i].ms.median, .error = scores[i].error, .index = i};
  qsort(order, count, sizeof *order, compare_ranked);
  for (uint32_t i = 0; i < count; i++)
    if (order[i].error < least) {
      least = order[i].error;
      out->front[out->front_count++] = order[i].index;
    }
  free(order);
}

/* Where a value lies between the front's ends; 0 where they are one. */
static double place(double value, double from, double to) {
  return from == to ? 0.0 : (value - from) / (to - from);
}

static uint32_t find_knee(const report_verdict *v, const report_score *scores) {
  const report_score *first = &scores[v->front[0]], *last = &scores[v->least_error];
  uint32_t knee = v->least_error;
  double best = INFINITY;
  for (uint32_t i = 0; i < v->front_count; i++) {
    const report_score *at = &scores[v->front[i]];
    const double sum =
        place(at->ms.median, first->ms.median, last->ms.median) + place(at->error, last->error, first->error);
    if (sum < best) {
      best = sum;
      knee = v->front[i];
    }
  }
  return knee;
}

void report_judge(report_verdict *out, const report_score *scores, uint32_t count, uint32_t base) {
  *out = (report_verdict){.error_rank = 1, .time_rank = 1};
  find_front(out, scores, count);
  out->least_error = out->front[out->front_count - 1];
  out->knee = find_knee(out, scores);
  for (uint32_t i = 0; i < count; i++) {
    out->error_rank += scores[i].error < scores[base].error;
    out->time_rank += scores[i].ms.median < scores[base].ms.median;
    out->better += i != base && scores[i].error <= scores[base].error && scores[i].ms.high < scores[base].ms.low;
  }
}

void report_verdict_free(report_verdict *verdict) {
  free(verdict->front);
  *verdict = (report_verdict){0};
}
