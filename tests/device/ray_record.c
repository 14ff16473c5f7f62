/* What rays find of an instance: rows that take the world to where the mesh's positions are stored, as shaders do it. */
#include "techniques/rays/ray_record.h"

#include <fenv.h>
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

#include "../plan/support.h"

typedef struct record {
  float rows[RAY_RECORD_ROWS][4];
} record;

static mesh_rays some_rays(void) {
  return (mesh_rays){.node_row = 1000,
                     .node_count = 77,
                     .triangle_row = 1077,
                     .triangle_count = 50,
                     .uv_row = 2000,
                     .alpha_row = 3000,
                     .alpha_size = {640, 16384},
                     .alpha_wrap = {CSM_WRAP_MIRROR, CSM_WRAP_CLAMP},
                     .alpha_cutoff = 0.25f,
                     .grid_scale = {10.0, 20.0, 1e9},
                     .grid_offset = {1.0, -3.5, 100.0},
                     .reach = 40.0};
}

static record write_record(const plan_instance *instance, const plan_bounds *bounds, const mesh_rays *rays) {
  record out;
  _Static_assert(sizeof out == RAY_RECORD_SIZE, "a record");
  feclearexcept(FE_ALL_EXCEPT);
  ray_record_write(&out, instance, bounds, rays);
  assert_no_exceptions();
  for (int row = 0; row < 6; ++row)
    assert_true(plan_finite_floats(out.rows[row], 4));
  return out;
}

static uint32_t whole(const record *r, int row, int column) {
  uint32_t value;
  memcpy(&value, &r->rows[row][column], sizeof value);
  return value;
}

/* ---- transforms ---- */

typedef enum kind { TURNED, MIRRORED, SHEARED, STRETCHED, FAR_AWAY, OFF_ITS_ORIGIN, KINDS } kind;

static void multiply(double out[9], const double a[9], const double b[9]) {
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      out[row * 3 + column] = a[row * 3] * b[column] + a[row * 3 + 1] * b[3 + column] + a[row * 3 + 2] * b[6 + column];
}

/* About a random axis (Rodrigues), in rows. */
static void turn(random_state *random, double out[9]) {
  double k[3];
  random_unit(random, k);
  const double angle = random_between(random, 0.0, 7.0), c = cos(angle), s = sin(angle);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      out[i * 3 + j] = k[i] * k[j] * (1.0 - c) + (i == j ? c : (j == (i + 1) % 3 ? -s : s) * k[3 - i - j]);
}

static plan_instance random_instance(random_state *random, kind kind) {
  plan_instance out = {0};
  double first[9], second[9], middle[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, half[9], all[9];
  const double size = random_scale(random, 1e-3, 1e3);
  for (int i = 0; i < 3; ++i)
    middle[i * 4] = kind == STRETCHED ? random_scale(random, 1.0, 100.0) : 1.0;
  if (kind == MIRRORED)
    middle[random_below(random, 3) * 4] = -1.0;
  if (kind == SHEARED)
    middle[1] = random_between(random, -5.0, 5.0), middle[5] = random_between(random, -5.0, 5.0);
  turn(random, first);
  turn(random, second);
  multiply(half, first, middle);
  multiply(all, half, second);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      out.transform[row * 4 + column] = size * all[row * 3 + column];
    out.transform[row * 4 + 3] = random_between(random, -1.0, 1.0) * (kind == FAR_AWAY ? 1e7 : 100.0);
  }
  return out;
}

/* ---- what must hold ---- */

/*
 * A place of the mesh, taken to the world here, and back by the record as a shader does it, but in doubles: what is left
 * is what its floats were rounded by, each by 2^-24, and two of them together by 2^-48.
 */
