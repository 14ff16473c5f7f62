/* The order of a mesh's triangles on a device, and the parts that a large one is divided into. */
#include "scene/mesh_parts.h"

#include <fenv.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "../plan/support.h"

enum { MOST_VERTICES = 5000, MOST_TRIANGLES = 12000, STRIDE = 5 };

typedef struct test_mesh {
  csm_mesh_info info;
  float positions[MOST_VERTICES][STRIDE];
  uint16_t narrow[3 * MOST_TRIANGLES];
  uint32_t wide[3 * MOST_TRIANGLES];
} test_mesh;

static const float *position(const test_mesh *mesh, uint32_t triangle, uint32_t corner) {
  return mesh->positions[mesh->wide[3 * triangle + corner]];
}

/* Positions are whole numbers up to `size`, so that areas are known exactly. */
static void make_mesh(test_mesh *mesh, random_state *random, uint32_t triangles, uint32_t size) {
  const uint32_t vertices = 3 + random_below(random, MOST_VERTICES - 3), spread = 1 + random_below(random, 40);
  const uint32_t lines = random_below(random, 4);
  for (uint32_t i = 0; i < vertices; ++i)
    for (int axis = 0; axis < 3; ++axis)
      mesh->positions[i][axis] = (float)random_below(random, 2 * size + 1) - (float)size;
  for (uint32_t i = 0; i < triangles; ++i) {
    const uint32_t first = random_below(random, vertices);
    for (uint32_t k = 0; k < 3; ++k)
      mesh->wide[3 * i + k] = (first + (k ? random_below(random, spread) : 0)) % vertices;
    if (lines && random_below(random, 10) < lines)
      mesh->wide[3 * i + 2] = mesh->wide[3 * i + random_below(random, 2)];
  }
  for (uint32_t i = 0; i < 3 * triangles; ++i)
    mesh->narrow[i] = (uint16_t)mesh->wide[i];
  const bool narrow = random_below(random, 2);
  mesh->info = (csm_mesh_info){.positions = mesh->positions,
                               .position_stride = STRIDE * sizeof(float),
                               .vertex_count = vertices,
                               .indices = narrow ? (const void *)mesh->narrow : mesh->wide,
                               .index_count = 3 * triangles,
                               .index_size = narrow ? 2 : 4};
}

static bool has_area(const test_mesh *mesh, uint32_t triangle) {
  const float *a = position(mesh, triangle, 0), *b = position(mesh, triangle, 1), *c = position(mesh, triangle, 2);
  bool area = false;
  for (int x = 0; x < 3; ++x) {
    const int y = (x + 1) % 3;
    area |= (b[x] - a[x]) * (c[y] - a[y]) != (b[y] - a[y]) * (c[x] - a[x]);
  }
  return area;
}

static bool holds(const plan_part *part, const test_mesh *mesh, uint32_t triangle) {
  bool inside = true;
  for (uint32_t i = 0; i < 9; ++i)
    inside &= fabs(position(mesh, triangle, i / 3)[i % 3] - part->center[i % 3]) <= part->extent[i % 3];
  return inside;
}

static bool corners_are_apart(const test_mesh *mesh, uint32_t triangle) {
  bool apart = true;
  for (uint32_t i = 0; i < 3; ++i)
    apart &= memcmp(position(mesh, triangle, i), position(mesh, triangle, (i + 1) % 3), 3 * sizeof(float)) != 0;
  return apart;
}

/* Every triangle once; those with an area first. Gives how many those are. */
static uint32_t check_order(const test_mesh *mesh, const geometry_order *order) {
  static bool named[MOST_TRIANGLES];
  const uint32_t count = mesh->info.index_count / 3;
  memset(named, 0, sizeof named);
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t triangle = order->triangles[i];
    assert_true(triangle < count && !named[triangle]);
    named[triangle] = true;
    assert_true(has_area(mesh, triangle) == (i < order->drawn));
  }
  return count;
}

