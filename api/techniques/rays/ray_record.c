#include "techniques/rays/ray_record.h"

#include <math.h>
#include <string.h>

/* What a place in a mesh may be off, as a share of its largest coordinate: a few last places of a float. */
static const double place_share = 3e-7;
/* A transform that stretches one way so many times more than another leaves nothing of a float. */
static const double most_stretch = 1e5;
/* And one that makes anything larger, or smaller, than this leaves room for squares in floats. */
static const double most_size = 1e15;

typedef struct record {
  float rows[3][4]; /* world to mesh, and where the mesh's origin stands */
  float low[4];     /* what floats leave of that; length that a metre may have in the mesh */
  float scale[4];   /* of a place in the mesh to the grid of its nodes */
  float offset[4];  /* and what places may be off */
  uint32_t tree[4]; /* first row of its nodes, how many, first row of its triangles, of its uvs */
  uint32_t alpha[3];
  float cutoff;
} record;
_Static_assert(sizeof(record) == RAY_RECORD_SIZE, "RAY_RECORD_SIZE");

static double length(const double *v, int stride) {
  return sqrt(v[0] * v[0] + v[stride] * v[stride] + v[2 * stride] * v[2 * stride]);
}

/* At least the length that a metre may have after a transform of three rows: of rows across each other just that.
   Gershgorin's bound of the largest eigenvalue of it times its transpose. */
static double widest(const double rows[9]) {
  double square = 0.0;
  for (int i = 0; i < 3; ++i) {
    double sum = 0.0;
    for (int k = 0; k < 3; ++k)
      sum += fabs(rows[3 * i] * rows[3 * k] + rows[3 * i + 1] * rows[3 * k + 1] + rows[3 * i + 2] * rows[3 * k + 2]);
    square = fmax(square, sum);
  }
  return sqrt(square);
}

/* The inverse of a transform's nine, in rows; false: too flat. Numbers are at most PLAN_LARGEST. */
static bool invert(double out[9], const double t[12]) {
  double m[16] = {0}, inverse[16];
  double longest = 0.0, shortest = INFINITY;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      m[column * 4 + row] = t[row * 4 + column];
  m[15] = 1.0;
  if (!plan_invert(inverse, m))
    return false;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      out[row * 3 + column] = inverse[column * 4 + row];
  if (!plan_finite(out, 9))
    return false;
  for (int i = 0; i < 9; ++i)
    if (fabs(out[i]) > most_size)
      return false;
  for (int i = 0; i < 3; ++i) {
    const double long_side = length(&t[i], 4), thin = length(&out[i * 3], 1);
    longest = fmax(longest, long_side);
    shortest = thin > 0.0 ? fmin(shortest, 1.0 / thin) : shortest;
  }
  return longest < most_stretch * shortest && longest < most_size && shortest * most_size > 1.0;
}

/* Where the mesh's stored origin stands in the world: positions are stored less an offset. False: farther than floats go. */
static bool find_place(double out[3], const plan_instance *instance, const plan_bounds *bounds) {
  bool near = true;
  for (int row = 0; row < 3; ++row) {
    const double *t = &instance->transform[row * 4];
    out[row] = t[0] * bounds->offset[0] + t[1] * bounds->offset[1] + t[2] * bounds->offset[2] + t[3];
    near = near && fabs(out[row]) <= PLAN_LARGEST;
  }
  return near;
}

static void write_place(record *to, const double place[3]) {
  for (int row = 0; row < 3; ++row) {
    to->rows[row][3] = (float)place[row];
    to->low[row] = (float)(place[row] - to->rows[row][3]);
  }
}

static void write_tree(record *to, const mesh_rays *rays) {
  for (int axis = 0; axis < 3; ++axis) {
    to->scale[axis] = (float)rays->grid_scale[axis];
    to->offset[axis] = (float)rays->grid_offset[axis];
  }
  to->offset[3] = (float)(place_share * rays->reach);
  to->tree[0] = rays->node_row;
  to->tree[1] = rays->node_count;
  to->tree[2] = rays->triangle_row;
  to->tree[3] = rays->uv_row;
  to->alpha[0] = rays->alpha_row;
  to->alpha[1] = rays->alpha_size[0] | rays->alpha_size[1] << 16;
  to->alpha[2] = rays->alpha_wrap[0] | rays->alpha_wrap[1] << 16;
  to->cutoff = rays->alpha_cutoff;
}

void ray_record_write(void *out, const plan_instance *instance, const plan_bounds *bounds, const mesh_rays *rays) {
  record to = {.rows = {{1.0f}, {0.0f, 1.0f}, {0.0f, 0.0f, 1.0f}}, .tree = {0, 0, 0, MESH_RAYS_NONE}};
  double inverse[9], place[3];
  if (rays && invert(inverse, instance->transform) && find_place(place, instance, bounds)) {
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 3; ++column)
        to.rows[row][column] = (float)inverse[row * 3 + column];
    to.low[3] = (float)widest(inverse);
    write_place(&to, place);
    write_tree(&to, rays);
  }
  memcpy(out, &to, sizeof to);
}
