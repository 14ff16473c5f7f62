#include "scene/sun_path.h"
#include "base/host.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PREFIX "day:"

bool sun_path_is(const char *text) {
  return strncmp(text, PREFIX, strlen(PREFIX)) == 0;
}

int sun_path_load(scene_light **lights, uint32_t *count, const char *text, double disc_deg) {
  const double pi = 3.14159265358979323846, tilt = sqrt(0.5);
  char *end;
  const unsigned long wanted = strtoul(text + strlen(PREFIX), &end, 10);
  if (*end || wanted < 2 || wanted > 86400)
    return host_fail(HOST_BAD_INPUT, "--light-path: not day:COUNT with 2 to 86400 lights: '%s'", text);
  *count = (uint32_t)wanted;
  *lights = host_allocate(wanted, sizeof **lights);
  for (uint32_t i = 0; i < *count; i++) {
    const double hour_angle = 2.0 * pi * i / *count - pi; /* 0 at noon */
    const double direction[3] = {sin(hour_angle), -tilt * cos(hour_angle), tilt * cos(hour_angle)};
    scene_light *light = &(*lights)[i];
    light->disc_deg = disc_deg;
    for (int k = 0; k < 3; k++)
      light->direction[k] = direction[k];
  }
  return 0;
}
