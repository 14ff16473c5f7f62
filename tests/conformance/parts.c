/*
 * parts.c: a large mesh is drawn in parts where what a camera sees asks for no more, and masks come out as they do where
 * all of it is drawn: at first, after its vertices have moved, and after a switch to another backend.
 */
#include "support.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
  WIDTH = 96,
  HEIGHT = 64,
  SIDE = 49,
  VERTICES = SIDE * SIDE,
  TRIANGLES = (SIDE - 1) * (SIDE - 1) * 2,
  INSTANCES = 6
};

typedef struct fixture {
  record record; /* first: what callbacks get */
  csm_context *context;
  csm_cascades *all, *seen; /* of what casts into the maps, and of what can shade what the camera sees */
  csm_view *view;
  csm_instance instances[INSTANCES];
  float positions[VERTICES][3];
  uint32_t indices[3 * TRIANGLES];
  csm_mesh_info hills;
  csm_mesh mesh;
} fixture;

static void place_hills(fixture *f, double phase) {
  for (int i = 0; i < VERTICES; ++i) {
    const double x = 80.0 * (i % SIDE) / (SIDE - 1) - 40, z = 80.0 * (i / SIDE) / (SIDE - 1) - 40;
    f->positions[i][0] = (float)x;
    f->positions[i][1] = (float)(sin(0.9 * x + phase) * cos(0.7 * z - phase) - 1);
    f->positions[i][2] = (float)z;
  }
}

static void make_hills(fixture *f) {
  uint32_t *out = f->indices;
  place_hills(f, 0);
  for (uint32_t row = 0; row + 1 < SIDE; ++row)
    for (uint32_t column = 0; column + 1 < SIDE; ++column) {
      const uint32_t a = row * SIDE + column, b = a + SIDE, corners[6] = {a, b, a + 1, a + 1, b, b + 1};
      memcpy(out, corners, sizeof corners);
      out += 6;
    }
  f->hills = (csm_mesh_info){.struct_size = sizeof f->hills,
                             .flags = CSM_MESH_TWO_SIDED,
                             .positions = f->positions,
                             .vertex_count = VERTICES,
                             .indices = f->indices,
                             .index_count = 3 * TRIANGLES,
                             .index_size = 4};
}

static csm_result CSM_CALL give(void *user, csm_mesh mesh, csm_mesh_info *info) {
  const fixture *f = user;
  if (mesh != f->mesh)
    return CSM_ERROR_INVALID_HANDLE;
  *info = f->hills;
  return CSM_SUCCESS;
}

static void setup(fixture *f, uint32_t flags) {
  memset(f, 0, sizeof *f);
  csm_create_info info = support_create_info(&f->record);
  info.flags |= flags;
  info.supply = flags & CSM_CREATE_KEEP_GEOMETRY ? NULL : give;
  assert_int_equal(csm_create(&info, &f->context), CSM_SUCCESS);
  csm_config config = support_config();
  config.resolution = 256;
  config.caster_set = CSM_CASTER_SET_MAP;
  assert_int_equal(csm_cascades_create(f->context, &config, &f->all), CSM_SUCCESS);
  config.caster_set = CSM_CASTER_SET_VIEW;
  assert_int_equal(csm_cascades_create(f->context, &config, &f->seen), CSM_SUCCESS);
  f->view = support_view(f->context);
  make_hills(f);
  assert_int_equal(csm_mesh_create(f->context, &f->hills, &f->mesh), CSM_SUCCESS);
  for (int i = 0; i < INSTANCES; ++i) /* more of them, mirrored and turned */
    f->instances[i] = support_instance(f->mesh, 3 * i, 0.3 * i - 1, 5 * i, i % 2 ? -1 : 1, 1 + 0.2 * i, 1);
}

/* A mask, and how many triangles were drawn for it. */
typedef struct drawing {
  float *mask;
  uint64_t triangles;
} drawing;

static drawing draw(fixture *f, csm_cascades *cascades, double turn) {
  shot shot = shot_make(f->instances, INSTANCES);
  csm_stats stats = {.struct_size = sizeof stats};
  memcpy(shot.light.direction, (const double[]){0.8, -0.6, 0.25}, sizeof shot.light.direction);
  support_look_at(shot.camera.view, (const double[]){-4, 4, 12},
                  (const double[]){12 * sin(turn), 0, 12 - 12 * cos(turn)});
  support_perspective(shot.camera.projection, 40, 1.5, 0.25, 200);
  assert_int_equal(csm_render_cascades(cascades, shot_frame(&shot)), CSM_SUCCESS);
  assert_int_equal(shot_resolve(&shot, f->view, cascades, WIDTH, HEIGHT), CSM_SUCCESS);
  assert_int_equal(csm_get_stats(cascades, &stats), CSM_SUCCESS);
  drawing drawn = {.mask = support_image(f->context, f->view, CSM_READ_MASK, WIDTH, HEIGHT)};
  for (uint32_t i = 0; i < stats.cascade_count; ++i)
    drawn.triangles += stats.cascades[i].triangles_drawn;
  return drawn;
}

/* Both ways from all sides; gives how many triangles the second draws, of the first's. */
static double compare(fixture *f) {
  double all = 0, seen = 0;
  uint32_t dark = 0;
  for (int i = 0; i < 6; ++i) {
    drawing whole = draw(f, f->all, 1.05 * i), parts = draw(f, f->seen, 1.05 * i);
    assert_memory_equal(whole.mask, parts.mask, WIDTH * HEIGHT * sizeof *whole.mask);
    for (int k = 0; k < WIDTH * HEIGHT; ++k)
      dark += whole.mask[k] < 0.5f;
    all += (double)whole.triangles;
    seen += (double)parts.triangles;
    free(whole.mask);
    free(parts.mask);
  }
  assert_true(dark > 500 || !strcmp(support_backend(), "null"));
  return seen / all;
}

static void move(fixture *f, double phase) {
  place_hills(f, phase);
  const csm_mesh_update_info info = {.struct_size = sizeof info, .positions = f->positions};
  assert_int_equal(csm_mesh_update(f->context, f->mesh, &info), CSM_SUCCESS);
}

static void switch_device(fixture *f) {
  csm_create_info info = support_create_info(&f->record);
  info.backend = support_backend();
  assert_int_equal(csm_switch_backend(f->context, &info), CSM_SUCCESS);
}

static void masks_are_the_same_by_parts(void **state) {
  (void)state;
  static fixture f;
  for (int kept = 0; kept < 2; ++kept) {
    setup(&f, kept ? CSM_CREATE_KEEP_GEOMETRY : 0);
    const double parts = compare(&f);
    assert_true(parts < 0.8);
    switch_device(&f);
    assert_true(compare(&f) == parts);
    move(&f, 0.7);
    const double whole = compare(&f);
    assert_true(whole > 1.1 * parts);
    switch_device(&f);
    assert_true(compare(&f) == whole);
    support_close(f.context, &f.record);
  }
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(masks_are_the_same_by_parts)};
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
