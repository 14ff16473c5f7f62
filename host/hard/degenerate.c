/*
 * degenerate.c: triangles without an area, twice the same and thinner than a texel; instances at any scale, mirrored,
 * sheared and of no extent. The world that is drawn is the same, so the picture is: 0 pixels differ.
 */
#include "base/host.h"
#include "base/linear.h"
#include "hard/hard.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MODES = CSM_FACE_CULLING_BACK + 1 };

static void make_yard(host_setup *out) {
  hard_setup_begin(out, 256, 144);
  hard_yard(out, false);
  out->config.resolution = 512;
}

/* ---- triangles ---- */

/* Vertex `i` of a mesh, from a number of any size. */
static void add_index(scene_mesh *mesh, uint32_t index) {
  ((uint32_t *)mesh->indices)[mesh->index_count++] = index % mesh->vertex_count;
}

static void make_room(scene_mesh *mesh, uint32_t vertices, uint32_t triangles) {
  size_t capacity = mesh->vertex_count, index_capacity = mesh->index_count;
  mesh->positions = host_grow(mesh->positions, &capacity, mesh->vertex_count + vertices, 3 * sizeof *mesh->positions);
  mesh->indices =
      host_grow(mesh->indices, &index_capacity, mesh->index_count + 3 * (size_t)triangles, sizeof(uint32_t));
}

/* A line from one of the mesh's vertices into the air, with a corner on it, which is rounded where `steps` is no power
 * of two. */
static void add_line(scene_mesh *mesh, uint32_t seed, float steps) {
  const uint32_t first = mesh->vertex_count;
  make_room(mesh, 3, 1);
  const float *from = mesh->positions + 3 * (size_t)(seed % first);
  for (uint32_t axis = 0; axis < 3; axis++) {
    const float way = (float)(int)(64.0 * noise_hash(seed, axis, 7) - (axis == 1 ? 0.0 : 32.0));
    for (uint32_t i = 0; i < 3; i++)
      mesh->positions[3 * (first + i) + axis] = from[axis] + way * (float)(i * i) / steps;
  }
  mesh->vertex_count += 3;
  for (uint32_t i = 0; i < 3; i++)
    add_index(mesh, first + i);
}

static void add_exact_line(scene_mesh *mesh, uint32_t seed) {
  add_line(mesh, seed, 32.0f);
}

static void add_rounded_line(scene_mesh *mesh, uint32_t seed) {
  add_line(mesh, seed, 29.0f);
}

/* Corners that are one vertex twice and thrice. */
static void add_points(scene_mesh *mesh, uint32_t seed) {
  make_room(mesh, 0, 2);
  const uint32_t corners[6] = {seed, seed, seed + 1, seed + 2, seed + 2, seed + 2};
  for (int i = 0; i < 6; i++)
    add_index(mesh, corners[i]);
}

/* The same triangle again, with another corner first, or seen from its other side. */
static void add_again(scene_mesh *mesh, uint32_t seed, bool turned) {
  make_room(mesh, 0, 1);
  const uint32_t *corners = (const uint32_t *)mesh->indices + 3 * (size_t)(seed % (mesh->index_count / 3));
  const uint32_t kept[3] = {corners[seed % 3], corners[(seed + 1 + turned) % 3], corners[(seed + 2 - turned) % 3]};
  for (int i = 0; i < 3; i++)
    add_index(mesh, kept[i]);
}

static void add_duplicate(scene_mesh *mesh, uint32_t seed) {
  add_again(mesh, seed, false);
}

static void add_turned(scene_mesh *mesh, uint32_t seed) {
  add_again(mesh, seed, true);
}

/* Two vertices at the places of others: corners that are as close as can be, and are not the same. */
static void add_copies(scene_mesh *mesh, uint32_t seed) {
  const uint32_t of = seed % mesh->vertex_count, first = mesh->vertex_count;
  make_room(mesh, 2, 1);
  for (uint32_t i = 0; i < 2; i++)
    memcpy(mesh->positions + 3 * (size_t)(first + i), mesh->positions + 3 * (size_t)of, 3 * sizeof(float));
  mesh->vertex_count += 2;
  add_index(mesh, first);
  add_index(mesh, seed + 1);
  add_index(mesh, first + 1);
}

/* ---- instances ---- */

/*
 * The same world from meshes and transforms that are other ones: positions times `inner`, and transforms times its
 * inverse. A mirrored mesh turns its triangles about, so that they face outwards as before.
 */
