#include "techniques/technique.h"

#include "device/clock.h"
#include "techniques/camera_depth/camera_depth.h"
#include "techniques/depth_samples/depth_samples.h"
#include "techniques/history/history.h"
#include "techniques/maps/maps.h"
#include "techniques/mask/mask.h"
#include "techniques/mask_count/mask_count.h"
#include "techniques/moments/moments.h"
#include "techniques/ranges/ranges.h"
#include "techniques/rays/instances.h"
#include "techniques/rays/rays.h"
#include "techniques/seen_depth/seen_depth.h"

static const technique *const of_cascades[] = {&technique_maps, &technique_moments, &technique_ranges,
                                               &technique_ray_instances};
static const technique *const of_views[] = {&technique_camera_depth, &technique_seen_depth, &technique_mask,
                                            &technique_rays,         &technique_mask_count, &technique_history,
                                            &technique_depth_samples};

enum {
  OF_CASCADES = sizeof of_cascades / sizeof of_cascades[0],
  OF_VIEWS = sizeof of_views / sizeof of_views[0],
};
_Static_assert((int)OF_CASCADES <= (int)TECHNIQUE_MAX && (int)OF_VIEWS <= (int)TECHNIQUE_MAX, "TECHNIQUE_MAX");

/* ---- owners ---- */

static csm_result begin(technique_set *set) {
  for (uint32_t i = 0; i < set->count; ++i) {
    set->states[i] = host_allocate(set->host, set->techniques[i]->state_size);
    if (!set->states[i]) {
      technique_set_end(set);
      return CSM_ERROR_OUT_OF_MEMORY;
    }
  }
  return CSM_SUCCESS;
}

csm_result technique_set_begin_cascades(technique_set *set, host *host) {
  *set = (technique_set){.techniques = of_cascades, .count = OF_CASCADES, .host = host};
  return begin(set);
}

csm_result technique_set_begin_view(technique_set *set, host *host) {
  *set = (technique_set){.techniques = of_views, .count = OF_VIEWS, .host = host};
  return begin(set);
}

void technique_set_end(technique_set *set) {
  for (uint32_t i = 0; i < set->count && set->states[i]; ++i) {
    if (set->techniques[i]->end)
      set->techniques[i]->end(set->states[i], set->host);
    host_release(set->host, set->states[i]);
    set->states[i] = NULL;
  }
}

void *technique_state(const technique_set *set, const technique *technique) {
  for (uint32_t i = 0; i < set->count; ++i)
    if (set->techniques[i] == technique)
      return set->states[i];
  return NULL;
}

/* ---- settings and devices ---- */

csm_result technique_set_make(technique_set *set, device *device, const csm_config *config) {
  csm_result result = CSM_SUCCESS;
  for (uint32_t i = 0; i < set->count && !result; ++i) {
    const technique *technique = set->techniques[i];
    if (technique->make && technique->wanted(config))
      result = technique->make(set->states[i], device, config);
  }
  if (result)
    technique_set_forget(set, device);
  return result;
}

void technique_set_adopt(technique_set *set, device *from, const csm_config *config) {
  for (uint32_t i = 0; i < set->count; ++i)
    (set->techniques[i]->wanted(config) ? set->techniques[i]->adopt : set->techniques[i]->drop)(set->states[i], from);
}

void technique_set_forget(technique_set *set, device *device) {
  for (uint32_t i = 0; i < set->count; ++i)
    set->techniques[i]->forget(set->states[i], device);
}

uint64_t technique_set_bytes(const technique_set *set, const device *device, const csm_config *config) {
  uint64_t bytes = 0;
  for (uint32_t i = 0; i < set->count; ++i)
    if (set->techniques[i]->bytes && set->techniques[i]->wanted(config))
      bytes += set->techniques[i]->bytes(set->states[i], device);
  return bytes;
}

void technique_set_drop(technique_set *set, device *device) {
  for (uint32_t i = 0; i < set->count; ++i)
    set->techniques[i]->drop(set->states[i], device);
}

void technique_set_drop_unwanted(technique_set *set, device *device, const csm_config *config) {
  for (uint32_t i = 0; i < set->count; ++i)
    if (!set->techniques[i]->wanted(config))
      set->techniques[i]->drop(set->states[i], device);
}

