/*
 * traps.c: exceptions trap while every number that an engine hands over takes the values that raise them: no call ends
 * in a signal, what is no number is refused by name, and what is planned is finite. On the null backend; the tests of
 * conformance run with traps on every backend as well (traps_on.c).
 */
#include "../conformance/support.h"

#include <fenv.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
  TRAPPED = FE_DIVBYZERO | FE_INVALID | FE_OVERFLOW,
  VERTICES = 4,
  INDICES = 6,
  ROWS = 2,
  WIDTH = 24,
  HEIGHT = 16
};

/* All that is handed over, as it is when nothing is wrong with it. */
typedef struct numbers {
  double view[16], projection[16], direction[3], angular_diameter, origin[3];
  double transform[16], matrices[16], rows_origin[3];
  float rows[12 * ROWS], positions[3 * VERTICES], uvs[2 * VERTICES], moved[3 * VERTICES], cutoff;
  csm_config config;
} numbers;

typedef struct place {
  uint32_t offset, size; /* in numbers; of one number */
} place;

enum { MOST_PLACES = 512 };

typedef struct fixture {
  record record;
  csm_context *context;
  csm_view *view;
  csm_alpha_mask alpha_mask;
  csm_mesh box;
  numbers good;
  place places[MOST_PLACES];
  uint32_t place_count;
} fixture;

static void add_places(fixture *f, uint32_t offset, uint32_t size, uint32_t count) {
  for (uint32_t i = 0; i < count; ++i) {
    assert_true(f->place_count < MOST_PLACES);
    f->places[f->place_count++] = (place){offset + i * size, size};
  }
}

/* The doubles of the configuration lie at its end, for they are listed by describing them. */
static void list_places(fixture *f) {
  const uint32_t doubles = offsetof(numbers, rows) / sizeof(double);
  add_places(f, 0, sizeof(double), doubles);
  add_places(f, offsetof(numbers, rows), sizeof(float), (offsetof(numbers, cutoff) - offsetof(numbers, rows)) / 4 + 1);
  csm_config_field field = {.struct_size = sizeof field};
  for (uint32_t i = 0; csm_config_describe(i, &field) == CSM_SUCCESS; ++i)
    if (field.type == CSM_FIELD_DOUBLE || field.type == CSM_FIELD_DOUBLES)
      add_places(f, (uint32_t)offsetof(numbers, config) + field.offset, sizeof(double), field.length);
}

static void fill_numbers(numbers *out) {
  static const float square[3 * VERTICES] = {-1, 0, -1, 1, 0, -1, 1, 0, 1, -1, 0, 1};
  support_scene scene;
  support_scene_make(&scene, NULL);
  memcpy(out->view, scene.shot.camera.view, sizeof out->view);
  memcpy(out->projection, scene.shot.camera.projection, sizeof out->projection);
  memcpy(out->direction, scene.shot.light.direction, sizeof out->direction);
  out->angular_diameter = 0.01;
  memcpy(out->transform, scene.instances[1].transform, sizeof out->transform);
  memcpy(out->matrices, scene.instances[2].transform, sizeof out->matrices);
  for (int i = 0; i < ROWS; ++i)
    out->rows[12 * i] = out->rows[12 * i + 5] = out->rows[12 * i + 10] = (float)(i + 1);
  memcpy(out->positions, square, sizeof square);
  memcpy(out->moved, square, sizeof square);
  for (int i = 0; i < 2 * VERTICES; ++i)
    out->uvs[i] = (float)(i % 3);
  out->cutoff = 0.5f;
  out->config = support_config();
  out->config.resolution = 32;
}

static void open_fixture(fixture *f, uint32_t filter) {
  memset(f, 0, sizeof *f);
  f->context = support_open_with(&f->record, CSM_CREATE_RAYS);
  f->record.quiet = true;
  f->view = support_view(f->context);
  f->box = support_box(f->context, 2);
  const uint8_t texels[4] = {0, 255, 255, 0};
  const csm_alpha_mask_info mask = {.struct_size = sizeof mask, .width = 2, .height = 2, .texels = texels};
  assert_int_equal(csm_alpha_mask_create(f->context, &mask, &f->alpha_mask), CSM_SUCCESS);
  fill_numbers(&f->good);
  f->good.config.filter = filter;
  list_places(f);
}

/* ---- every call that takes numbers ---- */

/* By its bits, for a comparison may raise what is looked for here. */
static bool is_finite(float value) {
  uint32_t bits;
  memcpy(&bits, &value, sizeof bits);
  return (bits & 0x7f800000u) != 0x7f800000u;
}

static void expect_finite(const void *constants, uint32_t size) {
  const float *values = constants;
  for (uint32_t i = 0; i < size / sizeof *values; ++i)
    if (!is_finite(values[i]))
      fail_msg("constant %u is not finite", i);
}