/* Parts follow each other through all that is drawn, hold their triangles, and keep them as they came. */
static void check_parts(const test_mesh *mesh, const geometry_order *order, const plan_parts *parts) {
  uint32_t next = 0;
  assert_true(parts->count >= 2 && parts->count <= PLAN_MOST_PARTS);
  for (uint32_t i = 0; i < parts->count; ++i) {
    const plan_part *part = &parts->parts[i];
    assert_int_equal(part->first_index, next);
    assert_true(part->index_count % 3 == 0 &&
                (part->index_count <= 3 * MESH_WHOLE / 2 || parts->count == PLAN_MOST_PARTS));
    next += part->index_count;
    for (uint32_t k = part->first_index / 3; k < next / 3; ++k) {
      assert_true(holds(part, mesh, order->triangles[k]));
      assert_true(k == part->first_index / 3 || order->triangles[k] > order->triangles[k - 1]);
    }
  }
  assert_int_equal(next, 3 * order->drawn);
}

/* What a rasteriser may find is a surface that receives, and lies in some part's box. */
static void check_lines(const test_mesh *mesh, const geometry_order *order, const plan_parts *parts) {
  for (uint32_t k = order->drawn; k < mesh->info.index_count / 3; ++k) {
    bool held = !corners_are_apart(mesh, order->triangles[k]);
    for (uint32_t i = 0; i < parts->count && !held; ++i)
      held = holds(&parts->parts[i], mesh, order->triangles[k]);
    assert_true(held);
  }
}

static void release(host *host, geometry_order *order, plan_parts *parts) {
  host_release(host, order->triangles);
  mesh_parts_free(parts, host);
  assert_true(!parts->parts && !parts->count);
}

static void every_triangle_has_its_place(void **state) {
  (void)state;
  static test_mesh mesh;
  random_state random = {1};
  host host = host_default();
  uint32_t divided = 0, full = 0, lines = 0;
  for (int i = 0; i < 600; ++i) {
    geometry_order order, again;
    plan_parts parts, more;
    make_mesh(&mesh, &random, (uint32_t)random_scale(&random, 1.0, MOST_TRIANGLES), 1 + random_below(&random, 100));
    feclearexcept(FE_ALL_EXCEPT);
    assert_int_equal(mesh_parts_make(&host, &mesh.info, &order, &parts), CSM_SUCCESS);
    assert_no_exceptions();
    const uint32_t count = check_order(&mesh, &order);
    assert_true(count > MESH_WHOLE || !parts.count);
    assert_true(order.drawn <= MESH_WHOLE || parts.count);
    if (parts.count) {
      check_parts(&mesh, &order, &parts);
      check_lines(&mesh, &order, &parts);
    }
    assert_int_equal(mesh_parts_make(&host, &mesh.info, &again, &more), CSM_SUCCESS);
    assert_int_equal(parts.count, more.count);
    assert_memory_equal(order.triangles, again.triangles, count * sizeof *order.triangles);
    if (parts.count)
      assert_memory_equal(parts.parts, more.parts, parts.count * sizeof *parts.parts);
    divided += parts.count > 0;
    full += parts.count == PLAN_MOST_PARTS;
    lines += order.drawn < count;
    release(&host, &order, &parts);
    release(&host, &again, &more);
  }
  assert_true(divided > 100 && full > 20 && lines > 100);
}

