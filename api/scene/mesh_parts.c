#include "scene/mesh_parts.h"

#include <math.h>
#include <string.h>

/* A triangle's bucket: the number of its part, or that it is not drawn. */
enum { UNDRAWN = PLAN_MOST_PARTS, BUCKETS };

/* A mesh while it is divided; one block of memory, which begins with the order. */
typedef struct division {
  const csm_mesh_info *info;
  uint32_t count;    /* of triangles */
  uint32_t *order;   /* as it comes out */
  uint32_t *divided; /* those that a rasteriser may find, from the first part's to the last's */
  float (*middles)[3];
  uint8_t *buckets; /* by triangle */
  uint32_t divided_count, part_count;
} division;

/* ---- triangles ---- */

static void read_triangle(float out[3][3], const csm_mesh_info *info, uint32_t triangle) {
  for (uint32_t i = 0; i < 3; ++i)
    memcpy(out[i],
           (const char *)info->positions + (size_t)geometry_index(info, 3 * triangle + i) * info->position_stride,
           sizeof out[i]);
}

static double larger(double a, double b) {
  return fabs(a) > b ? fabs(a) : b;
}

/*
 * Whether a triangle is a line or a point, which covers nothing; yet a rasteriser, which rounds its corners, would find
 * texels in it. What one corner's rounding to a float, 2^-24 of each coordinate, makes of a line counts as one. The area
 * is looked at in each plane of two axes, so that a scale along an axis changes nothing.
 */
static bool has_no_area(const float t[3][3]) {
  const double float_rounding = 0x1p-24, double_rounding = 0x1p-50;
  double corners[3][3], reach[3] = {0.0, 0.0, 0.0}, edge[3] = {0.0, 0.0, 0.0};
  for (int i = 0; i < 9; ++i)
    corners[i / 3][i % 3] = t[i / 3][i % 3];
  for (int i = 0; i < 3; ++i)
    for (int axis = 0; axis < 3; ++axis) {
      reach[axis] = larger(corners[i][axis], reach[axis]);
      edge[axis] = larger(corners[(i + 1) % 3][axis] - corners[i][axis], edge[axis]);
    }
  bool none = true;
  for (int x = 0; x < 3; ++x) {
    const int y = (x + 1) % 3;
    const double left = (corners[1][x] - corners[0][x]) * (corners[2][y] - corners[0][y]);
    const double right = (corners[1][y] - corners[0][y]) * (corners[2][x] - corners[0][x]);
    none = none && fabs(left - right) <= float_rounding * (reach[x] * edge[y] + reach[y] * edge[x]) +
                                             double_rounding * (fabs(left) + fabs(right));
  }
  return none;
}

static bool same_place(const float a[3], const float b[3]) {
  return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

/* Whether two corners lie at one place, so that no rasteriser finds anything, however it rounds. */
static bool is_line(const float t[3][3]) {
  return same_place(t[0], t[1]) || same_place(t[1], t[2]) || same_place(t[2], t[0]);
}

static void look_at_triangles(division *d) {
  for (uint32_t i = 0; i < d->count; ++i) {
    float t[3][3];
    read_triangle(t, d->info, i);
    d->buckets[i] = has_no_area((const float(*)[3])t) ? UNDRAWN : 0;
    for (int axis = 0; axis < 3; ++axis)
      d->middles[i][axis] = (float)(((double)t[0][axis] + t[1][axis] + t[2][axis]) / 3.0);
    if (!is_line((const float(*)[3])t))
      d->divided[d->divided_count++] = i;
  }
}

/* ---- boxes ---- */

typedef struct box {
  float low[3], high[3];
} box;

static const box no_box = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};

static void hold(box *box, const float point[3]) {
  for (int axis = 0; axis < 3; ++axis) {
    box->low[axis] = point[axis] < box->low[axis] ? point[axis] : box->low[axis];
    box->high[axis] = point[axis] > box->high[axis] ? point[axis] : box->high[axis];
  }
}

/* ---- dividing ---- */

/* Along an axis; where two lie alike, the earlier one comes first. */
static bool comes_before(const division *d, int axis, uint32_t a, uint32_t b) {
  const float at = d->middles[a][axis], other = d->middles[b][axis];
  return at < other || (at == other && a < b);
}

static void swap(uint32_t *a, uint32_t *b) {
  const uint32_t kept = *a;
  *a = *b;
  *b = kept;
}

/* Puts the middle one of the first, the middle and the last into the middle, and gives it. */
static uint32_t find_pivot(const division *d, int axis, uint32_t *ids, uint32_t count) {
  uint32_t *low = &ids[0], *middle = &ids[count / 2], *high = &ids[count - 1];
  if (comes_before(d, axis, *middle, *low))
    swap(middle, low);
  if (comes_before(d, axis, *high, *middle))
    swap(high, middle);
  if (comes_before(d, axis, *middle, *low))
    swap(middle, low);
  return *middle;
}

