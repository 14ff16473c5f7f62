#include "truth/sun_disc.h"
#include "base/host.h"
#include "base/linear.h"
#include <math.h>
#include <stdlib.h>

#define SETS 64
#define PI 3.14159265358979323846

static uint32_t hash(uint32_t value) {
  value = (value ^ value >> 16) * 0x7feb352du;
  value = (value ^ value >> 15) * 0x846ca68bu;
  return value ^ value >> 16;
}

/*
 * The first two dimensions of Sobol's sequence: a (0, 2)-sequence in base 2. A scramble turns bits, which keeps every
 * stratum.
 */
static double sobol(uint32_t index, int dimension, uint32_t scramble) {
  uint32_t bits = 0, direction = 1u << 31;
  for (; index; index >>= 1) {
    if (index & 1)
      bits ^= direction;
    direction = dimension == 0 ? direction >> 1 : direction ^ direction >> 1;
  }
  return ((bits ^ scramble) + 0.5) / 4294967296.0;
}

/* From the unit square to the unit disc, evenly, neighbours staying neighbours (Shirley and Chiu 1997). */
static void square_to_disc(double x, double y, double *radius, double *angle) {
  const double a = 2.0 * x - 1.0, b = 2.0 * y - 1.0;
  if (fabs(a) > fabs(b)) {
    *radius = a;
    *angle = PI / 4.0 * (b / a);
  } else {
    *radius = b;
    *angle = b == 0.0 ? 0.0 : PI / 2.0 - PI / 4.0 * (a / b);
  }
}

void truth_sun_make(truth_sun *out, const scene_light *light, uint32_t samples) {
  double middle[3] = {-light->direction[0], -light->direction[1], -light->direction[2]}, right[3], up[3];
  vec_normalize(middle);
  *out = (truth_sun){.set_count = light->disc_deg > 0.0 ? SETS : 1, .samples = light->disc_deg > 0.0 ? samples : 1};
  out->directions = host_allocate((size_t)out->set_count * out->samples, sizeof *out->directions);
  if (light->disc_deg == 0.0) {
    for (int i = 0; i < 3; i++)
      out->directions[0][i] = middle[i];
    return;
  }
  const double least[3] = {fabs(middle[0]) < 0.6, fabs(middle[0]) >= 0.6, 0.0};
  vec_cross(right, middle, least);
  vec_normalize(right);
  vec_cross(up, middle, right);
  const double depth =
      1.0 - cos(light->disc_deg * (PI / 360.0)); /* of the cap that the disc cuts off the unit sphere */
  for (uint32_t set = 0; set < SETS; set++)
    for (uint32_t i = 0; i < samples; i++) {
      double radius, angle;
      square_to_disc(sobol(i, 0, hash(2 * set + 1)), sobol(i, 1, hash(2 * set + 2)), &radius, &angle);
      const double along = 1.0 - radius * radius * depth; /* area on a sphere goes with height (Archimedes) */
      const double across = copysign(sqrt(fmax(0.0, 1.0 - along * along)), radius);
      for (int k = 0; k < 3; k++)
        out->directions[(size_t)set * samples + i][k] =
            along * middle[k] + across * (cos(angle) * right[k] + sin(angle) * up[k]);
    }
}

void truth_sun_free(truth_sun *sun) {
  free(sun->directions);
  *sun = (truth_sun){0};
}

const double (*truth_sun_set(const truth_sun *sun, uint32_t pixel))[3] {
  return (const double(*)[3])sun->directions + (size_t)(hash(pixel) % sun->set_count) * sun->samples;
}
