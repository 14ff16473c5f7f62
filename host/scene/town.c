/*
 * A town of about 300 m: blocks of houses around a square with arcades, a church, fences, and poles with wires thinner
 * than a shadow texel.
 */
#include "base/linear.h"
#include "scene/mesh_builder.h"
#include "scene/plants.h"
#include "scene/scene.h"
#include <math.h>
#include <stdio.h>

#define BLOCK_PITCH 50.0 /* a block of 40 m and a street of 10 m */
#define BLOCK_SIZE 40.0
#define BLOCKS 6
#define HOUSE_KINDS 6
#define PI 3.14159265358979323846

typedef struct town_meshes {
  uint32_t houses[HOUSE_KINDS];
  uint32_t arch, fence, pole, wire, lamp, tree, bush;
} town_meshes;

typedef struct spot {
  double x, y, z, turn, size;
} spot;

static void place(scene *s, uint32_t mesh, spot at) {
  double transform[16];
  mat_place(transform, (double[3]){at.x, at.y, at.z}, at.turn, (double[3]){at.size, at.size, at.size});
  scene_add_instance(s, mesh, transform);
}

/* From a corner. */
typedef struct box {
  double x, y, z, width, height, depth;
} box;

static void add_box(mesh_builder *b, box at) {
  builder_box(b, (double[3]){at.x, at.y, at.z}, (double[3]){at.x + at.width, at.y + at.height, at.z + at.depth});
}

/* ---- houses: 1 unit is 1 m; the front looks along +z, the middle stands on the origin ---- */

typedef struct house {
  double width, depth, height; /* of the walls */
  double roof;                 /* height of the ridge above them; it runs along x */
  uint32_t storeys, bays;
  float wall[3], tiles[3];
} house;

static void add_roof(mesh_builder *b, const house *h) {
  const double x = h->width / 2, z = h->depth / 2, eaves = 0.45, y = h->height, slope = h->roof / z;
  const double low = y - eaves * slope, out = z + eaves, side = x + 0.3, thick = 0.16;
  builder_color(b, h->tiles[0], h->tiles[1], h->tiles[2]);
  for (int facing = -1; facing <= 1; facing += 2) {
    const double f = facing;
    const double outer[4][3] = {{-f * side, low + thick, f * out},
                                {f * side, low + thick, f * out},
                                {f * side, y + h->roof + thick, 0},
                                {-f * side, y + h->roof + thick, 0}};
    const double inner[4][3] = {
        {f * side, low, f * out}, {-f * side, low, f * out}, {-f * side, y + h->roof, 0}, {f * side, y + h->roof, 0}};
    const double edge[4][3] = {{-f * side, low, f * out},
                               {f * side, low, f * out},
                               {f * side, low + thick, f * out},
                               {-f * side, low + thick, f * out}};
    const double verge[4][3] = {{f * side, low, f * out},
                                {f * side, y + h->roof, 0},
                                {f * side, y + h->roof + thick, 0},
                                {f * side, low + thick, f * out}};
    const double other[4][3] = {{-f * side, y + h->roof, 0},
                                {-f * side, low, f * out},
                                {-f * side, low + thick, f * out},
                                {-f * side, y + h->roof + thick, 0}};
    builder_quad(b, outer);
    builder_quad(b, inner);
    builder_quad(b, edge);
    builder_quad(b, verge);
    builder_quad(b, other);
  }
}

/* Walls up to the eaves, and the gables. */
static void add_walls(mesh_builder *b, const house *h) {
  const double x = h->width / 2, z = h->depth / 2, y = h->height;
  builder_color(b, h->wall[0], h->wall[1], h->wall[2]);
  builder_box(b, (double[3]){-x, -0.5, -z}, (double[3]){x, y, z});
  for (int facing = -1; facing <= 1; facing += 2) {
    const uint32_t i = builder_vertex(b, facing * x, y, facing * z), j = builder_vertex(b, facing * x, y, -facing * z);
    builder_triangle(b, i, j, builder_vertex(b, facing * x, y + h->roof, 0));
  }
  builder_color(b, 0.22f, 0.21f, 0.2f);
  builder_box(b, (double[3]){-x - 0.06, -0.5, -z - 0.06}, (double[3]){x + 0.06, 0.5, z + 0.06});
}

