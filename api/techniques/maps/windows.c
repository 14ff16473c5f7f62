#include "techniques/maps/windows.h"

#include "techniques/draw_list.h"

/* Up to where the next window's begin. */
static uint64_t bytes_of(const plan_window *window) {
  const uint64_t bytes = draw_list_bytes(&window->list, CASTER_ROWS);
  return (bytes + RING_ALIGNMENT - 1) / RING_ALIGNMENT * RING_ALIGNMENT;
}

uint64_t map_windows_bytes(const plan_frame *plan) {
  uint64_t bytes = 0;
  for (uint32_t i = 0; i < plan->window_count && !plan->unshadowed; ++i)
    bytes += bytes_of(&plan->windows[i]);
  return bytes;
}

void map_windows_write(map_windows *windows, const technique_run *run, const ring_range *ring) {
  uint64_t offset = 0;
  windows->buffer = ring->buffer;
  for (uint32_t i = 0; i < run->plan->window_count && !run->plan->unshadowed; ++i) {
    if (run->plan->windows[i].list.instance_count)
      plan_write_window_matrices((float *)((char *)ring->memory + offset), run->plan, i, run->scene);
    windows->offsets[i] = ring->offset + offset;
    offset += bytes_of(&run->plan->windows[i]);
  }
}

void map_windows_draw(const map_windows *windows, const technique_run *run, const caster_programs *casters,
                      uint32_t window) {
  draw_list(run->device->gpu,
            &(draw_list_info){.programs = {casters->programs[GPU_CULL_NONE], casters->programs[GPU_CULL_BACK],
                                           casters->programs[GPU_CULL_FRONT]},
                              .cull = casters->look.cull,
                              .skip_hidden = true,
                              .list = &run->plan->windows[window].list,
                              .meshes = run->device->geometry.meshes,
                              .matrices = windows->buffer,
                              .offset = windows->offsets[window],
                              .rows = CASTER_ROWS});
}
