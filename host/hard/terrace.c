/* terrace.c: every depth of a map at once. */
#include "hard/terrace.h"
#include <math.h>

/* The terrace is so many metres wide. */
static const double side = 60.0;

/* From next to the range's begin to next to its end. */
static double step_depth(uint32_t row) {
  return row == 0 ? 0.001 : row == TERRACE_CELLS - 1 ? 0.9995 : (row + 0.5) / TERRACE_CELLS;
}

/* From 1e-5 of the range on, twice as much from column to column, and by fifteenths of that from row to row. */
static double step_gap(uint32_t column, uint32_t row) {
  const double gap = 1e-5 * exp2(1.25 * column + (double)row / TERRACE_CELLS);
  return column % 5 == 0 || gap > step_depth(row) ? 0.0 : gap;
}

void terrace_make(host_setup *out, double range) {
  const double cell = side / TERRACE_CELLS;
  mesh_builder steps = {0}, lids = {0};
  overhead_begin(out, &(overhead){.side = side, .eye = range, .floor = -0.001 * range, .pixels = TERRACE_PIXELS});
  for (uint32_t row = 0; row < TERRACE_CELLS; row++)
    for (uint32_t column = 0; column < TERRACE_CELLS; column++) {
      const double gap = step_gap(column, row), height = range * (1.0 - step_depth(row));
      const double x = column * cell - 0.5 * side, z = row * cell - 0.5 * side;
      const double corners[4] = {x, z, x + cell, z + cell};
      overhead_tile(&steps, corners, height);
      if (gap > 0.0)
        overhead_tile(&lids, corners, height + range * gap);
    }
  hard_add(out, &steps, "steps", NULL);
  hard_add(out, &lids, "lids", NULL);
  overhead_range(out, range, 0.0);
  out->config.bias_constant_texels = out->config.bias_slope_texels = 0.0;
  out->config.bleeding_reduction = 0.0;
}

int terrace_hide_lids(hard_run *run) {
  return hard_flag(run, 1, 2, CSM_INSTANCE_CAST_ONLY);
}

bool terrace_step_at(terrace_step *out, const host_setup *setup, uint32_t column, uint32_t row, double reach) {
  const uint32_t i = column / TERRACE_CELL_PIXELS, j = row / TERRACE_CELL_PIXELS;
  const double pixel = side / TERRACE_PIXELS, half = 0.5 * TERRACE_CELL_PIXELS;
  double at[2];
  overhead_place(setup, column, row, at);
  *out = (terrace_step){.depth = step_depth(j), .gap = step_gap(i, j)};
  out->place[0] = at[0];
  out->place[1] = (1.0 - out->depth) * setup->camera.position[1];
  out->place[2] = at[1];
  const double x = column % TERRACE_CELL_PIXELS + 0.5 - half, y = row % TERRACE_CELL_PIXELS + 0.5 - half;
  return (half - fmax(fabs(x), fabs(y))) * pixel > reach;
}
