/*
 * forward_filters.c: filters of moments, of a light's size, and those that send rays give in an engine's forward shader,
 * which binds what csm_bind tells of, what the mask says.
 *
 *   forward_filters BACKEND
 *
 * A camera sees nothing but a ground; boxes above the view cast on it, near and far. What the shader reads are the very
 * images and buffers of the cascades.
 */
#include "../conformance/support.h"
#include "abi/cascades.h"
#include "csm_constants.h"
#include "device/tree_pool.h"
#include "forward_boxes.h"
#include "forward_code.h"
#include "forward_filter_10.h"
#include "forward_filter_11.h"
#include "forward_filter_12.h"
#include "forward_filter_13.h"
#include "forward_filter_14.h"
#include "forward_filter_15.h"
#include "forward_filter_16.h"
#include "forward_filter_17.h"
#include "forward_filter_18.h"
#include "forward_rays.h"
#include "forward_rays_18.h"
#include "forward_rays_19.h"
#include "forward_rays_19_compared.h"
#include "forward_traced_18.h"
#include "forward_traced_19.h"
#include "plane.h"
#include "shader_code.h"
#include "techniques/maps/maps.h"
#include "techniques/mask/mask_programs.h"
#include "techniques/moments/moments.h"
#include "techniques/rays/instances.h"
#include "techniques/rays/ray_record.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 512, HEIGHT = 256, PIXELS = WIDTH * HEIGHT, BOXES = FORWARD_BOXES };
enum {
  PLANE_BYTES = 64,
  BOX_BYTES = 32,
  AT_PLANE = MASK_CASCADES_BLOCK,
  UPLOAD_BYTES = AT_PLANE + PLANE_BYTES + BOX_BYTES * BOXES
};

typedef struct fixture {
  record record;
  csm_context *context;
  gpu gpu;
  csm_instance instances[BOXES + 1];
  shot shot;
  csm_view *view;
  csm_cascades *cascades;
  csm_binding binding;
  gpu_buffer *upload, *readback;
  gpu_image *picture, *none; /* what is drawn; moments of a filter that reads none */
  gpu_target *target;
} fixture;

/* ---- the scene ---- */

static void place_things(fixture *f) {
  support_boxes_above(f->context, f->instances, BOXES);
  f->shot = shot_make(f->instances, BOXES + 1);
  memcpy(f->shot.light.direction, (const double[]){0.4, -1, 0.25}, sizeof f->shot.light.direction);
  f->shot.light.angular_diameter = 0.03;
  support_look_at(f->shot.camera.view, (const double[]){2, 8, 4}, (const double[]){2, 1, -6});
  support_perspective(f->shot.camera.projection, 50, (double)WIDTH / HEIGHT, 0.5, 0);
}

/* ---- objects ---- */

static void make_objects(fixture *f) {
  const gpu_buffer_info upload = {"upload", GPU_BUFFER_UPLOAD, UPLOAD_BYTES, 0};
  const gpu_buffer_info readback = {"readback", GPU_BUFFER_READBACK, PIXELS, 0};
  const uint32_t usage = GPU_IMAGE_TARGET | GPU_IMAGE_SAMPLED;
  const gpu_image_info picture = {
      "picture", GPU_FORMAT_R8_UNORM, usage | GPU_IMAGE_COPY_SOURCE, WIDTH, HEIGHT, 1, false, 1};
  const gpu_image_info none = {"no moments", GPU_FORMAT_R32_FLOAT, usage, 1, 1, 1, true, 1};
  assert_int_equal(gpu_buffer_create(f->gpu, &upload, &f->upload), CSM_SUCCESS);
  assert_int_equal(gpu_buffer_create(f->gpu, &readback, &f->readback), CSM_SUCCESS);
  assert_int_equal(gpu_image_create(f->gpu, &picture, &f->picture), CSM_SUCCESS);
  assert_int_equal(gpu_image_create(f->gpu, &none, &f->none), CSM_SUCCESS);
  const gpu_target_info target = {.name = "picture", .color = f->picture};
  assert_int_equal(gpu_target_create(f->gpu, &target, &f->target), CSM_SUCCESS);
}

