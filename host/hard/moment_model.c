/* moment_model.c: Donnelly and Lauritzen 2006 (VSM), Annen et al. 2008 (ESM), Lauritzen and McCool 2008 (EVSM), Peters
 * and Klein 2015 (MSM, its Hamburger form). */
#include "hard/moment_model.h"
#include <math.h>

uint32_t moment_model_channels(const moment_model *model) {
  return model->filter == CSM_FILTER_ESM                                         ? 1
         : model->filter == CSM_FILTER_EVSM4 || model->filter == CSM_FILTER_MSM4 ? 4
                                                                                 : 2;
}

static double warp(double exponent, double z) {
  return exponent > 0.0 ? exp(exponent * z) : -exp(exponent * z);
}

void moment_model_warp(const moment_model *model, double z, double m[MOMENT_CHANNELS]) {
  double warped[2] = {z, 0.0};
  if (model->filter == CSM_FILTER_ESM || model->filter == CSM_FILTER_EVSM2 || model->filter == CSM_FILTER_EVSM4)
    warped[0] = warp(model->exponents[0], z);
  if (model->filter == CSM_FILTER_EVSM4)
    warped[1] = warp(-model->exponents[1], z);
  m[0] = warped[0];
  m[1] = warped[0] * warped[0];
  m[2] = model->filter == CSM_FILTER_MSM4 ? z * z * z : warped[1];
  m[3] = model->filter == CSM_FILTER_MSM4 ? z * z * z * z : warped[1] * warped[1];
}

/* ---- visibility ---- */

/* Chebyshev's inequality, of one side (Cantelli's). */
static double chebyshev(const double m[2], double t, double least_variance, double noise) {
  const double variance = fmax(m[1] - m[0] * m[0] - noise, least_variance);
  return t <= m[0] ? 1.0 : variance / (variance + (t - m[0]) * (t - m[0]));
}

/* A deviation of z, warped: by the warp's slope at the mean. */
static double warped_chebyshev(const moment_model *model, const double m[2], double exponent, double z) {
  const double deviation = model->deviation * exponent * m[0];
  return chebyshev(m, warp(exponent, z), deviation * deviation, model->noise * m[1]);
}

/* B x = y for the moments' symmetric matrix, by elimination. */
static void solve_hankel(double x[3], const double b[4], const double y[3]) {
  double rows[3][4] = {{1.0, b[0], b[1], y[0]}, {b[0], b[1], b[2], y[1]}, {b[1], b[2], b[3], y[2]}};
  for (int i = 0; i < 3; i++)
    for (int j = i + 1; j < 3; j++) {
      const double factor = rows[j][i] / rows[i][i];
      for (int k = i; k < 4; k++)
        rows[j][k] -= factor * rows[i][k];
    }
  for (int i = 2; i >= 0; i--) {
    x[i] = rows[i][3];
    for (int k = i + 1; k < 3; k++)
      x[i] -= rows[i][k] * x[k];
    x[i] /= rows[i][i];
  }
}

/* The least share of depths before t that four moments allow. */
static double least_share(const double moments[4], double bias, double t) {
  static const double spread[4] = {0.0, 0.4, 0.0, 0.4}; /* of 3/5 of the depths at 0, and 1/5 each at -1 and 1 */
  double b[4], c[3];
  for (int i = 0; i < 4; i++)
    b[i] = (1.0 - bias) * moments[i] + bias * spread[i];
  solve_hankel(c, b, (const double[3]){1.0, t, t * t});
  const double p = c[1] / c[2], q = c[0] / c[2], root = sqrt(fmax(0.25 * p * p - q, 0.0));
  const double low = -0.5 * p - root, high = -0.5 * p + root;
  if (t <= low)
    return 0.0;
  if (t <= high)
    return (t * high - b[0] * (t + high) + b[1]) / ((high - low) * (t - low));
  return 1.0 - (low * high - b[0] * (low + high) + b[1]) / ((t - low) * (t - high));
}

/* Of what is spread out nothing counts as a shadow. */
static double hamburger(const moment_model *model, const double moments[4], double t) {
  return fmax((least_share(moments, model->bias, t) - model->bias) / (1.0 - model->bias), 0.0);
}

static double reduce(const moment_model *model, double lit) {
  double x = fmin(fmax((lit - model->reduction) / (1.0 - model->reduction), 0.0), 1.0);
  if (model->smoothstep)
    x = x * x * (3.0 - 2.0 * x);
  return model->power > 1.0 ? pow(x, model->power) : x;
}

double moment_model_visibility(const moment_model *model, const double m[MOMENT_CHANNELS], double z) {
  double lit = 1.0;
  switch (model->filter) {
  case CSM_FILTER_ESM:
    lit = fmin(m[0] * exp(-model->exponents[0] * z), 1.0);
    break;
  case CSM_FILTER_EVSM2:
    lit = warped_chebyshev(model, m, model->exponents[0], z);
    break;
  case CSM_FILTER_EVSM4:
    lit = fmin(warped_chebyshev(model, m, model->exponents[0], z),
               warped_chebyshev(model, m + 2, -model->exponents[1], z));
    break;
  case CSM_FILTER_MSM4:
    lit = fmin(chebyshev(m, z, model->deviation * model->deviation, model->noise), 1.0 - hamburger(model, m, z));
    break;
  default:
    lit = chebyshev(m, z, model->deviation * model->deviation, model->noise);
  }
  return reduce(model, fmin(fmax(lit, 0.0), 1.0));
}

/* Visibility falls with the gap. */
double moment_model_least_gap(const moment_model *model, double z, double share) {
  double m[MOMENT_CHANNELS], low = 0.0, high = 2.0;
  moment_model_warp(model, z, m);
  for (int i = 0; i < 80; i++) {
    const double middle = 0.5 * (low + high);
    *(moment_model_visibility(model, m, z + middle) > share ? &low : &high) = middle;
  }
  return high;
}

/* ---- halves ---- */

double half_of(double value) {
  const double size = fabs(value);
  if (size == 0.0 || !isfinite(value))
    return value;
  const int exponent = ilogb(size) < -14 ? -14 : ilogb(size);
  const double step = ldexp(1.0, exponent - 10);
  const double rounded = nearbyint(size / step) * step;
  return copysign(rounded < 65520.0 ? rounded : INFINITY, value);
}
