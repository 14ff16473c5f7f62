/*
 * pages.c: maps of pages that stay while camera, casters and light move: what is drawn with pages that were kept is what is
 * drawn when all of them are made anew, in every bit.
 */
#include "base/host.h"
#include "hard/hard.h"
#include <string.h>

enum { BOXES_FROM = 1, STEPS = 31 };

/* A step's camera, from the first one: metres ahead and to the right, and degrees to the left. */
typedef struct pages_step {
  const char *what;
  double ahead, aside, turned_deg, light_deg;
  double box_up;      /* the first box: by so many metres */
  double ball_across; /* the last instance: likewise, along x */
  bool hidden;        /* the second box is not there */
} pages_step;

static const pages_step steps[STEPS] = {
    {.what = "at first"},
    {.what = "still"},
    {.what = "ahead", .ahead = 0.3},
    {.what = "ahead", .ahead = 0.9},
    {.what = "ahead", .ahead = 1.7},
    {.what = "turned", .ahead = 1.7, .turned_deg = 25.0},
    {.what = "turned on", .ahead = 1.7, .turned_deg = 160.0},
    {.what = "turned back", .ahead = 1.7},
    {.what = "far away", .ahead = -35.0, .aside = 20.0},
    {.what = "back again", .ahead = 1.7},
    {.what = "a box moved", .ahead = 1.7, .box_up = 0.5},
    {.what = "a box moved, and the camera", .ahead = 2.0, .aside = 0.5, .box_up = 0.75},
    {.what = "a box hidden", .ahead = 2.0, .box_up = 0.75, .hidden = true},
    {.what = "a box hidden still, seen from elsewhere", .ahead = -4.0, .aside = 2.0, .box_up = 0.75, .hidden = true},
    {.what = "a box shown", .ahead = -4.0, .aside = 2.0},
    {.what = "a ball moved", .ahead = -4.0, .aside = 2.0, .ball_across = 2.0},
    {.what = "a ball moved, behind the camera", .ahead = -4.0, .aside = 2.0, .turned_deg = 180.0, .ball_across = 3.0},
    {.what = "turned back to it", .ahead = -4.0, .aside = 2.0, .ball_across = 3.0},
    {.what = "a ball rolls", .ahead = -4.0, .aside = 2.0, .ball_across = 3.1},
    {.what = "it rolls on", .ahead = -4.0, .aside = 2.0, .ball_across = 3.25},
    {.what = "it rolls on", .ahead = -4.0, .aside = 2.0, .ball_across = 3.45},
    {.what = "and the camera moves", .ahead = -2.0, .aside = 1.0, .ball_across = 2.8},
    {.what = "and a box", .ahead = -2.0, .aside = 1.0, .ball_across = 2.2, .box_up = 0.5},
    {.what = "both", .ahead = -2.0, .aside = 1.0, .ball_across = 1.5, .box_up = 0.75},
    {.what = "the ball alone", .ahead = -2.0, .aside = 1.0, .ball_across = 0.7, .box_up = 0.75},
    {.what = "under another box", .aside = 1.0, .ball_across = 0.3, .box_up = 0.75, .hidden = true},
    {.what = "it lies still", .aside = 1.5, .ball_across = 0.3, .box_up = 0.75, .hidden = true},
    {.what = "the sun moved", .ahead = -4.0, .aside = 2.0, .ball_across = 3.0, .light_deg = 0.5},
    {.what = "under that sun", .ahead = -3.5, .aside = 1.5, .ball_across = 3.0, .light_deg = 0.5},
    {.what = "the sun moved on", .ahead = -3.5, .aside = 1.5, .light_deg = 20.0},
    {.what = "under that sun", .ahead = -3.0, .aside = 1.5, .light_deg = 20.0},
};

/* Filters that read maps in every way there is. */
typedef struct pages_way {
  const char *name;
  uint32_t filter, format, reversed;
} pages_way;

static const pages_way ways[] = {{.name = "pcf_3x3", .filter = CSM_FILTER_PCF_3X3},
                                 {"nearest, D16, reversed", CSM_FILTER_NEAREST, CSM_MAP_D16, 1},
                                 {.name = "pcf_7x7", .filter = CSM_FILTER_PCF_7X7},
                                 {.name = "backprojection", .filter = CSM_FILTER_BACKPROJECTION},
                                 {.name = "exact", .filter = CSM_FILTER_EXACT}};
enum { WAYS = sizeof ways / sizeof ways[0] };

static int place(hard_run *run, size_t instance, int axis, double by) {
  double transform[16];
  csm_result result = CSM_SUCCESS;
  memcpy(transform, run->setup->scene.instances[instance].transform, sizeof transform);
  transform[12 + axis] += by;
  for (uint32_t s = 0; !result && s < run->stage_count; s++) {
    const csm_scene_batch batch = {
        .struct_size = sizeof batch, .count = 1, .ids = &run->stages[s].instances[instance], .matrices = transform};
    result = csm_scene_move(run->stages[s].scene, &batch);
  }
  return hard_called(result, "moving");
}

/* What differs from the step before. */
static int change(hard_run *run, const pages_step *from, const pages_step *to) {
  int code = 0;
  if (from->box_up != to->box_up)
    code = place(run, BOXES_FROM, 1, to->box_up);
  if (code == 0 && from->ball_across != to->ball_across)
    code = place(run, run->setup->scene.instance_count - 1, 0, to->ball_across);
  if (code == 0 && from->hidden != to->hidden)
    code = hard_flag(run, BOXES_FROM + 1, BOXES_FROM + 2, to->hidden ? CSM_INSTANCE_HIDDEN : 0);
  return code;
}

