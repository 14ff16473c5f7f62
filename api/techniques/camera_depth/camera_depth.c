#include "techniques/camera_depth/camera_depth.h"

#include "shader_code.h"
#include "techniques/draw_list.h"
#include "techniques/drawn_image.h"
#include "techniques/engine_image.h"
#include "techniques/pass_timer.h"

enum { ROWS = 4 }; /* float4 rows for each instance's matrix */

/* Programs of a device, by shape. */
typedef struct camera_programs {
  uint32_t shapes;
  gpu_program *programs[DEVICE_MAX_SHAPES];
} camera_programs;

typedef struct camera_depth_state {
  drawn_images depth;              /* NULL as long as the engine brings its own */
  bool reduced;                    /* it was drawn in a reduction */
  plan_camera drawn_with, seen_by; /* the camera that it was drawn with last, and the frame's, for csm_read */
  camera_programs programs;
  ring_range ring; /* of the recording on its way */
  pass_timer timer;
} camera_depth_state;

/* ---- programs ---- */

static csm_result make_program(gpu gpu, const void *about, gpu_program **out) {
  const mesh_vertices *vertices = about;
  const draw_list_kind kind = {.name = "camera depth",
                               .vertex = shader_camera_depth_vs,
                               .cut_out_vertex = shader_camera_depth_alpha_mask_vs,
                               .rows = ROWS,
                               .format = GPU_FORMAT_D32_FLOAT,
                               .compare = GPU_COMPARE_GREATER,
                               .clip = true};
  return draw_list_program(gpu, &kind, *vertices, out);
}

static csm_result extend_programs(device *device, camera_programs *programs) {
  while (programs->shapes < device->shapes.count) {
    const mesh_vertices about = device->shapes.vertices[programs->shapes];
    const program_key key = {
        .make = make_program, .name = "a camera depth program", .about = &about, .size = sizeof about};
    const csm_result result = programs_find(device, &key, &programs->programs[programs->shapes]);
    if (result)
      return result;
    ++programs->shapes;
  }
  return CSM_SUCCESS;
}

/* ---- a picture ---- */

static bool wanted(const csm_config *config) {
  (void)config;
  return true;
}

static uint64_t size(const void *self, const technique_run *run) {
  (void)self;
  return draw_list_bytes(run->picture->seen, ROWS);
}

static csm_result import(device *device, technique_picture *picture) {
  const engine_image from = {.native = picture->engines_depth,
                             .name = "csm_mask_info: camera_depth",
                             .texels = GPU_TEXELS_DEPTH,
                             .width = picture->width,
                             .height = picture->height};
  engine_imported imported;
  const csm_result result = engine_image_import(device, &from, &imported);
  picture->depth = imported.image;
  picture->depth_rounding = imported.rounding;
  return result;
}

static csm_result reserve(void *self, technique_run *run, const ring_range *ring) {
  camera_depth_state *state = self;
  technique_picture *picture = run->picture;
  state->ring = *ring;
  if (picture->engines_depth)
    return import(run->device, picture);
  picture->depth_rounding = (plan_grain){.share = 0x1p-24};
  if (picture->depth_kept) {
    picture->depth = state->depth.now->image;
    return CSM_SUCCESS;
  }
  csm_result result = extend_programs(run->device, &state->programs);
  const gpu_image_info image = {
      .name = "camera depth", .format = GPU_FORMAT_D32_FLOAT, .width = picture->width, .height = picture->height};
  if (!result)
    result = drawn_image_reserve(&state->depth, run->device, &image);
  if (!result)
    picture->depth = drawn_image_next(&state->depth)->image;
  return result;
}

static void write(void *self, const technique_run *run) {
  const camera_depth_state *state = self;
  const technique_picture *picture = run->picture;
  if (picture->seen->instance_count)
    plan_write_view_matrices(state->ring.memory, picture->seen, picture->depth_camera, picture->scene);
}

static void adopt(void *self, device *from) {
  drawn_image_adopt(&((camera_depth_state *)self)->depth, from);
}

static void forget(void *self, device *device) {
  drawn_image_forget(&((camera_depth_state *)self)->depth, device);
}

static void drop(void *self, device *device) {
  camera_depth_state *state = self;
  pass_timer_drop(&state->timer, device);
  drawn_image_drop(&state->depth, device);
  state->programs = (camera_programs){0};
  state->reduced = false;
}

static void draw(const camera_depth_state *state, const technique_run *run) {
  const gpu gpu = run->device->gpu;
  const technique_picture *picture = run->picture;
  const drawn_image *depth = state->depth.now;
  gpu_marker_begin(gpu, "camera depth");
  gpu_clear_depth(gpu, depth->image, (float)plan_clear_depth(picture->depth_camera));
  if (picture->seen->draw_count) {
    gpu_pass_begin(gpu, &(gpu_pass_info){.target = depth->target});
    draw_list(gpu, &(draw_list_info){.programs = {state->programs.programs},
                                     .cull = GPU_CULL_NONE,
                                     .list = picture->seen,
                                     .meshes = run->device->geometry.meshes,
                                     .matrices = state->ring.buffer,
                                     .offset = state->ring.offset,
                                     .rows = ROWS});
    gpu_pass_end(gpu);
  }
  gpu_make_readable(gpu, depth->image, NULL);
  gpu_marker_end(gpu);
}

static void record(void *self, const technique_run *run) {
  camera_depth_state *state = self;
  const bool own = !run->picture->engines_depth;
  if (run->picture->depth_kept)
    return;
  pass_timer_begin(&state->timer, run, 1);
  if (own) {
    draw(state, run);
    state->drawn_with = *run->picture->depth_camera;
    state->seen_by = *run->picture->camera;
  }
  pass_timer_step(&state->timer, run);
  if (state->depth.now)
    state->depth.now->drawn = own;
  state->reduced = own && run->picture->reduces;
}

bool camera_depth_kept(const technique_set *view) {
  const camera_depth_state *state = technique_state(view, &technique_camera_depth);
  return state->reduced;
}

/* ---- what came of it ---- */

static void tell_view(const void *self, const device *device, csm_view_stats *stats) {
  const camera_depth_state *state = self;
  stats->camera_depth_gpu_ms = pass_timer_ms(&state->timer, 0);
  stats->bytes += drawn_image_bytes(&state->depth, device);
}

static csm_result find(const void *self, uint32_t source, uint32_t cascade, technique_image *out) {
  const camera_depth_state *state = self;
  (void)cascade;
  if (source != CSM_READ_CAMERA_DEPTH && source != CSM_READ_VIEW_DEPTH)
    return CSM_ERROR_UNSUPPORTED;
  const csm_result result = drawn_image_find(&state->depth, out);
  out->drawn_with = &state->drawn_with;
  out->read_as = source == CSM_READ_CAMERA_DEPTH ? &state->seen_by : NULL;
  return result;
}

const technique technique_camera_depth = {
    .name = "camera depth",
    .when = TECHNIQUE_BOTH,
    .state_size = sizeof(camera_depth_state),
    .wanted = wanted,
    .adopt = adopt,
    .forget = forget,
    .drop = drop,
    .size = size,
    .reserve = reserve,
    .write = write,
    .record = record,
    .tell_view = tell_view,
    .find = find,
};