static void free_objects(fixture *f) {
  gpu_target_destroy(f->gpu, f->target);
  gpu_image_destroy(f->gpu, f->picture);
  gpu_image_destroy(f->gpu, f->none);
  gpu_buffer_destroy(f->gpu, f->upload);
  gpu_buffer_destroy(f->gpu, f->readback);
}

static void open_fixture_as(fixture *f, uint32_t flags) {
  memset(f, 0, sizeof *f);
  csm_create_info info = support_create_info(&f->record);
  info.flags |= flags;
  assert_int_equal(csm_create(&info, &f->context), CSM_SUCCESS);
  f->gpu = context_device(f->context)->gpu;
  f->view = support_view(f->context);
  place_things(f);
  make_objects(f);
}

static void open_fixture(fixture *f) {
  open_fixture_as(f, CSM_CREATE_RAYS);
}

static void close_fixture(fixture *f) {
  free_objects(f);
  support_close(f->context, &f->record);
}

/* ---- the forward shader ---- */

/* With filters that send rays the binding tells of their buffers. */
static void check_buffers(const fixture *f) {
  const csm_binding *binding = &f->binding;
  const device *device = context_device(f->context);
  if (f->cascades->config.filter < CSM_FILTER_EXACT) {
    assert_int_equal(binding->native_ray_meshes | binding->ray_meshes_size, 0);
    assert_int_equal(binding->native_ray_instances | binding->ray_instances_size, 0);
    return;
  }
  const gpu_buffer *instances = ray_instances_buffer(&f->cascades->techniques);
  assert_int_equal(binding->native_ray_meshes, gpu_buffer_native(f->gpu, tree_pool_buffer(device)));
  assert_int_equal(binding->ray_meshes_size, tree_pool_bytes(device));
  assert_int_equal(binding->native_ray_instances, gpu_buffer_native(f->gpu, instances));
  assert_int_equal(binding->ray_instances_size % TREE_POOL_ROW, 0);
  assert_true(binding->ray_instances_size >= (BOXES + 1) * RAY_RECORD_SIZE);
}

/* The corners of what casts, relative to the binding's origin. */
static void write_boxes(float *out, const fixture *f) {
  for (uint32_t i = 0; i < BOXES; ++i) {
    const double *m = f->instances[i + 1].transform;
    for (int axis = 0; axis < 3; ++axis) {
      const double middle = m[12 + axis] - f->binding.origin[axis], half = m[axis * 5];
      out[i * 8 + axis] = (float)(middle - half);
      out[i * 8 + 4 + axis] = (float)(middle + half);
    }
  }
}

static void bind(fixture *f) {
  csm_binding *binding = &f->binding;
  *binding = (csm_binding){.struct_size = sizeof *binding};
  assert_int_equal(csm_bind(f->cascades, binding), CSM_SUCCESS);
  char *upload = gpu_buffer_memory(f->gpu, f->upload);
  memcpy(upload, binding->cascade_constants, binding->cascade_constants_size);
  memcpy(upload + 16 * CSM_S_BEGIN, binding->setting_constants, binding->setting_constants_size);
  plane_rows((float *)(upload + AT_PLANE), f->shot.camera.view, f->shot.camera.projection, -8, WIDTH, HEIGHT);
  write_boxes((float *)(upload + AT_PLANE + PLANE_BYTES), f);
  check_buffers(f);
}

/* An engine's shader: fixed to a filter, or to none, with rays or without. */
typedef struct reader {
  const char *name;
  uint32_t filter; /* ANY: as configured */
  bool glsl, rays;
  bool traced; /* it asks a tracer of its own for them */
  bool all;    /* it sends rays everywhere: a mask's search of a few texels overlooks some penumbras */
  gpu_code code;
} reader;

enum { ANY = 0xffffffffu, MOST_READERS = 23 };

#define GLSL(words)                                                                                                    \
  { .spirv = (words), .spirv_size = sizeof(words) }

