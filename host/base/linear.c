#include "base/linear.h"
#include <math.h>
#include <string.h>

void vec_subtract(double out[3], const double a[3], const double b[3]) {
  for (int i = 0; i < 3; i++)
    out[i] = a[i] - b[i];
}

void vec_cross(double out[3], const double a[3], const double b[3]) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

double vec_dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* hypot is slow, and only what is huge or tiny needs it: squares would leave a double's range. */
double vec_length(const double a[3]) {
  const double square = vec_dot(a, a);
  return square > 1e-200 && square < 1e200 ? sqrt(square) : hypot(hypot(a[0], a[1]), a[2]);
}

bool vec_normalize(double v[3]) {
  const double length = vec_length(v);
  if (!(length > 0.0) || !isfinite(length))
    return false;
  for (int i = 0; i < 3; i++)
    v[i] /= length;
  return true;
}

void mat_identity(double out[16]) {
  for (int i = 0; i < 16; i++)
    out[i] = i % 5 == 0 ? 1.0 : 0.0;
}

void mat_multiply(double out[16], const double a[16], const double b[16]) {
  for (int column = 0; column < 4; column++)
    for (int row = 0; row < 4; row++) {
      double sum = 0.0;
      for (int k = 0; k < 4; k++)
        sum += a[k * 4 + row] * b[column * 4 + k];
      out[column * 4 + row] = sum;
    }
}

/* The three row operations of an elimination. */
static void row_scale(double m[16], int row, double factor) {
  for (int column = 0; column < 4; column++)
    m[column * 4 + row] *= factor;
}

static void row_subtract(double m[16], int to, int from, double factor) {
  for (int column = 0; column < 4; column++)
    m[column * 4 + to] -= factor * m[column * 4 + from];
}

static void row_swap(double m[16], int a, int b) {
  for (int column = 0; column < 4; column++) {
    const double kept = m[column * 4 + a];
    m[column * 4 + a] = m[column * 4 + b];
    m[column * 4 + b] = kept;
  }
}

/* Gauss-Jordan elimination with partial pivoting. */
bool mat_invert(double out[16], const double m[16]) {
  double work[16];
  memcpy(work, m, sizeof work);
  mat_identity(out);
  for (int column = 0; column < 4; column++) {
    int pivot = column;
    for (int row = column + 1; row < 4; row++)
      if (fabs(work[column * 4 + row]) > fabs(work[column * 4 + pivot]))
        pivot = row;
    const double value = work[column * 4 + pivot];
    if (value == 0.0 || !isfinite(value))
      return false;
    row_swap(work, column, pivot);
    row_swap(out, column, pivot);
    row_scale(work, column, 1.0 / value);
    row_scale(out, column, 1.0 / value);
    for (int row = 0; row < 4; row++)
      if (row != column) {
        const double factor = work[column * 4 + row];
        row_subtract(work, row, column, factor);
        row_subtract(out, row, column, factor);
      }
  }
  return all_finite(out, 16);
}

void mat_transform(double out[4], const double m[16], const double v[3], double w) {
  for (int row = 0; row < 4; row++)
    out[row] = m[row] * v[0] + m[4 + row] * v[1] + m[8 + row] * v[2] + m[12 + row] * w;
}

void mat_place(double out[16], const double position[3], double turn, const double scale[3]) {
  const double c = cos(turn), s = sin(turn);
  const double placed[16] = {c * scale[0], 0.0, -s * scale[0], 0.0, 0.0,         scale[1],    0.0,         0.0,
                             s * scale[2], 0.0, c * scale[2],  0.0, position[0], position[1], position[2], 1.0};
  memcpy(out, placed, sizeof placed);
}

double mat_determinant3(const double m[16]) {
  double cross[3];
  vec_cross(cross, m + 4, m + 8);
  return vec_dot(m, cross);
}

bool all_finite(const double *values, uint32_t count) {
  for (uint32_t i = 0; i < count; i++)
    if (!isfinite(values[i]))
      return false;
  return true;
}
