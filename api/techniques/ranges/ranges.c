#include "techniques/ranges/ranges.h"

#include "csm_constants.h"
#include "private/ranges.h"
#include "shader_code.h"
#include "techniques/inputs.h"
#include "techniques/maps/maps.h"
#include "techniques/pass_timer.h"

#include <string.h>

/* Each step reads what the one before it made, the first one the maps. */
enum { BLOCKS, ROWS, COLUMNS, STEPS };

typedef struct range_images {
  retired retired;
  uint32_t blocks;          /* on a side of the largest map */
  gpu_image *images[STEPS]; /* a layer for each cascade */
  gpu_view *stores[STEPS];
  bool valid; /* they are of the maps that were drawn last */
} range_images;

typedef struct range_objects {
  device *device; /* NULL: nothing */
  range_images *images;
  gpu_program *programs[STEPS];
} range_objects;

typedef struct ranges_state {
  range_objects now, fresh;
  inputs inputs[STEPS];
  pass_timer timer;
  /* of the recording on its way */
  ring_range ring;
  input *reads[STEPS];
} ranges_state;

/* ---- images and programs ---- */

static void images_free(device *device, retired *self) {
  range_images *images = (range_images *)self;
  for (uint32_t i = 0; i < STEPS; ++i) {
    gpu_view_destroy(device->gpu, images->stores[i]);
    device_image_free(device, images->images[i]);
  }
  host_release(device->host, images);
}

static csm_result make_image(device *device, range_images *images, uint32_t step, uint32_t layers) {
  static const char *const names[STEPS] = {"blocks' ranges", "rows' ranges", "ranges"};
  const uint32_t needed = GPU_CAN_SAMPLE | GPU_CAN_STORE;
  const gpu_format format = step == BLOCKS ? GPU_FORMAT_R32_FLOAT : GPU_FORMAT_RGBA32_FLOAT;
  if ((device->info.can.formats[format] & needed) != needed)
    return host_fail(device->host, CSM_ERROR_UNSUPPORTED,
                     "filter: the device cannot store images of floats, which exact_soft needs");
  const gpu_image_info info = {.name = names[step],
                               .format = format,
                               .usage = GPU_IMAGE_SAMPLED | GPU_IMAGE_STORED,
                               .width = images->blocks,
                               .height = images->blocks,
                               .layers = layers,
                               .array = true};
  csm_result result = device_image(device, &info, &images->images[step]);
  if (result)
    return result;
  const gpu_view_info view = {.name = names[step], .image = images->images[step], .range = {.level_count = 1}};
  return device_check(device, gpu_view_create(device->gpu, &view, &images->stores[step]), "ranges");
}

static csm_result images_create(device *device, const csm_config *config, range_images **out) {
  uint32_t side = 0;
  for (uint32_t i = 0; i < config->cascade_count; ++i)
    side = plan_resolution(config, i) > side ? plan_resolution(config, i) : side;
  if (!device->info.can.compute)
    return host_fail(device->host, CSM_ERROR_UNSUPPORTED, "filter: the device cannot compute, which exact_soft needs");
  range_images *images = host_allocate(device->host, sizeof *images);
  if (!images)
    return CSM_ERROR_OUT_OF_MEMORY;
  images->blocks = (side + RANGES_BLOCK - 1) / RANGES_BLOCK;
  csm_result result = CSM_SUCCESS;
  for (uint32_t i = 0; i < STEPS && !result; ++i)
    result = make_image(device, images, i, config->cascade_count);
  if (result)
    images_free(device, &images->retired);
  else
    *out = images;
  return result;
}

static csm_result make_program(gpu gpu, const void *about, gpu_program **out) {
  const gpu_code codes[STEPS] = {
      [BLOCKS] = shader_ranges_blocks_cs, [ROWS] = shader_ranges_rows_cs, [COLUMNS] = shader_ranges_columns_cs};
  const uint64_t step = *(const uint64_t *)about;
  const gpu_program_info info = {.name = "ranges",
                                 .compute = codes[step],
                                 .constants_count = 1,
                                 .constants_sizes = {sizeof(csm_constants)},
                                 .texture_count = 1,
                                 .store_image_count = 1,
                                 .sampler_count = step == BLOCKS,
                                 .samplers = {GPU_SAMPLER_POINT_CLAMP}};
  return gpu_program_create(gpu, &info, out);
}