/* Of a filter. In HLSL a few are made, and GLSL is for Vulkan alone. */
static uint32_t list_readers_of(const fixture *f, uint32_t filter, reader out[MOST_READERS]) {
  const reader all[MOST_READERS] = {
      {"HLSL", CSM_FILTER_VSM, .code = shader_forward_vsm_ps},
      {"HLSL", CSM_FILTER_EVSM2, .code = shader_forward_evsm2_ps},
      {"HLSL", CSM_FILTER_PCSS, .code = shader_forward_pcss_ps},
      {"HLSL, no rays", CSM_FILTER_EXACT, .code = shader_forward_exact_bare_ps},
      {"HLSL", CSM_FILTER_EXACT, .rays = true, .code = shader_forward_exact_ps},
      {"HLSL", CSM_FILTER_EXACT_SOFT, .rays = true, .code = shader_forward_exact_soft_ps},
      {"HLSL, as configured", ANY, .rays = true, .code = shader_forward_rays_ps},
      {"HLSL, own tracer", CSM_FILTER_EXACT, .rays = true, .traced = true, .code = shader_forward_traced_ps},
      {"GLSL", CSM_FILTER_VSM, .glsl = true, .code = GLSL(forward_filter_10)},
      {"GLSL", CSM_FILTER_ESM, .glsl = true, .code = GLSL(forward_filter_11)},
      {"GLSL", CSM_FILTER_EVSM2, .glsl = true, .code = GLSL(forward_filter_12)},
      {"GLSL", CSM_FILTER_EVSM4, .glsl = true, .code = GLSL(forward_filter_13)},
      {"GLSL", CSM_FILTER_MSM4, .glsl = true, .code = GLSL(forward_filter_14)},
      {"GLSL", CSM_FILTER_PCSS, .glsl = true, .code = GLSL(forward_filter_15)},
      {"GLSL", CSM_FILTER_VSSM, .glsl = true, .code = GLSL(forward_filter_16)},
      {"GLSL", CSM_FILTER_BACKPROJECTION, .glsl = true, .code = GLSL(forward_filter_17)},
      {"GLSL, no rays", CSM_FILTER_EXACT, .glsl = true, .code = GLSL(forward_filter_18)},
      {"GLSL", CSM_FILTER_EXACT, .glsl = true, .rays = true, .code = GLSL(forward_rays_18)},
      {"GLSL", CSM_FILTER_EXACT_SOFT, .glsl = true, .rays = true, .code = GLSL(forward_rays_19)},
      {"GLSL, own tracer", CSM_FILTER_EXACT, .glsl = true, .rays = true, .traced = true,
       .code = GLSL(forward_traced_18)},
      {"GLSL, own tracer", CSM_FILTER_EXACT_SOFT, .glsl = true, .rays = true, .traced = true,
       .code = GLSL(forward_traced_19)},
      {"GLSL, comparisons", CSM_FILTER_EXACT_SOFT, .glsl = true, .rays = true, .all = true,
       .code = GLSL(forward_rays_19_compared)},
      {"GLSL, as configured", ANY, .glsl = true, .rays = true, .code = GLSL(forward_rays)},
  };
  const bool vulkan = strcmp(f->gpu.api->name, "vulkan") == 0;
  uint32_t count = 0;
  for (uint32_t i = 0; i < MOST_READERS; ++i) {
    const bool fits = all[i].filter == filter || (all[i].filter == ANY && filter >= CSM_FILTER_EXACT);
    if (fits && (vulkan || !all[i].glsl))
      out[count++] = all[i];
  }
  return count;
}

static uint32_t list_readers(const fixture *f, reader out[MOST_READERS]) {
  return list_readers_of(f, f->cascades->config.filter, out);
}

static gpu_program_info program_info(const reader *reader) {
  return (gpu_program_info){
      .name = "forward",
      .vertex = shader_screen_vs,
      .pixel = reader->code,
      .constants_count = 2,
      .constants_sizes = {MASK_CASCADES_BLOCK, PLANE_BYTES + (reader->traced ? BOX_BYTES * BOXES : 0)},
      .texture_count = 2,
      .buffer_count = reader->rays && !reader->traced ? 2 : 0,
      .sampler_count = 3,
      .samplers = {GPU_SAMPLER_POINT_CLAMP, GPU_SAMPLER_TRILINEAR_CLAMP, GPU_SAMPLER_COMPARE_LESS_EQUAL},
      .color_format = GPU_FORMAT_R8_UNORM,
      .cull = GPU_CULL_NONE,
  };
}

