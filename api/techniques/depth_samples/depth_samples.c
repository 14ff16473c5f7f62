#include "techniques/depth_samples/depth_samples.h"

#include "shader_code.h"
#include "techniques/tiles.h"

#include <string.h>

enum { TILE_PX = 32 };

/* The least and the greatest depth in each tile. */
static const tile_kind tiles_of_samples = {
    .steps = {{.name = "depth tiles", .pixel = &shader_depth_tiles_ps, .px = 8, .format = GPU_FORMAT_RG32_FLOAT},
              {.name = "depth tiles, large",
               .pixel = &shader_depth_tiles_large_ps,
               .px = TILE_PX,
               .format = GPU_FORMAT_RG32_FLOAT}},
    .count = 2};

typedef struct depth_samples_state {
  tile_images *now, *fresh;   /* NULL until a picture wants them */
  tile_read *read;            /* of the recording on its way */
  plan_depth_samples samples; /* the newest that came back; without columns if none did */
  void *memory;               /* that its depths lie in */
  void *room, *fresh_room;    /* for those of another size, until they come back; or NULL */
  uint32_t constants_offset;
} depth_samples_state;

static bool wanted(const csm_config *config) {
  return config->depth_samples != CSM_DEPTH_SAMPLES_OFF;
}

static uint64_t size(const void *self, const technique_run *run) {
  (void)self;
  (void)run;
  return tiles_bytes(&tiles_of_samples);
}

/* Takes over the newest tiles whose frame is done. */
static void collect(depth_samples_state *state, const device *device) {
  const tile_images *tiles = state->now;
  const tile_read *newest = tiles ? tile_images_newest(tiles, device) : NULL;
  if (!newest)
    return;
  if (state->room) {
    host_release(device->host, state->memory);
    state->memory = state->room;
    state->room = NULL;
  }
  tile_images_copy(tiles, newest, device, state->memory);
  state->samples = newest->about;
  state->samples.depths = state->memory;
}

/* Tiles of the picture's size, with room for their depths. */
static csm_result reserve_tiles(depth_samples_state *state, device *device, const technique_picture *picture) {
  if (state->now && state->now->width == picture->width && state->now->height == picture->height)
    return CSM_SUCCESS;
  const csm_result result =
      tile_images_create(device, &tiles_of_samples, picture->width, picture->height, &state->fresh);
  if (result)
    return result;
  state->fresh_room = host_allocate(device->host, tile_images_size(state->fresh));
  return state->fresh_room ? CSM_SUCCESS : CSM_ERROR_OUT_OF_MEMORY;
}

static csm_result reserve(void *self, technique_run *run, const ring_range *ring) {
  depth_samples_state *state = self;
  const technique_picture *picture = run->picture;
  collect(state, run->device);
  csm_result result = reserve_tiles(state, run->device, picture);
  if (result)
    return result;
  tile_images *tiles = state->fresh ? state->fresh : state->now;
  const tile_sources from = {.constants = ring->buffer, .depth = picture->depth};
  result = tile_images_find_read(tiles, run->device, &from, &state->read);
  if (result)
    return result;
  state->constants_offset = (uint32_t)ring->offset;
  state->read->about = (plan_depth_samples){.camera = *picture->depth_camera,
                                            .maps_camera = run->plan->camera,
                                            .width = picture->width,
                                            .height = picture->height,
                                            .tile_px = TILE_PX,
                                            .columns = tiles->columns,
                                            .rows = tiles->rows};
  tiles_write(ring->memory, &tiles_of_samples, picture->width, picture->height,
              (float)plan_clear_depth(picture->depth_camera));
  return CSM_SUCCESS;
}

static void forget(void *self, device *device) {
  depth_samples_state *state = self;
  if (state->fresh)
    tile_images_free(device, &state->fresh->retired);
  host_release(device->host, state->fresh_room);
  state->fresh = NULL;
  state->fresh_room = NULL;
}

/* What was seen in another size, or on another device, stays until something newer comes back: splits that follow it do
   not jump. */
static void adopt(void *self, device *from) {
  depth_samples_state *state = self;
  if (!state->fresh)
    return;
  if (state->now)
    retire(from, &state->now->retired, tile_images_free);
  host_release(from->host, state->room);
  state->now = state->fresh;
  state->room = state->fresh_room;
  state->fresh = NULL;
  state->fresh_room = NULL;
}

static void drop(void *self, device *device) {
  depth_samples_state *state = self;
  collect(state, device);
  if (state->now)
    retire(device, &state->now->retired, tile_images_free);
  state->now = NULL;
}

static void end(void *self, host *host) {
  depth_samples_state *state = self;
  host_release(host, state->memory);
  host_release(host, state->room);
}

static void record(void *self, const technique_run *run) {
  depth_samples_state *state = self;
  tiles_record(state->now, state->read, run->device, (uint32_t[]){state->constants_offset, 0});
}

static void tell_view(const void *self, const device *device, csm_view_stats *stats) {
  const depth_samples_state *state = self;
  if (state->now)
    stats->bytes += tile_images_bytes(state->now, device);
}

void depth_samples_collect(const technique_set *view, const device *device, plan_depth_samples *out) {
  depth_samples_state *state = technique_state(view, &technique_depth_samples);
  collect(state, device);
  *out = state->samples;
}

void depth_samples_drop(const technique_set *view, device *device) {
  depth_samples_state *state = technique_state(view, &technique_depth_samples);
  drop(state, device);
  end(state, device->host);
  state->memory = state->room = NULL;
  state->samples = (plan_depth_samples){0};
}

const technique technique_depth_samples = {
    .name = "depth samples",
    .state_size = sizeof(depth_samples_state),
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