/* ---- recordings ---- */

/* Who runs, in order. */
typedef struct running {
  uint32_t count;
  const technique *techniques[TECHNIQUE_MAX];
  void *states[TECHNIQUE_MAX];
  uint64_t offsets[TECHNIQUE_MAX + 1]; /* of each one's piece of the ring; the last is the size of all */
} running;

static bool runs(const technique *technique, const technique_run *run) {
  const bool reduces = run->picture && run->picture->reduces;
  return technique->when != (reduces ? TECHNIQUE_SHADOWS : TECHNIQUE_REDUCTION) &&
         (reduces || technique->wanted(run->config));
}

static void choose(running *out, const technique_run *run) {
  const technique_set *set = run->view ? run->view : run->cascades;
  *out = (running){0};
  for (uint32_t i = 0; i < set->count; ++i) {
    const technique *technique = set->techniques[i];
    if (!runs(technique, run))
      continue;
    const uint64_t size = technique->size(set->states[i], run);
    out->techniques[out->count] = technique;
    out->states[out->count] = set->states[i];
    out->offsets[out->count + 1] =
        out->offsets[out->count] + (size + RING_ALIGNMENT - 1) / RING_ALIGNMENT * RING_ALIGNMENT;
    ++out->count;
  }
}

static csm_result reserve(technique_run *run, const running *all) {
  ring_range ring = {0};
  csm_result result = recording_prepare(run->device, run->frame->frame, all->offsets[all->count], &ring);
  for (uint32_t i = 0; i < all->count && !result; ++i) {
    const ring_range piece = {.buffer = ring.buffer,
                              .offset = ring.offset + all->offsets[i],
                              .memory = ring.memory ? (char *)ring.memory + all->offsets[i] : NULL};
    result = all->techniques[i]->reserve(all->states[i], run, &piece);
  }
  return result;
}

static csm_result record(technique_run *run, const running *all) {
  const csm_result result = recording_begin(run->device, run->frame->command_buffer);
  if (result)
    return result;
  for (uint32_t i = 0; i < all->count; ++i)
    all->techniques[i]->adopt(all->states[i], run->device);
  for (uint32_t i = 0; i < all->count; ++i)
    all->techniques[i]->record(all->states[i], run);
  return recording_end(run->device);
}

csm_result technique_run_record(technique_run *run, technique_times *times) {
  running all;
  choose(&all, run);
  csm_result result = reserve(run, &all);
  const double reserved_ms = clock_ms();
  for (uint32_t i = 0; i < all.count && !result; ++i)
    if (all.techniques[i]->write)
      all.techniques[i]->write(all.states[i], run);
  const double written_ms = clock_ms();
  if (!result)
    result = record(run, &all);
  if (result) /* what was adopted already stays: the device is lost then */
    for (uint32_t i = 0; i < all.count; ++i)
      all.techniques[i]->forget(all.states[i], run->device);
  *times = (technique_times){.write_ms = written_ms - reserved_ms, .record_ms = clock_ms() - written_ms};
  return result;
}

/* ---- what came of it ---- */

void technique_set_bind(const technique_set *set, device *device, csm_binding *binding) {
  for (uint32_t i = 0; i < set->count; ++i)
    if (set->techniques[i]->bind)
      set->techniques[i]->bind(set->states[i], device, binding);
}

void technique_set_tell(const technique_set *set, const device *device, csm_stats *stats) {
  for (uint32_t i = 0; i < set->count; ++i)
    if (set->techniques[i]->tell)
      set->techniques[i]->tell(set->states[i], device, stats);
}

void technique_set_tell_view(const technique_set *set, const device *device, csm_view_stats *stats) {
  for (uint32_t i = 0; i < set->count; ++i)
    if (set->techniques[i]->tell_view)
      set->techniques[i]->tell_view(set->states[i], device, stats);
}

csm_result technique_set_find(const technique_set *set, uint32_t source, uint32_t cascade, technique_image *out) {
  csm_result result = CSM_ERROR_UNSUPPORTED;
  for (uint32_t i = 0; i < set->count && result == CSM_ERROR_UNSUPPORTED; ++i)
    if (set->techniques[i]->find)
      result = set->techniques[i]->find(set->states[i], source, cascade, out);
  return result;
}
