/*
 * budget.c: the controller of a budget.
 *
 * A choice is made from the middle of a few frames that were drawn alike, and from the choices before. Then maps get a step
 * coarser, or finer, or stay. Coarser maps follow from times above the target; finer ones from a prediction that leaves
 * room, which remembers what they took when they were drawn. So noise does not make maps swing between two steps.
 */
#include "plan/budget.h"

#include "plan/internal.h"
#include <math.h>
#include <string.h>

#define ROOM 0.85      /* share of a target that a prediction may take up for a choice that is not forced */
#define FAR_OVER 1.1   /* share of a target above which a choice is forced at once */
enum { PATIENCE = 2 }; /* choices in a row that have to wish alike, if nothing hurries */
/*
 * Wrong pixels from unsure ones, measured (docs/economy.md): of pcf_3x3 a share of 0.053 u + 0.32 u^2. Where edges lie close
 * together, a filter as wide as what lies between them loses it. Wrong pixels go with a map's side to the power of -0.95.
 */
#define WRONG_ALONE 0.053
#define WRONG_CLOSE 0.32
#define WRONG_SIDE (-0.95)
/* What is taken for granted of steps that were not drawn: half of what the finest takes goes with the texels; and what that
   weighs against what was measured. */
#define PRIOR_WEIGHT 0.02
#define FADING 0.98 /* of what is known of a step, with every choice */

/* ---- sides, and memory ---- */

static uint32_t coarser_side(uint32_t side, uint32_t unit, uint32_t step) {
  const double units = side * exp2(-0.25 * step) / unit;
  const uint32_t whole = (uint32_t)(units + 0.5);
  return (whole ? whole : 1) * unit;
}

void plan_budget_coarser(csm_config *out, const csm_config *config, uint32_t step) {
  const uint32_t unit = plan_has_pages(config) ? PLAN_CELLS : PLAN_LEAST_RESOLUTION;
  *out = *config;
  if (step == 0)
    return;
  out->resolution = coarser_side(config->resolution, unit, step);
  for (uint32_t i = 0; i < CSM_MAX_CASCADES; ++i)
    out->resolutions[i] = config->resolutions[i] ? coarser_side(config->resolutions[i], unit, step) : 0;
}

/* What keeps moving is kept apart in second layers of pages. */
uint64_t plan_budget_bytes(const csm_config *config) {
  plan_layout layout;
  plan_layout_make(&layout, config);
  const uint64_t depth = config->map_format == CSM_MAP_D16 ? 2 : 4, images = plan_has_pages(config) ? 2 : 1;
  uint64_t bytes = images * depth * layout.width * layout.height * layout.layers;
  if (!plan_has_moments(config))
    return bytes;
  plan_moments moments;
  plan_moments_make(&moments, config);
  const uint64_t texel = (config->moment_format == CSM_MOMENTS_FLOAT16 ? 2u : 4u) * moments.channels;
  for (uint32_t level = 0; level < moments.levels; ++level) {
    const uint64_t side = moments.side >> level;
    bytes += texel * side * side * config->cascade_count * moments.depth_layers;
  }
  return bytes;
}

uint32_t plan_budget_fit(const csm_config *config, uint32_t from) {
  for (uint32_t step = from; step < PLAN_BUDGET_STEPS; ++step) {
    csm_config coarser;
    plan_budget_coarser(&coarser, config, step);
    if (!plan_refuse_sides(&coarser) && (double)plan_budget_bytes(&coarser) <= plan_budget_cap(config))
      return step;
  }
  return PLAN_BUDGET_STEPS;
}

/* How wide a filter's edges are in a mask, as that of pcf_3x3 is 2: so many pixels are unsure, measured. 0: not known; wider
   filters lose what their unsure pixels do not tell of. */
static double edge_width(uint32_t filter) {
  switch (filter) {
  case CSM_FILTER_PCF_2X2:
    return 0.667;
  case CSM_FILTER_PCF_3X3:
    return 2.0;
  default:
    return 0.0;
  }
}

bool plan_budget_judges(const csm_config *config) {
  return edge_width(config->filter) > 0.0;
}

/* ---- what is known ---- */

