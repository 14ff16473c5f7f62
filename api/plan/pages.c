/* pages.c: maps of pages that stay: which of them are drawn in a frame, and how. */
#include "plan/internal.h"

#include <string.h>

enum {
  LAST = PLAN_CELLS - 1,
  WORTH_A_CUT = 32 /* cells: on a CPU, filling so many takes about as long as another window's draws */
};

/* ---- along the light ---- */

/* A range is kept while it holds the scene, and is not much longer. */
static bool holds(const double kept[2], const double needed[2]) {
  return kept[0] <= needed[0] && needed[1] <= kept[1] && kept[1] - kept[0] <= 4.0 * (needed[1] - needed[0]);
}

static bool same_light(const plan_frame *frame, const plan_history *before) {
  return before && memcmp(before->pages_basis, frame->basis, sizeof frame->basis) == 0;
}

void plan_pages_depth(plan_scene_box *box, plan_frame *frame, const plan_fit *fits, const plan_frame_info *info) {
  const plan_history *before = info->before;
  double needed[2] = {INFINITY, -INFINITY};
  for (uint32_t i = 0; i < box->corner_count; ++i) {
    needed[0] = fmin(needed[0], box->corners[i][2]);
    needed[1] = fmax(needed[1], box->corners[i][2]);
  }
  if (box->corner_count == 0)
    return;
  for (uint32_t i = 0; i < frame->cascade_count && !info->all_receivers; ++i) /* some may lie beside the scene */
    needed[1] = fmax(needed[1], fits[i].depth[1]);
  const double room = (needed[1] - needed[0]) / 8.0;
  const bool keeps = same_light(frame, before) && holds(before->pages_depth, needed);
  box->steady[0] = keeps ? before->pages_depth[0] : needed[0] - room;
  box->steady[1] = keeps ? before->pages_depth[1] : needed[1] + room;
  memcpy(frame->history.pages_depth, box->steady, sizeof box->steady);
}

/* ---- cells and slots ---- */

/* Cells count from the map's begin, right and up; slots are the places in its layer that their pages lie in. */
static uint64_t turned(uint64_t row, int64_t by) {
  const unsigned places = (unsigned)(by & LAST);
  return places ? row << places | row >> (PLAN_CELLS - places) : row;
}

static uint32_t slot_row(const plan_pages *pages, uint32_t y) {
  return LAST - (uint32_t)((pages->first[1] + y) & LAST);
}

static void to_slots(uint64_t slots[PLAN_CELLS], const uint64_t cells[PLAN_CELLS], const plan_pages *pages) {
  for (uint32_t y = 0; y < PLAN_CELLS; ++y)
    slots[slot_row(pages, y)] = turned(cells[y], pages->first[0]);
}

/* The cells of a map that another one held too, of so many from one's begin to the other's. */
static uint64_t shared(int64_t away) {
  if (away <= -PLAN_CELLS || away >= PLAN_CELLS)
    return 0;
  return away < 0 ? UINT64_MAX << -away : UINT64_MAX >> away;
}

/* The cells whose pages are there still. */
static void keep_cells(uint64_t valid[PLAN_CELLS], const plan_pages *before, const plan_pages *now) {
  const uint64_t columns = shared(now->first[0] - before->first[0]), rows = shared(now->first[1] - before->first[1]);
  for (uint32_t y = 0; y < PLAN_CELLS; ++y)
    valid[y] = rows >> y & 1 ? turned(before->valid[slot_row(now, y)], -now->first[0]) & columns : 0;
}

/* ---- what is kept ---- */

static void begin_pages(plan_pages *out, const plan_cascade *cascade, const plan_fit *fit) {
  const double page = fit->resolution / (double)PLAN_CELLS;
  *out = (plan_pages){.any = true, .depth = {cascade->to_clip[10], cascade->to_clip[11]}};
  memcpy(out->texel, fit->texel, sizeof out->texel);
  memcpy(out->anchor, fit->anchor, sizeof out->anchor);
  for (int axis = 0; axis < 2; ++axis)
    out->first[axis] = (int64_t)(fit->origin[axis] / page);
}

