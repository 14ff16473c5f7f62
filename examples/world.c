#include "world.h"
#include "app.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MESH_GROUND, MESH_STONE, MESH_TREE };
enum { TREE_SIDES = 12, TREE_RINGS = 16, STONES = 9 };

static const double center[3] = {12000.0, 0.0, -7000.0}; /* far from the world's origin, as in any large world */
static const double circle_radius = 7.5;
static const double tree_height = 6.5, base_radius = 0.85, top_radius = 0.35;
static const double pi = 3.14159265358979323846;

/* ---- vectors and matrices ---- */

static void multiply(double out[16], const double a[16], const double b[16]) {
  for (int column = 0; column < 4; column++)
    for (int row = 0; row < 4; row++) {
      double sum = 0.0;
      for (int k = 0; k < 4; k++)
        sum += a[k * 4 + row] * b[column * 4 + k];
      out[column * 4 + row] = sum;
    }
}

static void normalize(double v[3]) {
  const double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  for (int i = 0; i < 3; i++)
    v[i] /= length;
}

static void cross(double out[3], const double a[3], const double b[3]) {
  for (int i = 0; i < 3; i++)
    out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

/* Scale, then a turn about y, then a translation from the circle's centre. */
static void place(double out[16], const double at[3], double turn, const double size[3]) {
  const double c = cos(turn), s = sin(turn), *to = center;
  const double m[16] = {
      c * size[0],   0, -s * size[0], 0, 0, size[1], 0, 0, s * size[2], 0, c * size[2], 0, to[0] + at[0], to[1] + at[1],
      to[2] + at[2], 1};
  memcpy(out, m, sizeof m);
}

/* ---- meshes ---- */

static void mesh_allocate(mesh *m, const char *name, uint32_t vertex_count, uint32_t index_count) {
  m->name = name;
  m->vertices = app_allocate(vertex_count, sizeof *m->vertices);
  m->indices = app_allocate(index_count, sizeof *m->indices);
}

static void find_bounds(mesh *m) {
  for (int i = 0; i < 3; i++) {
    m->bounds_min[i] = INFINITY;
    m->bounds_max[i] = -INFINITY;
    for (uint32_t v = 0; v < m->vertex_count; v++) {
      m->bounds_min[i] = fminf(m->bounds_min[i], m->vertices[v].position[i]);
      m->bounds_max[i] = fmaxf(m->bounds_max[i], m->vertices[v].position[i]);
    }
  }
}

static void add_quad(mesh *m, uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
  const uint32_t corners[6] = {a, b, c, a, c, d};
  for (int i = 0; i < 6; i++)
    m->indices[m->index_count++] = (uint16_t)corners[i];
}

/* One side of a box or a ground: corners counter-clockwise, seen from the side that it faces. */
static void add_face(mesh *m, const float corners[4][3], const float normal[3]) {
  const uint32_t first = m->vertex_count;
  for (int i = 0; i < 4; i++) {
    memcpy(m->vertices[m->vertex_count].position, corners[i], sizeof corners[i]);
    memcpy(m->vertices[m->vertex_count++].normal, normal, 3 * sizeof *normal);
  }
  add_quad(m, first, first + 1, first + 2, first + 3);
}

static void make_ground(mesh *m) {
  mesh_allocate(m, "ground", 4, 6);
  add_face(m, (const float[4][3]){{-1, 0, 1}, {1, 0, 1}, {1, 0, -1}, {-1, 0, -1}}, (const float[3]){0, 1, 0});
}

/* A cube from (-1/2, 0, -1/2) to (1/2, 1, 1/2). */
static void make_stone(mesh *m) {
  mesh_allocate(m, "stone", 24, 36);
  for (int axis = 0; axis < 3; axis++)
    for (int side = -1; side <= 1; side += 2) {
      float corners[4][3], normal[3] = {0};
      normal[axis] = (float)side;
      for (int i = 0; i < 4; i++) {
        const float u = i == 1 || i == 2 ? 0.5f : -0.5f, v = i >= 2 ? 0.5f : -0.5f;
        corners[i][axis] = 0.5f * (float)side;
        corners[i][(axis + 1) % 3] = u * (float)side; /* mirrored on the negative side, to stay counter-clockwise */
        corners[i][(axis + 2) % 3] = v;
        corners[i][1] += 0.5f;
      }
      add_face(m, (const float(*)[3])corners, normal);
    }
}

/* A trunk that grows thin, closed at its top by a ring of no radius. */
static void make_tree(mesh *m) {
  mesh_allocate(m, "tree", (TREE_RINGS + 1) * TREE_SIDES, TREE_RINGS * TREE_SIDES * 6);
  for (int ring = 0; ring <= TREE_RINGS; ring++)
    for (int side = 0; side < TREE_SIDES; side++) {
      const double along = fmin((double)ring / (TREE_RINGS - 1), 1.0), angle = 2.0 * pi * side / TREE_SIDES;
      const double radius = ring == TREE_RINGS ? 0.0 : base_radius + (top_radius - base_radius) * along;
      double normal[3] = {cos(angle), (base_radius - top_radius) / tree_height, sin(angle)}; /* it leans inwards */
      normalize(normal);
      vertex *v = &m->vertices[m->vertex_count++];
      *v = (vertex){
          .position = {(float)(radius * cos(angle)), (float)(along * tree_height), (float)(radius * sin(angle))},
          .normal = {(float)normal[0], (float)normal[1], (float)normal[2]}};
    }
  for (uint32_t ring = 0; ring < TREE_RINGS; ring++)
    for (uint32_t side = 0; side < TREE_SIDES; side++) {
      const uint32_t next = (side + 1) % TREE_SIDES, low = ring * TREE_SIDES, high = low + TREE_SIDES;
      add_quad(m, low + side, high + side, high + next, low + next);
    }
}

/* ---- things ---- */

static thing *add_thing(world *w, uint32_t mesh, const float color[3]) {
  thing *t = &w->things[w->thing_count++];
  t->mesh = mesh;
  memcpy(t->color, color, sizeof t->color);
  return t;
}

static void add_stone(world *w, const double at[3], double turn, const double size[3]) {
  static const float grey[3] = {0.46f, 0.44f, 0.41f};
  thing *t = add_thing(w, MESH_STONE, grey);
  place(t->bones[0], at, turn, size);
  memcpy(t->bones[1], t->bones[0], sizeof t->bones[1]);
}

/* Standing stones in a circle, with lintels across the gaps of one half of it. */
static void add_circle(world *w) {
  for (int i = 0; i < STONES; i++) {
    const double angle = 2.0 * pi * i / STONES, next = 2.0 * pi * (i + 1) / STONES, middle = 0.5 * (angle + next);
    const double stone[3] = {1.7, 4.2 + 0.3 * (i > 4) * sin(3.0 * i), 0.9};
    const double at[3] = {circle_radius * sin(angle), 0.0, circle_radius * cos(angle)};
    add_stone(w, at, angle, stone);
    if (i < 4) {
      const double gap = 2.0 * circle_radius * sin(pi / STONES), out = circle_radius * cos(pi / STONES);
      const double above[3] = {out * sin(middle), 4.2, out * cos(middle)}, lintel[3] = {gap, 0.7, 1.0};
      add_stone(w, above, middle, lintel);
    }
  }
  add_stone(w, (const double[3]){2.6, 0.0, 1.4}, 0.5, (const double[3]){2.4, 0.8, 1.3});
}

/* The tree's upper bone turns about a point on its lower one. */
static void bend_tree(thing *tree, double seconds) {
  const double angle = 0.55 * sin(2.2 * seconds + 0.4), c = cos(angle), s = sin(angle), pivot = 1.5;
  const double turn[16] = {c, s, 0, 0, -s, c, 0, 0, 0, 0, 1, 0, pivot * s, pivot - pivot * c, 0, 1};
  place(tree->bones[0], (const double[3]){-0.5, 0.0, 0.5}, 0.8, (const double[3]){1.0, 1.0, 1.0});
  multiply(tree->bones[1], tree->bones[0], turn);
}

void world_create(world *w) {
  static const float grass[3] = {0.26f, 0.36f, 0.13f}, bark[3] = {0.42f, 0.24f, 0.12f};
  memset(w, 0, sizeof *w);
  make_ground(&w->meshes[MESH_GROUND]);
  make_stone(&w->meshes[MESH_STONE]);
  make_tree(&w->meshes[MESH_TREE]);
  for (int i = 0; i < WORLD_MESHES; i++)
    find_bounds(&w->meshes[i]);

  thing *ground = add_thing(w, MESH_GROUND, grass);
  place(ground->bones[0], (const double[3]){0.0, 0.0, 0.0}, 0.0, (const double[3]){60.0, 1.0, 60.0});
  memcpy(ground->bones[1], ground->bones[0], sizeof ground->bones[1]);
  add_circle(w);
  add_thing(w, MESH_TREE, bark)->bend = (float)(1.0 / tree_height);

  const double sun[3] = {-0.62, -0.55, 0.42};
  memcpy(w->sun_direction, sun, sizeof sun);
  normalize(w->sun_direction);
  memcpy(w->sun_light, (const float[3]){1.5f, 1.22f, 0.92f}, sizeof w->sun_light);
  memcpy(w->sky_light, (const float[3]){0.2f, 0.26f, 0.38f}, sizeof w->sky_light);
  world_animate(w, 1);
}

void world_destroy(world *w) {
  for (int i = 0; i < WORLD_MESHES; i++) {
    free(w->meshes[i].vertices);
    free(w->meshes[i].indices);
  }
}

static void look(world *w, const double target[3], double vertical_fov, double near, double far) {
  double forward[3], right[3], up[3];
  for (int i = 0; i < 3; i++)
    forward[i] = target[i] - w->camera[i];
  normalize(forward);
  cross(right, forward, (const double[3]){0, 1, 0});
  normalize(right);
  cross(up, right, forward);
  memset(w->view, 0, sizeof w->view);
  for (int i = 0; i < 3; i++) {
    const double axes[3] = {right[i], up[i], -forward[i]};
    for (int row = 0; row < 3; row++) {
      w->view[i * 4 + row] = axes[row];
      w->view[12 + row] -= axes[row] * w->camera[i];
    }
  }
  w->view[15] = 1.0;

  const double focal = 1.0 / tan(0.5 * vertical_fov);
  const double reversed[16] = {
      focal * WORLD_HEIGHT / WORLD_WIDTH, 0, 0, 0, 0, focal, 0, 0, 0, 0, near / (far - near), -1, 0, 0,
      near * far / (far - near),          0};
  memcpy(w->projection, reversed, sizeof reversed);
}

void world_animate(world *w, uint32_t frame) {
  const double seconds = 0.1 * frame, angle = 0.25 + 0.15 * seconds;
  w->camera[0] = center[0] + 19.0 * sin(angle);
  w->camera[1] = center[1] + 9.0;
  w->camera[2] = center[2] + 19.0 * cos(angle);
  look(w, (const double[3]){center[0], center[1] + 1.2, center[2]}, 0.75, 0.2, 200.0);
  bend_tree(&w->things[w->thing_count - 1], seconds);
}

double world_skinned_bounds(const world *w, double out[3]) {
  const double *base = w->things[w->thing_count - 1].bones[0];
  memcpy(out, base + 12, 3 * sizeof *out);
  out[1] += 0.5 * tree_height;
  return tree_height;
}

/* ---- for shaders ---- */

static void rows_of(float out[3][4], const double m[16]) {
  for (int row = 0; row < 3; row++)
    for (int column = 0; column < 4; column++)
      out[row][column] = (float)m[column * 4 + row];
}

static void surface_of(draw_constants *out, const thing *t) {
  memcpy(out->color, t->color, sizeof out->color);
  out->bend = t->bend;
}

void world_frame_constants(frame_constants *out, const world *w, const double origin[3]) {
  const double from_origin[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, origin[0], origin[1], origin[2], 1};
  double view[16], clip[16];
  multiply(view, w->view, from_origin);
  multiply(clip, w->projection, view);
  for (int row = 0; row < 4; row++)
    for (int column = 0; column < 4; column++)
      out->to_clip[row][column] = (float)clip[column * 4 + row];
  for (int i = 0; i < 3; i++)
    out->to_sun[i] = (float)-w->sun_direction[i];
  memcpy(out->sun_light, w->sun_light, sizeof w->sun_light);
  memcpy(out->sky_light, w->sky_light, sizeof w->sky_light);
}

void world_draw_constants(draw_constants *out, const thing *t, const double origin[3]) {
  for (int i = 0; i < 2; i++) {
    double relative[16];
    memcpy(relative, t->bones[i], sizeof relative);
    for (int axis = 0; axis < 3; axis++)
      relative[12 + axis] -= origin[axis];
    rows_of(out->bones[i], relative);
  }
  surface_of(out, t);
}

void world_caster_constants(draw_constants *out, const thing *t, const double world_to_clip[16]) {
  for (int i = 0; i < 2; i++) {
    double clip[16];
    multiply(clip, world_to_clip, t->bones[i]);
    rows_of(out->bones[i], clip);
  }
  surface_of(out, t);
}
