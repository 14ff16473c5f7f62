#include "techniques/mask/mask.h"

#include "csm_constants.h"
#include "techniques/drawn_image.h"
#include "techniques/engine_image.h"
#include "techniques/history/history.h"
#include "techniques/inputs.h"
#include "techniques/maps/maps.h"
#include "techniques/mask/mask_programs.h"
#include "techniques/moments/moments.h"
#include "techniques/pass_timer.h"
#include "techniques/ranges/ranges.h"

#include <string.h>

enum { BLOCKS = MASK_CASCADES_BLOCK + MASK_CAMERA_BLOCK };
_Static_assert(sizeof(csm_constants) <= MASK_CASCADES_BLOCK, "MASK_CASCADES_BLOCK");
_Static_assert(CSM_M_COUNT * 4 * sizeof(float) <= MASK_CAMERA_BLOCK, "MASK_CAMERA_BLOCK");

/* Shapes of programs, by the samplers that they have. */
enum { MASK_PLAIN, MASK_MOMENTS, MASK_LEVELS, MASK_PAGES, MASK_RANGES, MASK_SHAPES };

typedef struct mask_state {
  drawn_images mask, frame;      /* frame: one of the view's history, which has the mask then */
  inputs inputs[2][MASK_SHAPES]; /* without and with normals */
  bool accumulated;              /* the frame was drawn last */
  pass_timer timer;
  /* of the recording on its way */
  ring_range ring;
  gpu_program *program;
  input *input;
  plan_grain rounding; /* of what normals come from */
} mask_state;

static bool wanted(const csm_config *config) {
  (void)config;
  return true;
}

static uint64_t size(const void *self, const technique_run *run) {
  (void)self;
  (void)run;
  return BLOCKS;
}

/* The engine's normals. */
static csm_result import(device *device, const technique_picture *picture, engine_imported *out) {
  const engine_image from = {.native = picture->engines_normals,
                             .name = "csm_mask_info: normals",
                             .texels = GPU_TEXELS_NORMALS,
                             .width = picture->width,
                             .height = picture->height};
  return engine_image_import(device, &from, out);
}

/* What a picture is drawn into. */
static drawn_images *images_of(mask_state *state, const technique_run *run) {
  return history_takes(run->config, run->picture) ? &state->frame : &state->mask;
}

static csm_result reserve(void *self, technique_run *run, const ring_range *ring) {
  mask_state *state = self;
  device *device = run->device;
  technique_picture *picture = run->picture;
  const uint32_t show = history_takes(run->config, picture) ? CSM_SHOW_VISIBILITY : picture->show;
  engine_imported normals = {0};
  state->ring = *ring;
  drawn_images *images = images_of(state, run);
  const gpu_image_info image = {.name = "mask",
                                .format = mask_format(run->config, show),
                                .usage = plan_has_rays(run->config) ? GPU_IMAGE_STORED : 0u,
                                .width = picture->width,
                                .height = picture->height};
  csm_result result = drawn_image_reserve(images, device, &image);
  if (!result)
    result = import(device, picture, &normals);
  if (show != CSM_SHOW_VISIBILITY && show != CSM_SHOW_RAYS)
    normals = (engine_imported){0}; /* checked all the same */
  if (!result)
    result = mask_program(device, run->config, normals.image, show, &state->program);
  if (result)
    return result;
  gpu_image *moments = mask_reads_moments(run->config, show) ? moments_image(run->cascades, run->config) : NULL;
  gpu_image *ranges = mask_reads_ranges(run->config, show) ? ranges_image(run->cascades, run->config) : NULL;
  gpu_image *more = moments ? moments : ranges;
  const uint32_t shape = plan_has_pages(run->config)      ? MASK_PAGES
                         : ranges                         ? MASK_RANGES
                         : !moments                       ? MASK_PLAIN
                         : run->config->moment_levels > 1 ? MASK_LEVELS
                                                          : MASK_MOMENTS;
  picture->normals = normals;
  picture->mask_constants = *ring;
  picture->mask = drawn_image_next(images)->image;
  picture->mask_stores = drawn_image_next(images)->stores;
  state->rounding = normals.image ? normals.rounding : picture->depth_rounding;
  const gpu_bindings_info reads = {
      .name = "mask",
      .program = state->program,
      .constants = {ring->buffer, ring->buffer},
      .textures = {maps_image(run->cascades), picture->depth, more ? more : normals.image, more ? normals.image : NULL},
  };
  return inputs_find(&state->inputs[normals.image != NULL][shape], device, &reads, &state->input);
}

