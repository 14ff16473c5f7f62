#include "base/statistics.h"
#include "base/host.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static int compare_doubles(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/*
 * How many samples lie outside the interval at each end, as the sign test has it: the largest k for which fewer than k
 * of `count` tosses of a coin come up heads with a probability of at most 2.5 %.
 */
static uint32_t outside(uint32_t count) {
  double probability = 0.0;
  for (uint32_t k = 0; k < count / 2; k++) {
    probability += exp(lgamma(count + 1.0) - lgamma(k + 1.0) - lgamma(count - k + 1.0) - count * log(2.0));
    if (probability > 0.025)
      return k;
  }
  return count / 2;
}

/* Releases the samples. */
static estimate take(double *samples, uint32_t count) {
  qsort(samples, count, sizeof *samples, compare_doubles);
  const uint32_t rank = outside(count), first = rank > 0 ? rank - 1 : 0;
  const estimate result = {.median = 0.5 * (samples[(count - 1) / 2] + samples[count / 2]),
                           .low = samples[first],
                           .high = samples[count - 1 - first]};
  free(samples);
  return result;
}

estimate estimate_median(const double *samples, uint32_t count) {
  double *own = host_allocate(count, sizeof *own);
  return take(memcpy(own, samples, count * sizeof *own), count);
}

estimate estimate_ratio(const double *top, const double *bottom, uint32_t count) {
  double *ratios = host_allocate(count, sizeof *ratios);
  for (uint32_t i = 0; i < count; i++)
    ratios[i] = top[i] / bottom[i];
  return take(ratios, count);
}

json_t *estimate_to_json(const estimate *value) {
  json_t *object = json_object();
  json_object_set_new(object, "median", json_real(value->median));
  json_object_set_new(object, "low", json_real(value->low));
  json_object_set_new(object, "high", json_real(value->high));
  return object;
}