static csm_result make_mesh(const fixture *f, const numbers *n, csm_mesh *mesh) {
  static const uint16_t indices[INDICES] = {0, 2, 1, 0, 3, 2};
  const csm_mesh_info info = {.struct_size = sizeof info,
                              .positions = n->positions,
                              .vertex_count = VERTICES,
                              .indices = indices,
                              .index_count = INDICES,
                              .index_size = 2,
                              .uvs = n->uvs,
                              .alpha_mask = f->alpha_mask,
                              .alpha_cutoff = n->cutoff};
  const csm_mesh_update_info update = {.struct_size = sizeof update, .positions = n->moved};
  const csm_result made = csm_mesh_create(f->context, &info, mesh);
  return made ? made : csm_mesh_update(f->context, *mesh, &update);
}

static csm_result fill_scene(const fixture *f, const numbers *n, csm_mesh mesh, csm_scene *scene) {
  csm_instance_id id, rows[ROWS];
  csm_instance instances[ROWS] = {support_instance(mesh, 0, 0, 0, 1, 1, 1), support_instance(f->box, 0, 0, 0, 1, 1, 1)};
  csm_scene_batch batch = {.struct_size = sizeof batch, .count = ROWS, .ids = rows, .instances = instances};
  batch.rows = n->rows;
  memcpy(batch.origin, n->rows_origin, sizeof batch.origin);
  csm_result result = csm_scene_add(scene, &batch);
  memcpy(instances[0].transform, n->transform, sizeof n->transform);
  batch = (csm_scene_batch){.struct_size = sizeof batch, .count = 1, .ids = &id, .instances = instances};
  if (!result)
    result = csm_scene_add(scene, &batch);
  batch.instances = NULL;
  batch.matrices = n->matrices;
  return result ? result : csm_scene_move(scene, &batch);
}

static csm_result draw(const fixture *f, const numbers *n, csm_scene *scene, csm_cascades *cascades) {
  shot shot = shot_make(NULL, 0);
  csm_binding binding = {.struct_size = sizeof binding};
  csm_stats stats = {.struct_size = sizeof stats};
  memcpy(shot.camera.view, n->view, sizeof n->view);
  memcpy(shot.camera.projection, n->projection, sizeof n->projection);
  memcpy(shot.light.direction, n->direction, sizeof n->direction);
  shot.light.angular_diameter = n->angular_diameter;
  shot.frame.origin = n->origin;
  shot.frame.scene = scene;
  csm_result result = csm_render_cascades(cascades, shot_frame(&shot));
  if (!result)
    result = shot_resolve(&shot, f->view, cascades, WIDTH, HEIGHT);
  if (!result)
    result = csm_bind(cascades, &binding);
  if (result)
    return result;
  expect_finite(binding.cascade_constants, binding.cascade_constants_size);
  expect_finite(binding.setting_constants, binding.setting_constants_size);
  return csm_get_stats(cascades, &stats);
}

/* The first error of all that takes numbers. */
static csm_result use(const fixture *f, const numbers *n) {
  csm_mesh mesh = 0;
  csm_scene *scene = NULL;
  csm_cascades *cascades = NULL;
  feclearexcept(FE_ALL_EXCEPT);
  feenableexcept(TRAPPED);
  csm_result result = make_mesh(f, n, &mesh);
  if (!result)
    result = csm_scene_create(f->context, &scene);
  if (!result)
    result = fill_scene(f, n, mesh, scene);
  if (!result)
    result = csm_cascades_create(f->context, &n->config, &cascades);
  for (int frame = 0; frame < 2 && !result; ++frame)
    result = draw(f, n, scene, cascades);
  csm_cascades_destroy(cascades);
  csm_scene_destroy(scene);
  if (mesh)
    assert_int_equal(csm_mesh_destroy(f->context, mesh), CSM_SUCCESS);
  fedisableexcept(TRAPPED);
  return result;
}

/* ---- numbers that hurt ---- */

static double special(uint32_t index) {
  static const double values[] = {NAN,      -NAN,   INFINITY, -INFINITY, DBL_MAX, -DBL_MAX, 1e155,
                                  -1e155,   1e31,   FLT_MAX,  -FLT_MAX,  1e-310,  5e-324,   1e-45,
                                  1.0e-160, -1e-40, 0.0,      -0.0,      1e16,    -1.0};
  return values[index % (sizeof values / sizeof *values)];
}

enum { SPECIALS = 20, SIGNALLING = 4 };

/* A float that is out of its range becomes an infinity. Numbers are put by their bits: those of a signalling one, too. */
static void put(numbers *n, const place *place, uint32_t index, bool signalling) {
  char *at = (char *)n + place->offset;
  if (place->size == sizeof(float)) {
    float value = (float)special(index);
    const uint32_t bits = 0x7fa00000u;
    memcpy(at, signalling ? (const void *)&bits : &value, sizeof value);
  } else {
    double value = special(index);
    const uint64_t bits = 0x7ff4000000000000u;
    memcpy(at, signalling ? (const void *)&bits : &value, sizeof value);
  }
}