static int draw(hard_run *run, const pages_step *step, hard_picture *out) {
  const camera eye = camera_moved(&run->setup->camera, step->ahead, step->aside, step->turned_deg);
  const scene_light light = scene_light_turned(&run->setup->light, step->light_deg);
  return hard_draw(run, &eye, &light, 0, out);
}

/* What a walk's frames have drawn. */
typedef struct page_counts {
  uint32_t drawn, copied, valid;
} page_counts;

static int count_pages(hard_run *run, page_counts *counts) {
  csm_stats stats = {.struct_size = sizeof stats};
  const csm_result result = csm_get_stats(run->stages[0].cascades, &stats);
  counts->drawn += stats.pages_drawn;
  counts->copied += stats.pages_copied;
  counts->valid += stats.pages_valid;
  return hard_called(result, "counting pages");
}

/*
 * All steps; `anew` draws every page in each of them: with new cascades, which have seen nothing move. Once the sun has moved,
 * the old ones' grid is one that new ones would not have, so they stay.
 */
static int draw_steps(hard_run *run, const csm_config *config, bool anew, hard_picture drawn[STEPS]) {
  page_counts pages = {0};
  int code = hard_restart(run, config);
  for (int i = 0; i < STEPS && code == 0; i++) {
    code = change(run, &steps[i ? i - 1 : STEPS - 1], &steps[i]);
    if (code == 0 && anew)
      code = (steps[i].light_deg == 0.0 ? hard_restart : hard_configure)(run, config);
    if (code == 0)
      code = draw(run, &steps[i], &drawn[i]);
    if (code == 0)
      code = count_pages(run, &pages);
  }
  if (!anew) {
    hard_figure_add(run, (double)pages.drawn / pages.valid, 0.5, "1", "pages drawn, of those that are valid");
    hard_figure_add(run, pages.copied > 0 ? 0.0 : 1.0, 0.0, "1", "walks in which no page is copied");
  } else {
    hard_figure_add(run, pages.copied, 0.0, "pages", "copied, of those drawn anew");
  }
  return code;
}

/* Pages that are kept, of those that receivers and then of those that this frame's depth reads, with all drawn anew. */
static int compare_steps(hard_run *run, const char *name) {
  hard_picture kept[STEPS] = {{0}}, anew[STEPS] = {{0}};
  csm_config config = run->setup->config;
  int code = draw_steps(run, &config, true, anew);
  for (int depth = 0; depth < 2 && code == 0; depth++) {
    hard_by_depth(run, depth);
    code = draw_steps(run, &config, false, kept);
    hard_by_depth(run, false);
    for (int i = 0; i < STEPS && code == 0; i++)
      hard_figure_add(run, (double)hard_compare(run, &anew[i], &kept[i], 0.0).pixels, 0.0, "px",
                      "other than drawn anew%s: %s, %s", depth ? ", by depth" : "", name, steps[i].what);
  }
  for (int i = 0; i < STEPS; i++) {
    hard_picture_free(&kept[i]);
    hard_picture_free(&anew[i]);
  }
  return code;
}

/* Against whole maps: the texels lie elsewhere, but as much is right. */
static int judge(hard_run *run, host_setup *setup) {
  hard_picture drawn = {0};
  hard_truth truth = {0};
  double rms[2];
  int code = hard_cast(run, &setup->camera, &setup->light, &truth);
  for (uint32_t pages = 0; pages < 2 && code == 0; pages++) {
    csm_config config = setup->config;
    config.map_layout = pages ? CSM_LAYOUT_PAGES : CSM_LAYOUT_ARRAY;
    code = hard_restart(run, &config);
    if (code == 0)
      code = hard_draw(run, &setup->camera, &setup->light, 0, &drawn);
    if (code == 0)
      rms[pages] = hard_judge(run, &truth, drawn.mask, (hard_margin){.silhouette_px = 2.0}).rms;
  }
  if (code == 0)
    hard_figure_add(run, rms[1] / rms[0], 1.1, "1", "rmse, of that of whole maps");
  hard_truth_free(&truth);
  hard_picture_free(&drawn);
  return code;
}

static int run(hard_run *run) {
  host_setup setup;
  hard_setup_begin(&setup, 256, 144);
  hard_yard(&setup, true);
  setup.light.disc_deg = 0.53;
  setup.config.resolution = 512;
  setup.config.caster_set = CSM_CASTER_SET_VIEW;
  int code = hard_load(run, &setup);
  if (code == 0)
    code = judge(run, &setup);
  setup.config.map_layout = CSM_LAYOUT_PAGES;
  for (int i = 0; i < (run->sweep ? WAYS : 2) && code == 0; i++) {
    setup.config.filter = ways[i].filter;
    setup.config.map_format = ways[i].format;
    setup.config.map_reversed = ways[i].reversed;
    code = compare_steps(run, ways[i].name);
  }
  hard_unload(run);
  setup_free(&setup);
  return code;
}

const hard_case hard_pages = {.name = "pages",
                              .about = "maps of pages that are kept, against all of them drawn anew, as things move",
                              .run = run};
