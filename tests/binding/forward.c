/*
 * forward.c: what shaders/include gives in an engine's forward shader is what the mask says, on one backend.
 *
 *   forward BACKEND [--long]
 *
 * BACKEND is a backend's library. A camera sees nothing but a plane, so a shader can tell each pixel's position without
 * the camera's depth; boxes above the view cast on it. Exits with 0 if all holds, else with 1 and what does not.
 */
#include "../tools/gpu_host.h"
#include "csm_constants.h"
#include "forward_code.h"
#include "forward_glsl_0.h"
#include "forward_glsl_1.h"
#include "forward_glsl_2.h"
#include "forward_glsl_3.h"
#include "forward_glsl_4.h"
#include "abi/loader.h"
#include "plan/plan.h"
#include "plane.h"
#include "shader_code.h"
#include "techniques/draw_list.h"
#include "techniques/mask/mask_programs.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 192, HEIGHT = 96, PIXELS = WIDTH * HEIGHT, BOXES = 40, CASCADES = 3, RESOLUTION = 512 };
enum { FILTERS = CSM_FILTER_GRID_17 + 1 };
enum { READERS = 10, PICTURES = 1 + READERS }; /* the mask; what a forward shader gives that reads maps in each way */

/* Which configurations a shader is made for. */
enum { FOR_ALL, FOR_FIXED, FOR_POINTS };

/* GLSL is for Vulkan only. Through comparisons alone there is no bilinear depth. */
static const struct {
  const char *name;
  bool glsl, depths;
  uint32_t made_for;
  uint32_t sampler_count;
  gpu_sampler samplers[2];
} readers[READERS] = {
    {"HLSL, loads", .depths = true},
    {"HLSL, gathers", .depths = true, .sampler_count = 1, .samplers = {GPU_SAMPLER_POINT_CLAMP}},
    {"HLSL, fixed", .depths = true, .made_for = FOR_FIXED},
    {"HLSL, two lights", .depths = true, .sampler_count = 1, .samplers = {GPU_SAMPLER_POINT_CLAMP}},
    {"HLSL, points", .depths = true, .made_for = FOR_POINTS},
    {"GLSL, comparisons", .glsl = true, .sampler_count = 2,
     .samplers = {GPU_SAMPLER_COMPARE_LESS_EQUAL, GPU_SAMPLER_POINT_CLAMP}},
    {"GLSL, depths", .glsl = true, .depths = true, .sampler_count = 2,
     .samplers = {GPU_SAMPLER_COMPARE_LESS_EQUAL, GPU_SAMPLER_POINT_CLAMP}},
    {"GLSL, fixed", .glsl = true, .made_for = FOR_FIXED, .sampler_count = 2,
     .samplers = {GPU_SAMPLER_COMPARE_LESS_EQUAL, GPU_SAMPLER_POINT_CLAMP}},
    {"GLSL, two lights", .glsl = true, .depths = true, .sampler_count = 2,
     .samplers = {GPU_SAMPLER_COMPARE_LESS_EQUAL, GPU_SAMPLER_POINT_CLAMP}},
    {"GLSL, points", .glsl = true, .made_for = FOR_POINTS, .sampler_count = 2,
     .samplers = {GPU_SAMPLER_COMPARE_LESS_EQUAL, GPU_SAMPLER_POINT_CLAMP}},
};

/* What the fixed shaders were made with. */
static const char fixed_defines[] =
    "#define CSM_FILTER 1\n#define CSM_FILTER_TAPS 3\n#define CSM_FILTER_WEIGHTS 0\n#define CSM_EARLY_OUT 0\n"
    "#define CSM_BIAS_MODE 1\n#define CSM_BIAS_UNITS 0\n#define CSM_NORMAL_OFFSET_ON 0\n"
    "#define CSM_NORMAL_OFFSET_MODE 0\n#define CSM_SELECTION 1\n"
    "#define CSM_OUT_OF_RANGE 0\n#define CSM_BLENDING 0\n#define CSM_MAPS_ALIKE 1\n#define CSM_MAPS_REVERSED 0\n"
    "#define CSM_CASCADES 3\n";

