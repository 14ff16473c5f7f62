#include "techniques/moments/passes.h"

#include "csm_constants.h"
#include "private/moments.h"
#include "shader_code.h"

#include <string.h>

enum {
  SETTINGS_BYTES = sizeof(csm_constants) + MOMENTS_COUNT * 16,
  SETTINGS_BLOCK = (SETTINGS_BYTES + RING_ALIGNMENT - 1) / RING_ALIGNMENT * RING_ALIGNMENT,
  DISPATCH_BLOCK = RING_ALIGNMENT,
  GROUPS_MOST = 32768, /* in a row of a dispatch */
  LISTS = 3,           /* no list of tiles is needed longer than all tiles, so often */
};
_Static_assert(MOMENTS_TILE == PLAN_TILE, "a tile's side");
_Static_assert(MOMENTS_D_COUNT * 16 <= DISPATCH_BLOCK, "DISPATCH_BLOCK");

/* ---- programs ---- */

typedef struct program_about {
  uint64_t key;
} program_about;

static csm_result make_program(gpu gpu, const void *about, gpu_program **out) {
  const program_about *of = about;
  const gpu_program_info info = {
      .name = "moments",
      .compute = *shader_find(of->key),
      .constants_count = 2,
      .constants_sizes = {SETTINGS_BYTES, MOMENTS_D_COUNT * 16},
      .texture_count = 1,
      .buffer_count = 1,
      .store_image_count = 1,
  };
  return gpu_program_create(gpu, &info, out);
}

static csm_result find_program(device *device, uint64_t shader, gpu_program **out) {
  const program_about about = {.key = shader};
  const program_key key = {
      .make = make_program, .name = "a program for moments", .about = &about, .size = sizeof about};
  return programs_find(device, &key, out);
}

csm_result moment_programs_find(device *device, const csm_config *config, moment_programs *out) {
  plan_moments shape;
  plan_moments_make(&shape, config);
  const int32_t filter = (int32_t)(config->filter == CSM_FILTER_VSSM ? CSM_FILTER_VSM : config->filter);
  const int32_t half = config->moment_format == CSM_MOMENTS_FLOAT16, halved = (int32_t)config->moment_halved;
  const int32_t width = (int32_t)shape.channels / 2, small = config->moment_blur_texels <= MOMENTS_SMALL_RADIUS;
  const bool blurs = config->moment_blur_texels > 0;
  *out = (moment_programs){.radius = config->moment_blur_texels};
  csm_result result = find_program(
      device, blurs ? shader_key_moments_rows(filter, half, halved, small) : shader_key_moments(filter, half, halved),
      &out->rows);
  if (blurs && !result)
    result = find_program(device, shader_key_moments_columns(width, half, small), &out->columns);
  if (shape.levels > 1 && !result)
    result = find_program(device, shader_key_moments_level(width, half), &out->level);
  return result;
}

/* ---- lists of tiles ---- */

static uint32_t rows_of(uint32_t count) {
  return (count + GROUPS_MOST - 1) / GROUPS_MOST;
}

/* So many groups of a dispatch make whole rows; what a list lacks for that, its last tile fills. */
static void end_list(moment_list *list, uint32_t *tiles, uint32_t *used) {
  list->count = *used - list->first;
  const uint32_t rows = list->count ? rows_of(list->count) : 1;
  while ((*used - list->first) % rows) {
    tiles[*used] = tiles[*used - 1];
    ++*used;
  }
  list->count = *used - list->first;
}

static moment_list append(uint32_t *tiles, uint32_t *used, const uint8_t *wanted, uint32_t across, uint32_t cascade) {
  moment_list list = {.first = *used};
  for (uint32_t y = 0; y < across; ++y)
    for (uint32_t x = 0; x < across; ++x)
      if (wanted[y * across + x])
        tiles[(*used)++] = x | y << MOMENTS_TILE_BITS | cascade << (2 * MOMENTS_TILE_BITS);
  end_list(&list, tiles, used);
  return list;
}

static void spread_down(uint8_t *out, const uint8_t *due, uint32_t across) {
  for (uint32_t i = 0; i < across * across; ++i)
    out[i] = due[i] || (i >= across && due[i - across]) || (i + across < across * across && due[i + across]);
}

