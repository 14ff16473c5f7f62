/* base/statistics.h: what repeated measurements say. */
#ifndef HOST_STATISTICS_H
#define HOST_STATISTICS_H

#include <jansson.h>
#include <stdint.h>

typedef struct estimate {
  double median;
  double low, high; /* of an interval that holds the true median with a probability of at least 95 %. With fewer than
                       6 samples: all of them */
} estimate;

/* Order statistics: no assumption on how the samples are spread. Precondition: count > 0. */
estimate estimate_median(const double *samples, uint32_t count);
/* Of the ratios of samples that were taken in the same round. */
estimate estimate_ratio(const double *top, const double *bottom, uint32_t count);

json_t *estimate_to_json(const estimate *value);

#endif
