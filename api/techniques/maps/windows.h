/* windows.h: the casters of a plan's windows: their matrices in the ring, and their draws. */
#ifndef TECHNIQUES_MAP_WINDOWS_H
#define TECHNIQUES_MAP_WINDOWS_H

#include "techniques/maps/casters.h"
#include "techniques/technique.h"

/* Of the recording on its way. */
typedef struct map_windows {
  gpu_buffer *buffer;
  uint64_t offsets[PLAN_WINDOWS_MOST]; /* where each window's matrices begin */
} map_windows;

/* Bytes of the ring that the matrices take, a multiple of RING_ALIGNMENT. */
uint64_t map_windows_bytes(const plan_frame *plan);
void map_windows_write(map_windows *windows, const technique_run *run, const ring_range *ring);
/* Draws a window's casters into the pass that is open. */
void map_windows_draw(const map_windows *windows, const technique_run *run, const caster_programs *casters,
                      uint32_t window);

#endif
