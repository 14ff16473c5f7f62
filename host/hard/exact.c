/* exact.c: filter exact against the truth. */
#include "hard/exact.h"
#include <math.h>

const char *const exact_ways[EXACT_WAYS] = {"maps and rays", "rays alone"};

void exact_set(csm_config *config, int way) {
  config->filter = CSM_FILTER_EXACT;
  /* No cosine is above 1 */
  config->ray_unsure_cosine = way == EXACT_RAYS ? 1.0 : config->ray_unsure_cosine;
  config->ray_grazing_cosine = way == EXACT_RAYS ? 1.0 : config->ray_grazing_cosine;
}

static void add_figures(hard_run *run, const exact_asked *asked, int way, const hard_truth *truth, const float *mask) {
  const hard_margin all = {.silhouette_px = asked->margin.silhouette_px, .edge_px = asked->margin.edge_px};
  const hard_count count = hard_judge(run, truth, mask, asked->margin);
  const char *how = exact_ways[way];
  if (!asked->closed)
    hard_figure_add(run, (double)count.false_dark, 0.0, "px", "dark though lit, %s: %s", how, asked->what);
  hard_figure_add(run, (double)count.false_lit, 0.0, "px", "lit though dark, %s: %s", how, asked->what);
  hard_figure_add(run, asked->closed || count.judged > 100 ? 0.0 : 1.0, 0.0, "1",
                  "pictures in which next to nothing could be judged");
  if (asked->margin.cosine > 0.0)
    hard_figure_add(run, (double)hard_judge(run, truth, mask, all).false_lit, INFINITY, "px",
                    "lit though dark, grazed too, %s: %s", how, asked->what);
}

int exact_judge(hard_run *run, const scene_light *light, const exact_asked *asked, hard_truth *truth) {
  const host_setup *setup = run->setup;
  hard_picture drawn = {0};
  int code = hard_cast(run, &setup->camera, light, truth);
  for (size_t i = 0; code == 0 && asked->closed && i < (size_t)setup->width * setup->height; i++)
    truth->visibility[i] = 0.0f;
  for (int way = 0; code == 0 && way < EXACT_WAYS; way++) {
    csm_config config = setup->config;
    exact_set(&config, way);
    code = hard_configure(run, &config);
    if (code == 0)
      code = hard_draw(run, &setup->camera, light, 0, &drawn);
    if (code == 0)
      add_figures(run, asked, way, truth, drawn.mask);
  }
  hard_picture_free(&drawn);
  return code;
}

int exact_judge_setup(hard_run *run, const host_setup *setup, const exact_asked *asked) {
  hard_truth truth = {0};
  int code = hard_load(run, setup);
  if (code == 0)
    code = exact_judge(run, &setup->light, asked, &truth);
  hard_truth_free(&truth);
  hard_unload(run);
  return code;
}