static void check_place(const plan_instance *instance, const plan_bounds *bounds, const record *r,
                        const double stored[3]) {
  double away[3], reach[3];
  for (int row = 0; row < 3; ++row) {
    const double *t = &instance->transform[row * 4];
    long double world = t[3], large = fabs(t[3]);
    for (int i = 0; i < 3; ++i) {
      world += (long double)t[i] * ((long double)stored[i] + bounds->offset[i]);
      large += fabsl((long double)t[i] * bounds->offset[i]);
    }
    away[row] = (double)(world - r->rows[row][3] - r->rows[3][row]);
    reach[row] = (double)large;
  }
  for (int i = 0; i < 3; ++i) {
    double back = 0.0, rounding = 0.0;
    for (int k = 0; k < 3; ++k) {
      back += (double)r->rows[i][k] * away[k];
      rounding += fabs((double)r->rows[i][k]) * (fabs(away[k]) * 0x1p-23 + reach[k] * 0x1p-47);
    }
    assert_near(back, stored[i], rounding);
  }
}

/* A metre of the world is in no direction longer in the mesh than the record says, nor much shorter in all of them. */
static void check_length(random_state *random, const record *r) {
  double most = 0.0;
  for (int i = 0; i < 200; ++i) {
    double way[3], length = 0.0;
    random_unit(random, way);
    for (int row = 0; row < 3; ++row) {
      const float *m = r->rows[row];
      const double along = (double)m[0] * way[0] + (double)m[1] * way[1] + (double)m[2] * way[2];
      length += along * along;
    }
    most = fmax(most, sqrt(length));
  }
  const double told = r->rows[3][3];
  assert_true(most <= told * 1.000001 && told < most * 1.8);
}

static void places_are_those_of_the_mesh(void **state) {
  (void)state;
  random_state random = {1};
  const mesh_rays rays = some_rays();
  for (int i = 0; i < 6000; ++i) {
    const kind kind = (enum kind)(i % KINDS);
    const plan_instance instance = random_instance(&random, kind);
    plan_bounds bounds = {0};
    for (int axis = 0; axis < 3 && kind == OFF_ITS_ORIGIN; ++axis)
      bounds.offset[axis] = random_between(&random, -1e6, 1e6);
    const record r = write_record(&instance, &bounds, &rays);
    assert_int_equal(whole(&r, 6, 1), rays.node_count);
    for (int k = 0; k < 8; ++k) {
      double stored[3];
      for (int axis = 0; axis < 3; ++axis)
        stored[axis] = random_between(&random, -rays.reach, rays.reach);
      check_place(&instance, &bounds, &r, stored);
    }
    check_length(&random, &r);
  }
}