static void record_picture(const fixture *f, gpu_program *program, gpu_bindings *bindings) {
  const gpu gpu = f->gpu;
  gpu_pass_begin(gpu, &(gpu_pass_info){.target = f->target, .color_load = GPU_LOAD_DISCARD});
  gpu_pass_program(gpu, program);
  gpu_pass_bind(gpu, bindings, (const uint32_t[]){0, AT_PLANE});
  gpu_pass_draw(gpu, &(gpu_draw){.count = 3, .instance_count = 1});
  gpu_pass_end(gpu);
  gpu_copy_image(gpu, f->readback, 0, WIDTH, f->picture, &(gpu_region){.width = WIDTH, .height = HEIGHT});
}

static const uint8_t *draw_forward(const fixture *f, const reader *reader) {
  gpu_image *moments = moments_image(&f->cascades->techniques, &f->cascades->config);
  const gpu_program_info info = program_info(reader);
  gpu_program *program;
  gpu_bindings *bindings;
  assert_int_equal(gpu_program_create(f->gpu, &info, &program), CSM_SUCCESS);
  gpu_bindings_info reads = {.name = "forward",
                             .program = program,
                             .constants = {f->upload, f->upload},
                             .textures = {maps_image(&f->cascades->techniques), moments ? moments : f->none}};
  if (info.buffer_count) {
    reads.buffers[0] =
        (gpu_buffer_part){.buffer = tree_pool_buffer(context_device(f->context)), .stride = TREE_POOL_ROW};
    reads.buffers[1] =
        (gpu_buffer_part){.buffer = ray_instances_buffer(&f->cascades->techniques), .stride = TREE_POOL_ROW};
  }
  assert_int_equal(gpu_bindings_create(f->gpu, &reads, &bindings), CSM_SUCCESS);
  assert_int_equal(gpu_begin(f->gpu, &(gpu_record_info){.slot = 0, .first = true}), CSM_SUCCESS);
  if (!moments)
    gpu_make_readable(f->gpu, f->none, NULL);
  record_picture(f, program, bindings);
  assert_int_equal(gpu_end(f->gpu), CSM_SUCCESS);
  assert_int_equal(gpu_wait(f->gpu, 0), CSM_SUCCESS);
  gpu_bindings_destroy(f->gpu, bindings);
  gpu_program_destroy(f->gpu, program);
  return gpu_buffer_memory(f->gpu, f->readback);
}

/* ---- comparing ---- */

/* The mask has shadows, with something between light and dark but for a ray to the middle of the light. */
static void check_mask(const fixture *f, const float *mask) {
  const bool hard = f->cascades->config.filter == CSM_FILTER_EXACT;
  uint32_t lit = 0, dark = 0;
  for (uint32_t i = 0; i < PIXELS; ++i) {
    lit += mask[i] > 0.95f;
    dark += mask[i] < 0.2f;
  }
  assert_in_range(lit, PIXELS / 5, PIXELS);
  assert_in_range(dark, PIXELS / 200, PIXELS);
  assert_in_range(PIXELS - lit - dark, hard ? 0 : PIXELS / 200, hard ? 0 : PIXELS);
}

/*
 * The contract's tolerance: 1/255 on all but 0.01 % of the pixels. Anisotropic sampling takes a whole number of samples:
 * where that number changes the two may be one apart, so there on all but 0.1 %.
 */
static uint32_t may_differ(const fixture *f, const reader *reader) {
  const bool anisotropic = f->cascades->config.moment_sampling == CSM_SAMPLING_ANISOTROPIC;
  return PIXELS / (reader->all ? 200 : anisotropic ? 1000 : 10000);
}

static void compare(const fixture *f, const float *mask, const reader *reader, const char *what) {
  const uint8_t *picture = draw_forward(f, reader);
  uint32_t any = 0, wrong = 0;
  int largest = 0;
  for (uint32_t i = 0; i < PIXELS; ++i) {
    const int apart = abs((int)(mask[i] * 255.0f + 0.5f) - (int)picture[i]);
    any += apart > 0;
    wrong += apart > 1;
    largest = apart > largest ? apart : largest;
  }
  printf("%s: %u pixels differ, %u by more than 1/255, at most %d/255\n", what, any, wrong, largest);
  if (wrong > may_differ(f, reader))
    fail_msg("%s: %u pixels differ by more than 1/255", what, wrong);
}