/* A window with its sill and shutters, at the middle of its lower edge; `f` is the side that it faces along z. */
static void add_window(mesh_builder *b, double x, double y, double z, double f) {
  const double back = fmin(z, z + 0.04 * f), sill = fmin(z, z + 0.16 * f), shutter = fmin(z, z + 0.07 * f);
  builder_color(b, 0.05f, 0.07f, 0.09f);
  add_box(b, (box){x - 0.5, y, back, 1.0, 1.4, 0.04});
  builder_color(b, 0.55f, 0.52f, 0.47f);
  add_box(b, (box){x - 0.65, y - 0.1, sill, 1.3, 0.1, 0.16});
  add_box(b, (box){x - 0.58, y + 1.4, shutter, 1.16, 0.12, 0.07});
  builder_color(b, 0.1f, 0.17f, 0.15f);
  add_box(b, (box){x - 1.0, y, shutter, 0.45, 1.4, 0.07});
  add_box(b, (box){x + 0.55, y, shutter, 0.45, 1.4, 0.07});
}

static void add_fronts(mesh_builder *b, const house *h) {
  const double storey = h->height / h->storeys, bay = h->width / h->bays;
  for (uint32_t level = 0; level < h->storeys; level++)
    for (uint32_t i = 0; i < h->bays; i++) {
      const double x = (i + 0.5) * bay - h->width / 2, y = level * storey + 1.0;
      const bool door = level == 0 && i == h->bays / 2;
      if (!door)
        add_window(b, x, y, h->depth / 2, 1.0);
      add_window(b, x, y, -h->depth / 2, -1.0);
    }
  builder_color(b, 0.2f, 0.11f, 0.06f);
  const double x = (h->bays / 2 + 0.5) * bay - h->width / 2;
  add_box(b, (box){x - 0.55, 0.0, h->depth / 2, 1.1, 2.2, 0.06});
  builder_color(b, 0.45f, 0.43f, 0.4f);
  add_box(b, (box){x - 0.8, -0.2, h->depth / 2, 1.6, 0.4, 0.9});
  add_box(b, (box){x - 0.9, 2.35, h->depth / 2, 1.8, 0.12, 0.8});
}

static uint32_t make_house(scene *s, const char *name, const house *h) {
  mesh_builder b = {0};
  add_walls(&b, h);
  add_fronts(&b, h);
  add_roof(&b, h);
  builder_color(&b, 0.34f, 0.16f, 0.11f);
  add_box(&b, (box){h->width * 0.22, h->height + 0.3 * h->roof, -h->depth * 0.17, 0.8, h->roof * 0.7 + 1.1, 0.7});
  return builder_finish(&b, s, name, 2, false);
}

static void make_houses(scene *s, uint32_t out[HOUSE_KINDS]) {
  const house kinds[HOUSE_KINDS] = {
      {9.0, 8.5, 5.8, 3.4, 2, 3, {0.62f, 0.52f, 0.36f}, {0.36f, 0.13f, 0.075f}},
      {11.5, 9.0, 6.2, 3.8, 2, 4, {0.66f, 0.62f, 0.55f}, {0.3f, 0.115f, 0.07f}},
      {8.0, 9.5, 8.8, 3.6, 3, 3, {0.55f, 0.38f, 0.27f}, {0.26f, 0.105f, 0.07f}},
      {12.5, 9.0, 9.0, 3.4, 3, 4, {0.58f, 0.56f, 0.44f}, {0.33f, 0.14f, 0.09f}},
      {7.0, 7.5, 3.3, 3.2, 1, 2, {0.68f, 0.64f, 0.58f}, {0.2f, 0.15f, 0.125f}},
      {10.0, 8.0, 11.6, 3.2, 4, 4, {0.5f, 0.43f, 0.36f}, {0.28f, 0.12f, 0.08f}},
  };
  for (uint32_t k = 0; k < HOUSE_KINDS; k++) {
    char name[32];
    snprintf(name, sizeof name, "house %u", k);
    out[k] = make_house(s, name, &kinds[k]);
  }
}

