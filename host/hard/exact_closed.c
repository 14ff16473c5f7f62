/*
 * exact_closed.c: no light comes through a closed mesh: boxes, balls, needles and tiny triangles around the camera, from
 * a millimetre to 10^5 m and far from the origin, under light from everywhere; through the edges and vertices of a roof;
 * and through a small hole in a huge one, no more than there is.
 */
#include "hard/exact.h"
#include "hard/overhead.h"
#include <math.h>
#include <string.h>

/* ---- shells ---- */

static void build_box(mesh_builder *b, double half) {
  builder_box(b, (const double[3]){-half, -half, -half}, (const double[3]){half, half, half});
}

static void build_ball(mesh_builder *b, double half) {
  builder_ball(b, (const double[3]){0.0, 0.0, 0.0}, (const double[3]){half, half, half}, 4, 0.0, 1);
}

/* Two cones on one ring: all triangles of a cone meet at its tip. */
static void build_needles(mesh_builder *b, double half) {
  enum { SIDES = 512 };
  const uint32_t top = builder_vertex(b, 0.0, 1.5 * half, 0.0), bottom = builder_vertex(b, 0.0, -1.5 * half, 0.0);
  for (uint32_t i = 0; i < SIDES; i++) {
    const double angle = 2.0 * 3.14159265358979323846 * i / SIDES;
    builder_vertex(b, 1.5 * half * cos(angle), 0.0, 1.5 * half * sin(angle));
  }
  for (uint32_t i = 0; i < SIDES; i++) {
    const uint32_t at = bottom + 1 + i, next = bottom + 1 + (i + 1) % SIDES;
    builder_triangle(b, top, next, at);
    builder_triangle(b, bottom, at, next);
  }
}

/* A box whose lid is a tenth of a millimetre of four triangles, in a frame of eight as long as the lid. */
static void build_frame(mesh_builder *b, double half) {
  const double tiny = fmin(5e-5, 1e-3 * half), y = half;
  const double corners[8][3] = {{-half, -half, -half}, {half, -half, -half}, {half, -half, half}, {-half, -half, half},
                                {-half, y, -half},     {half, y, -half},     {half, y, half},     {-half, y, half}};
  uint32_t at[8], inner[4];
  for (int i = 0; i < 8; i++)
    at[i] = builder_vertex(b, corners[i][0], corners[i][1], corners[i][2]);
  for (int i = 0; i < 4; i++)
    inner[i] = builder_vertex(b, i == 1 || i == 2 ? tiny : -tiny, y, i > 1 ? tiny : -tiny);
  const uint32_t middle = builder_vertex(b, 0.0, y, 0.0);
  for (int i = 0; i < 4; i++) {
    const int next = (i + 1) % 4;
    builder_triangle(b, at[4 + i], inner[i], inner[next]);
    builder_triangle(b, at[4 + i], inner[next], at[4 + next]);
    builder_triangle(b, inner[i], middle, inner[next]);
    builder_triangle(b, at[i], at[4 + i], at[4 + next]);
    builder_triangle(b, at[i], at[4 + next], at[next]);
  }
  builder_triangle(b, at[0], at[1], at[2]);
  builder_triangle(b, at[0], at[2], at[3]);
}

typedef struct shell {
  const char *name;
  void (*build)(mesh_builder *b, double half);
} shell;

static const shell shells[] = {{"a box", build_box},
                               {"a ball", build_ball},
                               {"needles", build_needles},
                               {"a frame of long triangles", build_frame}};
enum { SHELLS = sizeof shells / sizeof shells[0] };

/* Within the shell stands a floor with a ball on it, and the camera. */
static void make_shell(host_setup *out, const shell *of, double half, const double at[3], uint32_t width) {
  mesh_builder b = {0};
  const double floor = -0.45 * half, wide = 0.6 * half;
  hard_setup_begin(out, width, width * 9 / 16);
  of->build(&b, half);
  hard_add(out, &b, "shell", at);
  builder_quad(
      &b, (const double[4][3]){{-wide, floor, -wide}, {-wide, floor, wide}, {wide, floor, wide}, {wide, floor, -wide}});
  hard_add(out, &b, "floor", at);
  builder_ball(&b, (const double[3]){0.0, -0.2 * half, 0.0}, (const double[3]){0.25 * half, 0.25 * half, 0.25 * half},
               3, 0.0, 1);
  hard_add(out, &b, "ball", at);
  hard_look(out, (const double[3]){at[0] - 0.3 * half, at[1] + 0.2 * half, at[2] + 0.5 * half},
            (const double[3]){at[0], at[1] - 0.1 * half, at[2]}, 90.0);
  out->scene.camera.near_depth = 1e-3 * half;
  camera_from_pose(&out->camera, &out->scene.camera, 16.0 / 9.0);
  hard_reach(out, 8.0 * half);
  out->config.resolution = 256;
}