/* Draws maps and mask, which the caller frees, with cascades that it destroys. */
static float *draw_mask(fixture *f, const csm_config *config) {
  assert_int_equal(csm_cascades_create(f->context, config, &f->cascades), CSM_SUCCESS);
  assert_int_equal(csm_render_cascades(f->cascades, shot_frame(&f->shot)), CSM_SUCCESS);
  assert_int_equal(shot_resolve(&f->shot, f->view, f->cascades, WIDTH, HEIGHT), CSM_SUCCESS);
  bind(f);
  return support_image(f->context, f->view, CSM_READ_MASK, WIDTH, HEIGHT);
}

static void check_config(fixture *f, const csm_config *config, const char *what) {
  const bool has_rays = config->filter >= CSM_FILTER_EXACT;
  reader readers[MOST_READERS];
  float *mask = draw_mask(f, config);
  check_mask(f, mask);
  for (uint32_t i = 0, count = list_readers(f, readers); i < count; ++i) {
    char name[128];
    snprintf(name, sizeof name, "%s, %s", what, readers[i].name);
    if (readers[i].rays == has_rays)
      compare(f, mask, &readers[i], name);
  }
  free(mask);
  assert_int_equal(csm_cascades_destroy(f->cascades), CSM_SUCCESS);
}

static csm_config config_of(uint32_t filter) {
  csm_config config = support_config();
  config.resolution = 512;
  config.shadow_distance = 40;
  config.filter = filter;
  config.soft_radius_max_texels = 16;
  config.soft_search_taps = 8;
  config.soft_taps = 8;
  config.ray_taps = 4;
  if (filter == CSM_FILTER_VSSM)
    config.moment_levels = 5;
  return config;
}

static void every_filter_is_as_in_the_mask(void **state) {
  static const char *const names[] = {"vsm",  "esm",  "evsm2",          "evsm4", "msm4",
                                      "pcss", "vssm", "backprojection", "exact", "exact_soft"};
  fixture f;
  (void)state;
  open_fixture(&f);
  for (uint32_t filter = CSM_FILTER_VSM; filter <= CSM_FILTER_EXACT_SOFT; ++filter) {
    const csm_config config = config_of(filter);
    check_config(&f, &config, names[filter - CSM_FILTER_VSM]);
  }
  close_fixture(&f);
}

/* Levels are chosen by how the position changes from pixel to pixel, which the shader tells. */
static void levels_are_as_in_the_mask(void **state) {
  fixture f;
  (void)state;
  open_fixture(&f);
  csm_config config = config_of(CSM_FILTER_EVSM2);
  config.moment_levels = 5;
  config.moment_sampling = CSM_SAMPLING_TRILINEAR;
  check_config(&f, &config, "evsm2, trilinear");
  config.moment_sampling = CSM_SAMPLING_ANISOTROPIC;
  config.moment_anisotropy = 4;
  check_config(&f, &config, "evsm2, anisotropic");
  config.filter = CSM_FILTER_VSM;
  config.moment_format = CSM_MOMENTS_FLOAT16;
  config.moment_layers = 2;
  config.moment_halved = 1;
  check_config(&f, &config, "vsm, 16 bits, halved, two layers, anisotropic");
  close_fixture(&f);
}

static void settings_are_as_in_the_mask(void **state) {
  fixture f;
  (void)state;
  open_fixture(&f);
  csm_config config = config_of(CSM_FILTER_VSM);
  config.moment_blur = CSM_BLUR_GAUSSIAN;
  config.moment_blur_texels = 4;
  config.bleeding_curve = CSM_BLEEDING_SMOOTHSTEP;
  config.bleeding_reduction = 0.2;
  config.bleeding_power = 2;
  config.moment_deviation_m = 0.05;
  check_config(&f, &config, "vsm, bleeding");
  config = config_of(CSM_FILTER_PCSS);
  config.soft_penumbra = CSM_PENUMBRA_RATIO;
  config.soft_light_range = 0.01;
  check_config(&f, &config, "pcss, ratio");
  close_fixture(&f);
}