/* A grid over a square: its parts are small, and lie beside each other. */
static void parts_of_a_terrain_are_small(void **state) {
  (void)state;
  enum { SIDE = 65, TRIANGLES = (SIDE - 1) * (SIDE - 1) * 2 };
  static test_mesh mesh;
  host host = host_default();
  geometry_order order;
  plan_parts parts;
  for (uint32_t i = 0; i < SIDE * SIDE; ++i) {
    mesh.positions[i][0] = (float)(i % SIDE);
    mesh.positions[i][1] = (float)(i * 7919 % 3);
    mesh.positions[i][2] = (float)(i / SIDE);
  }
  uint32_t *out = mesh.wide;
  for (uint32_t row = 0; row + 1 < SIDE; ++row)
    for (uint32_t column = 0; column + 1 < SIDE; ++column) {
      const uint32_t a = row * SIDE + column, b = a + SIDE, corners[6] = {a, b, a + 1, a + 1, b, b + 1};
      memcpy(out, corners, sizeof corners);
      out += 6;
    }
  mesh.info = (csm_mesh_info){.positions = mesh.positions,
                              .position_stride = STRIDE * sizeof(float),
                              .vertex_count = SIDE * SIDE,
                              .indices = mesh.wide,
                              .index_count = 3 * TRIANGLES,
                              .index_size = 4};
  assert_int_equal(mesh_parts_make(&host, &mesh.info, &order, &parts), CSM_SUCCESS);
  assert_int_equal(parts.count, PLAN_MOST_PARTS);
  check_parts(&mesh, &order, &parts);
  double area = 0.0;
  for (uint32_t i = 0; i < parts.count; ++i) {
    assert_int_equal(parts.parts[i].index_count, 3 * TRIANGLES / PLAN_MOST_PARTS);
    area += 4.0 * parts.parts[i].extent[0] * parts.parts[i].extent[2];
  }
  assert_true(area < 1.5 * (SIDE - 1) * (SIDE - 1));
  release(&host, &order, &parts);
}

/* Positions as far out as floats go, and all at one place. */
static void numbers_may_be_of_any_size(void **state) {
  (void)state;
  static test_mesh mesh;
  random_state random = {2};
  host host = host_default();
  for (int i = 0; i < 60; ++i) {
    geometry_order order;
    plan_parts parts;
    make_mesh(&mesh, &random, 1000 + random_below(&random, 5000), 1 + random_below(&random, 3));
    const float scale = i % 3 == 0 ? 0.0f : i % 3 == 1 ? 1e38f : 1e-42f;
    for (uint32_t k = 0; k < mesh.info.vertex_count; ++k)
      for (int axis = 0; axis < 3; ++axis)
        mesh.positions[k][axis] *= scale;
    feclearexcept(FE_ALL_EXCEPT);
    assert_int_equal(mesh_parts_make(&host, &mesh.info, &order, &parts), CSM_SUCCESS);
    assert_no_exceptions();
    assert_true(scale > 0.0f ? parts.count > 0 : !parts.count && !order.drawn);
    if (parts.count)
      check_parts(&mesh, &order, &parts);
    release(&host, &order, &parts);
  }
}

/* ---- memory ---- */

typedef struct counter {
  int left, live;
} counter;

static void *CSM_CALL count_allocation(void *user, size_t size, size_t alignment) {
  counter *counter = user;
  if (counter->left-- <= 0)
    return NULL;
  ++counter->live;
  return aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
}

static void CSM_CALL count_release(void *user, void *memory) {
  --((counter *)user)->live;
  free(memory);
}

static void no_memory_leaves_nothing(void **state) {
  (void)state;
  static test_mesh mesh;
  random_state random = {5};
  counter counter = {0};
  host host = host_default();
  host.allocate = count_allocation;
  host.release = count_release;
  host.user = &counter;
  make_mesh(&mesh, &random, 2000, 50);
  csm_result result = CSM_ERROR_OUT_OF_MEMORY;
  for (int most = 0; result; ++most) {
    geometry_order order;
    plan_parts parts;
    counter.left = most;
    result = mesh_parts_make(&host, &mesh.info, &order, &parts);
    if (result) {
      assert_int_equal(result, CSM_ERROR_OUT_OF_MEMORY);
      assert_true(!order.triangles && !parts.count);
    } else {
      assert_true(parts.count && counter.live == 2);
      release(&host, &order, &parts);
    }
    assert_int_equal(counter.live, 0);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_triangle_has_its_place),
      cmocka_unit_test(parts_of_a_terrain_are_small),
      cmocka_unit_test(numbers_may_be_of_any_size),
      cmocka_unit_test(no_memory_leaves_nothing),
  };
  return cmocka_run_group_tests_name("mesh-parts", tests, NULL, NULL);
}