/* Puts the `first` lowest of the triangles before the others (Hoare's selection). */
static void select_lowest(const division *d, int axis, uint32_t *ids, uint32_t count, uint32_t first) {
  while (count > 1) {
    const uint32_t pivot = find_pivot(d, axis, ids, count);
    uint32_t i = 0, k = count - 1;
    while (true) {
      while (comes_before(d, axis, ids[i], pivot))
        ++i;
      while (comes_before(d, axis, pivot, ids[k]))
        --k;
      if (i >= k)
        break;
      swap(&ids[i++], &ids[k--]);
    }
    if (first <= i) { /* these come before the pivot, or are it */
      count = i;
    } else {
      ids += i;
      count -= i;
      first -= i;
    }
  }
}

static int longest_axis(const division *d, const uint32_t *ids, uint32_t count) {
  box box = no_box;
  int longest = 0;
  for (uint32_t i = 0; i < count; ++i)
    hold(&box, d->middles[ids[i]]);
  for (int axis = 1; axis < 3; ++axis)
    if ((double)box.high[axis] - box.low[axis] > (double)box.high[longest] - box.low[longest])
      longest = axis;
  return longest;
}

/* The first triangle of a part, of so many. */
static uint32_t begin_of(const division *d, uint32_t part, uint32_t parts) {
  return (uint32_t)((uint64_t)d->divided_count * part / parts);
}

/* Halves all pieces along their longest axis until there are enough of them. */
static void divide(division *d) {
  d->part_count = 1;
  while (d->divided_count > MESH_WHOLE && d->part_count < PLAN_MOST_PARTS &&
         d->divided_count > d->part_count * (MESH_WHOLE / 2)) {
    for (uint32_t i = 0; i < d->part_count; ++i) {
      const uint32_t begin = begin_of(d, i, d->part_count), count = begin_of(d, i + 1, d->part_count) - begin;
      const uint32_t half = begin_of(d, 2 * i + 1, 2 * d->part_count) - begin;
      uint32_t *ids = &d->divided[begin];
      select_lowest(d, longest_axis(d, ids, count), ids, count, half);
    }
    d->part_count *= 2;
  }
}

/* ---- what comes of it ---- */

/* Puts triangles in a part into its bucket, unless they are not drawn, and finds the box around all of them. */
static void fill_part(plan_part *out, division *d, uint32_t part) {
  box box = no_box;
  for (uint32_t i = begin_of(d, part, d->part_count); i < begin_of(d, part + 1, d->part_count); ++i) {
    const uint32_t id = d->divided[i];
    float t[3][3];
    read_triangle(t, d->info, id);
    for (int k = 0; k < 3; ++k)
      hold(&box, t[k]);
    if (d->buckets[id] == UNDRAWN)
      continue;
    d->buckets[id] = (uint8_t)part;
    out->index_count += 3;
  }
  plan_bounds bounds;
  plan_bounds_in_place(&bounds, box.low, box.high);
  memcpy(out->center, bounds.center, sizeof out->center);
  memcpy(out->extent, bounds.extent, sizeof out->extent);
}

/* Bucket by bucket, and as they came in each: neighbours share vertices that a GPU has at hand. */
static uint32_t put_in_order(division *d) {
  uint32_t places[BUCKETS + 1] = {0};
  for (uint32_t i = 0; i < d->count; ++i)
    ++places[d->buckets[i] + 1];
  for (uint32_t i = 0; i < BUCKETS; ++i)
    places[i + 1] += places[i];
  const uint32_t drawn = places[UNDRAWN];
  for (uint32_t i = 0; i < d->count; ++i)
    d->order[places[d->buckets[i]]++] = i;
  return drawn;
}

static csm_result make_parts(host *host, division *d, plan_parts *out) {
  if (d->part_count == 1)
    return CSM_SUCCESS;
  plan_part *parts = host_allocate(host, d->part_count * sizeof *parts);
  if (!parts)
    return CSM_ERROR_OUT_OF_MEMORY;
  for (uint32_t i = 0, index = 0; i < d->part_count; ++i) {
    fill_part(&parts[i], d, i);
    parts[i].first_index = index;
    index += parts[i].index_count;
  }
  *out = (plan_parts){.parts = parts, .count = d->part_count};
  return CSM_SUCCESS;
}

static void *make_room(division *d, host *host) {
  const size_t ids = d->count * sizeof *d->order, middles = d->count * sizeof *d->middles;
  char *block = host_allocate(host, 2 * ids + middles + d->count + 4 * HOST_CARVED), *at = block;
  if (!block)
    return NULL;
  d->order = host_carve(&at, ids);
  d->divided = host_carve(&at, ids);
  d->middles = host_carve(&at, middles);
  d->buckets = host_carve(&at, d->count);
  return block;
}

csm_result mesh_parts_make(host *host, const csm_mesh_info *info, geometry_order *order, plan_parts *parts) {
  division d = {.info = info, .count = info->index_count / 3};
  *order = (geometry_order){0};
  *parts = (plan_parts){0};
  if (!make_room(&d, host))
    return CSM_ERROR_OUT_OF_MEMORY;
  look_at_triangles(&d);
  divide(&d);
  const csm_result result = make_parts(host, &d, parts);
  if (result) {
    host_release(host, d.order);
    return result;
  }
  *order = (geometry_order){.triangles = d.order, .drawn = put_in_order(&d)};
  return CSM_SUCCESS;
}

void mesh_parts_free(plan_parts *parts, host *host) {
  host_release(host, (void *)parts->parts);
  *parts = (plan_parts){0};
}
