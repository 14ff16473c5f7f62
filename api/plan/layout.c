/* layout.c: where each cascade's map lies in the image of all. */
#include "plan/internal.h"

/* Rows of squares, largest first, in an image of a width; returns its height, or 0 if a square is wider. */
static uint64_t shelve(plan_layout *layout, const uint32_t *order, const csm_config *config, uint64_t width) {
  uint64_t x = 0, y = 0, shelf = 0;
  for (uint32_t i = 0; i < config->cascade_count; ++i) {
    const uint32_t side = plan_resolution(config, order[i]);
    if (x + side > width) {
      x = 0;
      y += shelf;
      shelf = 0;
    }
    layout->rects[order[i]] = (plan_rect){.x = (uint32_t)x, .y = (uint32_t)y, .side = side};
    shelf = side > shelf ? side : shelf;
    x += side;
  }
  layout->width = (uint32_t)width;
  layout->height = (uint32_t)(y + shelf);
  return y + shelf;
}

static void sort_by_side(uint32_t *order, const csm_config *config) {
  for (uint32_t i = 0; i < config->cascade_count; ++i) {
    uint32_t at = i;
    for (; at && plan_resolution(config, order[at - 1]) < plan_resolution(config, i); --at)
      order[at] = order[at - 1];
    order[at] = i;
  }
}

/* The atlas that wastes least, and of those the squarest: some whole number of the largest map wide. */
static void make_atlas(plan_layout *out, const csm_config *config) {
  uint32_t order[CSM_MAX_CASCADES];
  sort_by_side(order, config);
  const uint64_t largest = plan_resolution(config, order[0]);
  uint64_t best_area = UINT64_MAX, best_side = UINT64_MAX;
  for (uint32_t across = 1; across <= config->cascade_count; ++across) {
    plan_layout tried = {.layers = 1};
    const uint64_t width = across * largest, height = shelve(&tried, order, config, width);
    const uint64_t area = width * height, side = width > height ? width : height;
    if (area < best_area || (area == best_area && side <= best_side)) {
      *out = tried;
      best_area = area;
      best_side = side;
    }
  }
}

bool plan_has_pages(const csm_config *config) {
  return config->map_layout == CSM_LAYOUT_PAGES;
}

uint32_t plan_windows_most(const csm_config *config) {
  return plan_has_pages(config) ? PLAN_WINDOWS_MOST / config->cascade_count * config->cascade_count
                                : config->cascade_count;
}

void plan_layout_make(plan_layout *out, const csm_config *config) {
  if (config->map_layout == CSM_LAYOUT_ATLAS) {
    make_atlas(out, config);
    return;
  }
  *out = (plan_layout){.layers = config->cascade_count};
  for (uint32_t i = 0; i < config->cascade_count; ++i) {
    const uint32_t side = plan_resolution(config, i);
    out->rects[i] = (plan_rect){.side = side, .layer = i};
    out->width = out->height = side > out->width ? side : out->width;
  }
}
