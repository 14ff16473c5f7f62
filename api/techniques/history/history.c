#include "techniques/history/history.h"

#include "csm_history.h"
#include "shader_code.h"
#include "techniques/drawn_image.h"
#include "techniques/engine_image.h"
#include "techniques/inputs.h"
#include "techniques/pass_timer.h"

enum { BLOCK = 256 };
_Static_assert(CSM_H_COUNT * 4 * sizeof(float) <= BLOCK, "BLOCK");

/* What a program is made for. */
enum { WITH_NORMALS = 1u << 0, WITH_MOTION = 1u << 1, TO_MASK = 1u << 2, PROGRAMS };

typedef struct history_state {
  drawn_images images[2]; /* the one that was drawn last is images[last] */
  drawn_images mask;      /* that comes of it */
  uint32_t last;
  plan_past past;   /* what images[last] was drawn for */
  uint32_t frames;  /* that were accumulated, whatever became of them */
  inputs inputs[2]; /* of the history, of the mask */
  pass_timer timer;
  /* of the recording on its way */
  bool runs, goes_on; /* goes_on: there is an earlier frame that counts */
  ring_range ring;
  gpu_program *programs[2];
  input *reads[2];
  plan_past now;
  bool unorm_normals;
} history_state;

static bool wanted(const csm_config *config) {
  return config->history == CSM_HISTORY_ON;
}

bool history_takes(const csm_config *config, const technique_picture *picture) {
  return wanted(config) && (picture->show == CSM_SHOW_VISIBILITY || picture->show == CSM_SHOW_HISTORY);
}

double history_phase(const technique_set *view) {
  const history_state *state = technique_state(view, &technique_history);
  return plan_history_phase(state->frames);
}

/* ---- programs ---- */

static csm_result make_program(gpu gpu, const void *about, gpu_program **out) {
  const uint32_t kind = *(const uint32_t *)about;
  const bool mask = kind == TO_MASK;
  const gpu_code pixels[] = {shader_history_ps, shader_history_normals_ps, shader_history_motion_ps,
                             shader_history_normals_motion_ps, shader_history_mask_ps};
  const gpu_program_info info = {.name = mask ? "history mask" : "history",
                                 .vertex = mask ? shader_screen_vs : shader_history_vs,
                                 .pixel = pixels[kind],
                                 .constants_count = 1,
                                 .constants_sizes = {BLOCK},
                                 .texture_count = mask ? 2 : 5,
                                 .sampler_count = mask ? 0 : 1,
                                 .samplers = {GPU_SAMPLER_POINT_CLAMP},
                                 .color_format = mask ? GPU_FORMAT_R8_UNORM : GPU_FORMAT_RGBA16_FLOAT,
                                 .cull = GPU_CULL_NONE};
  return gpu_program_create(gpu, &info, out);
}

static csm_result find_program(device *device, uint32_t kind, gpu_program **out) {
  const program_key key = {.make = make_program, .name = "a history program", .about = &kind, .size = sizeof kind};
  return programs_find(device, &key, out);
}

/* ---- a picture ---- */

static uint64_t size(const void *self, const technique_run *run) {
  (void)self;
  return history_takes(run->config, run->picture) ? BLOCK : 0;
}

static csm_result reserve_images(history_state *state, device *device, const technique_picture *picture) {
  gpu_image_info info = {
      .name = "history mask", .format = GPU_FORMAT_R8_UNORM, .width = picture->width, .height = picture->height};
  csm_result result = drawn_image_reserve(&state->mask, device, &info);
  info.name = "history";
  info.format = GPU_FORMAT_RGBA16_FLOAT;
  for (int i = 0; i < 2 && !result; ++i)
    result = drawn_image_reserve(&state->images[i], device, &info);
  return result;
}

static csm_result import_motion(device *device, const technique_picture *picture, engine_imported *out) {
  const engine_image from = {.native = picture->engines_motion,
                             .name = "csm_mask_info: motion",
                             .texels = GPU_TEXELS_MOTION,
                             .width = picture->width,
                             .height = picture->height};
  return engine_image_import(device, &from, out);
}

/* Programs, and what they read. What is not there is bound to something that is, and not read. */
static csm_result reserve_reads(history_state *state, technique_run *run, gpu_image *motion) {
  const technique_picture *picture = run->picture;
  gpu_image *normals = picture->normals.image;
  const gpu_image *now = drawn_image_next(&state->images[!state->last])->image;
  const uint32_t kind = (normals ? WITH_NORMALS : 0u) | (motion ? WITH_MOTION : 0u);
  csm_result result = find_program(run->device, kind, &state->programs[0]);
  if (!result)
    result = find_program(run->device, TO_MASK, &state->programs[1]);
  const gpu_bindings_info reads[2] = {
      {.name = "history",
       .program = state->programs[0],
       .constants = {state->ring.buffer},
       .textures = {picture->mask, picture->depth, drawn_image_next(&state->images[state->last])->image,
                    normals ? normals : picture->mask, motion ? motion : picture->mask}},
      {.name = "history mask",
       .program = state->programs[1],
       .constants = {state->ring.buffer},
       .textures = {(gpu_image *)now, picture->mask}}};
  for (int i = 0; i < 2 && !result; ++i)
    result = inputs_find(&state->inputs[i], run->device, &reads[i], &state->reads[i]);
  return result;
}

