/* The light's basis over the whole sphere of directions. */
#include "support.h"

#include <math.h>
#include <string.h>

static double dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void make_basis(double basis[9], const double direction[3]) {
  const char *error = "";
  if (plan_light_basis(basis, direction, &error))
    fail_msg("%g %g %g: %s", direction[0], direction[1], direction[2], error);
}

/* Orthonormal, along the unit direction, and right = along x up, so that the map is no mirror image. */
static void check_basis(const double basis[9], const double unit[3]) {
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b)
      assert_near(dot(&basis[a * 3], &basis[b * 3]), a == b, 1e-15);
    assert_near(basis[6 + a], unit[a], 4e-16);
    const int b = (a + 1) % 3, c = (a + 2) % 3;
    assert_near(basis[6 + b] * basis[3 + c] - basis[6 + c] * basis[3 + b], basis[a], 1e-15);
  }
}

static void is_orthonormal_for_every_direction(void **state) {
  (void)state;
  random_state random = {1};
  double unit[3], basis[9];
  for (int i = 0; i < 200000; ++i) {
    random_unit(&random, unit);
    const double length = sqrt(dot(unit, unit));
    for (int k = 0; k < 3; ++k)
      unit[k] /= length;
    make_basis(basis, unit);
    check_basis(basis, unit);
  }
}

static void is_orthonormal_along_the_axes_and_beside_them(void **state) {
  (void)state;
  const double away[] = {0.0, 1e-300, 1e-17, 1e-8, 1.745e-5, 1e-3};
  for (int axis = 0; axis < 6; ++axis)
    for (int side = 0; side < 3; ++side)
      for (size_t i = 0; i < sizeof away / sizeof *away; ++i) {
        double unit[3] = {0}, basis[9];
        unit[side] = away[i];
        unit[axis / 2] = axis % 2 ? -1.0 : 1.0;
        const double length = sqrt(dot(unit, unit));
        for (int k = 0; k < 3; ++k)
          unit[k] /= length;
        make_basis(basis, unit);
        check_basis(basis, unit);
      }
}

/* Where the basis turns over: found by where `right` changes most, and walked into down to the last bit. */
static void is_orthonormal_where_it_turns_over(void **state) {
  (void)state;
  random_state random = {2};
  const double pole[3] = {0.4379, 0.6471, 0.6241}, length = sqrt(dot(pole, pole));
  for (int i = 0; i < 20000; ++i) {
    double unit[3], aside[3], basis[9];
    random_unit(&random, aside);
    const double away = i % 10 ? random_scale(&random, 1e-17, 1e-1) : 0.0;
    for (int k = 0; k < 3; ++k)
      unit[k] = pole[k] / length + away * aside[k];
    const double norm = sqrt(dot(unit, unit));
    for (int k = 0; k < 3; ++k)
      unit[k] /= norm;
    make_basis(basis, unit);
    check_basis(basis, unit);
  }
}

/* A light that turns by an angle turns the basis by no more than a few times that, but near the one direction. */
static void turns_smoothly(void **state) {
  (void)state;
  random_state random = {3};
  const double pole[3] = {0.4379, 0.6471, 0.6241};
  for (int i = 0; i < 50000; ++i) {
    double unit[3], moved[3], aside[3], before[9], after[9];
    const double angle = random_scale(&random, 1e-9, 1e-2);
    random_unit(&random, unit);
    if (dot(unit, pole) > 0.95)
      continue;
    random_unit(&random, aside);
    for (int k = 0; k < 3; ++k)
      moved[k] = unit[k] + angle * aside[k];
    make_basis(before, unit);
    make_basis(after, moved);
    for (int k = 0; k < 9; ++k)
      assert_near(after[k], before[k], 10.0 * angle + 1e-15);
  }
}

static void ignores_the_length(void **state) {
  (void)state;
  random_state random = {4};
  for (int i = 0; i < 5000; ++i) {
    double unit[3], scaled[3], expected[9], basis[9];
    random_unit(&random, unit);
    const int exponent = (int)random_below(&random, 1900) - 960;
    for (int k = 0; k < 3; ++k)
      scaled[k] = ldexp(unit[k], exponent);
    make_basis(expected, unit);
    make_basis(basis, scaled);
    assert_memory_equal(basis, expected, sizeof basis);
  }
  double basis[9];
  make_basis(basis, (double[]){0.0, -4.9e-324, 0.0});
  check_basis(basis, (double[]){0.0, -1.0, 0.0});
  make_basis(basis, (double[]){1.7e308, 0.0, -1.7e308});
  check_basis(basis, (double[]){sqrt(0.5), 0.0, -sqrt(0.5)});
}

static void refuses_what_is_no_direction(void **state) {
  (void)state;
  double basis[9];
  const char *error = "";
  assert_int_equal(plan_light_basis(basis, (double[]){0.0, -0.0, 0.0}, &error), CSM_ERROR_INVALID_LIGHT);
  assert_non_null(strstr(error, "direction"));
  assert_int_equal(plan_light_basis(basis, (double[]){0.0, NAN, 1.0}, &error), CSM_ERROR_NOT_FINITE);
  assert_int_equal(plan_light_basis(basis, (double[]){0.0, 1.0, -INFINITY}, &error), CSM_ERROR_NOT_FINITE);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(is_orthonormal_for_every_direction),
      cmocka_unit_test(is_orthonormal_along_the_axes_and_beside_them),
      cmocka_unit_test(is_orthonormal_where_it_turns_over),
      cmocka_unit_test(turns_smoothly),
      cmocka_unit_test(ignores_the_length),
      cmocka_unit_test(refuses_what_is_no_direction),
  };
  return cmocka_run_group_tests_name("plan-light", tests, NULL, NULL);
}
