#include "scene/mesh_builder.h"
#include "base/host.h"
#include "base/linear.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void builder_color(mesh_builder *b, float red, float green, float blue) {
  b->color[0] = red;
  b->color[1] = green;
  b->color[2] = blue;
}

uint32_t builder_vertex(mesh_builder *b, double x, double y, double z) {
  const size_t needed = 3 * (b->vertex_count + 1);
  b->positions = host_grow(b->positions, &b->position_capacity, needed, sizeof *b->positions);
  b->colors = host_grow(b->colors, &b->color_capacity, needed, sizeof *b->colors);
  float *position = b->positions + 3 * b->vertex_count;
  position[0] = (float)x;
  position[1] = (float)y;
  position[2] = (float)z;
  memcpy(b->colors + 3 * b->vertex_count, b->color, sizeof b->color);
  return (uint32_t)b->vertex_count++;
}

void builder_triangle(mesh_builder *b, uint32_t i, uint32_t j, uint32_t k) {
  b->indices = host_grow(b->indices, &b->index_capacity, b->index_count + 3, sizeof *b->indices);
  b->indices[b->index_count++] = i;
  b->indices[b->index_count++] = j;
  b->indices[b->index_count++] = k;
}

void builder_cells(mesh_builder *b, uint32_t cells) {
  const uint32_t first = (uint32_t)b->vertex_count - (cells + 1) * (cells + 1);
  for (uint32_t j = 0; j < cells; j++)
    for (uint32_t i = 0; i < cells; i++) {
      const uint32_t at = first + j * (cells + 1) + i, below = at + cells + 1;
      builder_triangle(b, at, below, below + 1);
      builder_triangle(b, at, below + 1, at + 1);
    }
}

void builder_quad(mesh_builder *b, const double corners[4][3]) {
  uint32_t index[4];
  for (int i = 0; i < 4; i++)
    index[i] = builder_vertex(b, corners[i][0], corners[i][1], corners[i][2]);
  builder_triangle(b, index[0], index[1], index[2]);
  builder_triangle(b, index[0], index[2], index[3]);
}

