/*
 * exact_shapes.c: what rays go through: instances that are mirrored, sheared, stretched and flattened, meshes inside of
 * each other, walls of one face and of two, triangles that lie twice in one place, and cut-out leaves.
 */
#include "base/host.h"
#include "base/linear.h"
#include "hard/exact.h"
#include <math.h>
#include <string.h>

/* A rough ball on a scene's ground, by a transform of its own. */
static void add_ball(host_setup *out, const double transform[16]) {
  mesh_builder b = {0};
  builder_ball(&b, (const double[3]){0.0, 0.0, 0.0}, (const double[3]){1.0, 1.0, 1.0}, 4, 0.3, 7);
  scene_add_instance(&out->scene, builder_finish(&b, &out->scene, "ball", 4, false), transform);
}

static void add_box(host_setup *out, const double transform[16]) {
  mesh_builder b = {0};
  builder_box(&b, (const double[3]){-0.75, -0.75, -0.75}, (const double[3]){0.75, 0.75, 0.75});
  scene_add_instance(&out->scene, builder_finish(&b, &out->scene, "box", 4, false), transform);
}

/* Three balls and three boxes, that are made what they are by a transform of their own. */
static void add_row(host_setup *out, const double m[16]) {
  for (int i = 0; i < 6; i++) {
    double place[16], transform[16];
    mat_place(place, (const double[3]){-5.0 + 2.0 * i, 2.0, i & 1 ? 1.5 : -1.5}, 0.7 * i,
              (const double[3]){1.0, 1.0, 1.0});
    mat_multiply(transform, place, m);
    if (i & 1)
      add_box(out, transform);
    else
      add_ball(out, transform);
  }
}

