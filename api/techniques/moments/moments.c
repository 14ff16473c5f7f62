#include "techniques/moments/moments.h"

#include "techniques/maps/maps.h"
#include "techniques/moments/passes.h"
#include "techniques/pass_timer.h"

#include <string.h>

typedef struct moment_objects {
  device *device; /* NULL: nothing */
  moment_image *image;
  moment_programs programs;
} moment_objects;

typedef struct moments_state {
  moment_objects now, fresh;
  inputs inputs[MOMENT_STEPS];
  pass_timer timer;
  moment_work work; /* of the recording on its way */
} moments_state;

/* ---- settings and devices ---- */

static bool wanted(const csm_config *config) {
  return plan_has_moments(config);
}

static csm_result make(void *self, device *device, const csm_config *config) {
  moments_state *state = self;
  moment_objects made = {.device = device};
  csm_result result = moment_image_create(device, config, &made.image);
  if (result)
    return result;
  result = moment_programs_find(device, config, &made.programs);
  if (result)
    moment_image_free(device, &made.image->retired);
  else
    state->fresh = made;
  return result;
}

static uint64_t bytes(const void *self, const device *device) {
  return moment_image_bytes(device, ((const moments_state *)self)->fresh.image);
}

static void drop(void *self, device *device) {
  moments_state *state = self;
  pass_timer_drop(&state->timer, device);
  if (!state->now.device)
    return;
  for (uint32_t i = 0; i < MOMENT_STEPS; ++i)
    inputs_drop(&state->inputs[i], device);
  retire(device, &state->now.image->retired, moment_image_free);
  state->now = (moment_objects){0};
}

static void adopt(void *self, device *from) {
  moments_state *state = self;
  if (!state->fresh.device)
    return;
  drop(state, from);
  state->now = state->fresh;
  state->fresh = (moment_objects){0};
}

static void forget(void *self, device *device) {
  moments_state *state = self;
  if (!state->fresh.device)
    return;
  moment_image_free(device, &state->fresh.image->retired);
  state->fresh = (moment_objects){0};
}

/* ---- a frame ---- */

static uint64_t size(const void *self, const technique_run *run) {
  (void)run;
  return moment_work_size(((const moments_state *)self)->now.image);
}

static csm_result reserve(void *self, technique_run *run, const ring_range *ring) {
  moments_state *state = self;
  state->work = (moment_work){.ring = *ring};
  return moment_work_reserve(&state->work, state->inputs, run->device, state->now.image, &state->now.programs,
                             maps_image(run->cascades));
}

/* Tiles that the frame's camera sees, and that do not hold yet what their map is going to hold. */
static void find_due(const moment_image *image, const technique_run *run) {
  for (uint32_t i = 0; i < image->cascades; ++i) {
    const size_t count = (size_t)image->across[i] * image->across[i];
    if (!(run->same >> i & 1))
      memset(image->valid[i], 0, count);
    if (run->plan->unshadowed)
      memset(image->due[i], 0, count);
    else
      plan_seen_tiles(image->due[i], run->plan, run->config, i, image->shape.sides[i]);
    for (size_t k = 0; k < count; ++k)
      image->due[i][k] &= !image->valid[i][k];
  }
}

static void write(void *self, const technique_run *run) {
  moments_state *state = self;
  find_due(state->now.image, run);
  moment_work_write(&state->work, state->now.image, run->config, run->constants, run->constants_size);
}

static void record(void *self, const technique_run *run) {
  moments_state *state = self;
  const gpu gpu = run->device->gpu;
  moment_image *image = state->now.image;
  pass_timer_begin(&state->timer, run, 1);
  gpu_marker_begin(gpu, "moments");
  if (!image->begun)
    moment_image_clear(gpu, image);
  image->begun = true;
  moment_work_record(&state->work, image, &state->now.programs, run->device);
  gpu_make_readable(gpu, image->image, NULL);
  gpu_marker_end(gpu);
  pass_timer_step(&state->timer, run);
  for (uint32_t i = 0; i < image->cascades; ++i)
    for (size_t k = 0; k < (size_t)image->across[i] * image->across[i]; ++k)
      image->valid[i][k] |= image->due[i][k];
}

/* ---- what came of it ---- */

static void bind(const void *self, device *device, csm_binding *binding) {
  const moments_state *state = self;
  gpu_native_image native;
  if (!state->now.device)
    return;
  gpu_image_native(device->gpu, state->now.image->image, &native);
  binding->native_moments = native.image;
  binding->native_moments_view = native.view;
  if (binding->moments_descriptor)
    gpu_image_describe(device->gpu, state->now.image->image, binding->moments_descriptor);
}

static void tell(const void *self, const device *device, csm_stats *stats) {
  const moments_state *state = self;
  stats->moments_gpu_ms = pass_timer_ms(&state->timer, 0);
  stats->moment_bytes = state->now.device ? moment_image_bytes(device, state->now.image) : 0;
}

static csm_result find(const void *self, uint32_t source, uint32_t cascade, technique_image *out) {
  const moments_state *state = self;
  if (source != CSM_READ_MOMENTS || !state->now.device)
    return CSM_ERROR_UNSUPPORTED;
  const moment_image *image = state->now.image;
  if (!image->begun)
    return CSM_ERROR_INVALID_STATE;
  const uint32_t side = image->shape.sides[cascade];
  *out = (technique_image){.image = image->image,
                           .format = image->format,
                           .width = image->shape.side,
                           .height = image->shape.side,
                           .layer = cascade * image->shape.depth_layers,
                           .layers = image->shape.depth_layers,
                           .levels = image->shape.levels,
                           .part = {.width = side, .height = side}};
  return CSM_SUCCESS;
}

gpu_image *moments_image(const technique_set *cascades, const csm_config *config) {
  const moments_state *state = technique_state(cascades, &technique_moments);
  return plan_has_moments(config) ? state->now.image->image : NULL;
}

const technique technique_moments = {
    .name = "moments",
    .state_size = sizeof(moments_state),
    .wanted = wanted,
    .make = make,
    .adopt = adopt,
    .bytes = bytes,
    .forget = forget,
    .drop = drop,
    .size = size,
    .reserve = reserve,
    .write = write,
    .record = record,
    .bind = bind,
    .tell = tell,
    .find = find,
};
