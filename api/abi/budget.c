#include "abi/budget.h"

#include "abi/view.h"
#include "techniques/mask_count/mask_count.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* ---- memory ---- */

csm_result budget_make(csm_cascades *cascades, device *device, const csm_config *asked, csm_config *made) {
  technique_set *techniques = &cascades->techniques;
  *made = *asked;
  if (!(asked->budget & CSM_BUDGET_MEMORY))
    return technique_set_make(techniques, device, made);
  uint32_t step = 0;
  while ((step = plan_budget_fit(asked, step)) < PLAN_BUDGET_STEPS) {
    plan_budget_coarser(made, asked, step++);
    const csm_result result = technique_set_make(techniques, device, made);
    if (result || (double)technique_set_bytes(techniques, device, made) <= plan_budget_cap(asked))
      return result;
    technique_set_forget(techniques, device);
  }
  return host_fail(&cascades->context->host, CSM_ERROR_INVALID_VALUE,
                   "csm_config: budget_mib is less than the coarsest maps take on this device");
}

/* ---- time and error ---- */

static double known(double ms) {
  return fmax(ms, 0.0);
}

/* -1 before they are measured. */
static double maps_ms(const csm_cascades *cascades) {
  csm_stats stats = {0};
  technique_set_tell(&cascades->techniques, context_device(cascades->context), &stats);
  double ms = stats.clear_gpu_ms;
  for (uint32_t i = 0; i < cascades->config.cascade_count && ms >= 0.0; ++i)
    ms += known(stats.cascades[i].gpu_ms);
  return ms;
}

/* Of the slowest, and of the least sure, view. */
static plan_budget_cost views_cost(const csm_cascades *cascades) {
  const device *device = context_device(cascades->context);
  plan_budget_cost cost = {0.0, -1.0};
  for (const csm_view *v = cascades->context->views; v; v = v->next) {
    if (!view_resolves(v, cascades))
      continue;
    csm_view_stats stats = {.mask_gpu_ms = -1.0};
    technique_set_tell_view(&v->techniques, device, &stats);
    cost.ms = fmax(cost.ms, known(stats.mask_gpu_ms) + known(stats.rays_gpu_ms) + known(stats.history_gpu_ms));
    cost.unsure = fmax(cost.unsure, mask_count_unsure(&v->techniques, device));
  }
  return cost;
}

void budget_choose(const csm_cascades *cascades, plan_budget *next) {
  *next = cascades->budget;
  if (!(cascades->config.budget & (CSM_BUDGET_TIME | CSM_BUDGET_ERROR)))
    return;
  plan_budget_cost cost = views_cost(cascades);
  const double ms = maps_ms(cascades);
  cost.ms = ms < 0.0 ? -1.0 : ms + cost.ms;
  plan_budget_next(next, &cascades->config, &cost, budget_late(context_device(cascades->context)));
}

/* ---- words ---- */

typedef struct words {
  char *text;
  size_t size, used;
} words;

/* printf, cut where the room ends. */
static void say(words *to, const char *format, ...) {
  va_list values;
  va_start(values, format);
  const int length = vsnprintf(to->text + to->used, to->size - to->used, format, values);
  va_end(values);
  to->used += length < 0 ? 0 : (size_t)length;
  to->used = to->used < to->size ? to->used : to->size - 1;
}

static uint32_t side_of(const csm_config *config, uint32_t step) {
  csm_config coarser;
  plan_budget_coarser(&coarser, config, step);
  return plan_resolution(&coarser, 0);
}

static void say_memory(words *to, const csm_cascades *cascades) {
  const csm_config *asked = &cascades->asked;
  if (plan_resolution(asked, 0) != plan_resolution(&cascades->config, 0))
    say(to, "; %u would take %.4g of %.4g MiB", plan_resolution(asked, 0), (double)plan_budget_bytes(asked) / 1048576.0,
        asked->budget_mib);
}

static void say_time(words *to, const plan_budget *budget, const csm_config *config) {
  if (!(config->budget & CSM_BUDGET_TIME))
    return;
  if (budget->now.ms < 0.0)
    say(to, "; times are not known yet");
  else if (plan_budget_missed(budget, config) & CSM_BUDGET_TIME)
    say(to, "; still %.3g of %.3g ms", budget->now.ms, config->budget_ms);
  else if (budget->step)
    say(to, "; %u would take %.3g of %.3g ms", side_of(config, budget->step - 1),
        plan_budget_ms(budget, config, budget->step - 1), config->budget_ms);
}

static void say_error(words *to, const plan_budget *budget, const csm_config *config) {
  if (!(config->budget & CSM_BUDGET_ERROR))
    return;
  const double wrong = plan_budget_wrong(budget, config, budget->step);
  if (wrong < 0.0)
    say(to, "; errors are not known yet");
  else
    say(to, "; %s %.3g of %.3g %% of pixels are wrong",
        plan_budget_missed(budget, config) & CSM_BUDGET_ERROR ? "still" : "about", 100.0 * wrong,
        100.0 * config->budget_wrong);
}

void budget_tell(const csm_cascades *cascades, csm_stats *stats) {
  const csm_config *config = &cascades->config;
  const plan_budget *budget = &cascades->budget;
  stats->budget_ms_predicted = stats->budget_wrong_predicted = -1.0;
  if (!config->budget)
    return;
  words text = {.text = stats->budget_text, .size = sizeof stats->budget_text};
  stats->budget_side = side_of(config, budget->step);
  stats->budget_missed = plan_budget_missed(budget, config);
  if (config->budget & CSM_BUDGET_TIME)
    stats->budget_ms_predicted = plan_budget_ms(budget, config, budget->step);
  if (config->budget & CSM_BUDGET_ERROR)
    stats->budget_wrong_predicted = plan_budget_wrong(budget, config, budget->step);
  say(&text, "maps of %u of %u texels", stats->budget_side, plan_resolution(&cascades->asked, 0));
  say_memory(&text, cascades);
  say_time(&text, budget, config);
  say_error(&text, budget, config);
}