static void a_record_says_where_the_tree_is(void **state) {
  (void)state;
  const mesh_rays rays = some_rays();
  const plan_instance instance = {.transform = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
  const record r = write_record(&instance, &(plan_bounds){0}, &rays);
  for (int axis = 0; axis < 3; ++axis) {
    assert_true(r.rows[4][axis] == (float)rays.grid_scale[axis]);
    assert_true(r.rows[5][axis] == (float)rays.grid_offset[axis]);
  }
  /* A few last places of the largest coordinate */
  assert_true(r.rows[5][3] > 40.0f * 0x1p-23f && r.rows[5][3] < 40.0f * 0x1p-19f);
  const uint32_t expected[2][4] = {{1000, 77, 1077, 2000}, {3000, 640 | 16384u << 16, CSM_WRAP_MIRROR | 1 << 16, 0}};
  for (int row = 0; row < 2; ++row)
    for (int column = 0; column < 4 - row; ++column)
      assert_int_equal(whole(&r, 6 + row, column), expected[row][column]);
  assert_true(r.rows[7][3] == rays.alpha_cutoff);
}

/* ---- what cannot be traced ---- */

static bool is_traced(const double t[12], const plan_bounds *bounds) {
  const mesh_rays rays = some_rays();
  plan_instance instance = {0};
  memcpy(instance.transform, t, sizeof instance.transform);
  const record r = write_record(&instance, bounds, &rays);
  assert_true(whole(&r, 6, 1) == rays.node_count || (whole(&r, 6, 1) == 0 && whole(&r, 6, 3) == MESH_RAYS_NONE));
  return whole(&r, 6, 1) != 0;
}

static void flat_ones_are_not_traced(void **state) {
  (void)state;
  static const double flat[][12] = {
      {0},                                  /* nothing */
      {1, 0, 0, 5, 0, 0, 0, 6, 0, 0, 1, 7}, /* an axis that is 0 */
      {1, 2, 0, 0, 1, 2, 0, 0, 0, 0, 1, 0}, /* two axes along one line */
      {1, 2, 3, 0, 4, 5, 6, 0, 7, 8, 9, 0}, /* three of them in a plane */
      {1, 0, 0, 0, 0, 1e-6, 0, 0, 0, 0, 1, 0},
      {1e3, 0, 0, 0, 0, 1e-3, 0, 0, 0, 0, 1, 0},
      {1, 1, 0, 0, 1, 1.000001, 0, 0, 0, 0, 1, 0},
      {1e16, 0, 0, 0, 0, 1e16, 0, 0, 0, 0, 1e16, 0},
      {1e-16, 0, 0, 0, 0, 1e-16, 0, 0, 0, 0, 1e-16, 0},
      {1e30, 0, 0, 0, 0, 1e-30, 0, 0, 0, 0, 1, 0},
      {5e-324, 0, 0, 0, 0, 5e-324, 0, 0, 0, 0, 5e-324, 0},
  };
  for (size_t i = 0; i < sizeof flat / sizeof *flat; ++i)
    if (is_traced(flat[i], &(plan_bounds){0}))
      fail_msg("transform %zu is traced", i);
  const plan_instance instance = {.transform = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
  const record none = write_record(&instance, &(plan_bounds){0}, NULL);
  assert_int_equal(whole(&none, 6, 1), 0);
}

static void what_is_thin_is_traced(void **state) {
  (void)state;
  static const double thin[][12] = {
      {1, 0, 0, 0, 0, 1e-4, 0, 0, 0, 0, 1, 0},          {1e2, 0, 0, 0, 0, 1e-2, 0, 0, 0, 0, -1, 0},
      {1, 100, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0},           {1e10, 0, 0, 0, 0, 1e10, 0, 0, 0, 0, 1e10, 0},
      {1e-10, 0, 0, 0, 0, 1e-10, 0, 0, 0, 0, 1e-10, 0},
  };
  for (size_t i = 0; i < sizeof thin / sizeof *thin; ++i)
    if (!is_traced(thin[i], &(plan_bounds){0}))
      fail_msg("transform %zu is not traced", i);
}

/* Numbers of any size, for a mesh whose positions may be anything, too: nothing overflows. */
static void any_number_gives_a_record(void **state) {
  (void)state;
  static const double sizes[] = {0.0, 1e-300, 1e-30, 1e-14, 1.0, 1e14, 1e30, -1e30};
  enum { SIZES = sizeof sizes / sizeof *sizes };
  random_state random = {2};
  uint32_t traced = 0;
  for (int i = 0; i < 20000; ++i) {
    const double same = sizes[random_below(&random, SIZES)];
    plan_bounds bounds = {0};
    double t[12];
    for (int k = 0; k < 12; ++k)
      t[k] = random_below(&random, 3) ? (k % 5 ? 0.0 : same) : sizes[random_below(&random, SIZES)];
    for (int axis = 0; axis < 3; ++axis)
      bounds.offset[axis] = random_below(&random, 2) ? 0.0 : (random_below(&random, 2) ? 1.0 : -1.0) * FLT_MAX;
    traced += is_traced(t, &bounds);
  }
  assert_true(traced > 100);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(places_are_those_of_the_mesh), cmocka_unit_test(a_record_says_where_the_tree_is),
      cmocka_unit_test(flat_ones_are_not_traced),     cmocka_unit_test(what_is_thin_is_traced),
      cmocka_unit_test(any_number_gives_a_record),
  };
  return cmocka_run_group_tests_name("ray-record", tests, NULL, NULL);
}
