/* input_frame.c: configurations, cameras, lights and instances at the ABI, as bytes. */
#include "csm/csm.h"
#include "input.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { INSTANCES = 2 };

/* What the bytes are; handles and pointers are put in. */
typedef struct frame_bytes {
  csm_config config;
  csm_camera camera, viewer;
  csm_light light;
  csm_instance instances[INSTANCES];
  double origin[3];
  uint32_t flags, show, width, height;
} frame_bytes;

static void good_camera(csm_camera *camera, double x) {
  const double view[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -x, -2, -9, 1};
  const double projection[16] = {1, 0, 0, 0, 0, 1.5, 0, 0, 0, 0, 0, -1, 0, 0, 0.1, 0};
  *camera = (csm_camera){.struct_size = sizeof *camera};
  memcpy(camera->view, view, sizeof view);
  memcpy(camera->projection, projection, sizeof projection);
}

uint32_t input_seeds(input_seed out[INPUT_SEEDS]) {
  enum { COUNT = 6 };
  static frame_bytes seeds[COUNT];
  static const char *const presets[COUNT] = {"default", "low", "ultra", "ms11", "exact", "exact_soft"};
  for (int i = 0; i < COUNT; i++) {
    frame_bytes *seed = &seeds[i];
    *seed = (frame_bytes){.light = {.struct_size = sizeof seed->light, .direction = {0.3, -1, 0.2}},
                          .origin = {1, 2, 3},
                          .show = (uint32_t)i % 3,
                          .width = 16,
                          .height = 9};
    seed->config.struct_size = sizeof seed->config;
    csm_config_preset(presets[i], &seed->config);
    good_camera(&seed->camera, 0);
    good_camera(&seed->viewer, i);
    for (int k = 0; k < INSTANCES; k++) {
      seed->instances[k].struct_size = sizeof seed->instances[k];
      for (int axis = 0; axis < 4; axis++)
        seed->instances[k].transform[5 * axis] = 1;
    }
    out[i] = (input_seed){seed, sizeof *seed};
  }
  return COUNT;
}

static csm_mesh make_mesh(csm_context *context) {
  static const float corners[12] = {-1, 0, -1, 1, 0, -1, 1, 1, 1, -1, 0, 1};
  static const uint16_t indices[6] = {0, 2, 1, 0, 3, 2};
  const csm_mesh_info info = {.struct_size = sizeof info,
                              .positions = corners,
                              .vertex_count = 4,
                              .indices = indices,
                              .index_count = 6,
                              .index_size = 2};
  csm_mesh mesh;
  if (csm_mesh_create(context, &info, &mesh))
    abort();
  return mesh;
}

static void expect_finite(const float *values, uint32_t bytes) {
  for (uint32_t i = 0; i < bytes / sizeof *values; i++)
    if (!isfinite(values[i]))
      abort();
}

/* What shaders get is finite, whatever came in. */
static void check(csm_cascades *cascades) {
  csm_binding binding = {.struct_size = sizeof binding};
  csm_stats stats = {.struct_size = sizeof stats};
  if (csm_bind(cascades, &binding) || csm_get_stats(cascades, &stats) || !stats.plan_hash)
    abort();
  expect_finite(binding.cascade_constants, binding.cascade_constants_size);
  expect_finite(binding.setting_constants, binding.setting_constants_size);
}

static void draw(csm_context *context, frame_bytes *in) {
  csm_cascades *cascades;
  csm_view *view;
  csm_frame frame = {.struct_size = sizeof frame,
                     .flags = in->flags,
                     .camera = &in->camera,
                     .light = &in->light,
                     .origin = in->origin,
                     .instances = in->instances,
                     .instance_count = INSTANCES};
  const csm_mask_info mask = {.struct_size = sizeof mask,
                              .frame = &frame,
                              .width = in->width % 64,
                              .height = in->height % 64,
                              .show = in->show};
  if (csm_cascades_create(context, &in->config, &cascades))
    return;
  if (csm_view_create(context, &view))
    abort();
  for (int i = 0; i < 2; i++) { /* with a history, too */
    if (csm_render_cascades(cascades, &frame) == CSM_SUCCESS)
      check(cascades);
    frame.camera = &in->viewer;
    (void)csm_resolve_mask(view, cascades, &mask);
  }
  csm_view_destroy(view);
  csm_cascades_destroy(cascades);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static csm_context *context;
  static csm_mesh mesh;
  const csm_create_info info = {.struct_size = sizeof info,
                                .flags = CSM_CREATE_RAYS,
                                .version = CSM_VERSION,
                                .backend = "null",
                                .memory_limit = 64 << 20};
  frame_bytes in;
  if (!context) {
    if (csm_create(&info, &context))
      abort();
    mesh = make_mesh(context);
  }
  memset(&in, 0, sizeof in);
  memcpy(&in, data, size < sizeof in ? size : sizeof in);
  /* A size that says more than there is would be a lie. */
  in.config.struct_size = in.config.struct_size > sizeof in.config ? sizeof in.config : in.config.struct_size;
  in.camera.struct_size = sizeof in.camera;
  in.viewer.struct_size = sizeof in.viewer;
  in.light.struct_size = sizeof in.light;
  in.config.resolution = in.config.resolution > 64 ? 64 : in.config.resolution;
  memset(in.config.resolutions, 0, sizeof in.config.resolutions);
  for (int i = 0; i < INSTANCES; i++) {
    in.instances[i].struct_size = sizeof in.instances[i];
    in.instances[i].mesh = mesh;
  }
  draw(context, &in);
  return 0;
}