static void reshape(scene *s, const double inner[16]) {
  double inverse[16], moved[16];
  mat_invert(inverse, inner);
  for (size_t m = 0; m < s->mesh_count; m++) {
    scene_mesh *mesh = &s->meshes[m];
    for (uint32_t v = 0; v < mesh->vertex_count; v++) {
      float *p = mesh->positions + 3 * (size_t)v;
      mat_transform(moved, inner, (const double[3]){p[0], p[1], p[2]}, 1.0);
      for (int axis = 0; axis < 3; axis++)
        p[axis] = (float)moved[axis];
    }
    uint32_t *indices = mesh->indices;
    for (uint32_t i = 0; mat_determinant3(inner) < 0.0 && i < mesh->index_count; i += 3) {
      const uint32_t kept = indices[i + 1];
      indices[i + 1] = indices[i + 2];
      indices[i + 2] = kept;
    }
  }
  for (size_t i = 0; i < s->instance_count; i++) {
    mat_multiply(moved, s->instances[i].transform, inverse);
    memcpy(s->instances[i].transform, moved, sizeof moved);
  }
}

/* Instances of every mesh that are flattened to lines and points, in the air where they would cast, and huge ones. */
static void add_flattened(scene *s) {
  static const double scales[][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1000, 0}, {0, 0, 1e-3}, {1e-300, 0, 1e-200}};
  const size_t count = s->instance_count;
  for (size_t i = 0; i < count; i++)
    for (size_t k = 0; k < sizeof scales / sizeof scales[0]; k++) {
      double transform[16];
      const double position[3] = {(double)i - 6.0, 1.0 + (double)k, -4.0 - 2.0 * (double)i};
      mat_place(transform, position, 0.3 * (double)i, scales[k]);
      scene_add_instance(s, s->instances[i].mesh, transform);
    }
}

static void add_twice(scene *s) {
  const size_t count = s->instance_count;
  for (size_t i = 0; i < count; i++)
    for (int again = 0; again < 3; again++) {
      const scene_instance kept = s->instances[i]; /* the array may move */
      scene_add_instance(s, kept.mesh, kept.transform);
    }
}

/* Each triangle becomes three, about a point that is 1/4096 of its height away from an edge: the same surface. */
static void split_thinly(scene *s) {
  for (size_t m = 0; m < s->mesh_count; m++) {
    scene_mesh *mesh = &s->meshes[m];
    const uint32_t triangles = mesh->index_count / 3;
    make_room(mesh, triangles, 2 * triangles);
    for (uint32_t t = 0; t < triangles; t++) {
      uint32_t *corners = (uint32_t *)mesh->indices + 3 * (size_t)t;
      const uint32_t a = corners[0], b = corners[1], c = corners[2], inner = mesh->vertex_count++;
      float *p = mesh->positions;
      for (uint32_t axis = 0; axis < 3; axis++)
        p[3 * inner + axis] =
            0.5f * (p[3 * a + axis] + p[3 * b + axis]) + (p[3 * c + axis] - p[3 * a + axis]) / 4096.0f;
      corners[2] = inner;
      const uint32_t others[6] = {b, c, inner, c, a, inner};
      for (int i = 0; i < 6; i++)
        add_index(mesh, others[i]);
    }
  }
}

/* ---- comparing ---- */

/* What is changed in the yard. */
typedef struct odd_yard {
  const char *what;
  void (*add)(scene_mesh *mesh, uint32_t seed); /* to every mesh, or NULL */
  void (*change)(scene *s);                     /* the scene, or NULL */
  const double *inner;                          /* of reshape, or NULL */
  uint32_t modes; /* ways to leave faces out, from none on: turned duplicates are faces of the other kind */
  bool rounds;    /* depths and products of matrices come out with another rounding: vertices move by a step */
} odd_yard;

/*
 * A vertex that moves by a rounding step may be snapped to the next 1/256 of a texel or a pixel. What has its centre as
 * near to an edge as that, on either side, may change: 1/128 of what an edge goes through. Twice, for an edge that
 * runs along its row goes through more.
 */
static double rounding_bound(const hard_picture *expected) {
  uint64_t edge = 0;
  for (size_t i = 0; i < (size_t)expected->width * expected->height; i++)
    edge += expected->mask[i] > 0.0f && expected->mask[i] < 1.0f;
  return ceil((double)edge / 64.0);
}

static void compare(hard_run *run, const odd_yard *odd, uint32_t mode, const hard_picture *expected,
                    const hard_picture *drawn) {
  static const char *const culled[] = {"", ", front faces culled", ", back faces culled"};
  const hard_difference found = hard_compare(run, expected, drawn, 0.0);
  hard_figure_add(run, (double)found.pixels, odd->rounds ? rounding_bound(expected) : 0.0, "px", "changed: %s%s",
                  odd->what, culled[mode]);
}

/* With each way to leave faces out. */
static int draw(hard_run *run, const host_setup *setup, uint32_t modes, hard_picture out[MODES]) {
  int code = hard_load(run, setup);
  for (uint32_t mode = 0; code == 0 && mode < modes; mode++) {
    csm_config config = setup->config;
    config.face_culling = mode;
    code = hard_restart(run, &config);
    if (code == 0)
      code = hard_draw(run, &setup->camera, &setup->light, 0, &out[mode]);
  }
  hard_unload(run);
  return code;
}