static bool drawn_alike(const plan_pages *a, const plan_pages *b) {
  return a->any && memcmp(a->texel, b->texel, sizeof a->texel) == 0 &&
         memcmp(a->anchor, b->anchor, sizeof a->anchor) == 0 && memcmp(a->depth, b->depth, sizeof a->depth) == 0;
}

/* Whether all that changed since pages were drawn is known. */
static bool knows_changes(const plan_frame *frame, const plan_frame_info *info) {
  const plan_cache *cache = info->cache;
  const plan_history *before = info->before;
  return info->maps_kept && before && cache && info->scene->identity && cache->keeps && !cache->unknown &&
         before->pages_identity == info->scene->identity && cache->identity == info->scene->identity &&
         before->pages_layers == info->light_layers && same_light(frame, before);
}

void plan_pages_begin(const plan_frame_info *info) {
  plan_cache *cache = info->cache;
  if (!cache || !info->before || cache->identity != info->before->pages_identity ||
      cache->revision != info->before->pages_revision)
    return;
  cache->changed = 0;
  cache->unknown = false;
}

/* Over which cells something changed; a texel's centre may be covered from beside it. */
static void spoil(uint64_t valid[PLAN_CELLS], const plan_cells *cells, const plan_frame_info *info, double texel) {
  plan_cells changed = {.begin = {cells->begin[0], cells->begin[1]}, .size = {cells->size[0], cells->size[1]}};
  const plan_span_across *boxes = plan_cache_changed(info->cache);
  for (uint32_t i = 0; i < info->cache->changed; ++i)
    plan_cells_add(&changed, (double[]){boxes[i].low[0] - texel, boxes[i].low[1] - texel},
                   (double[]){boxes[i].high[0] + texel, boxes[i].high[1] + texel});
  for (uint32_t y = 0; y < PLAN_CELLS; ++y)
    valid[y] &= ~changed.read[y];
}

/* ---- windows ---- */

/* The columns, or rows, of cells that lie in the first of two squares of the world, or in the second. */
static uint64_t half(int64_t first, int which) {
  const unsigned in_first = (unsigned)(PLAN_CELLS - (first & LAST));
  const uint64_t low = UINT64_MAX >> (PLAN_CELLS - in_first);
  return which ? ~low : low;
}

/* From light space to the clip space of the square in which a cell's page lies. */
static void place_window(plan_window *window, const plan_cascade *cascade, const plan_fit *fit,
                         const int64_t square[2]) {
  memcpy(window->to_clip, cascade->to_clip, sizeof window->to_clip);
  for (int axis = 0; axis < 2; ++axis) {
    const double begin = fit->anchor[axis] / fit->texel[axis] + (double)square[axis] * fit->resolution;
    window->to_clip[axis * 5] = 2.0 / (fit->texel[axis] * fit->resolution);
    window->to_clip[axis * 4 + 3] = -2.0 * begin / fit->resolution - 1.0;
  }
}

/* Columns and rows of cells, from the first to the last. */
typedef struct cell_bounds {
  uint32_t low[2], high[2];
} cell_bounds;

/* The least rectangle around all cells that are read; false: there are none. */
static bool bound(cell_bounds *out, const plan_cells *cells) {
  uint64_t columns = 0;
  *out = (cell_bounds){.low = {0, PLAN_CELLS}};
  for (uint32_t y = 0; y < PLAN_CELLS; ++y) {
    columns |= cells->read[y];
    out->low[1] = cells->read[y] && out->low[1] == PLAN_CELLS ? y : out->low[1];
    out->high[1] = cells->read[y] ? y : out->high[1];
  }
  if (!columns)
    return false;
  out->low[0] = (uint32_t)__builtin_ctzll(columns);
  out->high[0] = LAST - (uint32_t)__builtin_clzll(columns);
  return true;
}