/* A shader that sends no rays has pcf_3x3 in place of exact: nothing undecided leaves it. */
static void without_rays_exact_is_pcf_3x3(void **state) {
  fixture f;
  reader readers[MOST_READERS];
  (void)state;
  open_fixture(&f);
  csm_config config = config_of(CSM_FILTER_PCF_3X3);
  float *mask = draw_mask(&f, &config);
  check_mask(&f, mask);
  assert_int_equal(csm_cascades_destroy(f.cascades), CSM_SUCCESS);
  config.filter = CSM_FILTER_EXACT;
  free(draw_mask(&f, &config));
  for (uint32_t i = 0, count = list_readers(&f, readers); i < count; ++i)
    if (!readers[i].rays)
      compare(&f, mask, &readers[i], readers[i].name);
  assert_int_equal(csm_cascades_destroy(f.cascades), CSM_SUCCESS);
  free(mask);
  close_fixture(&f);
}

/* A shader that traces by itself needs no trees, nor a context that makes them: its maps may be those of another filter. */
static void compare_tracers(uint32_t filter, uint32_t maps_filter) {
  fixture f;
  reader readers[MOST_READERS];
  open_fixture(&f);
  csm_config config = config_of(filter);
  float *mask = draw_mask(&f, &config);
  close_fixture(&f);
  open_fixture_as(&f, 0);
  config.filter = maps_filter;
  free(draw_mask(&f, &config));
  for (uint32_t i = 0, count = list_readers_of(&f, filter, readers); i < count; ++i)
    if (readers[i].traced)
      compare(&f, mask, &readers[i], readers[i].name);
  free(mask);
  close_fixture(&f);
}

static void an_own_tracer_needs_no_trees(void **state) {
  (void)state;
  compare_tracers(CSM_FILTER_EXACT, CSM_FILTER_PCF_3X3);
  compare_tracers(CSM_FILTER_EXACT_SOFT, CSM_FILTER_PCSS);
}

/* What a box is that rays cannot meet: so flat that it has no tree. */
static void flatten_boxes(fixture *f) {
  for (uint32_t i = 1; i <= BOXES; ++i)
    f->instances[i].transform[5] = 1e-6;
}

/* Whether the share of 4 x 4 texels goes with pcf_3x3's level, in which those of two borders may weigh as good as nothing. */
static bool goes_with(float mask, uint8_t level) {
  const int most = 7 * 255 / 16 + 1;
  return mask == 0.0f ? level <= most : mask == 1.0f ? level >= 255 - most : level > 0;
}

/* Visibility is a share of 4 x 4 texels where a map decides: nothing is lit where that is dark. */
static void check_shares(const float *mask, const uint8_t *picture, const char *what) {
  uint32_t between = 0, wrong = 0;
  for (uint32_t i = 0; i < PIXELS; ++i) {
    const float share = (float)picture[i] * (16.0f / 255.0f), whole = (float)(int)(share + 0.5f);
    between += picture[i] > 0 && picture[i] < 255;
    wrong += !goes_with(mask[i], picture[i]) || share - whole > 0.05f || whole - share > 0.05f;
  }
  printf("%s: %u pixels between, %u wrong\n", what, between, wrong);
  assert_in_range(between, PIXELS / 200, PIXELS);
  assert_in_range(wrong, 0, PIXELS / 10000);
}

static void maps_decide_where_rays_meet_nothing(void **state) {
  fixture f;
  reader readers[MOST_READERS];
  (void)state;
  open_fixture(&f);
  flatten_boxes(&f);
  csm_config config = config_of(CSM_FILTER_PCF_3X3);
  float *mask = draw_mask(&f, &config);
  assert_int_equal(csm_cascades_destroy(f.cascades), CSM_SUCCESS);
  config.filter = CSM_FILTER_EXACT;
  free(draw_mask(&f, &config));
  for (uint32_t i = 0, count = list_readers(&f, readers); i < count; ++i)
    if (readers[i].rays && !readers[i].traced)
      check_shares(mask, draw_forward(&f, &readers[i]), readers[i].name);
  assert_int_equal(csm_cascades_destroy(f.cascades), CSM_SUCCESS);
  free(mask);
  close_fixture(&f);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_filter_is_as_in_the_mask), cmocka_unit_test(levels_are_as_in_the_mask),
      cmocka_unit_test(settings_are_as_in_the_mask),    cmocka_unit_test(without_rays_exact_is_pcf_3x3),
      cmocka_unit_test(an_own_tracer_needs_no_trees),   cmocka_unit_test(maps_decide_where_rays_meet_nothing),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof *tests);
}
