/*
 * A valley 2 km deep along the view: hills on both sides, a river, mountains at its end, forests and rocks. The terrain
 * is tiled, so that there is something to cull.
 */
#include "base/host.h"
#include "base/linear.h"
#include "scene/mesh_builder.h"
#include "scene/plants.h"
#include "scene/scene.h"
#include <math.h>
#include <stdio.h>

#define VALLEY_WIDTH 2400.0 /* x from -1200 to 1200 */
#define VALLEY_FRONT 200.0  /* z of the edge behind the camera; the view is along -z */
#define TILE_SIZE 200.0
#define TILE_CELLS 40u
#define TILES_X 12u
#define TILES_Z 12u
#define WATER_LEVEL 1.2
#define CAMERA_X -24.0 /* at z = 0 */

static double smooth_step(double low, double high, double x) {
  const double t = fmin(fmax((x - low) / (high - low), 0.0), 1.0);
  return t * t * (3.0 - 2.0 * t);
}

static double mix(double a, double b, double t) {
  return a + (b - a) * t;
}

/* x of the river's middle. */
static double river_x(double z) {
  return 55.0 * sin(z / 210.0 + 0.6) + 34.0 * sin(z / 97.0);
}

static double ground_height(double x, double z) {
  const double from_river = fabs(x - river_x(z));
  const double side = smooth_step(30.0, 1050.0, from_river);
  const double end = smooth_step(-1350.0, -2250.0, z);
  const double ridges = 1.0 - 2.0 * fabs(noise_fractal(x / 620.0, z / 620.0, 4, 11));
  const double hills = noise_fractal(x / 260.0, z / 260.0, 5, 23);
  const double bumps = noise_fractal(x / 34.0, z / 34.0, 3, 41);
  double height = 4.0 + 300.0 * pow(side, 1.35) * (0.55 + 0.6 * ridges) + side * 60.0 * hills;
  height += smooth_step(20.0, 160.0, from_river) * (7.0 * hills + 5.0);
  height += end * (90.0 + 210.0 * ridges) * (0.35 + 0.65 * smooth_step(0.0, 500.0, from_river));
  height += bumps * mix(0.8, 4.0, side);
  return mix(-2.2, height, smooth_step(4.0, 17.0, from_river));
}

static void ground_normal(double normal[3], double x, double z) {
  const double step = 3.0;
  normal[0] = ground_height(x - step, z) - ground_height(x + step, z);
  normal[1] = 2.0 * step;
  normal[2] = ground_height(x, z - step) - ground_height(x, z + step);
  vec_normalize(normal);
}

/* Grass below, rock where it is steep, snow on the heights, sand by the water. */
static void ground_color(mesh_builder *b, double x, double y, double z) {
  static const double grass[3] = {0.085, 0.125, 0.04}, meadow[3] = {0.17, 0.165, 0.07}, rock[3] = {0.2, 0.185, 0.165},
                      snow[3] = {0.82, 0.84, 0.88}, sand[3] = {0.4, 0.35, 0.25};
  double normal[3];
  ground_normal(normal, x, z);
  const double patch = noise_fractal(x / 70.0, z / 70.0, 4, 77);
  const double dry = smooth_step(-0.25, 0.35, patch);
  const double bare = smooth_step(0.84, 0.72, normal[1] + 0.06 * patch);
  const double white = smooth_step(300.0, 350.0, y + 60.0 * patch) * smooth_step(0.6, 0.8, normal[1]);
  const double wet = smooth_step(WATER_LEVEL + 1.6, WATER_LEVEL + 0.3, y);
  float color[3];
  for (int i = 0; i < 3; i++)
    color[i] = (float)mix(mix(mix(mix(grass[i], meadow[i], dry), rock[i], bare), snow[i], white), sand[i], wet);
  builder_color(b, color[0], color[1], color[2]);
}

static void add_ground_tile(scene *s, uint32_t column, uint32_t row) {
  const double cell = TILE_SIZE / TILE_CELLS;
  const double origin[3] = {column * TILE_SIZE - VALLEY_WIDTH / 2.0, 0.0, VALLEY_FRONT - (row + 1) * TILE_SIZE};
  mesh_builder b = {0};
  for (uint32_t j = 0; j <= TILE_CELLS; j++)
    for (uint32_t i = 0; i <= TILE_CELLS; i++) {
      const double x = origin[0] + i * cell, z = origin[2] + j * cell, y = ground_height(x, z);
      ground_color(&b, x, y, z);
      builder_vertex(&b, i * cell, y, j * cell);
    }
  builder_cells(&b, TILE_CELLS);
  char name[32];
  snprintf(name, sizeof name, "ground %u %u", column, row);
  double transform[16];
  mat_place(transform, origin, 0.0, (double[3]){1, 1, 1});
  scene_add_instance(s, builder_finish(&b, s, name, 2, true), transform);
}