/* Tiles of a level that is half as large, from those of the level before: each once, as long as neighbours come together. */
static moment_list append_halved(uint32_t *tiles, uint32_t *used, moment_list from) {
  moment_list list = {.first = *used};
  const uint32_t mask = (1u << MOMENTS_TILE_BITS) - 1, high = mask << MOMENTS_TILE_BITS;
  for (uint32_t i = from.first; i < from.first + from.count; ++i) {
    const uint32_t tile = tiles[i];
    const uint32_t halved = (tile & ~(mask | high)) | ((tile & mask) >> 1) | ((tile & high) >> 1 & high);
    bool known = false;
    for (uint32_t k = *used; k > list.first && !known; --k)
      known = tiles[k - 1] == halved;
    if (!known)
      tiles[(*used)++] = halved;
  }
  end_list(&list, tiles, used);
  return list;
}

static uint32_t list_room(const moment_image *image) {
  return LISTS * image->tile_count + MOMENT_LEVELS_MOST * (1 + rows_of(image->tile_count)) * CSM_MAX_CASCADES;
}

/* ---- a recording ---- */

/* In the order of the blocks: rows and columns of each layer, or all at once, and the levels. */
static uint32_t dispatch_count(const moment_image *image) {
  return (image->between ? 2 * image->layers : 1) + image->shape.levels - 1;
}

uint64_t moment_work_size(const moment_image *image) {
  return SETTINGS_BLOCK + (uint64_t)dispatch_count(image) * DISPATCH_BLOCK + (uint64_t)list_room(image) * 4;
}

csm_result moment_work_reserve(moment_work *work, inputs inputs[MOMENT_STEPS], device *device,
                               const moment_image *image, const moment_programs *programs, gpu_image *maps) {
  gpu_buffer *buffer = work->ring.buffer;
  work->tiles = work->ring.offset + SETTINGS_BLOCK + (uint64_t)dispatch_count(image) * DISPATCH_BLOCK;
  work->tile_bytes = list_room(image) * 4;
  gpu_bindings_info reads = {.name = "moments",
                             .program = programs->rows,
                             .constants = {buffer, buffer},
                             .textures = {maps},
                             .buffers = {{buffer, work->tiles, work->tile_bytes, 4}},
                             .store_images = {image->between ? image->between_view : image->levels[0]}};
  csm_result result = inputs_find(&inputs[MOMENT_ROWS], device, &reads, &work->inputs[MOMENT_ROWS]);
  if (image->between && !result) {
    reads.program = programs->columns;
    reads.textures[0] = image->between;
    reads.store_images[0] = image->levels[0];
    result = inputs_find(&inputs[MOMENT_COLUMNS], device, &reads, &work->inputs[MOMENT_COLUMNS]);
  }
  for (uint32_t i = 1; i < image->shape.levels && !result; ++i) {
    reads.program = programs->level;
    reads.textures[0] = NULL;
    reads.texture_views[0] = image->levels[i - 1];
    reads.store_images[0] = image->levels[i];
    result = inputs_find(&inputs[MOMENT_LEVEL + i - 1], device, &reads, &work->inputs[MOMENT_LEVEL + i - 1]);
  }
  return result;
}

static void write_lists(moment_work *work, const moment_image *image, uint32_t *tiles) {
  uint32_t used = 0;
  work->all = (moment_list){0};
  for (uint32_t i = 0; i < image->cascades; ++i)
    work->due[i] = append(tiles, &used, image->due[i], image->across[i], i);
  end_list(&work->all, tiles, &used);
  for (uint32_t i = 0; i < image->cascades && image->between; ++i) {
    spread_down(image->spread, image->due[i], image->across[i]);
    work->spread[i] = append(tiles, &used, image->spread, image->across[i], i);
  }
  for (uint32_t level = 4; level < image->shape.levels; ++level)
    work->levels[level] = append_halved(tiles, &used, level > 4 ? work->levels[level - 1] : work->all);
}

/* Groups of a tile's level: parts in a row. */
static uint32_t level_parts(uint32_t level) {
  return level < 3 ? 8u >> level : 1;
}

static moment_list level_list(const moment_work *work, uint32_t level) {
  return level < 4 ? work->all : work->levels[level];
}

