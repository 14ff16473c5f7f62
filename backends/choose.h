/* choose.h: which of several devices a backend takes: the same one in all. */
#ifndef CHOOSE_H
#define CHOOSE_H

#include "gpu.h"

/* A device that may be taken. */
typedef struct choose_candidate {
  const char *name;
  gpu_device_type type;
  const char *lacks; /* what it lacks that csm cannot do without; NULL: nothing */
} choose_candidate;

/* A choice among devices that are offered one by one. Begins with all zero but `part`. */
typedef struct choose_choice {
  const char *part; /* of the name asked for, in letters of either case; NULL: any */
  uint32_t offered;
  uint32_t rank;     /* of the best so far; 0: none */
  char lacking[320]; /* the last one that had the name and lacks something, in words */
} choose_choice;

/* Whether this device is better than those offered before: discrete, integrated, virtual, CPU, others; the first of
   equals. */
bool choose_offer(choose_choice *choice, const choose_candidate *candidate);

/* Why none was taken, in words. */
void choose_refusal(const choose_choice *choice, char *out, size_t size);

#endif