static void add_river(scene *s) {
  mesh_builder b = {0};
  builder_color(&b, 0.05f, 0.1f, 0.13f);
  const uint32_t steps = 240;
  for (uint32_t i = 0; i <= steps; i++) {
    const double z = VALLEY_FRONT - i * 2400.0 / steps, x = river_x(z);
    builder_vertex(&b, x - 20.0, WATER_LEVEL, z);
    builder_vertex(&b, x + 20.0, WATER_LEVEL, z);
    if (i > 0) {
      const uint32_t last = 2 * i;
      builder_triangle(&b, last - 2, last - 1, last + 1);
      builder_triangle(&b, last - 2, last + 1, last);
    }
  }
  double transform[16];
  mat_identity(transform);
  scene_add_instance(s, builder_finish(&b, s, "river", 2, true), transform);
}

/* ---- plants ---- */

typedef struct valley_kind {
  uint32_t mesh;
  uint32_t count;
  double low, high; /* heights of the ground where it grows */
  double steepest;  /* least y of the ground's normal */
  double clumping;  /* 0: everywhere; 1: in forests only */
  double min_size, max_size;
} valley_kind;

static bool grows_here(const valley_kind *kind, double x, double y, double z, double chance) {
  double normal[3];
  ground_normal(normal, x, z);
  const double forest = smooth_step(-0.12, 0.12, noise_fractal(x / 170.0, z / 170.0, 3, 59));
  return y >= kind->low && y <= kind->high && normal[1] >= kind->steepest && chance < mix(1.0, forest, kind->clumping);
}

static void plant_kind(scene *s, const valley_kind *kind, uint32_t seed) {
  uint32_t planted = 0;
  for (uint32_t attempt = 0; planted < kind->count && attempt < 400000; attempt++) {
    /* denser towards the camera, and within what it sees */
    const double ahead = 2100.0 * pow(noise_hash(attempt, 1, seed), 1.7) - 40.0;
    const double x = (2.0 * noise_hash(attempt, 2, seed) - 1.0) * fmin(0.85 * ahead + 130.0, 1150.0), z = -ahead;
    const double y = ground_height(x, z);
    if (hypot(x - CAMERA_X, z) < 34.0 || !grows_here(kind, x, y, z, noise_hash(attempt, 3, seed)))
      continue;
    const double size = mix(kind->min_size, kind->max_size, noise_hash(attempt, 4, seed));
    const double width = size * mix(0.88, 1.12, noise_hash(attempt, 5, seed));
    double transform[16];
    mat_place(transform, (double[3]){x, y - 0.05, z}, 6.2831853 * noise_hash(attempt, 6, seed),
              (double[3]){width, size, width});
    scene_add_instance(s, kind->mesh, transform);
    planted++;
  }
}

static void add_plants(scene *s) {
  const valley_kind kinds[] = {
      {plant_conifer(s, "spruce", 17.0, 6, 101), 1300, 6.0, 270.0, 0.72, 0.95, 0.6, 1.35},
      {plant_conifer(s, "fir", 23.0, 8, 102), 800, 10.0, 250.0, 0.72, 0.95, 0.6, 1.25},
      {plant_conifer(s, "young spruce", 6.0, 4, 103), 400, 5.0, 300.0, 0.7, 0.5, 0.5, 1.4},
      {plant_broadleaf(s, "oak", 14.0, 4, 104), 130, 3.0, 90.0, 0.85, 0.45, 0.7, 1.3},
      {plant_broadleaf(s, "birch", 11.0, 3, 105), 130, 3.0, 120.0, 0.82, 0.6, 0.7, 1.25},
      {plant_dead_tree(s, "dead tree", 11.0, 106), 90, 4.0, 280.0, 0.7, 0.0, 0.6, 1.3},
      {plant_bush(s, "bush", 1.7, 107), 360, 2.6, 200.0, 0.7, 0.2, 0.5, 1.5},
      {plant_rock(s, "boulder", (double[3]){1.6, 1.2, 1.4}, 2, 108), 140, 1.0, 400.0, 0.5, 0.0, 0.4, 2.2},
      {plant_rock(s, "slab", (double[3]){2.6, 0.6, 1.7}, 1, 109), 160, 1.0, 400.0, 0.5, 0.0, 0.4, 1.8},
      {plant_rock(s, "crag", (double[3]){1.5, 3.4, 1.3}, 2, 110), 90, 20.0, 420.0, 0.4, 0.0, 0.5, 2.4},
      {plant_rock(s, "stone", (double[3]){0.5, 0.35, 0.45}, 1, 111), 260, 1.0, 200.0, 0.6, 0.0, 0.5, 1.8},
  };
  for (uint32_t k = 0; k < sizeof kinds / sizeof kinds[0]; k++)
    plant_kind(s, &kinds[k], 1000 + k);
}

void scene_make_valley(scene *s) {
  scene_add_material(s, &(scene_material){.name = "land", .color = {1, 1, 1}});
  for (uint32_t row = 0; row < TILES_Z; row++)
    for (uint32_t column = 0; column < TILES_X; column++)
      add_ground_tile(s, column, row);
  add_river(s);
  add_plants(s);
  const double eye = ground_height(CAMERA_X, 0.0) + 15.0;
  s->camera = (camera_pose){.position = {CAMERA_X, eye, 0.0},
                            .target = {-6.0, eye - 9.0, -100.0},
                            .vertical_fov_deg = 50.0,
                            .near_depth = 0.5,
                            .far_depth = 4000.0};
  s->light = (scene_light){.direction = {-0.72, -0.5, -0.28}};
  s->shadow_distance = 2000.0;
  s->haze_distance = 4200.0;
}
