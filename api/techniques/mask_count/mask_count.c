#include "techniques/mask_count/mask_count.h"

#include "shader_code.h"
#include "techniques/mask/mask_programs.h"
#include "techniques/tiles.h"

/* How many pixels of each tile are unsure, and how many face the light, of four in each small one. */
static const tile_kind tiles_of_unsure = {
    .steps =
        {{.name = "mask tiles", .pixel = &shader_mask_tiles_ps, .px = 8, .format = GPU_FORMAT_RG32_FLOAT, .masks = 1},
         {.name = "mask tiles, large",
          .pixel = &shader_mask_tiles_large_ps,
          .px = 32,
          .format = GPU_FORMAT_RG32_FLOAT}},
    .count = 2};

typedef struct mask_count_state {
  tile_images *now, *fresh; /* NULL until a picture wants them */
  tile_read *read;          /* of the recording on its way; NULL: the picture shows no visibility */
  void *memory, *fresh_memory;
  bool known;
  double unsure;
  uint32_t constants_offset;
} mask_count_state;

static bool wanted(const csm_config *config) {
  return config->budget & CSM_BUDGET_ERROR;
}

static uint64_t size(const void *self, const technique_run *run) {
  (void)self;
  (void)run;
  return tiles_bytes(&tiles_of_unsure);
}

static void collect(mask_count_state *state, const device *device) {
  const tile_images *tiles = state->now;
  const tile_read *newest = tiles ? tile_images_newest(tiles, device) : NULL;
  if (!newest)
    return;
  const float(*counts)[2] = state->memory;
  double unsure = 0.0, facing = 0.0;
  tile_images_copy(tiles, newest, device, state->memory);
  for (uint32_t i = 0; i < tiles->columns * tiles->rows; ++i) {
    unsure += counts[i][0];
    facing += counts[i][1];
  }
  state->known = true;
  state->unsure = facing > 0.0 ? unsure / facing : 0.0;
}

static csm_result reserve_tiles(mask_count_state *state, device *device, const technique_picture *picture) {
  if (state->now && state->now->width == picture->width && state->now->height == picture->height)
    return CSM_SUCCESS;
  const csm_result result =
      tile_images_create(device, &tiles_of_unsure, picture->width, picture->height, &state->fresh);
  if (result)
    return result;
  state->fresh_memory = host_allocate(device->host, tile_images_size(state->fresh));
  return state->fresh_memory ? CSM_SUCCESS : CSM_ERROR_OUT_OF_MEMORY;
}

static csm_result reserve(void *self, technique_run *run, const ring_range *ring) {
  mask_count_state *state = self;
  const technique_picture *picture = run->picture;
  const tile_sources from = {.constants = ring->buffer, .depth = picture->depth, .mask = picture->mask};
  collect(state, run->device);
  state->read = NULL;
  if (picture->show != CSM_SHOW_VISIBILITY)
    return CSM_SUCCESS;
  const csm_result result = reserve_tiles(state, run->device, picture);
  if (result)
    return result;
  state->constants_offset = (uint32_t)ring->offset;
  tiles_write(ring->memory, &tiles_of_unsure, picture->width, picture->height,
              (float)plan_clear_depth(picture->depth_camera));
  return tile_images_find_read(state->fresh ? state->fresh : state->now, run->device, &from, &state->read);
}

static void forget(void *self, device *device) {
  mask_count_state *state = self;
  if (state->fresh)
    tile_images_free(device, &state->fresh->retired);
  host_release(device->host, state->fresh_memory);
  state->fresh = NULL;
  state->fresh_memory = NULL;
}

static void drop(void *self, device *device) {
  mask_count_state *state = self;
  if (state->now)
    retire(device, &state->now->retired, tile_images_free);
  host_release(device->host, state->memory);
  state->now = NULL;
  state->memory = NULL;
  state->known = false;
}

static void adopt(void *self, device *from) {
  mask_count_state *state = self;
  if (!state->fresh)
    return;
  drop(state, from);
  state->now = state->fresh;
  state->memory = state->fresh_memory;
  state->fresh = NULL;
  state->fresh_memory = NULL;
}

static void record(void *self, const technique_run *run) {
  mask_count_state *state = self;
  const uint32_t offsets[] = {state->constants_offset,
                              (uint32_t)run->picture->mask_constants.offset + MASK_CASCADES_BLOCK};
  if (state->read)
    tiles_record(state->now, state->read, run->device, offsets);
}

static void tell_view(const void *self, const device *device, csm_view_stats *stats) {
  const mask_count_state *state = self;
  if (state->now)
    stats->bytes += tile_images_bytes(state->now, device);
}

double mask_count_unsure(const technique_set *view, const device *device) {
  mask_count_state *state = technique_state(view, &technique_mask_count);
  collect(state, device);
  return state->known ? state->unsure : -1.0;
}

const technique technique_mask_count = {
    .name = "mask count",
    .state_size = sizeof(mask_count_state),
    .wanted = wanted,
    .adopt = adopt,
    .forget = forget,
    .drop = drop,
    .size = size,
    .reserve = reserve,
    .record = record,
    .tell_view = tell_view,
};