static uint32_t area_of(const plan_cells *cells) {
  cell_bounds b;
  return bound(&b, cells) ? (b.high[0] - b.low[0] + 1) * (b.high[1] - b.low[1] + 1) : 0;
}

/* Those before a column or row, and those from it on. */
static void cut(plan_cells parts[2], const plan_cells *cells, int axis, uint32_t at) {
  const uint64_t before = (1ull << at) - 1; /* at > 0 */
  for (int part = 0; part < 2; ++part) {
    parts[part] = *cells;
    for (uint32_t y = 0; y < PLAN_CELLS; ++y)
      parts[part].read[y] &= axis ? ((y < at) == !part ? UINT64_MAX : 0) : part ? ~before : before;
  }
}

/* The cut that leaves the smallest rectangles: what they save, in cells. */
static uint32_t best_cut(plan_cells parts[2], const plan_cells *cells) {
  cell_bounds b;
  plan_cells tried[2];
  const uint32_t whole = area_of(cells);
  uint32_t best = 0;
  if (!bound(&b, cells))
    return 0;
  for (int axis = 0; axis < 2; ++axis)
    for (uint32_t at = b.low[axis] + 1; at <= b.high[axis]; ++at) {
      cut(tried, cells, axis, at);
      const uint32_t saved = whole - area_of(&tried[0]) - area_of(&tried[1]);
      if (saved <= best)
        continue;
      best = saved;
      memcpy(parts, tried, sizeof tried);
    }
  return best;
}

static void finish_window(plan_window *window, const plan_cascade *of, const plan_fit *fit, const plan_cells *cells,
                          const plan_pages *pages) {
  cell_bounds b;
  int64_t square[2];
  (void)bound(&b, cells);
  for (int axis = 0; axis < 2; ++axis)
    square[axis] = (pages->first[axis] + b.low[axis]) >> 6; /* 64 pages; it rounds down */
  place_window(window, of, fit, square);
  window->slots[0] = (uint32_t)((pages->first[0] + b.low[0]) & LAST);
  window->slots[1] = slot_row(pages, b.high[1]);
  window->slots[2] = b.high[0] - b.low[0] + 1;
  window->slots[3] = b.high[1] - b.low[1] + 1;
}

/* What is due, in each of the squares that the map lies in. */
static uint32_t divide_squares(plan_cells *out, const plan_cells *due, const plan_pages *pages) {
  uint32_t count = 0;
  for (int part = 0; part < 4; ++part) {
    const uint64_t columns = half(pages->first[0], part & 1), rows = half(pages->first[1], part >> 1);
    plan_cells *to = &out[count];
    uint64_t any = 0;
    *to = *due;
    for (uint32_t y = 0; y < PLAN_CELLS; ++y)
      any |= to->read[y] = rows >> y & 1 ? due->read[y] & columns : 0;
    count += any != 0;
  }
  return count;
}

/*
 * A cascade's windows, and the cells of each. Returns a mask of them. A triangle is drawn over all of a window's rectangle,
 * also where nothing is due, so windows are divided while that leaves out enough.
 */
static uint32_t make_windows(plan_frame *frame, plan_cells *cells, uint32_t cascade, const plan_fit *fit,
                             const plan_cells *due) {
  const plan_pages *pages = &frame->history.pages[cascade];
  plan_cells *own = &cells[frame->window_count], parts[2];
  const uint32_t most = PLAN_WINDOWS_MOST / frame->cascade_count;
  uint32_t count = divide_squares(own, due, pages), made = 0;
  for (uint32_t i = 0; i < count && count < most;)
    if (best_cut(parts, &own[i]) >= WORTH_A_CUT) {
      own[i] = parts[0];
      own[count++] = parts[1];
    } else {
      ++i;
    }
  for (uint32_t i = 0; i < count; ++i) {
    plan_window *window = &frame->windows[frame->window_count];
    *window = (plan_window){.cascade = cascade};
    finish_window(window, &frame->cascades[cascade], fit, &own[i], pages);
    made |= 1u << frame->window_count++;
  }
  return made;
}