static bool is_named(csm_result result) {
  return result == CSM_ERROR_NOT_FINITE || result == CSM_ERROR_INVALID_MATRIX || result == CSM_ERROR_INVALID_CAMERA ||
         result == CSM_ERROR_INVALID_LIGHT || result == CSM_ERROR_INVALID_VALUE;
}

/* Whoever hands over something that is no number is told so, whatever else may be wrong with it. */
static void spoil_each_number(uint32_t filter) {
  fixture f;
  open_fixture(&f, filter);
  assert_int_equal(use(&f, &f.good), CSM_SUCCESS);
  for (uint32_t i = 0; i < f.place_count; ++i)
    for (uint32_t k = 0; k < SPECIALS + 1; ++k) {
      numbers odd = f.good;
      const bool none = k < SIGNALLING || k == SPECIALS;
      put(&odd, &f.places[i], k, k == SPECIALS);
      const csm_result result = use(&f, &odd);
      if (none ? result != CSM_ERROR_NOT_FINITE : result && !is_named(result))
        fail_msg("number %u at %u as special %u: %s (%s)", i, f.places[i].offset, k, csm_result_name(result),
                 csm_last_error(f.context));
    }
  assert_int_equal(use(&f, &f.good), CSM_SUCCESS);
  support_close(f.context, &f.record);
}

static void each_number_may_be_anything(void **state) {
  (void)state;
  spoil_each_number(CSM_FILTER_PCF_3X3);
  spoil_each_number(CSM_FILTER_EXACT);
}

/* Two and more at once: infinities that meet, scales that cancel. */
static void spoil_many_numbers(uint32_t filter) {
  enum { TRIES = 5000 };
  fixture f;
  open_fixture(&f, filter);
  uint64_t random = 1;
  uint32_t drawn = 0;
  for (uint32_t i = 0; i < TRIES; ++i) {
    numbers odd = f.good;
    for (uint32_t count = 2 + i % 3; count; --count) {
      random = random * 6364136223846793005u + 1442695040888963407u;
      const uint32_t chosen = (uint32_t)(random >> 33);
      put(&odd, &f.places[chosen / SPECIALS % f.place_count], chosen % SPECIALS, false);
    }
    const csm_result result = use(&f, &odd);
    if (result && !is_named(result))
      fail_msg("try %u: %s (%s)", i, csm_result_name(result), csm_last_error(f.context));
    drawn += !result;
  }
  assert_true(drawn > TRIES / 100);
  support_close(f.context, &f.record);
}

static void many_numbers_may_be_anything(void **state) {
  (void)state;
  spoil_many_numbers(CSM_FILTER_PCF_3X3);
  spoil_many_numbers(CSM_FILTER_EXACT);
}

static void set_field(csm_config *config, const csm_config_field *field, double value) {
  char *at = (char *)config + field->offset;
  for (uint32_t i = 0; i < field->length; ++i)
    if (field->type == CSM_FIELD_DOUBLE || field->type == CSM_FIELD_DOUBLES)
      memcpy(at + i * sizeof value, &value, sizeof value);
    else
      memcpy(at + i * sizeof(uint32_t), &(uint32_t){(uint32_t)value}, sizeof(uint32_t));
}

/* Every field at its ends, and with every other field at its ends. */
static void each_pair_of_settings_may_be_at_its_ends(void **state) {
  (void)state;
  fixture f;
  open_fixture(&f, CSM_FILTER_PCF_3X3);
  csm_config_field a = {.struct_size = sizeof a}, b = {.struct_size = sizeof b};
  uint32_t drawn = 0, refused = 0;
  for (uint32_t i = 0; csm_config_describe(i, &a) == CSM_SUCCESS; ++i)
    for (uint32_t k = 0; k <= i && csm_config_describe(k, &b) == CSM_SUCCESS; ++k)
      for (uint32_t ends = 0; ends < 4; ++ends) {
        numbers odd = f.good;
        set_field(&odd.config, &a, ends & 1 ? a.maximum : a.minimum);
        set_field(&odd.config, &b, ends & 2 ? b.maximum : b.minimum);
        const csm_result result = use(&f, &odd);
        if (result && result != CSM_ERROR_INVALID_VALUE && result != CSM_ERROR_LIMIT_EXCEEDED)
          fail_msg("%s and %s, ends %u: %s (%s)", a.name, b.name, ends, csm_result_name(result),
                   csm_last_error(f.context));
        drawn += !result;
        refused += result != CSM_SUCCESS;
      }
  assert_true(drawn > 1000 && refused < drawn);
  support_close(f.context, &f.record);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(each_number_may_be_anything),
      cmocka_unit_test(many_numbers_may_be_anything),
      cmocka_unit_test(each_pair_of_settings_may_be_at_its_ends),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