/* Widths and depths as above, for placing. */
static const double house_width[HOUSE_KINDS] = {9.0, 11.5, 8.0, 12.5, 7.0, 10.0};

/* ---- arcade: one bay, 4 m wide along x, 3.4 m deep, a round arch on pillars, a wall and a roof above ---- */

typedef struct arch {
  double radius, spring, top; /* the arch begins at `spring`, the wall ends at `top` */
  double z0, z1;
} arch;

static void add_arch_slice(mesh_builder *b, const arch *a, double from, double to) {
  const double x0 = a->radius * cos(from), y0 = a->spring + a->radius * sin(from);
  const double x1 = a->radius * cos(to), y1 = a->spring + a->radius * sin(to), top = a->top, z0 = a->z0, z1 = a->z1;
  const double front[4][3] = {{x1, y1, z1}, {x0, y0, z1}, {x0, top, z1}, {x1, top, z1}};
  const double back[4][3] = {{x0, y0, z0}, {x1, y1, z0}, {x1, top, z0}, {x0, top, z0}};
  const double under[4][3] = {{x0, y0, z0}, {x0, y0, z1}, {x1, y1, z1}, {x1, y1, z0}};
  builder_quad(b, front);
  builder_quad(b, back);
  builder_quad(b, under);
}

static uint32_t make_arch(scene *s) {
  const double half = 2.0, radius = 1.6, spring = 2.6, top = 4.9, z0 = -0.25, z1 = 0.25;
  const uint32_t slices = 20;
  mesh_builder b = {0};
  builder_color(&b, 0.62f, 0.56f, 0.45f);
  for (uint32_t i = 0; i < slices; i++)
    add_arch_slice(&b, &(arch){radius, spring, top, z0, z1}, PI * i / slices, PI * (i + 1) / slices);
  add_box(&b, (box){-half, spring, z0, half - radius, top - spring, z1 - z0});
  add_box(&b, (box){radius, spring, z0, half - radius, top - spring, z1 - z0});
  builder_color(&b, 0.58f, 0.55f, 0.5f);
  for (int side = -1; side <= 1; side += 2) {
    const double x = side * (half + radius) / 2.0;
    builder_tube(&b, (double[3]){x, 0.3, 0}, (double[3]){x, spring - 0.25, 0}, 0.17, 0.15, 14);
    add_box(&b, (box){x - 0.25, 0.0, -0.25, 0.5, 0.3, 0.5});
    add_box(&b, (box){x - 0.23, spring - 0.25, -0.24, 0.46, 0.25, 0.48});
  }
  builder_color(&b, 0.34f, 0.13f, 0.08f);
  const double roof[4][3] = {{-half, 4.8, 0.6}, {half, 4.8, 0.6}, {half, 6.0, -3.4}, {-half, 6.0, -3.4}};
  const double ceiling[4][3] = {{-half, 6.0, -3.4}, {half, 6.0, -3.4}, {half, 4.7, 0.6}, {-half, 4.7, 0.6}};
  builder_quad(&b, roof);
  builder_quad(&b, ceiling);
  return builder_finish(&b, s, "arch", 2, false);
}

/* ---- thin things ---- */