static void put_dispatch(char **at, const moment_image *image, moment_list list, uint32_t slice, const float pass[4]) {
  float block[MOMENTS_D_COUNT][4] = {{0}};
  block[MOMENTS_D_TILES][0] = (float)list.first;
  block[MOMENTS_D_TILES][1] = list.count ? (float)(list.count / rows_of(list.count)) : 0.0f;
  block[MOMENTS_D_TILES][2] = (float)slice;
  block[MOMENTS_D_TILES][3] = (float)image->shape.depth_layers;
  memcpy(block[MOMENTS_D_PASS], pass, sizeof block[0]);
  memcpy(*at, block, sizeof block);
  *at += DISPATCH_BLOCK;
}

static void write_settings(char *at, const moment_image *image, const csm_config *config, const void *constants,
                           uint32_t constants_size) {
  float more[MOMENTS_COUNT][4] = {{0}};
  double weights[2 * MOMENTS_RADIUS_MOST + 1];
  plan_blur_weights(weights, config);
  for (uint32_t i = 0; i < image->cascades; ++i)
    more[MOMENTS_SIDES + i][0] = (float)image->shape.sides[i];
  for (uint32_t i = 0; i <= 2 * config->moment_blur_texels; ++i)
    more[MOMENTS_WEIGHTS + i][0] = (float)weights[i];
  memcpy(at, constants, constants_size);
  memcpy(at + constants_size, more, sizeof more);
}

void moment_work_write(moment_work *work, const moment_image *image, const csm_config *config, const void *constants,
                       uint32_t constants_size) {
  const float pass[4] = {(float)config->moment_blur_texels};
  char *memory = work->ring.memory, *at = memory + SETTINGS_BLOCK;
  write_settings(memory, image, config, constants, constants_size);
  write_lists(work, image, (uint32_t *)(memory + (work->tiles - work->ring.offset)));
  for (uint32_t i = 0; i < image->layers && image->between; ++i) {
    const uint32_t cascade = i / image->shape.depth_layers, slice = i % image->shape.depth_layers;
    put_dispatch(&at, image, work->spread[cascade], slice, pass);
    put_dispatch(&at, image, work->due[cascade], slice, pass);
  }
  if (!image->between)
    put_dispatch(&at, image, work->all, 0, pass);
  for (uint32_t level = 1; level < image->shape.levels; ++level)
    put_dispatch(&at, image, level_list(work, level), 0,
                 (const float[4]){0.0f, (float)level, (float)level_parts(level)});
}

/* What dispatches share. */
typedef struct recording {
  const moment_work *work;
  const device *device;
  uint32_t next; /* offset of the next dispatch's constants */
} recording;

static void run(recording *to, gpu_program *program, uint32_t step, moment_list list, uint32_t depth) {
  const uint32_t offsets[] = {(uint32_t)to->work->ring.offset, to->next};
  to->next += DISPATCH_BLOCK;
  if (!list.count)
    return;
  const uint32_t rows = rows_of(list.count);
  gpu_dispatch(to->device->gpu, &(gpu_dispatch_info){.program = program,
                                                     .bindings = inputs_use(to->work->inputs[step], to->device),
                                                     .offsets = offsets,
                                                     .groups = {list.count / rows, rows, depth}});
}

void moment_work_record(const moment_work *work, const moment_image *image, const moment_programs *programs,
                        const device *device) {
  recording to = {.work = work, .device = device, .next = (uint32_t)work->ring.offset + SETTINGS_BLOCK};
  const uint32_t slices = image->shape.depth_layers, runs = MOMENTS_TILE / MOMENTS_RUN;
  for (uint32_t i = 0; i < image->layers && image->between; ++i) {
    run(&to, programs->rows, MOMENT_ROWS, work->spread[i / slices], runs);
    run(&to, programs->columns, MOMENT_COLUMNS, work->due[i / slices], runs);
  }
  if (!image->between)
    run(&to, programs->rows, MOMENT_ROWS, work->all, slices);
  for (uint32_t level = 1; level < image->shape.levels; ++level)
    run(&to, programs->level, MOMENT_LEVEL + level - 1, level_list(work, level),
        level_parts(level) * level_parts(level) * slices);
}