static void write(void *self, const technique_run *run) {
  const mask_state *state = self;
  const technique_picture *picture = run->picture;
  char *blocks = state->ring.memory;
  memcpy(blocks, run->constants, run->constants_size);
  if (history_takes(run->config, picture))
    plan_write_phase((float *)blocks, history_phase(run->view), run->config);
  plan_write_mask_constants((float *)(blocks + MASK_CASCADES_BLOCK), run->plan,
                            &(plan_picture){.camera = picture->depth_camera,
                                            .width = picture->width,
                                            .height = picture->height,
                                            .show = picture->show,
                                            .normals = picture->normals.image != NULL,
                                            .unorm_normals = picture->normals.unorm,
                                            .rounding = state->rounding,
                                            .depth_rounding = picture->depth_rounding},
                            run->config);
}

static void adopt(void *self, device *from) {
  mask_state *state = self;
  drawn_image_adopt(&state->mask, from);
  drawn_image_adopt(&state->frame, from);
}

static void forget(void *self, device *device) {
  mask_state *state = self;
  drawn_image_forget(&state->mask, device);
  drawn_image_forget(&state->frame, device);
}

static void drop(void *self, device *device) {
  mask_state *state = self;
  pass_timer_drop(&state->timer, device);
  drawn_image_drop(&state->mask, device);
  drawn_image_drop(&state->frame, device);
  for (int normals = 0; normals < 2; ++normals)
    for (int shape = 0; shape < MASK_SHAPES; ++shape)
      inputs_drop(&state->inputs[normals][shape], device);
  state->accumulated = false;
}

static void record(void *self, const technique_run *run) {
  mask_state *state = self;
  const gpu gpu = run->device->gpu;
  const uint32_t offset = (uint32_t)state->ring.offset;
  const uint32_t offsets[] = {offset, offset + MASK_CASCADES_BLOCK};
  drawn_image *into = images_of(state, run)->now;
  pass_timer_begin(&state->timer, run, 1);
  gpu_marker_begin(gpu, "mask");
  gpu_pass_begin(gpu, &(gpu_pass_info){.target = into->target, .color_load = GPU_LOAD_DISCARD});
  gpu_pass_program(gpu, state->program);
  gpu_pass_bind(gpu, inputs_use(state->input, run->device), offsets);
  gpu_pass_draw(gpu, &(gpu_draw){.count = 3, .instance_count = 1});
  gpu_pass_end(gpu);
  gpu_make_readable(gpu, into->image, NULL);
  gpu_marker_end(gpu);
  pass_timer_step(&state->timer, run);
  into->drawn = true;
  state->accumulated = history_takes(run->config, run->picture);
  if (run->config->history == CSM_HISTORY_OFF)
    drawn_image_drop(&state->frame, run->device);
}

static void bind(const void *self, device *device, csm_binding *binding) {
  const mask_state *state = self;
  if (!state->accumulated)
    drawn_image_bind(&state->mask, device, binding);
}

static void tell_view(const void *self, const device *device, csm_view_stats *stats) {
  const mask_state *state = self;
  const drawn_image *mask = (state->accumulated ? &state->frame : &state->mask)->now;
  stats->mask_gpu_ms = pass_timer_ms(&state->timer, 0);
  stats->history_bytes += drawn_image_bytes(&state->frame, device);
  stats->bytes += drawn_image_bytes(&state->mask, device) + drawn_image_bytes(&state->frame, device);
  if (mask && mask->drawn) {
    stats->width = mask->width;
    stats->height = mask->height;
  }
}

static csm_result find(const void *self, uint32_t source, uint32_t cascade, technique_image *out) {
  const mask_state *state = self;
  (void)cascade;
  return source == CSM_READ_MASK && !state->accumulated ? drawn_image_find(&state->mask, out) : CSM_ERROR_UNSUPPORTED;
}

const technique technique_mask = {
    .name = "mask",
    .state_size = sizeof(mask_state),
    .wanted = wanted,
    .adopt = adopt,
    .forget = forget,
    .drop = drop,
    .size = size,
    .reserve = reserve,
    .write = write,
    .record = record,
    .bind = bind,
    .tell_view = tell_view,
    .find = find,
};