static const double mirrored[16] = {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
static const double sheared[16] = {1, 0.5, 0, 0, 0.8, 1, 0, 0, -1.5, 0, 1, 0, 0, 0, 0, 1};
static const double stretched[16] = {0.2, 0, 0, 0, 0, 1.4, 0, 0, 0, 0, 3, 0, 0, 0, 0, 1};
static const double thin[16] = {1, 0, 0, 0, 0, 1e-3, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
static const double flat[16] = {1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

static void add_mirrored(host_setup *out) {
  add_row(out, mirrored);
}

static void add_sheared(host_setup *out) {
  add_row(out, sheared);
}

static void add_stretched(host_setup *out) {
  add_row(out, stretched);
}

static void add_thin(host_setup *out) {
  add_row(out, thin);
}

static void add_flat(host_setup *out) {
  add_row(out, flat);
}

/* Balls and boxes that go through each other and the ground. */
static void add_crossing(host_setup *out) {
  for (int i = 0; i < 8; i++) {
    double transform[16];
    mat_place(transform, (const double[3]){-2.0 + 0.6 * i, 0.3 + 0.2 * (i % 3), 0.5 * (i % 2)}, 0.4 * i,
              (const double[3]){1.0, 1.0, 1.0});
    if (i & 1)
      add_box(out, transform);
    else
      add_ball(out, transform);
  }
}

/* An upright wall from the ground, of one face; or of another one, too, which looks the other way. */
static void add_walls(host_setup *out, bool both) {
  static const double feet[][4] = {{-4, -1, -1, -2}, {0, 1, 1, -2}, {2, 0, 5, 1}, {-3, 2, -2.5, 3}};
  mesh_builder b = {0};
  for (size_t i = 0; i < sizeof feet / sizeof feet[0]; i++) {
    const double *f = feet[i];
    const double corners[4][3] = {{f[0], 0, f[1]}, {f[2], 0, f[3]}, {f[2], 2, f[3]}, {f[0], 2, f[1]}};
    const double turned[4][3] = {{f[0], 0, f[1]}, {f[0], 2, f[1]}, {f[2], 2, f[3]}, {f[2], 0, f[3]}};
    builder_quad(&b, corners);
    if (both)
      builder_quad(&b, turned);
  }
  hard_add(out, &b, "walls", NULL);
}

static void add_single_walls(host_setup *out) {
  add_walls(out, false);
}

static void add_double_walls(host_setup *out) {
  add_walls(out, true);
}

/* Each thing stands twice in one place, and so does the ground. */
static void add_twice(host_setup *out) {
  add_crossing(out);
  const size_t count = out->scene.instance_count;
  for (size_t i = 0; i < count; i++) {
    const scene_instance kept = out->scene.instances[i]; /* the array may move */
    scene_add_instance(&out->scene, kept.mesh, kept.transform);
  }
}

/* ---- leaves ---- */

enum { LEAF = 32 };

/* A ring, with alpha that falls off at its borders. */
static uint32_t add_leaf_material(scene *s, scene_wrap wrap) {
  scene_material material = {.name = "leaf", .color = {0.2f, 0.6f, 0.2f}, .alpha_tested = true, .two_sided = true};
  scene_alpha_mask *mask = &material.alpha_mask;
  *mask = (scene_alpha_mask){.width = LEAF, .height = LEAF, .wrap = {wrap, wrap}, .cutoff = 0.5};
  mask->alpha = host_allocate(LEAF * LEAF, 1);
  for (int i = 0; i < LEAF * LEAF; i++) {
    const double x = i % LEAF - 0.5 * (LEAF - 1), y = i / LEAF - 0.5 * (LEAF - 1), radius = hypot(x, y);
    mask->alpha[i] = (uint8_t)(255.0 * fmin(fmax(1.0 - fabs(radius - 10.0) / 7.0, 0.0), 1.0));
  }
  return scene_add_material(s, &material);
}

/* A leaning card of the material; uv goes from below 0 to above 1, so that the mask is wrapped. */
static void add_leaf(host_setup *out, uint32_t material, double x) {
  static const float uvs[8] = {-0.7f, 1.6f, 1.3f, 1.6f, 1.3f, -0.4f, -0.7f, -0.4f};
  const double corners[4][3] = {{x - 1.5, 0.5, 1.0}, {x + 1.5, 0.5, 0.0}, {x + 1.5, 3.5, -1.0}, {x - 1.5, 3.5, 0.0}};
  double transform[16];
  mesh_builder b = {0};
  builder_quad(&b, corners);
  const uint32_t mesh = builder_finish(&b, &out->scene, "leaf", 4, false);
  out->scene.meshes[mesh].material = material;
  out->scene.meshes[mesh].uvs = host_allocate(8, sizeof(float));
  memcpy(out->scene.meshes[mesh].uvs, uvs, sizeof uvs);
  mat_identity(transform);
  scene_add_instance(&out->scene, mesh, transform);
}

static void add_leaves(host_setup *out) {
  for (int wrap = SCENE_WRAP_REPEAT; wrap <= SCENE_WRAP_CLAMP; wrap++)
    add_leaf(out, add_leaf_material(&out->scene, (scene_wrap)wrap), 3.5 * (wrap - 1));
}

/* ---- the case ---- */

typedef struct shape {
  const char *name;
  void (*add)(host_setup *out);
} shape;

static const shape shapes[] = {
    {"mirrored", add_mirrored},
    {"sheared", add_sheared},
    {"stretched", add_stretched},
    {"thinned to a thousandth", add_thin},
    {"flattened", add_flat},
    {"meshes that cross", add_crossing},
    {"walls of one face", add_single_walls},
    {"walls of two faces", add_double_walls},
    {"all of it twice", add_twice},
    {"cut-out leaves", add_leaves},
};

static void make_scene(host_setup *out, const shape *of) {
  mesh_builder b = {0};
  hard_setup_begin(out, 256, 144);
  hard_ground(&b, (const double[3]){0.0, 0.0, 0.0}, 64.0, 2);
  hard_add(out, &b, "ground", NULL);
  of->add(out);
  hard_look(out, (const double[3]){0.0, 4.0, 9.0}, (const double[3]){0.0, 1.0, 0.0}, 50.0);
  hard_reach(out, 60.0);
}

/* As the truth has it, but for the pixels that an edge goes between, and two beside a thing's edge. */
static int draw_shape(hard_run *run, const shape *of) {
  static const double suns[][2] = {{35.0, 30.0}, {70.0, 200.0}, {12.0, 110.0}, {50.0, 290.0}};
  host_setup setup;
  hard_truth truth = {0};
  const exact_asked asked = {.what = of->name, .margin = {.silhouette_px = 2.0, .edge_px = 1.0}};
  make_scene(&setup, of);
  int code = hard_load(run, &setup);
  for (int i = 0; code == 0 && i < (run->sweep ? 4 : 2); i++) {
    const scene_light sun = hard_sun(suns[i][0], suns[i][1]);
    code = exact_judge(run, &sun, &asked, &truth);
  }
  hard_truth_free(&truth);
  hard_unload(run);
  setup_free(&setup);
  return code;
}

static int run_case(hard_run *run) {
  int code = 0;
  for (size_t i = 0; code == 0 && i < sizeof shapes / sizeof shapes[0]; i++)
    code = draw_shape(run, &shapes[i]);
  return code;
}

const hard_case hard_exact_shapes = {
    .name = "exact_shapes",
    .about = "exact: instances of any transform, meshes that cross, walls without thickness, duplicates, leaves",
    .run = run_case};