void builder_box(mesh_builder *b, const double minimum[3], const double maximum[3]) {
  static const uint8_t faces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                      {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  for (int face = 0; face < 6; face++) {
    double corners[4][3];
    for (int i = 0; i < 4; i++)
      for (int axis = 0; axis < 3; axis++)
        corners[i][axis] = faces[face][i] >> axis & 1 ? maximum[axis] : minimum[axis];
    builder_quad(b, (const double(*)[3])corners);
  }
}

/* A ring of vertices around `center`, or a single one where the radius is 0. Returns the first. */
static uint32_t add_ring(mesh_builder *b, const double center[3], const double side[3], const double other[3],
                         double radius, uint32_t sides) {
  const uint32_t first = (uint32_t)b->vertex_count;
  for (uint32_t i = 0; i < sides; i++) {
    const double angle = 6.28318530717958648 * i / sides;
    const double u = radius * cos(angle), v = radius * sin(angle);
    builder_vertex(b, center[0] + u * side[0] + v * other[0], center[1] + u * side[1] + v * other[1],
                   center[2] + u * side[2] + v * other[2]);
  }
  return first;
}

void builder_tube(mesh_builder *b, const double from[3], const double to[3], double from_radius, double to_radius,
                  uint32_t sides) {
  double axis[3], side[3], other[3];
  vec_subtract(axis, to, from);
  if (!vec_normalize(axis))
    return;
  const bool steep = fabs(axis[1]) > 0.9;
  vec_cross(side, (const double[3]){steep ? 1.0 : 0.0, steep ? 0.0 : 1.0, 0.0}, axis);
  vec_normalize(side);
  vec_cross(other, axis, side);

  const uint32_t low = from_radius > 0.0 ? add_ring(b, from, side, other, from_radius, sides) : 0;
  const uint32_t high = to_radius > 0.0 ? add_ring(b, to, side, other, to_radius, sides) : 0;
  const uint32_t low_center = builder_vertex(b, from[0], from[1], from[2]);
  const uint32_t high_center = builder_vertex(b, to[0], to[1], to[2]);
  for (uint32_t i = 0; i < sides; i++) {
    const uint32_t next = (i + 1) % sides;
    if (from_radius > 0.0) {
      builder_triangle(b, low + i, low + next, to_radius > 0.0 ? high + next : high_center);
      builder_triangle(b, low_center, low + next, low + i);
    }
    if (to_radius > 0.0) {
      builder_triangle(b, from_radius > 0.0 ? low + i : low_center, high + next, high + i);
      builder_triangle(b, high_center, high + i, high + next);
    }
  }
}

/* ---- ball: an icosahedron whose triangles are divided in four; midpoints are shared ---- */

typedef struct midpoint {
  uint32_t low, high, vertex; /* of an edge */
} midpoint;

typedef struct ball {
  double (*points)[3]; /* on the unit sphere */
  uint32_t point_count;
  uint32_t (*faces)[3];
  uint32_t face_count;
  midpoint *midpoints;
  uint32_t midpoint_count;
} ball;

static uint32_t ball_midpoint(ball *shape, uint32_t i, uint32_t j) {
  const uint32_t low = i < j ? i : j, high = i < j ? j : i;
  for (uint32_t m = 0; m < shape->midpoint_count; m++)
    if (shape->midpoints[m].low == low && shape->midpoints[m].high == high)
      return shape->midpoints[m].vertex;
  double *point = shape->points[shape->point_count];
  for (int axis = 0; axis < 3; axis++)
    point[axis] = shape->points[i][axis] + shape->points[j][axis];
  vec_normalize(point);
  shape->midpoints[shape->midpoint_count++] = (midpoint){low, high, shape->point_count};
  return shape->point_count++;
}

static void ball_divide(ball *shape) {
  const uint32_t count = shape->face_count;
  shape->midpoint_count = 0;
  for (uint32_t f = 0; f < count; f++) {
    uint32_t *face = shape->faces[f];
    const uint32_t a = face[0], b = face[1], c = face[2];
    const uint32_t ab = ball_midpoint(shape, a, b), bc = ball_midpoint(shape, b, c), ca = ball_midpoint(shape, c, a);
    const uint32_t parts[4][3] = {{ab, bc, ca}, {a, ab, ca}, {b, bc, ab}, {c, ca, bc}};
    memcpy(face, parts[0], sizeof parts[0]);
    memcpy(shape->faces[shape->face_count], parts[1], 3 * sizeof parts[0]);
    shape->face_count += 3;
  }
}

static void ball_begin(ball *shape, uint32_t subdivisions) {
  const double t = 0.85065080835203993, s = 0.52573111211913361;
  const double points[12][3] = {{-s, t, 0},  {s, t, 0},  {-s, -t, 0}, {s, -t, 0}, {0, -s, t},  {0, s, t},
                                {0, -s, -t}, {0, s, -t}, {t, 0, -s},  {t, 0, s},  {-t, 0, -s}, {-t, 0, s}};
  static const uint8_t faces[20][3] = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                       {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                       {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                       {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  const uint32_t face_count = 20u << (2 * subdivisions);
  *shape = (ball){.points = host_allocate(face_count / 2 + 2, sizeof *shape->points),
                  .faces = host_allocate(face_count, sizeof *shape->faces),
                  .midpoints = host_allocate(face_count, sizeof *shape->midpoints),
                  .point_count = 12,
                  .face_count = 20};
  memcpy(shape->points, points, sizeof points);
  for (int f = 0; f < 20; f++)
    for (int i = 0; i < 3; i++)
      shape->faces[f][i] = faces[f][i];
  for (uint32_t i = 0; i < subdivisions; i++)
    ball_divide(shape);
}

void builder_ball(mesh_builder *b, const double center[3], const double radius[3], uint32_t subdivisions,
                  double roughness, uint32_t seed) {
  ball shape;
  ball_begin(&shape, subdivisions);
  const uint32_t first = (uint32_t)b->vertex_count;
  for (uint32_t v = 0; v < shape.point_count; v++) {
    const double *p = shape.points[v];
    const double bump = noise_value(2.3 * p[0] + 1.7 * p[2], 2.3 * p[1] - 1.1 * p[2], seed);
    const double factor = 1.0 + roughness * (0.6 * bump + 0.4 * (2.0 * noise_hash(v, 7, seed) - 1.0));
    builder_vertex(b, center[0] + radius[0] * factor * p[0], center[1] + radius[1] * factor * p[1],
                   center[2] + radius[2] * factor * p[2]);
  }
  for (uint32_t f = 0; f < shape.face_count; f++)
    builder_triangle(b, first + shape.faces[f][0], first + shape.faces[f][1], first + shape.faces[f][2]);
  free(shape.points);
  free(shape.faces);
  free(shape.midpoints);
}

/* ---- finishing ---- */

/* Area-weighted normals of shared vertices. */
static float *smooth_normals(const mesh_builder *b) {
  float *normals = host_allocate(3 * b->vertex_count, sizeof *normals);
  for (size_t t = 0; t < b->index_count; t += 3) {
    double corner[3][3], edge[2][3], normal[3];
    for (int i = 0; i < 3; i++)
      for (int axis = 0; axis < 3; axis++)
        corner[i][axis] = b->positions[3 * (size_t)b->indices[t + i] + axis];
    vec_subtract(edge[0], corner[1], corner[0]);
    vec_subtract(edge[1], corner[2], corner[0]);
    vec_cross(normal, edge[0], edge[1]);
    for (int i = 0; i < 3; i++)
      for (int axis = 0; axis < 3; axis++)
        normals[3 * (size_t)b->indices[t + i] + axis] += (float)normal[axis];
  }
  for (size_t v = 0; v < b->vertex_count; v++) {
    double normal[3] = {normals[3 * v], normals[3 * v + 1], normals[3 * v + 2]};
    if (!vec_normalize(normal))
      normal[1] = 1.0;
    for (int axis = 0; axis < 3; axis++)
      normals[3 * v + axis] = (float)normal[axis];
  }
  return normals;
}

static void *narrow_indices(const mesh_builder *b) {
  uint16_t *narrow = host_allocate(b->index_count, sizeof *narrow);
  for (size_t i = 0; i < b->index_count; i++)
    narrow[i] = (uint16_t)b->indices[i];
  return narrow;
}

uint32_t builder_finish(mesh_builder *b, scene *s, const char *name, uint32_t index_size, bool smooth) {
  const bool narrow = index_size == 2 && b->vertex_count <= 65535;
  scene_mesh mesh = {.vertex_count = (uint32_t)b->vertex_count,
                     .index_count = (uint32_t)b->index_count,
                     .index_size = narrow ? 2 : 4,
                     .positions = b->positions,
                     .normals = smooth ? smooth_normals(b) : NULL,
                     .colors = b->colors,
                     .indices = narrow ? narrow_indices(b) : b->indices};
  snprintf(mesh.name, sizeof mesh.name, "%s", name);
  if (narrow)
    free(b->indices);
  memset(b, 0, sizeof *b);
  return scene_add_mesh(s, &mesh);
}

/* ---- noise ---- */

double noise_hash(uint32_t a, uint32_t b, uint32_t seed) {
  uint32_t h = a * 0x9e3779b1u ^ b * 0x85ebca77u ^ seed * 0xc2b2ae3du;
  h = (h ^ h >> 16) * 0x7feb352du;
  h = (h ^ h >> 15) * 0x846ca68bu;
  h ^= h >> 16;
  return h * (1.0 / 4294967296.0);
}

double noise_value(double x, double y, uint32_t seed) {
  const double column = floor(x), row = floor(y);
  const uint32_t i = (uint32_t)(int32_t)column, j = (uint32_t)(int32_t)row;
  const double fx = x - column, fy = y - row;
  const double u = fx * fx * fx * (fx * (6.0 * fx - 15.0) + 10.0), v = fy * fy * fy * (fy * (6.0 * fy - 15.0) + 10.0);
  const double low = noise_hash(i, j, seed) * (1.0 - u) + noise_hash(i + 1, j, seed) * u;
  const double high = noise_hash(i, j + 1, seed) * (1.0 - u) + noise_hash(i + 1, j + 1, seed) * u;
  return 2.0 * (low * (1.0 - v) + high * v) - 1.0;
}

double noise_fractal(double x, double y, uint32_t octaves, uint32_t seed) {
  double sum = 0.0, amplitude = 0.5;
  for (uint32_t octave = 0; octave < octaves; octave++) {
    sum += amplitude * noise_value(x, y, seed + octave);
    const double turned = 1.6 * x - 1.2 * y; /* turned by 37 degrees and doubled, so that no grid shows */
    y = 1.2 * x + 1.6 * y;
    x = turned;
    amplitude *= 0.5;
  }
  return sum;
}