/* Along axes and diagonals, in which faces are seen edge-on and edges end-on, and from everywhere. */
static void light_way(scene_light *out, uint32_t i) {
  static const double ways[][3] = {{0, -1, 0}, {1, 0, 0},    {1, -1, 0}, {-1, -1, -1},
                                   {0, 0, -1}, {0, 1, -0.5}, {0, -1, 1}, {1, 1, -1}};
  const uint32_t fixed = sizeof ways / sizeof ways[0];
  const double up = i < fixed ? 0.0 : 1.0 - 2.0 * ((i - fixed + 0.5) / 24.0), angle = 2.39996323 * i;
  const double across = sqrt(1.0 - up * up), around[3] = {across * cos(angle), up, across * sin(angle)};
  *out = (scene_light){0};
  memcpy(out->direction, i < fixed ? ways[i] : around, sizeof around);
}

static uint64_t count_turned(const hard_truth *truth, double cosine) {
  uint64_t count = 0;
  for (size_t i = 0; i < (size_t)truth->view.width * truth->view.height; i++)
    count += truth_facing(&truth->view.surfaces[i], &truth->light) > cosine;
  return count;
}

/*
 * All that is seen is dark. Next to an edge, on two triangles at once, a ray goes past the second one: within 3e-6 of the
 * view depth of it. It comes to that one where it rises from the first one by less than the second does: in a ball of 5120
 * triangles, and from needle to needle, by less than 0.1. There grazing rays slip through, and so they do where a map's
 * texels lie about the rim of what they see of the shell: these are stated.
 */
static int draw_shell(hard_run *run, const shell *of, double half, const double at[3]) {
  host_setup setup;
  hard_truth truth = {0};
  char what[64];
  uint64_t turned = 0;
  make_shell(&setup, of, half, at, run->sweep ? 160 : 96);
  snprintf(what, sizeof what, "in %s of %.0e m%s", of->name, half, at[0] != 0.0 ? ", far away" : "");
  const exact_asked asked = {.what = what, .margin = {.cosine = 0.1}, .closed = true};
  int code = hard_load(run, &setup);
  for (uint32_t i = 0; code == 0 && i < (run->sweep ? 32 : 8); i++) {
    scene_light light;
    light_way(&light, run->sweep ? i : i + i / 6 * 4);
    code = exact_judge(run, &light, &asked, &truth);
    turned += code ? 0 : count_turned(&truth, asked.margin.cosine);
  }
  hard_figure_add(run, turned > 5000 ? 0.0 : 1.0, 0.0, "1", "shells of which next to nothing could be judged");
  hard_truth_free(&truth);
  hard_unload(run);
  setup_free(&setup);
  return code;
}

static int draw_shells(hard_run *run) {
  static const double here[3] = {0.0, 0.0, 0.0}, away[3] = {1e7, -3e6, 5e6};
  static const double halves[] = {1e-3, 1.0, 1e5, 1e-2, 1e3, 1e4};
  int code = 0;
  for (int i = 0; code == 0 && i < SHELLS; i++) {
    for (int k = 0; code == 0 && k < (run->sweep ? 6 : 3); k++)
      code = draw_shell(run, &shells[i], halves[k], here);
    if (code == 0)
      code = draw_shell(run, &shells[i], 10.0, away);
  }
  return code;
}

/* ---- edges and vertices ---- */