static csm_result find_programs(device *device, gpu_program *out[STEPS]) {
  csm_result result = CSM_SUCCESS;
  for (uint64_t step = 0; step < STEPS && !result; ++step) {
    const program_key key = {.make = make_program, .name = "a program for ranges", .about = &step, .size = sizeof step};
    result = programs_find(device, &key, &out[step]);
  }
  return result;
}

/* ---- settings and devices ---- */

static csm_result make(void *self, device *device, const csm_config *config) {
  ranges_state *state = self;
  range_objects made = {.device = device};
  csm_result result = images_create(device, config, &made.images);
  if (result)
    return result;
  result = find_programs(device, made.programs);
  if (result)
    images_free(device, &made.images->retired);
  else
    state->fresh = made;
  return result;
}

static void drop(void *self, device *device) {
  ranges_state *state = self;
  pass_timer_drop(&state->timer, device);
  if (!state->now.device)
    return;
  for (uint32_t i = 0; i < STEPS; ++i)
    inputs_drop(&state->inputs[i], device);
  retire(device, &state->now.images->retired, images_free);
  state->now = (range_objects){0};
}

static void adopt(void *self, device *from) {
  ranges_state *state = self;
  if (!state->fresh.device)
    return;
  drop(state, from);
  state->now = state->fresh;
  state->fresh = (range_objects){0};
}

static void forget(void *self, device *device) {
  ranges_state *state = self;
  if (!state->fresh.device)
    return;
  images_free(device, &state->fresh.images->retired);
  state->fresh = (range_objects){0};
}

/* ---- a frame ---- */

static uint64_t size(const void *self, const technique_run *run) {
  (void)self;
  return run->constants_size;
}

static csm_result reserve(void *self, technique_run *run, const ring_range *ring) {
  ranges_state *state = self;
  csm_result result = CSM_SUCCESS;
  state->ring = *ring;
  for (uint32_t i = 0; i < STEPS && !result; ++i) {
    const gpu_bindings_info reads = {
        .name = "ranges",
        .program = state->now.programs[i],
        .constants = {ring->buffer},
        .textures = {i == BLOCKS ? maps_image(run->cascades) : state->now.images->images[i - 1]},
        .store_images = {state->now.images->stores[i]}};
    result = inputs_find(&state->inputs[i], run->device, &reads, &state->reads[i]);
  }
  return result;
}

static void write(void *self, const technique_run *run) {
  const ranges_state *state = self;
  memcpy(state->ring.memory, run->constants, run->constants_size);
}

static void record(void *self, const technique_run *run) {
  ranges_state *state = self;
  range_images *images = state->now.images;
  const gpu gpu = run->device->gpu;
  const uint32_t cascades = run->config->cascade_count, offset = (uint32_t)state->ring.offset;
  const uint32_t groups = (images->blocks + RANGES_THREADS - 1) / RANGES_THREADS;
  const bool kept = images->valid && run->same == (1u << cascades) - 1;
  pass_timer_begin(&state->timer, run, 1);
  gpu_marker_begin(gpu, "ranges");
  for (uint32_t i = 0; i < STEPS && !kept; ++i)
    gpu_dispatch(gpu, &(gpu_dispatch_info){.program = state->now.programs[i],
                                           .bindings = inputs_use(state->reads[i], run->device),
                                           .offsets = &offset,
                                           .groups = {groups, groups, cascades}});
  gpu_make_readable(gpu, images->images[COLUMNS], NULL);
  gpu_marker_end(gpu);
  pass_timer_step(&state->timer, run);
  images->valid = true;
}

/* ---- what came of it ---- */

static void tell(const void *self, const device *device, csm_stats *stats) {
  const ranges_state *state = self;
  stats->ranges_gpu_ms = pass_timer_ms(&state->timer, 0);
  for (uint32_t i = 0; i < STEPS && state->now.device; ++i)
    stats->range_bytes += gpu_image_bytes(device->gpu, state->now.images->images[i]);
}

gpu_image *ranges_image(const technique_set *cascades, const csm_config *config) {
  const ranges_state *state = technique_state(cascades, &technique_ranges);
  return plan_has_ranges(config) ? state->now.images->images[COLUMNS] : NULL;
}

const technique technique_ranges = {
    .name = "ranges",
    .state_size = sizeof(ranges_state),
    .wanted = plan_has_ranges,
    .make = make,
    .adopt = adopt,
    .forget = forget,
    .drop = drop,
    .size = size,
    .reserve = reserve,
    .write = write,
    .record = record,
    .tell = tell,
};