void plan_budget_forget(plan_budget *budget, uint32_t late) {
  budget->now = (plan_budget_cost){-1.0, budget->now.unsure};
  memset(budget->weights, 0, sizeof budget->weights);
  budget->count = 0;
  budget->wait = late;
  budget->wishes = 0;
  budget->fresh = true;
}

void plan_budget_begin(plan_budget *budget, const csm_config *config, uint32_t late) {
  *budget = (plan_budget){.now.unsure = -1.0};
  plan_budget_forget(budget, late);
  csm_config coarser;
  for (uint32_t step = 1; step < PLAN_BUDGET_STEPS; ++step) {
    plan_budget_coarser(&coarser, config, step);
    budget->last = plan_refuse_sides(&coarser) ? budget->last : step;
  }
}

/* Texels of a step's first map, as a share of those of the finest. */
static double texels_of(const csm_config *config, uint32_t step) {
  csm_config coarser;
  plan_budget_coarser(&coarser, config, step);
  const double side = plan_resolution(&coarser, 0), most = plan_resolution(config, 0);
  return side * side / (most * most);
}

/* Milliseconds for each share of texels: a regression over the steps that were drawn, which what is taken for granted steadies. */
static double slope_of(const plan_budget *budget, const csm_config *config) {
  const double now = texels_of(config, budget->step);
  double sum = 0.0, x = 0.0, y = 0.0, xx = PRIOR_WEIGHT, xy = PRIOR_WEIGHT * budget->now.ms / (1.0 + now);
  for (uint32_t i = 0; i <= budget->last; ++i) {
    sum += budget->weights[i];
    x += budget->weights[i] * texels_of(config, i);
    y += budget->weights[i] * budget->ms[i];
  }
  for (uint32_t i = 0; i <= budget->last && sum > 0.0; ++i) {
    const double away = texels_of(config, i) - x / sum;
    xx += budget->weights[i] * away * away;
    xy += budget->weights[i] * away * (budget->ms[i] - y / sum);
  }
  return fmin(fmax(xy / xx, plan_has_rays(config) ? -budget->now.ms / now : 0.0), budget->now.ms / now);
}

double plan_budget_ms(const plan_budget *budget, const csm_config *config, uint32_t step) {
  if (budget->now.ms < 0.0)
    return -1.0;
  const double more = texels_of(config, step) - texels_of(config, budget->step);
  return budget->now.ms + slope_of(budget, config) * more;
}

static double wrong_of(double unsure) {
  return WRONG_ALONE * unsure + WRONG_CLOSE * unsure * unsure;
}

/* The other way round. */
static double unsure_for(double wrong) {
  return (sqrt(WRONG_ALONE * WRONG_ALONE + 4.0 * WRONG_CLOSE * wrong) - WRONG_ALONE) / (2.0 * WRONG_CLOSE);
}

double plan_budget_wrong(const plan_budget *budget, const csm_config *config, uint32_t step) {
  if (budget->now.unsure < 0.0 || !plan_budget_judges(config))
    return -1.0;
  const double unsure = budget->now.unsure * 2.0 / edge_width(config->filter);
  const double sides = sqrt(texels_of(config, step) / texels_of(config, budget->step));
  return wrong_of(unsure) * pow(sides, WRONG_SIDE);
}

/* ---- choices ---- */

static double middle(const plan_budget *budget, double (*part)(const plan_budget_cost *)) {
  double sorted[PLAN_BUDGET_TAKEN];
  for (uint32_t i = 0; i < PLAN_BUDGET_TAKEN; ++i) {
    const double value = part(&budget->taken[i]);
    uint32_t at = i;
    for (; at && sorted[at - 1] > value; --at)
      sorted[at] = sorted[at - 1];
    sorted[at] = value;
  }
  return sorted[PLAN_BUDGET_TAKEN / 2];
}

static double ms_of(const plan_budget_cost *cost) {
  return cost->ms;
}

static double unsure_of(const plan_budget_cost *cost) {
  return cost->unsure;
}

static bool too_slow(const plan_budget *budget, const csm_config *config) {
  return config->budget & CSM_BUDGET_TIME && budget->now.ms > config->budget_ms;
}

