#include "techniques/seen_depth/seen_depth.h"

#include "shader_code.h"
#include "techniques/pass_timer.h"
#include "techniques/tiles.h"

/* plan_seen_tile, as texels. */
static const tile_kind tiles_of_depth = {.steps = {{.name = "seen depth",
                                                    .pixel = &shader_seen_depth_ps,
                                                    .px = PLAN_SEEN_PX,
                                                    .format = GPU_FORMAT_RGBA32_FLOAT}},
                                         .count = 1};
_Static_assert(sizeof(plan_seen_tile) == 4 * sizeof(float), "a texel is a tile");

typedef struct seen_depth_state {
  tile_images *now, *fresh;
  tile_read *read, *next; /* of the last reduction, NULL: none on this device; and of the recording on its way */
  plan_seen_depth seen;   /* by the last reduction */
  bool taken;             /* its tiles lie in memory */
  void *memory;
  size_t memory_size;
  uint32_t constants_offset;
  pass_timer timer;
} seen_depth_state;

static bool wanted(const csm_config *config) {
  (void)config;
  return true;
}

static uint64_t size(const void *self, const technique_run *run) {
  (void)self;
  (void)run;
  return tiles_bytes(&tiles_of_depth);
}

static csm_result reserve(void *self, technique_run *run, const ring_range *ring) {
  seen_depth_state *state = self;
  const technique_picture *picture = run->picture;
  csm_result result = CSM_SUCCESS;
  if (!state->now || state->now->width != picture->width || state->now->height != picture->height)
    result = tile_images_create(run->device, &tiles_of_depth, picture->width, picture->height, &state->fresh);
  if (!result)
    result = tile_images_find_read(state->fresh ? state->fresh : state->now, run->device,
                                   &(tile_sources){.constants = ring->buffer, .depth = picture->depth}, &state->next);
  if (result)
    return result;
  state->constants_offset = (uint32_t)ring->offset;
  tiles_write(ring->memory, &tiles_of_depth, picture->width, picture->height,
              (float)plan_clear_depth(picture->depth_camera));
  return CSM_SUCCESS;
}

static void forget(void *self, device *device) {
  seen_depth_state *state = self;
  if (state->fresh)
    tile_images_free(device, &state->fresh->retired);
  state->fresh = NULL;
}

static void adopt(void *self, device *from) {
  seen_depth_state *state = self;
  if (!state->fresh)
    return;
  if (state->now)
    retire(from, &state->now->retired, tile_images_free);
  state->now = state->fresh;
  state->fresh = NULL;
}

static void drop(void *self, device *device) {
  seen_depth_state *state = self;
  pass_timer_drop(&state->timer, device);
  if (state->now)
    retire(device, &state->now->retired, tile_images_free);
  state->now = NULL;
  state->read = NULL;
  state->taken = false;
}

static void end(void *self, host *host) {
  host_release(host, ((seen_depth_state *)self)->memory);
}

static void record(void *self, const technique_run *run) {
  seen_depth_state *state = self;
  const technique_picture *picture = run->picture;
  pass_timer_begin(&state->timer, run, 1);
  tiles_record(state->now, state->next, run->device, (uint32_t[]){state->constants_offset, 0});
  pass_timer_step(&state->timer, run);
  state->read = state->next;
  state->taken = false;
  state->seen = (plan_seen_depth){.camera = *picture->depth_camera,
                                  .width = picture->width,
                                  .height = picture->height,
                                  .columns = state->now->columns,
                                  .rows = state->now->rows,
                                  .rounding = picture->depth_rounding};
}

static void tell_view(const void *self, const device *device, csm_view_stats *stats) {
  const seen_depth_state *state = self;
  stats->reduce_gpu_ms = pass_timer_ms(&state->timer, 0);
  if (state->now)
    stats->bytes += tile_images_bytes(state->now, device);
}

csm_result seen_depth_collect(const technique_set *view, device *device, const plan_seen_depth **out) {
  seen_depth_state *state = technique_state(view, &technique_seen_depth);
  if (!state->read)
    return host_fail(device->host, CSM_ERROR_INVALID_STATE,
                     "csm_frame: depth_view has reduced no depth on this device yet");
  csm_result result = CSM_SUCCESS;
  if (!state->taken)
    result = recording_wait(device, state->read->serial);
  if (!result && !state->taken)
    result = host_grow(device->host, &state->memory, &state->memory_size, tile_images_size(state->now));
  if (result)
    return result;
  if (!state->taken)
    tile_images_copy(state->now, state->read, device, state->memory);
  state->taken = true;
  state->seen.tiles = state->memory;
  *out = &state->seen;
  return CSM_SUCCESS;
}

const technique technique_seen_depth = {
    .name = "seen depth",
    .when = TECHNIQUE_REDUCTION,
    .state_size = sizeof(seen_depth_state),
    .wanted = wanted,
    .adopt = adopt,
    .forget = forget,
    .drop = drop,
    .end = end,
    .size = size,
    .reserve = reserve,
    .record = record,
    .tell_view = tell_view,
};
