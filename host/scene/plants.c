#include "scene/plants.h"
#include "scene/mesh_builder.h"
#include <math.h>

static double between(double low, double high, uint32_t index, uint32_t seed) {
  return low + (high - low) * noise_hash(index, 91, seed);
}

static void bark_color(mesh_builder *b) {
  builder_color(b, 0.16f, 0.105f, 0.065f);
}

static void leaf_color(mesh_builder *b, double red, double green, double blue, double shade) {
  builder_color(b, (float)(red * shade), (float)(green * shade), (float)(blue * shade));
}

uint32_t plant_conifer(scene *s, const char *name, double height, uint32_t tiers, uint32_t seed) {
  mesh_builder b = {0};
  bark_color(&b);
  builder_tube(&b, (double[3]){0, -0.6, 0}, (double[3]){0, 0.8 * height, 0}, 0.028 * height, 0.006 * height, 8);
  for (uint32_t tier = 0; tier < tiers; tier++) {
    const double share = (double)tier / tiers;
    const double base = height * (0.13 + 0.75 * share), top = fmin(height, base + height * 0.34 * (1.15 - 0.5 * share));
    const double radius = height * 0.24 * (1.0 - 0.78 * share) * between(0.92, 1.08, tier, seed);
    const double lean = 0.02 * height * (1.0 - share);
    const double x = lean * between(-1, 1, tier, seed + 1), z = lean * between(-1, 1, tier, seed + 2);
    leaf_color(&b, 0.045, 0.105, 0.05, 0.75 + 0.55 * share);
    builder_tube(&b, (double[3]){x, base, z}, (double[3]){0.4 * x, top, 0.4 * z}, radius, 0.0, 14);
  }
  return builder_finish(&b, s, name, 2, true);
}

uint32_t plant_broadleaf(scene *s, const char *name, double height, uint32_t crowns, uint32_t seed) {
  mesh_builder b = {0};
  bark_color(&b);
  const double fork = 0.36 * height;
  builder_tube(&b, (double[3]){0, -0.6, 0}, (double[3]){0, fork, 0}, 0.04 * height, 0.028 * height, 9);
  for (uint32_t crown = 0; crown < crowns; crown++) {
    const double angle = 6.2831853 * (crown + 0.4 * noise_hash(crown, 3, seed)) / crowns;
    const double out = crown == 0 ? 0.0 : height * between(0.15, 0.23, crown, seed);
    const double size = height * between(0.17, 0.24, crown, seed + 5);
    const double center[3] = {out * cos(angle), height * between(0.55, 0.76, crown, seed + 6), out * sin(angle)};
    bark_color(&b);
    builder_tube(&b, (double[3]){0, 0.9 * fork, 0}, center, 0.02 * height, 0.008 * height, 6);
    leaf_color(&b, 0.115, 0.19, 0.045, between(0.8, 1.15, crown, seed + 7));
    builder_ball(&b, center, (double[3]){size, 0.85 * size, size}, 2, 0.32, seed + crown);
  }
  return builder_finish(&b, s, name, 4, true);
}

uint32_t plant_dead_tree(scene *s, const char *name, double height, uint32_t seed) {
  mesh_builder b = {0};
  builder_color(&b, 0.27f, 0.24f, 0.2f);
  builder_tube(&b, (double[3]){0, -0.6, 0}, (double[3]){0.04 * height, height, 0}, 0.03 * height, 0.006 * height, 8);
  for (uint32_t branch = 0; branch < 11; branch++) {
    const double angle = 2.399963 * branch, at = height * (0.3 + 0.058 * branch);
    const double length = height * 0.36 * (1.0 - 0.07 * branch) * between(0.7, 1.2, branch, seed);
    const double from[3] = {0.04 * at, at, 0};
    const double to[3] = {from[0] + length * cos(angle), at + length * between(0.2, 0.7, branch, seed + 1),
                          length * sin(angle)};
    builder_tube(&b, from, to, 0.012 * height, 0.003 * height, 5);
    const double mid[3] = {0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1]), 0.5 * (from[2] + to[2])};
    const double twig[3] = {mid[0] + 0.4 * length * cos(angle + 0.9), mid[1] + 0.3 * length,
                            mid[2] + 0.4 * length * sin(angle + 0.9)};
    builder_tube(&b, mid, twig, 0.006 * height, 0.002 * height, 4);
  }
  return builder_finish(&b, s, name, 4, true);
}

uint32_t plant_bush(scene *s, const char *name, double height, uint32_t seed) {
  mesh_builder b = {0};
  for (uint32_t part = 0; part < 3; part++) {
    const double angle = 2.1 * part, size = height * between(0.45, 0.62, part, seed);
    leaf_color(&b, 0.1, 0.16, 0.05, between(0.75, 1.15, part, seed + 7));
    builder_ball(&b, (double[3]){0.4 * height * cos(angle), 0.35 * height, 0.4 * height * sin(angle)},
                 (double[3]){size, 0.9 * size, size}, 1, 0.35, seed + part);
  }
  return builder_finish(&b, s, name, 2, true);
}

uint32_t plant_rock(scene *s, const char *name, const double radius[3], uint32_t subdivisions, uint32_t seed) {
  mesh_builder b = {0};
  const float shade = (float)between(0.85, 1.1, 0, seed);
  builder_color(&b, 0.3f * shade, 0.285f * shade, 0.265f * shade);
  builder_ball(&b, (double[3]){0, 0.3 * radius[1], 0}, radius, subdivisions, 0.38, seed);
  return builder_finish(&b, s, name, 4, false);
}
