/*
 * budget.h: how fine maps may be, for the targets of a configuration's budget. Pure: what was measured goes in, a choice and
 * what is expected of it come out.
 */
#ifndef PLAN_BUDGET_H
#define PLAN_BUDGET_H

#include "plan/plan.h"

enum {
  PLAN_BUDGET_STEPS = 13, /* of 2^(1/4) texels a side: the last is an eighth */
  PLAN_BUDGET_TAKEN = 5   /* frames that a choice is made from */
};

/* A configuration whose maps are all so many steps coarser. */
void plan_budget_coarser(csm_config *out, const csm_config *config, uint32_t step);
/* Device memory of a configuration's maps and moments, as it is without a driver's padding. */
uint64_t plan_budget_bytes(const csm_config *config);
static inline double plan_budget_cap(const csm_config *config) { /* in bytes */
  return config->budget_mib * 1048576.0;
}
/* The first step from `from` on that budget_mib has room for; PLAN_BUDGET_STEPS: there is none. */
uint32_t plan_budget_fit(const csm_config *config, uint32_t from);
/* Whether a filter's wrong pixels can be told from a mask. */
bool plan_budget_judges(const csm_config *config);

/* Of a frame, or expected of one. Negative: not known. */
typedef struct plan_budget_cost {
  double ms;     /* of maps and mask */
  double unsure; /* share of the pixels facing the light that are neither lit nor dark */
} plan_budget_cost;

/* What is known of a configuration's steps, and which one is drawn. Zero is to be begun. */
typedef struct plan_budget {
  uint32_t step, last; /* last: the coarsest there is */
  uint32_t wait;       /* frames until what comes in is of this step */
  uint32_t count;      /* of those that came in since */
  plan_budget_cost taken[PLAN_BUDGET_TAKEN];
  plan_budget_cost now;                                     /* their middle, of this step or the one before */
  double ms[PLAN_BUDGET_STEPS], weights[PLAN_BUDGET_STEPS]; /* of each step, when it was drawn last */
  int32_t wish;                                             /* steps to coarser that the last choice wished for */
  uint32_t wishes;                                          /* choices in a row that did */
  bool fresh;                                               /* nothing has come in of this step */
} plan_budget;

/* What is drawn is measured up to `late` frames later, here and below. */
void plan_budget_begin(plan_budget *budget, const csm_config *config, uint32_t late);
/* Another device: times say nothing any more. The step stays. */
void plan_budget_forget(plan_budget *budget, uint32_t late);
/* Takes in a frame, and chooses the step of the next one. */
void plan_budget_next(plan_budget *budget, const csm_config *config, const plan_budget_cost *cost, uint32_t late);
/* Expected of a step, negative as long as nothing is known: milliseconds, and a share of wrong pixels. */
double plan_budget_ms(const plan_budget *budget, const csm_config *config, uint32_t step);
double plan_budget_wrong(const plan_budget *budget, const csm_config *config, uint32_t step);
/* CSM_BUDGET_TIME and CSM_BUDGET_ERROR: which targets are missed. */
uint32_t plan_budget_missed(const plan_budget *budget, const csm_config *config);

#endif