/* 4 m along x: posts, two rails, and pickets of 5 x 2 cm. */
static uint32_t make_fence(scene *s) {
  mesh_builder b = {0};
  builder_color(&b, 0.33f, 0.26f, 0.19f);
  add_box(&b, (box){-2.0, -0.3, -0.05, 0.1, 1.5, 0.1});
  add_box(&b, (box){-2.0, 0.3, -0.02, 4.0, 0.06, 0.04});
  add_box(&b, (box){-2.0, 0.85, -0.02, 4.0, 0.06, 0.04});
  for (int i = 0; i < 26; i++)
    add_box(&b, (box){-1.86 + 0.15 * i, 0.1, 0.02, 0.05, 1.0, 0.02});
  return builder_finish(&b, s, "fence", 2, false);
}

static const double pole_height = 7.6;
static const double wire_offsets[3] = {-0.65, 0.0, 0.65}; /* along the cross-arm, which is along x */

static uint32_t make_pole(scene *s) {
  mesh_builder b = {0};
  builder_color(&b, 0.2f, 0.15f, 0.11f);
  builder_tube(&b, (double[3]){0, -0.5, 0}, (double[3]){0, pole_height + 0.4, 0}, 0.11, 0.07, 10);
  builder_tube(&b, (double[3]){-0.8, pole_height, 0}, (double[3]){0.8, pole_height, 0}, 0.045, 0.045, 6);
  builder_color(&b, 0.6f, 0.6f, 0.58f);
  for (int i = 0; i < 3; i++)
    builder_tube(&b, (double[3]){wire_offsets[i], pole_height, 0}, (double[3]){wire_offsets[i], pole_height + 0.16, 0},
                 0.035, 0.03, 6);
  return builder_finish(&b, s, "pole", 4, true);
}

/* Three wires of 1.4 cm along +z, one BLOCK_PITCH / 2 long, sagging. */
static uint32_t make_wires(scene *s) {
  const double length = BLOCK_PITCH / 2.0, sag = 0.5;
  const uint32_t pieces = 16;
  mesh_builder b = {0};
  builder_color(&b, 0.03f, 0.03f, 0.03f);
  for (int wire = 0; wire < 3; wire++)
    for (uint32_t i = 0; i < pieces; i++) {
      const double u = (double)i / pieces, v = (double)(i + 1) / pieces, x = wire_offsets[wire];
      builder_tube(&b, (double[3]){x, pole_height + 0.15 - 4.0 * sag * u * (1.0 - u), u * length},
                   (double[3]){x, pole_height + 0.15 - 4.0 * sag * v * (1.0 - v), v * length}, 0.007, 0.007, 5);
    }
  return builder_finish(&b, s, "wires", 4, true);
}

static uint32_t make_lamp(scene *s) {
  mesh_builder b = {0};
  builder_color(&b, 0.06f, 0.07f, 0.07f);
  builder_tube(&b, (double[3]){0, -0.2, 0}, (double[3]){0, 0.5, 0}, 0.12, 0.07, 10);
  builder_tube(&b, (double[3]){0, 0.5, 0}, (double[3]){0, 3.6, 0}, 0.045, 0.035, 8);
  builder_tube(&b, (double[3]){0, 4.05, 0}, (double[3]){0, 4.25, 0}, 0.24, 0.0, 6);
  builder_color(&b, 0.8f, 0.78f, 0.68f);
  builder_tube(&b, (double[3]){0, 3.6, 0}, (double[3]){0, 4.05, 0}, 0.1, 0.2, 6);
  return builder_finish(&b, s, "lamp", 2, false);
}

/* ---- single buildings ---- */

