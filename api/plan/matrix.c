/* matrix.c: the few matrix operations that a plan needs, for numbers of any scale. */
#include "plan/internal.h"

#include <float.h>
#include <math.h>
#include <string.h>

void plan_multiply(double out[16], const double a[16], const double b[16]) {
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 4; ++row) {
      double sum = 0.0;
      for (int k = 0; k < 4; ++k)
        sum += a[k * 4 + row] * b[column * 4 + k];
      out[column * 4 + row] = sum;
    }
}

/* The power of two that brings the largest of four values, `stride` apart, into [0.5, 1); 0 if all are 0. */
static bool binary_exponent(int *exponent, const double *values, int stride) {
  double largest = 0.0;
  for (int i = 0; i < 4; ++i)
    largest = fmax(largest, fabs(values[i * stride]));
  (void)frexp(largest, exponent);
  return largest > 0.0;
}

/* Scales by powers of two, which loses nothing, until the largest entry of every row and column is about 1. */
static bool equilibrate(double m[16], int rows[4], int columns[4]) {
  for (int pass = 0; pass < 3; ++pass)
    for (int i = 0; i < 4; ++i) {
      int column = 0, row = 0;
      if (!binary_exponent(&column, &m[i * 4], 1))
        return false;
      for (int k = 0; k < 4; ++k)
        m[i * 4 + k] = ldexp(m[i * 4 + k], -column);
      if (!binary_exponent(&row, &m[i], 4))
        return false;
      for (int k = 0; k < 4; ++k)
        m[k * 4 + i] = ldexp(m[k * 4 + i], -row);
      columns[i] -= column;
      rows[i] -= row;
    }
  return true;
}

static void swap_rows(double m[16], int a, int b) {
  for (int column = 0; column < 4; ++column) {
    const double value = m[column * 4 + a];
    m[column * 4 + a] = m[column * 4 + b];
    m[column * 4 + b] = value;
  }
}

static int pivot_row(const double m[16], int column) {
  int best = column;
  for (int row = column + 1; row < 4; ++row)
    if (fabs(m[column * 4 + row]) > fabs(m[column * 4 + best]))
      best = row;
  return best;
}

/* Gauss-Jordan elimination with partial pivoting; m becomes the identity. */
static bool eliminate(double m[16], double inverse[16]) {
  const double singular = 1e-14; /* below it, what is left of an equilibrated matrix is rounding error */
  for (int column = 0; column < 4; ++column) {
    const int best = pivot_row(m, column);
    if (!(fabs(m[column * 4 + best]) > singular))
      return false;
    swap_rows(m, column, best);
    swap_rows(inverse, column, best);
    const double scale = 1.0 / m[column * 4 + column];
    for (int k = 0; k < 4; ++k) {
      m[k * 4 + column] *= scale;
      inverse[k * 4 + column] *= scale;
    }
    for (int row = 0; row < 4; ++row) {
      const double factor = m[column * 4 + row];
      if (row == column || factor == 0.0)
        continue;
      for (int k = 0; k < 4; ++k) {
        m[k * 4 + row] -= factor * m[k * 4 + column];
        inverse[k * 4 + row] -= factor * inverse[k * 4 + column];
      }
    }
  }
  return true;
}

/* Multiplies by a power of two; false: the product is too large for a double. */
static bool scale_binary(double *value, int power) {
  int exponent;
  (void)frexp(*value, &exponent);
  if (*value != 0.0 && exponent + power > DBL_MAX_EXP)
    return false;
  *value = ldexp(*value, power);
  return true;
}

bool plan_invert(double out[16], const double m[16]) {
  if (!plan_finite(m, 16))
    return false;
  double scaled[16], inverse[16] = {[0] = 1.0, [5] = 1.0, [10] = 1.0, [15] = 1.0};
  for (int i = 0; i < 16; ++i)
    scaled[i] = m[i];
  int rows[4] = {0}, columns[4] = {0};
  if (!equilibrate(scaled, rows, columns) || !eliminate(scaled, inverse))
    return false;
  /* scaled = 2^rows m 2^columns, hence its inverse's rows take the columns' scales and the other way round */
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 4; ++row)
      if (!scale_binary(&inverse[column * 4 + row], columns[row] + rows[column]))
        return false;
  for (int i = 0; i < 16; ++i)
    out[i] = inverse[i];
  return true;
}

bool plan_finite(const double *values, uint32_t count) {
  return plan_within(values, count, DBL_MAX);
}

bool plan_finite_floats(const float *values, uint32_t count) {
  const uint32_t exponent = 0x7f800000u;
  bool finite = true;
  for (uint32_t i = 0; i < count; ++i) {
    uint32_t bits;
    memcpy(&bits, &values[i], sizeof bits);
    finite = finite && (bits & exponent) != exponent;
  }
  return finite;
}

/* By their bits, which a comparison of NaN would raise an exception for: those of positive numbers rise with them. */
bool plan_within(const double *values, uint32_t count, double most) {
  uint64_t limit, largest = 0;
  memcpy(&limit, &most, sizeof limit);
  for (uint32_t i = 0; i < count; ++i) {
    uint64_t bits;
    memcpy(&bits, &values[i], sizeof bits);
    bits &= INT64_MAX;
    largest = bits > largest ? bits : largest;
  }
  return largest <= limit;
}

void plan_cross(double out[3], const double a[3], const double b[3]) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

bool plan_normalize(double v[3]) {
  if (!plan_finite(v, 3))
    return false;
  const double largest = fmax(fabs(v[0]), fmax(fabs(v[1]), fabs(v[2])));
  if (largest == 0.0)
    return false;
  int exponent;
  (void)frexp(largest, &exponent);
  for (int i = 0; i < 3; ++i)
    v[i] = ldexp(v[i], -exponent);
  const double length = sqrt(plan_dot(v, v));
  for (int i = 0; i < 3; ++i)
    v[i] /= length;
  return true;
}

/* The signed volume of unit vectors along the columns, -1 to 1; 0 if a column is 0. */
static double unit_volume(const double m[16]) {
  double columns[3][3], cross[3];
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k)
      columns[i][k] = m[i * 4 + k];
    if (!plan_normalize(columns[i]))
      return 0.0;
  }
  plan_cross(cross, columns[0], columns[1]);
  return plan_dot(cross, columns[2]);
}

csm_result plan_check_affine(const double m[16]) {
  const double last_row = 1e-6; /* an engine that inverts matrices in floats leaves as much there */
  const double dependent = 1e-12;
  if (!plan_finite(m, 16))
    return CSM_ERROR_NOT_FINITE;
  const bool affine =
      fabs(m[3]) <= last_row && fabs(m[7]) <= last_row && fabs(m[11]) <= last_row && fabs(m[15] - 1.0) <= last_row;
  return affine && fabs(unit_volume(m)) > dependent ? CSM_SUCCESS : CSM_ERROR_INVALID_MATRIX;
}