/* From masks of cascades to masks of windows. */
static void spread(plan_lists *lists, const plan_frame *frame, const uint32_t windows[CSM_MAX_CASCADES]) {
  for (uint32_t slot = 0; slot < frame->slot_count; ++slot) {
    uint32_t of_windows = 0;
    for (uint32_t mask = lists->masks[slot]; mask; mask &= mask - 1)
      of_windows |= windows[__builtin_ctz(mask)];
    lists->masks[slot] = of_windows;
  }
}

/* ---- a frame ---- */

/* Which pages of a map are drawn, of those that are read: `cells` become those. */
static void find_due(plan_frame *frame, uint32_t cascade, const plan_fit *fit, plan_cells *cells,
                     const plan_frame_info *info) {
  plan_cascade *of = &frame->cascades[cascade];
  plan_pages *pages = &frame->history.pages[cascade];
  uint64_t valid[PLAN_CELLS] = {0};
  begin_pages(pages, of, fit);
  if (knows_changes(frame, info) && drawn_alike(&info->before->pages[cascade], pages)) {
    keep_cells(valid, &info->before->pages[cascade], pages);
    spoil(valid, cells, info, fmax(fit->texel[0], fit->texel[1]));
  }
  for (uint32_t y = 0; y < PLAN_CELLS; ++y) {
    const uint64_t read = cells->read[y];
    cells->read[y] = read & ~valid[y];
    valid[y] |= read;
  }
  to_slots(pages->valid, valid, pages);
  to_slots(of->due, cells->read, pages);
  memcpy(of->valid, pages->valid, sizeof of->valid);
  const uint32_t page = fit->resolution / PLAN_CELLS;
  of->begin_texels[0] = (uint32_t)(pages->first[0] & LAST) * page;
  of->begin_texels[1] = slot_row(pages, LAST) * page;
}

void plan_pages_make(plan_frame *frame, const plan_fit *fits, plan_lists *lists, plan_cells *cells,
                     const plan_frame_info *info) {
  plan_cells due[CSM_MAX_CASCADES];
  uint32_t windows[CSM_MAX_CASCADES] = {0};
  plan_history *history = &frame->history;
  memcpy(due, cells, frame->cascade_count * sizeof *due);
  frame->window_count = 0;
  for (uint32_t i = 0; i < frame->cascade_count; ++i) {
    find_due(frame, i, &fits[i], &due[i], info);
    windows[i] = make_windows(frame, cells, i, &fits[i], &due[i]);
  }
  spread(lists, frame, windows);
  const bool stays = info->cache && info->cache->keeps && info->cache->identity == info->scene->identity;
  history->pages_identity = stays ? info->scene->identity : 0;
  history->pages_revision = stays ? info->cache->revision : 0;
  history->pages_layers = info->light_layers;
  memcpy(history->pages_basis, frame->basis, sizeof history->pages_basis);
}

bool plan_next_slots(uint32_t out[4], uint64_t rows[PLAN_CELLS]) {
  uint32_t y = 0;
  while (y < PLAN_CELLS && !rows[y])
    ++y;
  if (y == PLAN_CELLS)
    return false;
  const uint32_t x = (uint32_t)__builtin_ctzll(rows[y]);
  const uint64_t above = ~(rows[y] >> x);
  const uint32_t width = above ? (uint32_t)__builtin_ctzll(above) : PLAN_CELLS;
  const uint64_t columns = UINT64_MAX >> (PLAN_CELLS - width) << x;
  out[0] = x;
  out[1] = y;
  out[2] = width;
  for (; y < PLAN_CELLS && (rows[y] & columns) == columns; ++y)
    rows[y] &= ~columns;
  out[3] = y - out[1];
  return true;
}