static void add_triangles(scene *s, void (*add)(scene_mesh *mesh, uint32_t seed), uint32_t each) {
  for (size_t m = 0; m < s->mesh_count; m++)
    for (uint32_t seed = 0; seed < each; seed++)
      add(&s->meshes[m], seed * 31 + (uint32_t)m);
}

/* Swaps how many of a mesh's indices are drawn. The vertices stay, for boxes and ranges go by them. */
static void swap_counts(scene *s, uint32_t *counts) {
  for (size_t m = 0; m < s->mesh_count; m++) {
    const uint32_t kept = s->meshes[m].index_count;
    s->meshes[m].index_count = counts[m];
    counts[m] = kept;
  }
}

static int draw_odd(hard_run *run, const odd_yard *odd) {
  host_setup setup;
  hard_picture expected[MODES] = {{0}}, drawn[MODES] = {{0}};
  make_yard(&setup);
  uint32_t *counts = host_allocate(setup.scene.mesh_count, sizeof *counts);
  for (size_t m = 0; m < setup.scene.mesh_count; m++)
    counts[m] = setup.scene.meshes[m].index_count;
  if (odd->add)
    add_triangles(&setup.scene, odd->add, run->sweep ? 400 : 40);
  swap_counts(&setup.scene, counts);
  int code = draw(run, &setup, odd->modes, expected);
  swap_counts(&setup.scene, counts);
  if (odd->change)
    odd->change(&setup.scene);
  if (odd->inner)
    reshape(&setup.scene, odd->inner);
  if (code == 0)
    code = draw(run, &setup, odd->modes, drawn);
  for (uint32_t mode = 0; mode < odd->modes; mode++) {
    if (code == 0)
      compare(run, odd, mode, &expected[mode], &drawn[mode]);
    hard_picture_free(&expected[mode]);
    hard_picture_free(&drawn[mode]);
  }
  free(counts);
  setup_free(&setup);
  return code;
}

/* Scales are powers of two from about 1e-3 to 1e3, so that all that is reshaped stays exact. */
static const double smaller[16] = {1024, 0, 0, 0, 0, 1024, 0, 0, 0, 0, 1024, 0, 0, 0, 0, 1};
static const double larger[16] = {0x1p-10, 0, 0, 0, 0, 0x1p-10, 0, 0, 0, 0, 0x1p-10, 0, 0, 0, 0, 1};
static const double uneven[16] = {1024, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0x1p-10, 0, 0, 0, 0, 1};
static const double mirrored[16] = {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
static const double mirrored_thrice[16] = {-2, 0, 0, 0, 0, -1, 0, 0, 0, 0, -4, 0, 0, 0, 0, 1};
static const double turned[16] = {0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1};
static const double sheared[16] = {1, 0.5, 0, 0, 0, 1, 0, 0, -2, 0, 1, 0, 0, 0, 0, 1};

static const odd_yard odd_yards[] = {
    {.what = "repeated corners", .add = add_points, .modes = MODES},
    {.what = "corners in one place", .add = add_copies, .modes = MODES},
    {.what = "corners in a line", .add = add_exact_line, .modes = MODES},
    {.what = "corners in a line, rounded", .add = add_rounded_line, .modes = MODES},
    {.what = "duplicates", .add = add_duplicate, .modes = MODES},
    {.what = "duplicates seen from the other side", .add = add_turned, .modes = 1},
    {.what = "slivers", .change = split_thinly, .modes = MODES, .rounds = true},
    {.what = "instances that are lines and points", .change = add_flattened, .modes = MODES},
    {.what = "instances that stand there four times", .change = add_twice, .modes = MODES},
    {.what = "scaled by 1/1024", .inner = smaller, .modes = MODES},
    {.what = "scaled by 1024", .inner = larger, .modes = MODES},
    {.what = "scaled by 1/1024, 1 and 1024", .inner = uneven, .modes = MODES},
    {.what = "mirrored", .inner = mirrored, .modes = MODES},
    {.what = "mirrored thrice", .inner = mirrored_thrice, .modes = MODES},
    {.what = "turned by quarters", .inner = turned, .modes = MODES},
    {.what = "sheared", .inner = sheared, .modes = MODES, .rounds = true},
};

static int run_case(hard_run *run) {
  int code = 0;
  for (size_t i = 0; code == 0 && i < sizeof odd_yards / sizeof odd_yards[0]; i++)
    code = draw_odd(run, &odd_yards[i]);
  return code;
}

const hard_case hard_degenerate = {.name = "degenerate",
                                   .about = "triangles of no area, duplicates, any scale, mirrored and sheared",
                                   .run = run_case};
