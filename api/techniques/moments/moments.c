#include "techniques/moments/moments.h"

#include "csm_constants.h"
#include "shader_code.h"
#include "techniques/inputs.h"
#include "techniques/maps/maps.h"

#include <string.h>

enum { MAX_LAYERS = CSM_MAX_CASCADES * 4, SETTINGS_BLOCK = 1280, LAYER_BLOCK = 256 };
_Static_assert(sizeof(csm_constants) <= SETTINGS_BLOCK, "SETTINGS_BLOCK");

/* The image that a configuration's moments lie in. */
typedef struct moment_image {
  retired retired;
  gpu_image *image;
  gpu_target *targets[MAX_LAYERS];
  plan_moments shape;
  gpu_format format;
  uint32_t layers;
  bool drawn;
} moment_image;

typedef struct moment_objects {
  device *device; /* NULL: nothing */
  moment_image *image;
  gpu_program *program;
} moment_objects;

typedef struct moments_state {
  moment_objects now, fresh;
  inputs inputs;
  double gpu_ms;
  /* of the recording on its way */
  ring_range ring;
  input *input;
} moments_state;

/* ---- images ---- */

static void image_free(device *device, retired *self) {
  moment_image *image = (moment_image *)self;
  for (uint32_t i = 0; i < image->layers; ++i)
    gpu_target_destroy(device->gpu, image->targets[i]);
  device_image_free(device, image->image);
  host_release(device->host, image);
}

static gpu_format format_of(const plan_moments *shape, const csm_config *config) {
  static const gpu_format formats[2][3] = {
      {GPU_FORMAT_R32_FLOAT, GPU_FORMAT_RG32_FLOAT, GPU_FORMAT_RGBA32_FLOAT},
      {GPU_FORMAT_R16_FLOAT, GPU_FORMAT_RG16_FLOAT, GPU_FORMAT_RGBA16_FLOAT},
  };
  return formats[config->moment_format == CSM_MOMENTS_FLOAT16][shape->channels / 2];
}

static csm_result image_create(device *device, const plan_moments *shape, const csm_config *config,
                               moment_image **out) {
  moment_image *image = host_allocate(device->host, sizeof *image);
  if (!image)
    return CSM_ERROR_OUT_OF_MEMORY;
  image->shape = *shape;
  image->format = format_of(shape, config);
  const gpu_image_info info = {
      .name = "moments",
      .format = image->format,
      .usage = GPU_IMAGE_TARGET | GPU_IMAGE_SAMPLED | GPU_IMAGE_COPY_SOURCE,
      .width = shape->side,
      .height = shape->side,
      .layers = config->cascade_count * shape->depth_layers,
      .array = true,
  };
  csm_result result = device_image(device, &info, &image->image);
  for (uint32_t i = 0; i < info.layers && !result; ++i) {
    const gpu_target_info target = {.name = "moments", .color = image->image, .color_layer = i};
    result = device_check(device, gpu_target_create(device->gpu, &target, &image->targets[i]), "moments");
    image->layers += !result;
  }
  if (result) {
    image_free(device, &image->retired);
    return result;
  }
  *out = image;
  return CSM_SUCCESS;
}

/* ---- programs ---- */

typedef struct program_about {
  uint64_t filter, format;
} program_about;

static csm_result make_program(gpu gpu, const void *about, gpu_program **out) {
  const program_about *of = about;
  const gpu_program_info info = {
      .name = "moments",
      .vertex = shader_screen_vs,
      .pixel = *shader_find(shader_key_moments((int32_t)of->filter)),
      .constants_count = 2,
      .constants_sizes = {SETTINGS_BLOCK, LAYER_BLOCK},
      .texture_count = 1,
      .color_format = (gpu_format)of->format,
      .cull = GPU_CULL_NONE,
  };
  return gpu_program_create(gpu, &info, out);
}

static csm_result find_program(device *device, const csm_config *config, gpu_format format, gpu_program **out) {
  const program_about about = {.filter = config->filter == CSM_FILTER_VSSM ? CSM_FILTER_VSM : config->filter,
                               .format = format};
  const program_key key = {
      .make = make_program, .name = "a program for moments", .about = &about, .size = sizeof about};
  return programs_find(device, &key, out);
}