static uint32_t make_church(scene *s) {
  const house nave = {24.0, 11.0, 9.0, 7.0, 1, 5, {0.6f, 0.57f, 0.5f}, {0.2f, 0.13f, 0.11f}};
  mesh_builder b = {0};
  add_walls(&b, &nave);
  add_roof(&b, &nave);
  builder_color(&b, 0.62f, 0.59f, 0.52f);
  add_box(&b, (box){12.0, -0.5, -3.2, 6.4, 22.5, 6.4});
  for (int corner = 0; corner < 4; corner++)
    add_box(&b, (box){corner & 1 ? 17.5 : 12.0, 22.0, corner & 2 ? 2.3 : -3.2, 0.9, 3.4, 0.9});
  add_box(&b, (box){11.8, 25.4, -3.4, 6.8, 0.4, 6.8});
  builder_color(&b, 0.13f, 0.24f, 0.2f);
  builder_tube(&b, (double[3]){15.2, 25.8, 0}, (double[3]){15.2, 38.0, 0}, 4.4, 0.0, 8);
  builder_color(&b, 0.06f, 0.07f, 0.09f);
  for (int i = 0; i < 5; i++)
    for (int side = -1; side <= 1; side += 2)
      add_box(&b, (box){-10.4 + 4.6 * i, 2.4, side * 5.5 - 0.04, 1.1, 4.6, 0.08});
  builder_color(&b, 0.5f, 0.47f, 0.42f);
  for (int i = 0; i < 6; i++)
    for (int side = -1; side <= 1; side += 2)
      add_box(&b, (box){-12.0 + 4.6 * i, -0.5, side * 6.0 - 0.5, 0.7, 7.5, 1.0});
  return builder_finish(&b, s, "church", 2, false);
}

static uint32_t make_fountain(scene *s) {
  mesh_builder b = {0};
  builder_color(&b, 0.5f, 0.48f, 0.44f);
  for (int i = 0; i < 24; i++) {
    const double a = 2.0 * PI * i / 24, c = 2.0 * PI * (i + 1) / 24;
    builder_tube(&b, (double[3]){3.2 * cos(a), 0.45, 3.2 * sin(a)}, (double[3]){3.2 * cos(c), 0.45, 3.2 * sin(c)}, 0.32,
                 0.32, 8);
  }
  builder_tube(&b, (double[3]){0, 0, 0}, (double[3]){0, 2.4, 0}, 0.5, 0.22, 12);
  builder_tube(&b, (double[3]){0, 2.4, 0}, (double[3]){0, 2.8, 0}, 0.25, 1.1, 16);
  builder_color(&b, 0.06f, 0.11f, 0.14f);
  builder_tube(&b, (double[3]){0, -0.2, 0}, (double[3]){0, 0.4, 0}, 3.1, 3.1, 24);
  return builder_finish(&b, s, "fountain", 2, false);
}

/* Ground in squares of one pitch: cobbles in the streets, a raised pavement around each block's yard. */
static uint32_t make_ground(scene *s) {
  mesh_builder b = {0};
  const double edge = BLOCK_PITCH / 2.0, curb = BLOCK_SIZE / 2.0 + 1.2, yard = BLOCK_SIZE / 2.0 - 10.5;
  const uint32_t cells = 20;
  builder_color(&b, 0.24f, 0.225f, 0.2f);
  for (uint32_t j = 0; j < cells; j++)
    for (uint32_t i = 0; i < cells; i++) {
      const double x0 = -edge + i * 2.0 * edge / cells, x1 = -edge + (i + 1) * 2.0 * edge / cells;
      const double z0 = -edge + j * 2.0 * edge / cells, z1 = -edge + (j + 1) * 2.0 * edge / cells;
      builder_quad(&b, (const double[4][3]){{x0, 0, z1}, {x1, 0, z1}, {x1, 0, z0}, {x0, 0, z0}});
    }
  builder_color(&b, 0.36f, 0.34f, 0.31f);
  add_box(&b, (box){-curb, -0.1, -curb, 2.0 * curb, 0.22, 2.0 * curb});
  builder_color(&b, 0.1f, 0.145f, 0.05f);
  add_box(&b, (box){-yard, -0.1, -yard, 2.0 * yard, 0.28, 2.0 * yard});
  return builder_finish(&b, s, "block", 2, false);
}

