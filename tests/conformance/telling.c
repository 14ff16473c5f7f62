#include "telling.h"

#include <string.h>

/* Closed, and not its own mirror image. */
static const float wedge_positions[4][3] = {{-1, 0, -1}, {1, 0, -1}, {-1, 0, 1}, {-1, 3, -1}};
static const uint16_t wedge_indices[12] = {0, 1, 2, 0, 3, 1, 0, 2, 3, 1, 3, 2};

static const float leaf_positions[4][3] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
static const float leaf_uvs[4][2] = {{0, 1}, {2, 1}, {2, 0}, {0, 0}};
static const uint16_t leaf_indices[6] = {0, 1, 2, 0, 2, 3};

static void make_meshes(telling *scene, csm_context *context) {
  scene->square = support_square(context);
  scene->box = support_box(context, 2);
  const csm_mesh_info wedge = {.struct_size = sizeof wedge,
                               .positions = wedge_positions,
                               .vertex_count = 4,
                               .indices = wedge_indices,
                               .index_count = 12,
                               .index_size = 2,
                               .name = "wedge"};
  assert_int_equal(csm_mesh_create(context, &wedge, &scene->wedge), CSM_SUCCESS);
  uint8_t texels[8 * 8];
  for (int i = 0; i < 64; ++i) {
    const int x = i % 8 - 4, y = i / 8 - 4;
    texels[i] = x * x + 2 * y * y < 16 && (x + y) % 4 ? 255 : 20;
  }
  const csm_alpha_mask_info alpha_mask = {.struct_size = sizeof alpha_mask, .width = 8, .height = 8, .texels = texels};
  assert_int_equal(csm_alpha_mask_create(context, &alpha_mask, &scene->alpha_mask), CSM_SUCCESS);
  const csm_mesh_info leaf = {.struct_size = sizeof leaf,
                              .flags = CSM_MESH_TWO_SIDED,
                              .positions = leaf_positions,
                              .vertex_count = 4,
                              .indices = leaf_indices,
                              .index_count = 6,
                              .index_size = 2,
                              .alpha_mask = scene->alpha_mask,
                              .uvs = leaf_uvs,
                              .alpha_cutoff = 0.5f,
                              .name = "leaf"};
  assert_int_equal(csm_mesh_create(context, &leaf, &scene->leaf), CSM_SUCCESS);
}

void telling_make(telling *scene, csm_context *context) {
  memset(scene, 0, sizeof *scene);
  make_meshes(scene, context);
  uint32_t n = 0;
  csm_instance *to = scene->instances;
  to[n++] = support_instance(scene->square, 0, 0, 0, 60, 1, 60);
  to[n++] = support_instance(scene->box, 0, 1, 0, 1, 1, 1);
  to[n++] = support_instance(scene->box, 4, 2, -6, -1.5, 2, 1); /* mirrored */
  to[n] = support_instance(scene->box, -6, 1.5, -8, 2, 1, 1);
  to[n].transform[4] = 0.7; /* sheared, and turned a little */
  to[n++].transform[2] = 0.5;
  to[n++] = support_instance(scene->wedge, -3, 0, 3, 1, 1, 1);
  to[n++] = support_instance(scene->wedge, 3, 0, 4, -1, 0.7, 1);
  to[n++] = support_instance(scene->wedge, 8, 0, -14, 2, 1.5, -2);
  to[n++] = support_instance(scene->leaf, -1, 3, -3, 1.5, 1.5, 1);
  to[n++] = support_instance(scene->leaf, 6, 2, 1, -1, 1, 1);
  to[n++] = support_instance(scene->square, -9, 4, -2, 2, 1, 2);   /* a sheet seen from above */
  to[n++] = support_instance(scene->square, -9, 5, -10, 2, -1, 2); /* and one from below */
  to[n++] = support_instance(scene->box, 2, 20, -4, 0.1, 20, 0.1); /* the mast */
  to[n++] = support_instance(scene->box, 1, 45, -12, 4, 0.3, 4);   /* high above */
  to[n++] = support_instance(scene->box, -8, 8, -45, 3, 8, 3);     /* beyond the last cascade */
  to[n++] = support_instance(scene->box, 0, 0.1, -1.7, 0.3, 0.1, 0.3);
  to[n++] = support_instance(scene->box, -2, 0.4, 6, 0.02, 0.4, 0.02);
  assert_int_equal(n, TELLING_INSTANCES);
}

shot telling_shot(const telling *scene, uint32_t camera, uint32_t step, double aspect) {
  static const double eyes[TELLING_CAMERAS][3] = {{-4, 5, 12}, {12, 3, 6}, {-2, 18, -2}};
  static const double targets[TELLING_CAMERAS][3] = {{0, 0, -4}, {-2, 1, -4}, {1, 0, -12}};
  static const double suns[TELLING_CAMERAS][3] = {{0.4, -1, 0.25}, {0.8, -0.7, 0.4}, {0.1, -1, -0.7}};
  shot shot = shot_make(scene->instances, TELLING_INSTANCES);
  const uint32_t i = camera % TELLING_CAMERAS;
  double eye[3], target[3];
  for (int k = 0; k < 3; ++k) {
    eye[k] = eyes[i][k] + 0.11 * step;
    target[k] = targets[i][k] - 0.07 * step;
    shot.light.direction[k] = suns[i][k] + (k == 0 ? 0.004 * step : 0);
  }
  support_look_at(shot.camera.view, eye, target);
  support_perspective(shot.camera.projection, 55, aspect, 0.1, i == 1 ? 300 : 0);
  if (i == 2) { /* reversed-Z is off: depth grows */
    shot.camera.projection[10] = -1;
    shot.camera.projection[14] = -0.1;
  }
  return shot;
}