/* Where things lie in the upload buffer */
enum {
  AT_GEOMETRY = 0,
  GEOMETRY_BYTES = 1024,
  AT_PLANE = GEOMETRY_BYTES,
  AT_BLOCKS = AT_PLANE + 256,
  AT_VIEW = AT_BLOCKS + MASK_CASCADES_BLOCK + MASK_CAMERA_BLOCK,
  AT_MATRICES = AT_VIEW + 4096,
  MATRICES_BYTES = 4096,
  UPLOAD_BYTES = AT_MATRICES + CASCADES * MATRICES_BYTES,
};
enum { MAP_ROWS = 3, CAMERA_ROWS = 4 }; /* float4 rows for each instance */
_Static_assert((BOXES + 1) * CAMERA_ROWS * 16 <= 4096, "matrices fit");
/* and in the geometry */
enum { AT_BOX = 64, AT_SQUARE_INDICES = 256, AT_BOX_INDICES = 512 };

/* So far out that only positions relative to the constants' origin can be right. */
static const double base[3] = {3e5, 2e4, -7e5};
static const double eye[3] = {3e5 + 2, 2e4 + 8, -7e5 + 4};

static const float square[4][3] = {{-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}};
static const uint16_t square_indices[6] = {0, 2, 1, 0, 3, 2};
static const float box[8][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                                {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};
static const uint16_t box_indices[36] = {0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4,
                                         3, 7, 6, 3, 6, 2, 0, 4, 7, 0, 7, 3, 1, 2, 6, 1, 6, 5};

typedef struct bench {
  gpu gpu;
  uint32_t failures;
  gpu_buffer *upload, *geometry, *readback;
  gpu_image *maps, *depth, *pictures[PICTURES];
  gpu_target *map_targets[CASCADES], *depth_target, *picture_targets[PICTURES];
  gpu_program *cascade_depth, *camera_depth, *mask[2][FILTERS], *forward[READERS];
  bool every;         /* reader with every plan */
  bool fixed, points; /* the plan is one that the shaders of that kind are made for */
  gpu_bindings *mask_bindings, *forward_bindings[READERS];
  plan_instance instances[BOXES + 1];
  plan_box boxes[BOXES + 1];
  plan_scene scene;
  plan_frame frame;
  plan_list view;
  plan_memory frame_memory, view_memory;
} bench;

static bool check(bench *b, bool holds, const char *what) {
  if (!holds) {
    b->failures++;
    fprintf(stderr, "does not hold: %s\n", what);
  }
  return holds;
}

/* ---- the host's side ---- */

static void CSM_CALL message(void *user, int32_t level, const char *text) {
  bench *b = user;
  b->failures += level <= CSM_LOG_WARNING;
  fprintf(stderr, "log %d: %s\n", level, text);
}

/* ---- scene and camera ---- */

static double between(uint32_t *random, double low, double high) {
  *random = *random * 1664525u + 1013904223u;
  return low + (high - low) * (double)(*random >> 8) / 16777216.0;
}

static plan_instance place(uint32_t mesh, const double at[3], double sx, double sy, double sz) {
  return (plan_instance){
      .mesh = mesh, .transform = {sx, 0, 0, base[0] + at[0], 0, sy, 0, base[1] + at[1], 0, 0, sz, base[2] + at[2]}};
}

static void make_scene(bench *b) {
  static const plan_bounds bounds[2] = {{.extent = {1, 0, 1}}, {.extent = {1, 1, 1}}};
  uint32_t random = 1;
  b->instances[0] = place(0, (const double[]){0, 0, 0}, 200, 1, 200);
  for (uint32_t i = 1; i <= BOXES; ++i) {
    const double at[3] = {between(&random, -25, 15), between(&random, 10, 16), between(&random, -50, 0)};
    b->instances[i] = place(1, at, between(&random, 0.1, 1.5), between(&random, 0.1, 1.0), between(&random, 0.1, 1.5));
  }
  for (uint32_t i = 0; i <= BOXES; ++i) {
    check(b, plan_instance_check(&b->instances[i]) == CSM_SUCCESS, "instances are sound");
    plan_instance_box(&b->boxes[i], &b->instances[i], &bounds[b->instances[i].mesh]);
  }
  b->scene = (plan_scene){.instances = b->instances,
                          .boxes = b->boxes,
                          .slot_count = BOXES + 1,
                          .caster_count = BOXES + 1,
                          .receiver_count = BOXES + 1,
                          .meshes = bounds,
                          .mesh_count = 2};
}

/* Looks along -z, 35 degrees down; reversed-Z, without a far plane. */
static void make_camera(double view[16], double projection[16]) {
  const double down = 35 * 0.017453292519943295, c = cos(down), s = sin(down);
  const double rows[3][3] = {{1, 0, 0}, {0, c, -s}, {0, s, c}};
  memset(view, 0, 16 * sizeof *view);
  for (int row = 0; row < 3; ++row)
    for (int k = 0; k < 3; ++k) {
      view[k * 4 + row] = rows[row][k];
      view[12 + row] -= rows[row][k] * eye[k];
    }
  view[15] = 1;
  memset(projection, 0, 16 * sizeof *projection);
  projection[5] = 1 / tan(25 * 0.017453292519943295);
  projection[0] = projection[5] * HEIGHT / WIDTH;
  projection[11] = -1;
  projection[14] = 0.5;
}

static csm_config make_config(uint32_t filter, uint32_t bias_mode, bool sloped) {
  csm_config config = {.struct_size = sizeof config};
  plan_config_default(&config);
  config.cascade_count = CASCADES;
  config.resolution = RESOLUTION;
  config.shadow_distance = 40;
  config.filter = filter;
  config.bias_mode = bias_mode;
  if (!sloped) {
    config.bias_slope_texels = 0.0;
    config.bias_constant_texels = 4.0; /* or all is acne */
  }
  return config;
}

/* What the fixed shaders were made with is what is asked for. */
static void check_defines(bench *b, const csm_config *config) {
  char text[sizeof fixed_defines + 8] = "";
  b->fixed = false;
  if (config->filter != CSM_FILTER_PCF_3X3 || config->bias_mode != CSM_BIAS_RECEIVER_PLANE)
    return;
  check(b, plan_shader_defines(config, NULL, 0) == sizeof fixed_defines, "the defines' size can be asked");
  check(b, plan_shader_defines(config, text, 9) == sizeof fixed_defines && !strcmp(text, "#define "),
        "no more is written");
  check(b, plan_shader_defines(config, text, sizeof text) == sizeof fixed_defines && !strcmp(text, fixed_defines),
        "the defines are those that the fixed shaders were made with");
  b->fixed = true;
}

static bool make_plan(bench *b, const csm_config *config) {
  check_defines(b, config);
  b->points = config->bias_mode == CSM_BIAS_SLOPE && config->bias_slope_texels == 0.0;
  double view[16], projection[16];
  const char *error = "";
  make_camera(view, projection);
  const plan_frame_info info = {.config = config,
                                .view = view,
                                .projection = projection,
                                .light = (const double[]){0.4, -1, 0.25},
                                .scene = &b->scene};
  if (plan_frame_make(&b->frame, &info, &b->frame_memory, &error))
    return check(b, false, error);
  (void)plan_view_make(&b->view, &b->frame.camera, &b->scene, NULL, &b->view_memory);
  check(b, b->view.instance_count == 1, "the camera sees the plane alone");

  char *upload = b->gpu.api->buffer_memory(b->upload);
  plane_rows((float *)(upload + AT_PLANE), view, projection, base[1] - eye[1], WIDTH, HEIGHT);
  plan_write_constants((float *)(upload + AT_BLOCKS), &b->frame, config);
  plan_write_mask_constants((float *)(upload + AT_BLOCKS + MASK_CASCADES_BLOCK), &b->frame,
                            &(plan_picture){.camera = &b->frame.camera, .width = WIDTH, .height = HEIGHT}, config);
  plan_write_view_matrices((float *)(upload + AT_VIEW), &b->view, &b->frame.camera, &b->scene);
  for (uint32_t i = 0; i < CASCADES; ++i)
    plan_write_window_matrices((float *)(upload + AT_MATRICES + i * MATRICES_BYTES), &b->frame, i, &b->scene);
  return true;
}

/* ---- objects ---- */

static csm_result make_buffers(bench *b) {
  const gpu_backend *api = b->gpu.api;
  const gpu_buffer_info infos[] = {{"upload", GPU_BUFFER_UPLOAD, UPLOAD_BYTES, 0},
                                   {"geometry", GPU_BUFFER_DEVICE, GEOMETRY_BYTES, 0},
                                   {"readback", GPU_BUFFER_READBACK, PICTURES * PIXELS, 0}};
  gpu_buffer **buffers[] = {&b->upload, &b->geometry, &b->readback};
  for (uint32_t i = 0; i < 3; ++i)
    if (api->buffer_create(b->gpu.device, &infos[i], buffers[i]))
      return CSM_ERROR_DEVICE;
  char *upload = api->buffer_memory(b->upload);
  memcpy(upload, square, sizeof square);
  memcpy(upload + AT_BOX, box, sizeof box);
  memcpy(upload + AT_SQUARE_INDICES, square_indices, sizeof square_indices);
  memcpy(upload + AT_BOX_INDICES, box_indices, sizeof box_indices);
  return CSM_SUCCESS;
}

static csm_result make_images(bench *b) {
  const gpu_backend *api = b->gpu.api;
  gpu_device *device = b->gpu.device;
  const uint32_t read = GPU_IMAGE_TARGET | GPU_IMAGE_SAMPLED, copy = read | GPU_IMAGE_COPY_SOURCE;
  csm_result result = api->image_create(
      device, &(gpu_image_info){"maps", GPU_FORMAT_D32_FLOAT, read, RESOLUTION, RESOLUTION, CASCADES, true, 1},
      &b->maps);
  for (uint32_t i = 0; i < CASCADES && !result; ++i)
    result = api->target_create(device, &(gpu_target_info){.name = "map", .depth = b->maps, .depth_layer = i},
                                &b->map_targets[i]);
  if (!result)
    result = api->image_create(
        device, &(gpu_image_info){"depth", GPU_FORMAT_D32_FLOAT, read, WIDTH, HEIGHT, 1, false, 1}, &b->depth);
  if (!result)
    result = api->target_create(device, &(gpu_target_info){.name = "depth", .depth = b->depth}, &b->depth_target);
  for (uint32_t i = 0; i < PICTURES && !result; ++i) {
    result = api->image_create(
        device, &(gpu_image_info){"picture", GPU_FORMAT_R8_UNORM, copy, WIDTH, HEIGHT, 1, false, 1}, &b->pictures[i]);
    if (!result)
      result = api->target_create(device, &(gpu_target_info){.name = "picture", .color = b->pictures[i]},
                                  &b->picture_targets[i]);
  }
  return result;
}

/* *out stays NULL where the device does not take the language. */
static csm_result make_forward(bench *b, uint32_t reader, gpu_program **out) {
  const gpu_code codes[READERS] = {
      shader_forward_ps,
      shader_forward_gathers_ps,
      shader_forward_fixed_ps,
      shader_forward_two_ps,
      shader_forward_point_ps,
      {.spirv = forward_glsl_0, .spirv_size = sizeof forward_glsl_0},
      {.spirv = forward_glsl_1, .spirv_size = sizeof forward_glsl_1},
      {.spirv = forward_glsl_2, .spirv_size = sizeof forward_glsl_2},
      {.spirv = forward_glsl_3, .spirv_size = sizeof forward_glsl_3},
      {.spirv = forward_glsl_4, .spirv_size = sizeof forward_glsl_4},
  };
  if (readers[reader].glsl && strcmp(b->gpu.api->name, "vulkan"))
    return CSM_SUCCESS;
  const gpu_program_info info = {
      .name = readers[reader].name,
      .vertex = shader_screen_vs,
      .pixel = codes[reader],
      .constants_count = 2,
      .constants_sizes = {MASK_CASCADES_BLOCK, 64},
      .texture_count = 1,
      .sampler_count = readers[reader].sampler_count,
      .samplers = {readers[reader].samplers[0], readers[reader].samplers[1]},
      .color_format = GPU_FORMAT_R8_UNORM,
      .cull = GPU_CULL_NONE,
  };
  const csm_result result = b->gpu.api->program_create(b->gpu.device, &info, out);
  if (result)
    return result;
  const gpu_bindings_info inputs = {
      .name = "forward", .program = *out, .constants = {b->upload, b->upload}, .textures = {b->maps}};
  return b->gpu.api->bindings_create(b->gpu.device, &inputs, &b->forward_bindings[reader]);
}

static csm_result make_mask(bench *b, uint32_t filter, uint32_t bias) {
  const csm_config config = make_config(filter, bias, true);
  return mask_program_create(b->gpu, &config, false, false, &b->mask[bias][filter]);
}

static csm_result make_programs(bench *b) {
  const draw_list_kind maps = {.name = "cascade depth",
                               .vertex = shader_cascade_depth_vs,
                               .rows = MAP_ROWS,
                               .format = GPU_FORMAT_D32_FLOAT,
                               .compare = GPU_COMPARE_LESS};
  const draw_list_kind camera = {.name = "camera depth",
                                 .vertex = shader_camera_depth_vs,
                                 .rows = CAMERA_ROWS,
                                 .format = GPU_FORMAT_D32_FLOAT,
                                 .compare = GPU_COMPARE_GREATER,
                                 .clip = true};
  csm_result result = draw_list_program(b->gpu, &maps, (mesh_vertices){.stride = 12}, &b->cascade_depth);
  if (!result)
    result = draw_list_program(b->gpu, &camera, (mesh_vertices){.stride = 12}, &b->camera_depth);
  for (uint32_t filter = 0; filter < FILTERS && !result; ++filter)
    for (uint32_t bias = 0; bias < 2 && !result; ++bias)
      if (!bias || filter != CSM_FILTER_LINEAR_DEPTH)
        result = make_mask(b, filter, bias);
  if (!result) {
    const gpu_bindings_info inputs = {
        .name = "mask", .program = b->mask[0][0], .constants = {b->upload, b->upload}, .textures = {b->maps, b->depth}};
    result = b->gpu.api->bindings_create(b->gpu.device, &inputs, &b->mask_bindings);
  }
  for (uint32_t reader = 0; reader < READERS && !result; ++reader)
    result = make_forward(b, reader, &b->forward[reader]);
  return result;
}

static void free_objects(bench *b) {
  const gpu_backend *api = b->gpu.api;
  gpu_device *device = b->gpu.device;
  api->bindings_destroy(device, b->mask_bindings);
  for (uint32_t i = 0; i < READERS; ++i) {
    api->bindings_destroy(device, b->forward_bindings[i]);
    api->program_destroy(device, b->forward[i]);
  }
  for (uint32_t i = 0; i < FILTERS; ++i)
    for (uint32_t bias = 0; bias < 2; ++bias)
      api->program_destroy(device, b->mask[bias][i]);
  api->program_destroy(device, b->cascade_depth);
  api->program_destroy(device, b->camera_depth);
  for (uint32_t i = 0; i < CASCADES; ++i)
    api->target_destroy(device, b->map_targets[i]);
  api->target_destroy(device, b->depth_target);
  for (uint32_t i = 0; i < PICTURES; ++i) {
    api->target_destroy(device, b->picture_targets[i]);
    api->image_destroy(device, b->pictures[i]);
  }
  api->image_destroy(device, b->maps);
  api->image_destroy(device, b->depth);
  api->buffer_destroy(device, b->upload);
  api->buffer_destroy(device, b->geometry);
  api->buffer_destroy(device, b->readback);
}

/* ---- drawing ---- */

/* A pass over the whole of a picture, which is then read back. */
static void record_picture(bench *b, uint32_t picture, gpu_program *program, gpu_bindings *bindings, uint32_t second) {
  const gpu gpu = b->gpu;
  gpu_pass_begin(gpu, &(gpu_pass_info){.target = b->picture_targets[picture], .color_load = GPU_LOAD_DISCARD});
  gpu_pass_program(gpu, program);
  gpu_pass_bind(gpu, bindings, (const uint32_t[]){AT_BLOCKS, second});
  gpu_pass_draw(gpu, &(gpu_draw){.count = 3, .instance_count = 1});
  gpu_pass_end(gpu);
  gpu_copy_image(gpu, b->readback, (uint64_t)picture * PIXELS, WIDTH, b->pictures[picture],
                 &(gpu_region){.width = WIDTH, .height = HEIGHT});
}

static void record_list(bench *b, gpu_target *target, float clear, const draw_list_info *list) {
  gpu_pass_begin(b->gpu, &(gpu_pass_info){.target = target, .depth_load = GPU_LOAD_CLEAR, .clear_depth = clear});
  draw_list(b->gpu, list);
  gpu_pass_end(b->gpu);
}

static void record_depths(bench *b) {
  const mesh_place meshes[2] = {
      {.vertices = b->geometry,
       .indices = b->geometry,
       .index_offset = AT_SQUARE_INDICES,
       .index_count = 6,
       .index_size = 2},
      {.vertices = b->geometry,
       .indices = b->geometry,
       .vertex_offset = AT_BOX,
       .index_offset = AT_BOX_INDICES,
       .index_count = 36,
       .index_size = 2},
  };
  draw_list_info list = {.programs = {&b->cascade_depth}, .meshes = meshes, .matrices = b->upload, .rows = MAP_ROWS};
  for (uint32_t i = 0; i < CASCADES; ++i) {
    list.list = &b->frame.windows[i].list;
    list.offset = AT_MATRICES + i * MATRICES_BYTES;
    record_list(b, b->map_targets[i], 1.0f, &list);
  }
  list.programs[0] = &b->camera_depth;
  list.list = &b->view;
  list.offset = AT_VIEW;
  list.rows = CAMERA_ROWS;
  record_list(b, b->depth_target, 0.0f, &list);
  gpu_make_readable(b->gpu, b->maps, NULL);
  gpu_make_readable(b->gpu, b->depth, NULL);
}

/* Whether the reader's shader is there, and is made for the plan. The short form has a reader that follows any plan see each
   filter with one of the biases, in turn. */
static bool applies(const bench *b, const csm_config *config, uint32_t reader) {
  const uint32_t made_for = readers[reader].made_for, filter = config->filter;
  const bool both = b->every || b->fixed || b->points || filter == CSM_FILTER_LINEAR_DEPTH;
  if (!both && made_for == FOR_ALL && (filter + reader) % 2 != config->bias_mode)
    return false;
  return b->forward[reader] && (filter != CSM_FILTER_LINEAR_DEPTH || readers[reader].depths) &&
         (made_for != FOR_FIXED || b->fixed) && (made_for != FOR_POINTS || b->points);
}

static csm_result draw(bench *b, const csm_config *config) {
  const csm_result result = gpu_begin(b->gpu, &(gpu_record_info){.slot = 0, .first = true});
  if (result)
    return result;
  gpu_copy_buffer(b->gpu, b->geometry, 0, b->upload, AT_GEOMETRY, GEOMETRY_BYTES);
  record_depths(b);
  record_picture(b, 0, b->mask[config->bias_mode][config->filter], b->mask_bindings, AT_BLOCKS + MASK_CASCADES_BLOCK);
  for (uint32_t reader = 0; reader < READERS; ++reader)
    if (applies(b, config, reader))
      record_picture(b, 1 + reader, b->forward[reader], b->forward_bindings[reader], AT_PLANE);
  const csm_result ended = gpu_end(b->gpu);
  return ended ? ended : gpu_wait(b->gpu, 0);
}

/* ---- comparing ---- */

static uint32_t differing(const uint8_t *a, const uint8_t *b, int more_than, int *largest) {
  uint32_t count = 0;
  *largest = 0;
  for (uint32_t i = 0; i < PIXELS; ++i) {
    const int apart = abs((int)a[i] - (int)b[i]);
    count += apart > more_than;
    *largest = apart > *largest ? apart : *largest;
  }
  return count;
}

/* The contract's tolerance: 1/255 on all but 0.01 % of the pixels. */
static void compare_forward(bench *b, uint32_t filter, uint32_t bias_mode, uint32_t reader) {
  const uint8_t *mask = b->gpu.api->buffer_memory(b->readback);
  int largest;
  const uint8_t *picture = mask + (1 + (size_t)reader) * PIXELS;
  const uint32_t any = differing(mask, picture, 0, &largest), wrong = differing(mask, picture, 1, &largest);
  printf("%s, filter %u, bias %u, %s: %u pixels differ, %u by more than 1/255, at most %d/255\n", b->gpu.api->name,
         filter, bias_mode, readers[reader].name, any, wrong, largest);
  check(b, wrong <= PIXELS / 10000, "forward is within 1/255 of the mask on all but 0.01 % of the pixels");
}

/* There is something to compare: lit, shadowed and, but where one comparison is all, between. */
static void check_mask(bench *b, uint32_t filter) {
  const uint8_t *mask = b->gpu.api->buffer_memory(b->readback);
  uint32_t lit = 0, dark = 0;
  for (uint32_t i = 0; i < PIXELS; ++i) {
    lit += mask[i] == 255;
    dark += mask[i] == 0;
  }
  const bool once = filter == CSM_FILTER_NEAREST || filter == CSM_FILTER_LINEAR_DEPTH;
  const uint32_t between = PIXELS - lit - dark;
  printf("%u lit, %u dark, %u between\n", lit, dark, between);
  check(b, lit > PIXELS / 5 && dark > PIXELS / 40 && (once ? !between : between > PIXELS / 200),
        "the mask has shadows");
}

static void compare_filter(bench *b, const csm_config *config, uint8_t *mask) {
  const uint32_t filter = config->filter, bias_mode = config->bias_mode;
  if (!make_plan(b, config) || !check(b, draw(b, config) == CSM_SUCCESS, "drawing"))
    return;
  check_mask(b, filter);
  for (uint32_t reader = 0; reader < READERS; ++reader)
    if (applies(b, config, reader))
      compare_forward(b, filter, bias_mode, reader);
  memcpy(mask, b->gpu.api->buffer_memory(b->readback), PIXELS);
}

static void compare_with(bench *b, uint32_t filter, uint32_t bias_mode, bool sloped, uint8_t *mask) {
  const csm_config config = make_config(filter, bias_mode, sloped);
  compare_filter(b, &config, mask);
}

/* No filter is drawn in place of another. */
static void compare_masks(bench *b, uint8_t masks[FILTERS][PIXELS]) {
  int largest;
  for (uint32_t i = 0; i < FILTERS; ++i)
    for (uint32_t k = 0; k < i; ++k)
      check(b, differing(masks[i], masks[k], 1, &largest) > PIXELS / 500, "the filters can be told apart");
}

static void run(bench *b) {
  static uint8_t masks[2][FILTERS][PIXELS];
  make_scene(b);
  b->frame_memory =
      (plan_memory){.at = test_allocate(NULL, plan_memory_size(BOXES + 1, 2, CASCADES), 16), .most = BOXES + 1};
  b->view_memory = (plan_memory){.at = test_allocate(NULL, plan_memory_size(BOXES + 1, 2, 0), 16), .most = BOXES + 1};
  if (check(b, !make_buffers(b) && !make_images(b) && !make_programs(b), "making objects")) {
    for (uint32_t bias_mode = 0; bias_mode < 2; ++bias_mode)
      for (uint32_t filter = 0; filter < FILTERS; ++filter)
        if (!bias_mode || filter != CSM_FILTER_LINEAR_DEPTH) /* which has no texels for a plane */
          compare_with(b, filter, bias_mode, true, masks[bias_mode][filter]);
    compare_masks(b, masks[0]);
    compare_with(b, CSM_FILTER_PCF_3X3, CSM_BIAS_SLOPE, false, masks[0][0]);
  }
  free_objects(b);
  test_release(NULL, b->frame_memory.at);
  test_release(NULL, b->view_memory.at);
}

int main(int argc, char **argv) {
  if (argc < 2)
    return 2;
  char error[512] = "";
  loader_library library;
  bench b = {.every = argc > 2 && !strcmp(argv[2], "--long")};
  const gpu_host host = {.user = &b, .allocate = test_allocate, .release = test_release, .log = message};
  const gpu_open_info info = {
      .host = &host, .validate = true, .names = true, .slots = 1, .error = error, .error_size = sizeof error};
  if (loader_open(&library, argv[1], error, sizeof error) || library.backend->open(&info, &b.gpu.device)) {
    fprintf(stderr, "%s\n", error);
    loader_close(&library);
    return 1;
  }
  b.gpu.api = library.backend;
  run(&b);
  b.gpu.api->close(b.gpu.device);
  loader_close(&library);
  return b.failures != 0;
}