static csm_result reserve(void *self, technique_run *run, const ring_range *ring) {
  history_state *state = self;
  const technique_picture *picture = run->picture;
  engine_imported motion = {0};
  state->runs = history_takes(run->config, picture);
  state->ring = *ring;
  csm_result result = import_motion(run->device, picture, &motion);
  if (result || !state->runs)
    return result;
  state->now = (plan_past){.camera = *picture->depth_camera,
                           .width = picture->width,
                           .height = picture->height,
                           .shadow_end = run->plan->shadow_end,
                           .settings = run->settings,
                           .changes = run->changes};
  result = reserve_images(state, run->device, picture);
  state->goes_on = !state->images[0].fresh && plan_past_counts(&state->past, &state->now);
  state->unorm_normals = picture->normals.unorm;
  return result ? result : reserve_reads(state, run, motion.image);
}

static void write(void *self, const technique_run *run) {
  const history_state *state = self;
  const technique_picture *picture = run->picture;
  if (state->runs)
    plan_write_history_constants(state->ring.memory, run->plan,
                                 &(plan_picture){.show = picture->show,
                                                 .normals = picture->normals.image != NULL,
                                                 .unorm_normals = state->unorm_normals},
                                 &(plan_passage){.past = state->goes_on ? &state->past : &state->now,
                                                 .now = &state->now,
                                                 .phase = plan_history_phase(state->frames)},
                                 run->config);
}

static void adopt(void *self, device *from) {
  history_state *state = self;
  for (int i = 0; i < 2; ++i)
    drawn_image_adopt(&state->images[i], from);
  drawn_image_adopt(&state->mask, from);
}

static void forget(void *self, device *device) {
  history_state *state = self;
  for (int i = 0; i < 2; ++i)
    drawn_image_forget(&state->images[i], device);
  drawn_image_forget(&state->mask, device);
}

static void drop(void *self, device *device) {
  history_state *state = self;
  pass_timer_drop(&state->timer, device);
  for (int i = 0; i < 2; ++i) {
    drawn_image_drop(&state->images[i], device);
    inputs_drop(&state->inputs[i], device);
  }
  drawn_image_drop(&state->mask, device);
  state->past = (plan_past){0};
  state->frames = 0; /* patterns, too, begin anew */
}

/* ---- recording ---- */

/* A history without frames: no pixel finds anything there. */
static void clear(gpu gpu, const drawn_image *image) {
  gpu_pass_begin(gpu, &(gpu_pass_info){.target = image->target,
                                       .color_load = GPU_LOAD_CLEAR,
                                       .clear_color = {0.0f, (float)CSM_H_NO_FRAMES}});
  gpu_pass_end(gpu);
  gpu_make_readable(gpu, image->image, NULL);
}

static void draw(const history_state *state, device *device, int step, const drawn_image *into) {
  const gpu gpu = device->gpu;
  const uint32_t offset = (uint32_t)state->ring.offset;
  gpu_pass_begin(gpu, &(gpu_pass_info){.target = into->target, .color_load = GPU_LOAD_DISCARD});
  gpu_pass_program(gpu, state->programs[step]);
  gpu_pass_bind(gpu, inputs_use(state->reads[step], device), &offset);
  gpu_pass_draw(gpu, &(gpu_draw){.count = 3, .instance_count = 1});
  gpu_pass_end(gpu);
  gpu_make_readable(gpu, into->image, NULL);
}

static void record(void *self, const technique_run *run) {
  history_state *state = self;
  const gpu gpu = run->device->gpu;
  if (!state->runs) {
    pass_timer_skip(&state->timer, run);
    if (state->mask.now)
      state->mask.now->drawn = false;
    return;
  }
  pass_timer_begin(&state->timer, run, 1);
  gpu_marker_begin(gpu, "history");
  if (!state->goes_on)
    clear(gpu, state->images[state->last].now);
  draw(state, run->device, 0, state->images[!state->last].now);
  draw(state, run->device, 1, state->mask.now);
  gpu_marker_end(gpu);
  pass_timer_step(&state->timer, run);
  state->mask.now->drawn = true;
  state->last = !state->last;
  state->past = state->now;
  ++state->frames;
}

/* ---- what came of it ---- */

static void bind(const void *self, device *device, csm_binding *binding) {
  drawn_image_bind(&((const history_state *)self)->mask, device, binding);
}

static void tell_view(const void *self, const device *device, csm_view_stats *stats) {
  const history_state *state = self;
  uint64_t bytes = drawn_image_bytes(&state->mask, device);
  for (int i = 0; i < 2; ++i)
    bytes += drawn_image_bytes(&state->images[i], device);
  stats->history_gpu_ms = pass_timer_ms(&state->timer, 0);
  stats->history_bytes += bytes;
  stats->bytes += bytes;
}

static csm_result find(const void *self, uint32_t source, uint32_t cascade, technique_image *out) {
  const history_state *state = self;
  (void)cascade;
  const bool drawn = state->mask.now && state->mask.now->drawn;
  return source == CSM_READ_MASK && drawn ? drawn_image_find(&state->mask, out) : CSM_ERROR_UNSUPPORTED;
}

const technique technique_history = {
    .name = "history",
    .state_size = sizeof(history_state),
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
