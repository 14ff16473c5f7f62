/* pages.c: maps of pages that stay: which of them are drawn in a frame, and how. */
#include "plan/internal.h"

#include <string.h>

enum { LAST = PLAN_CELLS - 1 };

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
uint32_t plan_slot_row(const plan_pages *pages, uint32_t y) {
  return LAST - (uint32_t)((pages->first[1] + y) & LAST);
}

static uint64_t turned(uint64_t row, int64_t by) {
  const unsigned places = (unsigned)(by & LAST);
  return places ? row << places | row >> (PLAN_CELLS - places) : row;
}

static void to_slots(uint64_t slots[PLAN_CELLS], const uint64_t cells[PLAN_CELLS], const plan_pages *pages) {
  for (uint32_t y = 0; y < PLAN_CELLS; ++y)
    slots[plan_slot_row(pages, y)] = turned(cells[y], pages->first[0]);
}

/* The cells of a map that another one held too, of so many from one's begin to the other's. */
static uint64_t shared(int64_t away) {
  if (away <= -PLAN_CELLS || away >= PLAN_CELLS)
    return 0;
  return away < 0 ? UINT64_MAX << -away : UINT64_MAX >> away;
}

/* The cells of the slots that are marked, of those whose pages are there still. */
static void keep_cells(uint64_t cells[PLAN_CELLS], const uint64_t slots[PLAN_CELLS], const plan_pages *before,
                       const plan_pages *now) {
  const uint64_t columns = shared(now->first[0] - before->first[0]), rows = shared(now->first[1] - before->first[1]);
  for (uint32_t y = 0; y < PLAN_CELLS; ++y)
    cells[y] = rows >> y & 1 ? turned(slots[plan_slot_row(now, y)], -now->first[0]) & columns : 0;
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

/* The cache, if it is of the scene, which then stays; else NULL. */
static const plan_cache *cache_of(const plan_frame_info *info) {
  const plan_cache *cache = info->cache;
  const bool of_scene = cache && info->scene->identity && cache->keeps && cache->identity == info->scene->identity &&
                        info->scene->slot_count <= cache->slots;
  return of_scene ? cache : NULL;
}

/* Whether all that changed since pages were drawn is known. */
static bool knows_changes(const plan_frame *frame, const plan_frame_info *info) {
  const plan_cache *cache = cache_of(info);
  const plan_history *before = info->before;
  return info->maps_kept && before && cache && !cache->unknown && before->pages_identity == info->scene->identity &&
         before->pages_layers == info->light_layers && same_light(frame, before);
}

void plan_pages_begin(const plan_frame_info *info) {
  plan_cache *cache = info->cache;
  const plan_history *before = info->before;
  if (!cache)
    return;
  if (before && cache->identity == before->pages_identity && cache->revision == before->pages_revision &&
      cache->plans == before->pages_plan)
    plan_cache_forget_changes(cache);
  ++cache->plans;
  plan_cache_rest(cache);
}

/* Cells of a map, a bit each. */
typedef struct cell_set {
  uint64_t rows[PLAN_CELLS];
} cell_set;

/* Of a map before anything is drawn: pages that hold what they should; of the second layer, likewise; those that hold what
   the second layer's should. And where something moves, and something stands still. */
typedef struct page_state {
  bool known; /* false: nothing is kept */
  cell_set valid, still, clean, moving, standing;
} page_state;

/* Notes a box's cells; a texel's centre may be covered from beside it. */
static void add_box(plan_cells *cells, const double low[2], const double high[2], double texel) {
  plan_cells_add(cells, (double[]){low[0] - texel, low[1] - texel}, (double[]){high[0] + texel, high[1] + texel});
}

/* Takes out what changed. */
static void spoil(page_state *state, const plan_cells *like, const plan_frame_info *info, double texel) {
  const plan_kept kept = plan_cache_kept(info->cache);
  plan_cells changed[2] = {{.begin = {like->begin[0], like->begin[1]}, .size = {like->size[0], like->size[1]}}};
  changed[1] = changed[0];
  for (uint32_t i = 0; i < info->cache->changed; ++i)
    for (int layer = 0; layer < 2; ++layer)
      if (kept.spoils[i] & (layer ? PLAN_SPOILS_STILL : PLAN_SPOILS_PAGES))
        add_box(&changed[layer], kept.changed[i].low, kept.changed[i].high, texel);
  for (uint32_t y = 0; y < PLAN_CELLS; ++y) {
    state->valid.rows[y] &= ~changed[0].read[y];
    state->still.rows[y] &= ~changed[1].read[y];
    state->clean.rows[y] &= ~changed[1].read[y];
  }
}

static void add_slot(plan_cells *cells, const plan_kept *kept, uint32_t slot, double texel) {
  plan_span_across box;
  if (plan_kept_box(&box, kept, slot))
    add_box(cells, box.low, box.high, texel);
}

/* What stands still is looked for among what the cascade draws. */
static void find_moving(page_state *state, const plan_cells *like, const plan_cache *cache, const plan_lists *lists,
                        uint32_t cascade, double texel) {
  const plan_cells none = {.begin = {like->begin[0], like->begin[1]}, .size = {like->size[0], like->size[1]}};
  const plan_kept kept = plan_cache_kept(cache);
  plan_cells moving = none, standing = none;
  for (uint32_t i = 0; i < cache->movers; ++i)
    add_slot(&moving, &kept, kept.movers[i], texel);
  for (uint32_t i = 0; i < lists->found_count; ++i)
    if (lists->found[i].mask >> cascade & 1 && !kept.moves[lists->found[i].slot])
      add_slot(&standing, &kept, lists->found[i].slot, texel);
  memcpy(state->moving.rows, moving.read, sizeof moving.read);
  memcpy(state->standing.rows, standing.read, sizeof standing.read);
}

static page_state find_state(const plan_frame *frame, uint32_t cascade, const plan_lists *lists, const plan_cells *like,
                             const plan_frame_info *info) {
  const plan_pages *now = &frame->history.pages[cascade];
  const plan_pages *before = knows_changes(frame, info) ? &info->before->pages[cascade] : NULL;
  const double texel = fmax(now->texel[0], now->texel[1]);
  page_state state = {0};
  cell_set mixed;
  state.known = before && drawn_alike(before, now);
  if (state.known) {
    keep_cells(state.valid.rows, before->valid, before, now);
    keep_cells(state.still.rows, before->still, before, now);
    keep_cells(mixed.rows, before->mixed, before, now);
    for (uint32_t y = 0; y < PLAN_CELLS; ++y)
      state.clean.rows[y] = state.valid.rows[y] & ~mixed.rows[y];
    spoil(&state, like, info, texel);
  }
  const plan_cache *cache = cache_of(info);
  if (cache && cache->movers)
    find_moving(&state, like, cache, lists, cascade, texel);
  return state;
}

/* ---- a map ---- */

/* What is drawn of a map's pages, and what is copied. */
typedef struct page_work {
  plan_cells drawn[PLAN_WINDOW_KINDS];
  cell_set copied, saved;
} page_work;

/*
 * Where something moves over what stands still, or the second layer has the page already, it is copied from there. That layer
 * gets what it lacks: the page as it was before anything moved into it, or drawn.
 */
static void divide_work(page_work *out, const plan_cells *due, const page_state *state) {
  for (int kind = 0; kind < PLAN_WINDOW_KINDS; ++kind)
    out->drawn[kind] = *due;
  for (uint32_t y = 0; y < PLAN_CELLS; ++y) {
    const uint64_t still = state->still.rows[y], moving = state->moving.rows[y];
    const uint64_t copied = due->read[y] & ((moving & state->standing.rows[y]) | still), lacks = copied & ~still;
    out->copied.rows[y] = copied;
    out->saved.rows[y] = lacks & state->clean.rows[y];
    out->drawn[PLAN_WINDOW_ALL].read[y] = due->read[y] & ~copied;
    out->drawn[PLAN_WINDOW_STILL].read[y] = lacks & ~state->clean.rows[y];
    out->drawn[PLAN_WINDOW_MOVING].read[y] = copied & moving;
  }
}

/* All that is due is drawn into the maps at once: where there are too many windows, and where all is made anew, as it may be in
   the next frame, too. */
static void undivide_work(page_work *out, const plan_cells *due) {
  *out = (page_work){0};
  out->drawn[PLAN_WINDOW_ALL] = *due;
}

/* What then is valid, and what is done for it. */
static void note_work(plan_frame *frame, uint32_t cascade, const page_state *state, const plan_cells *read,
                      const plan_cells *due, const page_work *work) {
  plan_cascade *of = &frame->cascades[cascade];
  plan_pages *pages = &frame->history.pages[cascade];
  cell_set valid, still, mixed;
  for (uint32_t y = 0; y < PLAN_CELLS; ++y) {
    valid.rows[y] = state->valid.rows[y] | read->read[y];
    still.rows[y] = state->still.rows[y] | work->copied.rows[y];
    mixed.rows[y] = (state->valid.rows[y] & ~state->clean.rows[y]) | (due->read[y] & state->moving.rows[y]);
  }
  to_slots(pages->valid, valid.rows, pages);
  to_slots(pages->still, still.rows, pages);
  to_slots(pages->mixed, mixed.rows, pages);
  memcpy(of->valid, pages->valid, sizeof of->valid);
  to_slots(of->due, due->read, pages);
  to_slots(of->copied, work->copied.rows, pages);
  to_slots(of->saved, work->saved.rows, pages);
  to_slots(of->still_due, work->drawn[PLAN_WINDOW_STILL].read, pages);
}

/* Which pages of a map are made anew, of those that are read, and how. Returns its windows. */
static plan_windows make_map(plan_frame *frame, uint32_t cascade, const plan_fit *fit, const plan_lists *lists,
                             plan_cells *cells, const plan_cells *read, const plan_frame_info *info) {
  plan_cascade *of = &frame->cascades[cascade];
  plan_pages *pages = &frame->history.pages[cascade];
  begin_pages(pages, of, fit);
  const page_state state = find_state(frame, cascade, lists, read, info);
  plan_cells due = *read;
  for (uint32_t y = 0; y < PLAN_CELLS; ++y)
    due.read[y] &= ~state.valid.rows[y];
  page_work work;
  plan_windows made;
  divide_work(&work, &due, &state);
  if (!state.known || !plan_windows_make(&made, frame, cells, cascade, fit, work.drawn)) {
    undivide_work(&work, &due);
    (void)plan_windows_make(&made, frame, cells, cascade, fit, work.drawn);
  }
  note_work(frame, cascade, &state, read, &due, &work);
  const uint32_t page = fit->resolution / PLAN_CELLS;
  of->begin_texels[0] = (uint32_t)(pages->first[0] & LAST) * page;
  of->begin_texels[1] = plan_slot_row(pages, LAST) * page;
  return made;
}

/* From masks of cascades to masks of windows. */
static void spread(plan_lists *lists, const plan_windows *windows, const plan_cache *cache) {
  const bool *moves = cache && cache->movers ? plan_cache_kept(cache).moves : NULL;
  for (uint32_t i = 0; i < lists->found_count; ++i) {
    const plan_window_kind kind = moves && moves[lists->found[i].slot] ? PLAN_WINDOW_MOVING : PLAN_WINDOW_STILL;
    uint64_t of_windows = 0;
    for (uint64_t mask = lists->found[i].mask; mask; mask &= mask - 1) {
      const plan_windows *of = &windows[__builtin_ctzll(mask)];
      of_windows |= of->of[PLAN_WINDOW_ALL] | of->of[kind];
    }
    lists->found[i].mask = of_windows;
  }
}

void plan_pages_make(plan_frame *frame, const plan_fit *fits, plan_lists *lists, plan_cells *cells,
                     const plan_frame_info *info) {
  plan_cells read[CSM_MAX_CASCADES];
  plan_windows windows[CSM_MAX_CASCADES];
  plan_history *history = &frame->history;
  memcpy(read, cells, frame->cascade_count * sizeof *read);
  frame->window_count = 0;
  for (uint32_t i = 0; i < frame->cascade_count; ++i)
    windows[i] = make_map(frame, i, &fits[i], lists, cells, &read[i], info);
  const plan_cache *cache = cache_of(info);
  spread(lists, windows, cache);
  history->pages_identity = cache ? info->scene->identity : 0;
  history->pages_revision = cache ? cache->revision : 0;
  history->pages_plan = cache ? cache->plans : 0;
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
