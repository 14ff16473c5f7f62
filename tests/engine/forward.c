/*
 * forward.c: an engine's own shader sends rays through the buffers that csm_bind tells, on the engine's device, and gives what
 * the mask says.
 */
#include "../binding/plane.h"
#include "rig_forward.h"
#include "stage.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 256, HEIGHT = 128, PIXELS = WIDTH * HEIGHT, BOXES = 24 };

static const picture_size size = {WIDTH, HEIGHT};

typedef struct fixture {
  rig *rig;
  stage stage;
  csm_instance instances[BOXES + 1];
  shot shot;
  rig_forward *forward;
  csm_binding binding;
} fixture;

/* A camera sees nothing but a ground; boxes above the view cast on it. */
static void place_things(fixture *f) {
  support_boxes_above(f->stage.context, f->instances, BOXES);
  f->shot = shot_make(f->instances, BOXES + 1);
  memcpy(f->shot.light.direction, (const double[]){0.4, -1, 0.25}, sizeof f->shot.light.direction);
  support_look_at(f->shot.camera.view, (const double[]){2, 8, 4}, (const double[]){2, 1, -6});
  support_perspective(f->shot.camera.projection, 50, (double)WIDTH / HEIGHT, 0.5, 0);
}

static void open_fixture(fixture *f, rig_kind kind, uint32_t layout) {
  *f = (fixture){.rig = rig_open(kind)};
  stage_open_with(&f->stage, f->rig, CSM_CREATE_RAYS);
  place_things(f);
  f->stage.config.filter = layout == CSM_LAYOUT_PAGES ? CSM_FILTER_PCF_3X3 : CSM_FILTER_EXACT;
  f->stage.config.shadow_distance = 40;
  f->stage.config.map_layout = layout;
  f->stage.config.resolution = 256;
  stage_configure(&f->stage);
  f->forward = rig_forward_make(f->rig, WIDTH, HEIGHT, layout != CSM_LAYOUT_PAGES);
}

static void close_fixture(fixture *f) {
  rig_forward_free(f->forward);
  stage_close(&f->stage);
  rig_close(f->rig);
}

/* The contract's tolerance: 1/255 on all but 0.01 % of the pixels; and there is something to differ in. */
static void compare(const fixture *f, const picture_layer *mask) {
  const unsigned char *picture = rig_forward_picture(f->forward);
  const uint32_t pitch = rig_pitch(WIDTH, 1);
  uint32_t wrong = 0, lit = 0, dark = 0;
  for (uint32_t y = 0; y < HEIGHT; ++y)
    for (uint32_t x = 0; x < WIDTH; ++x) {
      const int level = (int)(mask->texels[y * WIDTH + x] * 255.0f + 0.5f);
      wrong += abs(level - (int)picture[y * pitch + x]) > 1;
      lit += level == 255;
      dark += level == 0;
    }
  printf("%u pixels lit, %u dark, %u differ\n", lit, dark, wrong);
  assert_in_range(lit, PIXELS / 5, PIXELS);
  assert_in_range(dark, PIXELS / 200, PIXELS);
  assert_in_range(wrong, 0, PIXELS / 10000);
}

/* A frame of maps, mask and the engine's own shader. */
static void draw(fixture *f) {
  float plane[FORWARD_PLANE];
  rig_begin(f->rig);
  f->shot.frame.frame = rig_frame(f->rig);
  f->shot.frame.command_buffer = rig_commands(f->rig);
  stage_render(&f->stage, &f->shot);
  stage_resolve(&f->stage, &f->shot, size);
  picture_copy copy = stage_record(&f->stage, size); /* which waits for no fragment shader that reads the maps */
  f->binding = (csm_binding){.struct_size = sizeof f->binding};
  assert_int_equal(csm_bind(f->stage.cascades, &f->binding), CSM_SUCCESS);
  plane_rows(plane, f->shot.camera.view, f->shot.camera.projection, -8, WIDTH, HEIGHT);
  rig_forward_draw(f->forward, &f->binding, plane);
  stage_finish(&f->stage);
  picture drawn = picture_take(f->rig, &copy);
  compare(f, &drawn.layers[drawn.count - 1]);
  picture_free(&drawn);
}

/* Triangles on a line, with trees of more bytes than the meshes' buffer has left. */
static void make_large_mesh(csm_context *context) {
  enum { TRIANGLES = 20000, VERTICES = TRIANGLES + 2 };
  float(*positions)[3] = calloc(VERTICES, sizeof *positions);
  uint32_t *indices = calloc(TRIANGLES, 3 * sizeof *indices);
  assert_true(positions && indices);
  for (uint32_t i = 0; i < VERTICES; ++i) {
    positions[i][0] = (float)i;
    positions[i][1] = (float)(i % 2);
  }
  for (uint32_t i = 0; i < 3 * TRIANGLES; ++i)
    indices[i] = i / 3 + i % 3;
  const csm_mesh_info info = {.struct_size = sizeof info,
                              .positions = positions,
                              .vertex_count = VERTICES,
                              .indices = indices,
                              .index_count = 3 * TRIANGLES,
                              .index_size = 4,
                              .name = "long"};
  csm_mesh mesh;
  assert_int_equal(csm_mesh_create(context, &info, &mesh), CSM_SUCCESS);
  free(positions);
  free(indices);
}

/* And again when the buffers have moved, and some of what casts has. */
static void rays_are_read(rig_kind kind) {
  fixture f;
  open_fixture(&f, kind, CSM_LAYOUT_ARRAY);
  draw(&f);
  const uint64_t before = f.binding.native_ray_meshes;
  assert_true(before && f.binding.native_ray_instances && f.binding.native_ray_instances != before);
  make_large_mesh(f.stage.context);
  for (uint32_t i = 1; i <= BOXES; i += 3)
    f.instances[i].transform[12] += 1.5;
  draw(&f);
  assert_true(f.binding.native_ray_meshes != before);
  close_fixture(&f);
}

static void rays_are_read_on_a_typical_device(void **state) {
  (void)state;
  rays_are_read(RIG_TYPICAL);
}

static void rays_are_read_on_a_modern_device(void **state) {
  (void)state;
  rays_are_read(RIG_MODERN);
}

/* Maps of pages begin anywhere in their layer, and go on at the other side. */
static void pages_are_read(void **state) {
  (void)state;
  fixture f;
  open_fixture(&f, RIG_TYPICAL, CSM_LAYOUT_PAGES);
  for (int step = 0; step < 3; ++step) {
    support_look_at(f.shot.camera.view, (const double[]){2 + 0.7 * step, 8, 4 - 1.3 * step},
                    (const double[]){2 - 2.0 * step, 1, -6});
    draw(&f);
  }
  close_fixture(&f);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(pages_are_read),
      cmocka_unit_test(rays_are_read_on_a_typical_device),
      cmocka_unit_test(rays_are_read_on_a_modern_device),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
