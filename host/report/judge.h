/* report/judge.h: which of many settings to use, by what they cost and how wrong they are. */
#ifndef HOST_REPORT_JUDGE_H
#define HOST_REPORT_JUDGE_H

#include "base/statistics.h"
#include <stdbool.h>

/* One setting. Both are above 0. */
typedef struct report_score {
  estimate ms;
  double error;
} report_score;

typedef struct report_verdict {
  uint32_t least_error; /* the fastest of those that have it */
  uint32_t knee;        /* the point of the front farthest below the line between its ends, with both axes stretched
                           to the front's extent */
  uint32_t error_rank;  /* 1 + how many have less error than the base */
  uint32_t time_rank;   /* 1 + how many are faster */
  uint32_t better;      /* no more error and less time than the base, by intervals of time that do not overlap */
  uint32_t front_count;
  uint32_t *front; /* Pareto front, from the fastest to the one with least error */
} report_verdict;

/* Precondition: base < count. */
void report_judge(report_verdict *out, const report_score *scores, uint32_t count, uint32_t base);
void report_verdict_free(report_verdict *verdict);

#endif