/* A square of ground from above, under a roof whose vertices stand over the pixels' middles, or between two of them. */
static void make_roof(host_setup *out, double shift, bool halves, uint32_t side) {
  const uint32_t all = 2 * side;
  mesh_builder b = {0};
  overhead_begin(out, &(overhead){.side = side, .eye = 4.0, .floor = -1.0, .pixels = side});
  hard_ground(&b, (const double[3]){0.0, 0.0, 0.0}, side, 1);
  hard_add(out, &b, "ground", NULL);
  for (int half = 0; half < 1 + halves; half++) {
    /* Two roofs meet along x = shift */
    const double begin = halves && half ? shift : shift - all / 2.0, cells = all / (1.0 + halves);
    const uint32_t across = (uint32_t)cells, first = (uint32_t)b.vertex_count;
    for (uint32_t j = 0; j <= all; j++)
      for (uint32_t i = 0; i <= across; i++)
        builder_vertex(&b, begin + i, 8.0, shift - all / 2.0 + j);
    for (uint32_t j = 0; j < all; j++)
      for (uint32_t i = 0; i < across; i++) {
        const uint32_t at = first + j * (across + 1) + i;
        builder_triangle(&b, at, at + across + 1, at + across + 2);
        builder_triangle(&b, at, at + across + 2, at + 1);
      }
    hard_add(out, &b, "roof", NULL);
  }
  out->config.resolution = 256;
}

static int draw_roofs(hard_run *run) {
  static const double ways[][3] = {{0, -1, 0}, {0.25, -1, 0.5}, {1, -1, 0}, {0.3, -1, 0.7}};
  int code = 0;
  for (uint32_t i = 0; code == 0 && i < 16; i++) {
    host_setup setup;
    make_roof(&setup, i & 1 ? 0.5 : 0.0, i & 2, run->sweep ? 64 : 32);
    for (int k = 0; k < 3; k++)
      setup.light.direction[k] = ways[i / 4][k];
    code = exact_judge_setup(
        run, &setup, &(exact_asked){.what = i & 2 ? "under two roofs that meet" : "under a roof of many triangles"});
    setup_free(&setup);
  }
  return code;
}

/* ---- a hole ---- */

/* A roof at a height over the ground, from its middle on to each side, with a hole of a metre. */
static void make_hole(host_setup *out, double half, double height) {
  mesh_builder b = {0};
  hard_setup_begin(out, 160, 90);
  hard_ground(&b, (const double[3]){0.0, 0.0, 0.0}, 64.0, 2);
  hard_add(out, &b, "ground", NULL);
  const double sides[2] = {half, 0.5};
  uint32_t at[8];
  for (int i = 0; i < 8; i++) {
    const double side = sides[i / 4];
    at[i] = builder_vertex(&b, (i & 3) == 1 || (i & 3) == 2 ? side : -side, 0.0, (i & 3) > 1 ? side : -side);
  }
  for (int i = 0; i < 4; i++) {
    const int next = (i + 1) % 4;
    builder_triangle(&b, at[i], at[4 + i], at[4 + next]);
    builder_triangle(&b, at[i], at[4 + next], at[next]);
  }
  hard_add(out, &b, "roof", (const double[3]){0.0, height, 0.0});
  hard_look(out, (const double[3]){0.0, 1.5, 4.0}, (const double[3]){0.0, 0.0, 0.0}, 60.0);
  hard_reach(out, 60.0);
}

/*
 * The hole's light is where it belongs, but for the pixels that its edge goes between. A mesh of 10^6 m is no finer than
 * 3e-7 of that, so that its roof hangs higher.
 */
static int draw_holes(hard_run *run) {
  static const double halves[] = {1e6, 1e3, 1e5, 1e4};
  int code = 0;
  for (int i = 0; code == 0 && i < (run->sweep ? 4 : 2); i++)
    for (int k = 0; code == 0 && k < 2; k++) {
      host_setup setup;
      char what[64];
      make_hole(&setup, halves[i], k ? 3.0 : 2.0);
      setup.light = hard_sun(k ? 60.0 : 85.0, 40.0);
      snprintf(what, sizeof what, "a hole of 1 m in a roof of %.0e m", halves[i]);
      code = exact_judge_setup(run, &setup, &(exact_asked){.what = what, .margin = {.edge_px = 1.0}});
      setup_free(&setup);
    }
  return code;
}

static int run_case(hard_run *run) {
  int code = draw_shells(run);
  if (code == 0)
    code = draw_roofs(run);
  return code ? code : draw_holes(run);
}

const hard_case hard_exact_closed = {
    .name = "exact_closed",
    .about = "exact: closed meshes from 1 mm to 10^5 m around the camera, edges, vertices, holes",
    .run = run_case};
