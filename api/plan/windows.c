/* windows.c: what is drawn at one go of a map that is made of pages. */
#include "plan/internal.h"

#include <string.h>

enum {
  LAST = PLAN_CELLS - 1,
  WORTH_A_CUT = 32 /* cells: on a CPU, filling so many takes about as long as another window's draws */
};

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
  window->slots[1] = plan_slot_row(pages, b.high[1]);
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

/* Divides windows, from one on, while that leaves out enough, and there is room. */
static uint32_t cut_windows(plan_cells *cells, uint32_t count, uint32_t most) {
  plan_cells parts[2];
  for (uint32_t i = 0; i < count && count < most;)
    if (best_cut(parts, &cells[i]) >= WORTH_A_CUT) {
      cells[i] = parts[0];
      cells[count++] = parts[1];
    } else {
      ++i;
    }
  return count;
}

/* A triangle is drawn over all of a window's rectangle, also where nothing is due. So windows are divided. */
bool plan_windows_make(plan_windows *out, plan_frame *frame, plan_cells *cells, uint32_t cascade, const plan_fit *fit,
                       const plan_cells due[PLAN_WINDOW_KINDS]) {
  const plan_pages *pages = &frame->history.pages[cascade];
  const uint32_t most = PLAN_WINDOWS_MOST / frame->cascade_count;
  plan_cells squares[PLAN_WINDOW_KINDS][4];
  uint32_t counts[PLAN_WINDOW_KINDS], left = most;
  for (int kind = 0; kind < PLAN_WINDOW_KINDS; ++kind) {
    counts[kind] = divide_squares(squares[kind], &due[kind], pages);
    if (counts[kind] > left)
      return false;
    left -= counts[kind];
  }
  *out = (plan_windows){0};
  for (int kind = 0; kind < PLAN_WINDOW_KINDS; ++kind) {
    plan_cells *own = &cells[frame->window_count];
    memcpy(own, squares[kind], counts[kind] * sizeof *own);
    const uint32_t count = cut_windows(own, counts[kind], counts[kind] + left);
    left -= count - counts[kind];
    for (uint32_t i = 0; i < count; ++i) {
      plan_window *window = &frame->windows[frame->window_count];
      *window = (plan_window){.cascade = cascade, .kind = (plan_window_kind)kind};
      finish_window(window, &frame->cascades[cascade], fit, &own[i], pages);
      out->of[kind] |= (uint64_t)1 << frame->window_count++;
    }
  }
  return true;
}
