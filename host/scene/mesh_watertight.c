#include "scene/mesh_watertight.h"
#include "base/host.h"
#include <stdlib.h>
#include <string.h>

typedef struct edge {
  uint32_t low, high;
  int32_t turns; /* 1 from low to high, -1 back */
} edge;

static uint32_t index_at(const scene_mesh *mesh, size_t i) {
  return mesh->index_size == 2 ? ((const uint16_t *)mesh->indices)[i] : ((const uint32_t *)mesh->indices)[i];
}

/* ---- vertices at one place ---- */

static int compare_places(const void *a, const void *b, void *positions) {
  const float *p = (const float *)positions + *(const uint32_t *)a * 3;
  const float *q = (const float *)positions + *(const uint32_t *)b * 3;
  for (int axis = 0; axis < 3; axis++)
    if (p[axis] != q[axis])
      return p[axis] < q[axis] ? -1 : 1;
  return 0;
}

/* For each vertex the first one at its place. */
static uint32_t *weld(const scene_mesh *mesh) {
  uint32_t *order = host_allocate(mesh->vertex_count, sizeof *order);
  uint32_t *first = host_allocate(mesh->vertex_count, sizeof *first);
  for (uint32_t i = 0; i < mesh->vertex_count; i++)
    order[i] = i;
  qsort_r(order, mesh->vertex_count, sizeof *order, compare_places, mesh->positions);
  for (uint32_t i = 0; i < mesh->vertex_count; i++) {
    const bool same = i && compare_places(&order[i - 1], &order[i], mesh->positions) == 0;
    first[order[i]] = same ? first[order[i - 1]] : order[i];
  }
  free(order);
  return first;
}

/* ---- edges ---- */

static int compare_edges(const void *a, const void *b) {
  const edge *p = a, *q = b;
  if (p->low != q->low)
    return p->low < q->low ? -1 : 1;
  return p->high < q->high ? -1 : p->high > q->high;
}

static bool edges_cancel(edge *edges, size_t count) {
  int32_t turns = 0;
  qsort(edges, count, sizeof *edges, compare_edges);
  for (size_t i = 0; i < count; i++) {
    if (i && compare_edges(&edges[i - 1], &edges[i]) && turns)
      return false;
    turns += edges[i].turns;
  }
  return turns == 0;
}

/* ---- pieces ---- */

static uint32_t piece_of(uint32_t *parents, uint32_t vertex) {
  while (parents[vertex] != vertex)
    vertex = parents[vertex] = parents[parents[vertex]];
  return vertex;
}

/* Six times the volume between a triangle and the origin. */
static double signed_volume(const float *a, const float *b, const float *c) {
  return a[0] * ((double)b[1] * c[2] - (double)b[2] * c[1]) + a[1] * ((double)b[2] * c[0] - (double)b[0] * c[2]) +
         a[2] * ((double)b[0] * c[1] - (double)b[1] * c[0]);
}

static bool all_outwards(const scene_mesh *mesh, const uint32_t *first) {
  uint32_t *parents = host_allocate(mesh->vertex_count, sizeof *parents);
  double *volumes = host_allocate(mesh->vertex_count, sizeof *volumes);
  bool outwards = true;
  for (uint32_t i = 0; i < mesh->vertex_count; i++)
    parents[i] = i;
  for (size_t i = 0; i < mesh->index_count; i++) {
    const uint32_t a = piece_of(parents, first[index_at(mesh, i)]);
    const uint32_t b = piece_of(parents, first[index_at(mesh, i / 3 * 3)]);
    parents[a] = b;
  }
  for (size_t t = 0; t < mesh->index_count; t += 3) {
    const uint32_t corners[3] = {index_at(mesh, t), index_at(mesh, t + 1), index_at(mesh, t + 2)};
    volumes[piece_of(parents, first[corners[0]])] += signed_volume(
        &mesh->positions[corners[0] * 3], &mesh->positions[corners[1] * 3], &mesh->positions[corners[2] * 3]);
  }
  for (size_t i = 0; i < mesh->index_count && outwards; i++)
    outwards = volumes[piece_of(parents, first[index_at(mesh, i)])] > 0.0;
  free(volumes);
  free(parents);
  return outwards;
}

bool mesh_is_closed(const scene_mesh *mesh) {
  uint32_t *first = weld(mesh);
  edge *edges = host_allocate(mesh->index_count, sizeof *edges);
  size_t count = 0;
  for (size_t i = 0; i < mesh->index_count; i++) {
    const uint32_t from = first[index_at(mesh, i)], to = first[index_at(mesh, i % 3 == 2 ? i - 2 : i + 1)];
    if (from != to)
      edges[count++] = (edge){from < to ? from : to, from < to ? to : from, from < to ? 1 : -1};
  }
  const bool closed = count && edges_cancel(edges, count) && all_outwards(mesh, first);
  free(edges);
  free(first);
  return closed;
}