static uint32_t make_plaza(scene *s) {
  mesh_builder b = {0};
  const double edge = BLOCK_PITCH / 2.0;
  for (int j = 0; j < 10; j++)
    for (int i = 0; i < 10; i++) {
      const float shade = (i + j) % 2 ? 0.34f : 0.29f;
      const double x0 = -edge + i * 5.0, z0 = -edge + j * 5.0;
      builder_color(&b, shade, 0.95f * shade, 0.87f * shade);
      builder_quad(&b,
                   (const double[4][3]){{x0, 0, z0 + 5.0}, {x0 + 5.0, 0, z0 + 5.0}, {x0 + 5.0, 0, z0}, {x0, 0, z0}});
    }
  return builder_finish(&b, s, "square", 2, false);
}

static void add_meadow(scene *s) {
  mesh_builder b = {0};
  const uint32_t cells = 40;
  for (uint32_t j = 0; j <= cells; j++)
    for (uint32_t i = 0; i <= cells; i++) {
      const double x = (i - cells / 2.0) * 20.0, z = (j - cells / 2.0) * 20.0;
      const double beyond = fmax(hypot(x, z) - 190.0, 0.0);
      const float dry = (float)(0.5 + 0.5 * noise_fractal(x / 50.0, z / 50.0, 3, 9));
      builder_color(&b, 0.09f + 0.07f * dry, 0.14f + 0.03f * dry, 0.045f + 0.02f * dry);
      builder_vertex(&b, x, -0.35 + beyond * (0.06 + 0.09 * noise_fractal(x / 120.0, z / 120.0, 3, 4)), z);
    }
  builder_cells(&b, cells);
  double transform[16];
  mat_identity(transform);
  scene_add_instance(s, builder_finish(&b, s, "meadow", 4, true), transform);
}

/* ---- the plan of the town ---- */

/* A row of houses along one side of a block; `turn` says which. The front of each stands on the pavement's edge. */
static void add_row(scene *s, const town_meshes *m, double x, double z, double turn, uint32_t seed) {
  const double front = BLOCK_SIZE / 2.0 - 4.6, end = BLOCK_SIZE / 2.0;
  double along = -end;
  for (uint32_t i = 0;; i++) {
    const uint32_t kind = (uint32_t)(noise_hash(i, 1, seed) * HOUSE_KINDS);
    const double width = house_width[kind];
    if (along + width > end - 9.0)
      return;
    const double u = along + width / 2.0;
    place(s, m->houses[kind],
          (spot){x + u * cos(turn) + front * sin(turn), 0.1, z - u * sin(turn) + front * cos(turn), turn, 1.0});
    along += width + (noise_hash(i, 2, seed) > 0.7 ? 2.5 : 0.02);
  }
}

static void add_yard(scene *s, const town_meshes *m, double x, double z, uint32_t seed) {
  for (int side = 0; side < 4; side++)
    for (int i = 0; i < 4; i++) {
      const double turn = side * PI / 2.0, u = -6.0 + 4.0 * i, out = 8.4;
      place(s, m->fence,
            (spot){x + u * cos(turn) + out * sin(turn), 0.1, z - u * sin(turn) + out * cos(turn), turn, 1.0});
    }
  for (uint32_t i = 0; i < 3; i++)
    place(s, i == 0 ? m->tree : m->bush,
          (spot){x + 12.0 * noise_hash(i, 3, seed) - 6.0, 0.15, z + 12.0 * noise_hash(i, 4, seed) - 6.0,
                 6.28 * noise_hash(i, 5, seed), 0.8 + 0.5 * noise_hash(i, 6, seed)});
}

static void add_block(scene *s, const town_meshes *m, uint32_t ground, double x, double z, uint32_t seed) {
  place(s, ground, (spot){x, 0.0, z, 0.0, 1.0});
  for (int side = 0; side < 4; side++)
    add_row(s, m, x, z, side * PI / 2.0, seed * 4u + (uint32_t)side);
  add_yard(s, m, x, z, seed);
}