/* ---- settings and devices ---- */

static csm_result make(void *self, device *device, const csm_config *config) {
  moments_state *state = self;
  moment_objects made = {.device = device};
  plan_moments shape;
  plan_moments_make(&shape, config);
  csm_result result = find_program(device, config, format_of(&shape, config), &made.program);
  if (!result)
    result = image_create(device, &shape, config, &made.image);
  if (!result)
    state->fresh = made;
  return result;
}

static void drop(void *self, device *device) {
  moments_state *state = self;
  recording_forget_timing(device, state);
  state->gpu_ms = -1;
  if (!state->now.device)
    return;
  inputs_drop(&state->inputs, device);
  retire(device, &state->now.image->retired, image_free);
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
  image_free(device, &state->fresh.image->retired);
  state->fresh = (moment_objects){0};
}

/* ---- a frame ---- */

static uint64_t size(const void *self, const technique_run *run) {
  const moments_state *state = self;
  (void)run;
  return SETTINGS_BLOCK + (uint64_t)state->now.image->layers * LAYER_BLOCK;
}

static csm_result reserve(void *self, technique_run *run, const ring_range *ring) {
  moments_state *state = self;
  state->ring = *ring;
  const gpu_bindings_info reads = {.name = "moments",
                                   .program = state->now.program,
                                   .constants = {ring->buffer, ring->buffer},
                                   .textures = {maps_image(run->cascades)}};
  return inputs_find(&state->inputs, run->device, &reads, &state->input);
}

static void write(void *self, const technique_run *run) {
  const moments_state *state = self;
  const moment_image *image = state->now.image;
  char *blocks = state->ring.memory;
  memcpy(blocks, run->constants, run->constants_size);
  for (uint32_t i = 0; i < image->layers; ++i) {
    const float layer[4] = {(float)(i / image->shape.depth_layers), (float)(i % image->shape.depth_layers)};
    memcpy(blocks + SETTINGS_BLOCK + i * LAYER_BLOCK, layer, sizeof layer);
  }
}

static void take_timing(void *self, const uint64_t *stamps, uint32_t count) {
  moments_state *state = self;
  (void)count;
  state->gpu_ms = (double)(stamps[1] - stamps[0]) * 1e-6;
}

static void record(void *self, const technique_run *run) {
  moments_state *state = self;
  const gpu gpu = run->device->gpu;
  moment_image *image = state->now.image;
  gpu_bindings *bindings = inputs_use(state->input, run->device);
  const timing_sink sink = {.take = take_timing, .user = state};
  const uint32_t settings = (uint32_t)state->ring.offset;
  uint32_t first = 0;
  const bool timed = run->timestamps && recording_expect_timing(run->device, &sink, 2, &first);
  if (timed)
    gpu_timestamp(gpu, first);
  gpu_marker_begin(gpu, "moments");
  for (uint32_t i = 0; i < image->layers; ++i) {
    const uint32_t side = image->shape.sides[i / image->shape.depth_layers];
    gpu_pass_begin(gpu, &(gpu_pass_info){.target = image->targets[i],
                                         .color_load = GPU_LOAD_DISCARD,
                                         .area = {.width = side, .height = side}});
    gpu_pass_program(gpu, state->now.program);
    gpu_pass_bind(gpu, bindings, (const uint32_t[]){settings, settings + SETTINGS_BLOCK + i * LAYER_BLOCK});
    gpu_pass_draw(gpu, &(gpu_draw){.count = 3, .instance_count = 1});
    gpu_pass_end(gpu);
  }
  gpu_make_readable(gpu, image->image, NULL);
  gpu_marker_end(gpu);
  if (timed)
    gpu_timestamp(gpu, first + 1);
  image->drawn = true;
}

/* ---- what came of it ---- */

static bool wanted(const csm_config *config) {
  return plan_has_moments(config);
}

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
  stats->moments_gpu_ms = state->now.device ? state->gpu_ms : -1;
  stats->moment_bytes = state->now.device ? gpu_image_bytes(device->gpu, state->now.image->image) : 0;
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
    .forget = forget,
    .drop = drop,
    .size = size,
    .reserve = reserve,
    .write = write,
    .record = record,
    .bind = bind,
    .tell = tell,
};