static bool too_wrong(const plan_budget *budget, const csm_config *config) {
  return config->budget & CSM_BUDGET_ERROR && plan_budget_wrong(budget, config, budget->step) > config->budget_wrong;
}

static bool leaves_time(const plan_budget *budget, const csm_config *config, uint32_t step) {
  const double ms = plan_budget_ms(budget, config, step);
  return !(config->budget & CSM_BUDGET_TIME) || (ms >= 0.0 && ms <= ROOM * config->budget_ms);
}

/* Where rays decide what maps do not, coarser maps may take longer. */
static int32_t wish_faster(const plan_budget *budget, const csm_config *config) {
  if (slope_of(budget, config) < 0.0)
    return budget->step == 0 ? 0 : -1;
  return budget->step == budget->last ? 0 : 1;
}

/* Steps to coarser: 1, 0 or -1. Time goes before error. */
static int32_t wish(const plan_budget *budget, const csm_config *config) {
  const bool finest = budget->step == 0, coarsest = budget->step == budget->last;
  if (too_slow(budget, config))
    return wish_faster(budget, config);
  if (!finest && leaves_time(budget, config, budget->step - 1) &&
      (!(config->budget & CSM_BUDGET_ERROR) || too_wrong(budget, config)))
    return -1;
  const double wrong = coarsest ? -1.0 : plan_budget_wrong(budget, config, budget->step + 1);
  const bool suffices = config->budget & CSM_BUDGET_ERROR && wrong >= 0.0 && wrong <= ROOM * config->budget_wrong;
  return suffices ? 1 : 0;
}

/* Until the new step is measured, it is what was expected of it. */
static void move(plan_budget *budget, const csm_config *config, int32_t to) {
  const uint32_t step = (uint32_t)((int32_t)budget->step + to);
  const double ms = plan_budget_ms(budget, config, step), wrong = plan_budget_wrong(budget, config, step);
  budget->now.ms = ms;
  budget->now.unsure = wrong < 0.0 ? -1.0 : unsure_for(wrong) * edge_width(config->filter) / 2.0;
  budget->step = step;
  budget->wishes = 0;
}

static void choose(plan_budget *budget, const csm_config *config, uint32_t late) {
  const int32_t to = wish(budget, config);
  budget->wishes = to == budget->wish ? budget->wishes + 1 : 1;
  budget->wish = to;
  const bool hurries = too_slow(budget, config) && budget->now.ms > FAR_OVER * config->budget_ms;
  if (to == 0 || (budget->wishes < PATIENCE && !hurries))
    return;
  move(budget, config, to);
  budget->fresh = true;
  budget->wait = late;
}

/* Takes in what was measured, or, of a step that stays, some of the way to it. */
static void learn(plan_budget *budget) {
  const plan_budget_cost now = {middle(budget, ms_of), middle(budget, unsure_of)};
  const double share = budget->fresh ? 1.0 : 0.3;
  budget->now.ms += share * (now.ms - budget->now.ms);
  budget->now.unsure += share * (now.unsure - budget->now.unsure);
  budget->fresh = false;
  for (uint32_t i = 0; i < PLAN_BUDGET_STEPS; ++i)
    budget->weights[i] *= FADING;
  if (budget->now.ms >= 0.0) {
    budget->ms[budget->step] = budget->now.ms;
    budget->weights[budget->step] = 1.0;
  }
}

void plan_budget_next(plan_budget *budget, const csm_config *config, const plan_budget_cost *cost, uint32_t late) {
  if (budget->wait) {
    --budget->wait;
    return;
  }
  if (config->budget & CSM_BUDGET_TIME && cost->ms < 0.0)
    return;
  if (config->budget & CSM_BUDGET_ERROR && cost->unsure < 0.0)
    return;
  budget->taken[budget->count++] = *cost;
  if (budget->count < PLAN_BUDGET_TAKEN)
    return;
  budget->count = 0;
  learn(budget);
  choose(budget, config, late);
}

uint32_t plan_budget_missed(const plan_budget *budget, const csm_config *config) {
  return (too_slow(budget, config) ? CSM_BUDGET_TIME : 0u) | (too_wrong(budget, config) ? CSM_BUDGET_ERROR : 0u);
}