/* Poles and wires along every other street, lamps along the others. */
static void add_streets(scene *s, const town_meshes *m) {
  for (int street = 0; street <= BLOCKS; street++) {
    const double x = (street - BLOCKS / 2.0) * BLOCK_PITCH - 3.4;
    for (int i = 0; i < 2 * BLOCKS; i++) {
      const double z = (i - BLOCKS) * BLOCK_PITCH / 2.0;
      if (street % 2 == 1) {
        place(s, m->pole, (spot){x, 0.0, z, 0.0, 1.0});
        if (i + 1 < 2 * BLOCKS)
          place(s, m->wire, (spot){x, 0.0, z, 0.0, 1.0});
      } else {
        place(s, m->lamp, (spot){x, 0.0, z + 9.0, 0.0, 1.0});
      }
    }
  }
}

/* Arcades on three sides of the square, whose middle is at (x, z). */
static void add_square(scene *s, const town_meshes *m, double x, double z) {
  place(s, make_plaza(s), (spot){x, 0.0, z, 0.0, 1.0});
  place(s, make_fountain(s), (spot){x, 0.0, z, 0.0, 1.0});
  for (int side = 0; side < 3; side++)
    for (int i = 0; i < 9; i++) {
      const double turn = PI / 2.0 - side * PI / 2.0, u = -16.0 + 4.0 * i, out = -18.0;
      place(s, m->arch,
            (spot){x + u * cos(turn) + out * sin(turn), 0.0, z - u * sin(turn) + out * cos(turn), turn, 1.0});
    }
  for (int i = 0; i < 4; i++)
    place(s, m->tree, (spot){x + (i & 1 ? 11.0 : -11.0), 0.0, z + (i & 2 ? 11.0 : -11.0), 1.3 * i, 0.75 + 0.06 * i});
}

static void add_outskirts(scene *s, const town_meshes *m) {
  for (uint32_t i = 0; i < 160; i++) {
    const double angle = 6.2831853 * noise_hash(i, 1, 77), out = 185.0 + 150.0 * noise_hash(i, 2, 77);
    place(s, m->tree,
          (spot){out * cos(angle), 0.02 * (out - 190.0) - 0.6, out * sin(angle), angle,
                 0.7 + 0.7 * noise_hash(i, 3, 77)});
  }
}

void scene_make_town(scene *s) {
  scene_add_material(s, &(scene_material){.name = "town", .color = {1, 1, 1}});
  town_meshes m;
  make_houses(s, m.houses);
  m.arch = make_arch(s);
  m.fence = make_fence(s);
  m.pole = make_pole(s);
  m.wire = make_wires(s);
  m.lamp = make_lamp(s);
  m.tree = plant_broadleaf(s, "lime tree", 10.0, 4, 201);
  m.bush = plant_bush(s, "hedge", 1.5, 202);
  const uint32_t ground = make_ground(s);
  add_meadow(s);
  for (int row = 0; row < BLOCKS; row++)
    for (int column = 0; column < BLOCKS; column++) {
      const double x = (column - (BLOCKS - 1) / 2.0) * BLOCK_PITCH, z = (row - (BLOCKS - 1) / 2.0) * BLOCK_PITCH;
      if (row == 3 && column == 3)
        add_square(s, &m, x, z);
      else if (row == 2 && column == 3) {
        place(s, ground, (spot){x, 0.0, z, 0.0, 1.0});
        place(s, make_church(s), (spot){x, 0.1, z + 4.0, 0.0, 1.0});
      } else
        add_block(s, &m, ground, x, z, (uint32_t)(row * BLOCKS + column) + 300u);
    }
  add_streets(s, &m);
  add_outskirts(s, &m);
  s->camera = (camera_pose){.position = {-1.5, 7.0, 56.0},
                            .target = {17.0, 5.6, 20.0},
                            .vertical_fov_deg = 60.0,
                            .near_depth = 0.2,
                            .far_depth = INFINITY};
  s->light = (scene_light){.direction = {0.62, -0.6, 0.38}};
  s->shadow_distance = 300.0;
  s->haze_distance = 1400.0;
}
