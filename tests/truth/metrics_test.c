/* metrics_test.c: the metrics on masks whose figures are known. */
#include "base/json_source.h"
#include "metrics/flicker.h"
#include "support.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#define WIDTH 200
#define HEIGHT 80
#define PIXELS (WIDTH * HEIGHT)

/* A wall across the picture at one view depth, facing the light. */
typedef struct picture {
  camera camera;
  truth_surface surfaces[PIXELS];
  truth_view view;
  scene_light light;
  float visibility[PIXELS], mask[PIXELS], depth[PIXELS];
  uint8_t kinds[PIXELS];
  metrics_frame frame;
} picture;

/* Lit right of column `true_edge` in truth, and of `drawn_edge` as drawn. */
static picture *make_picture(double view_depth, uint32_t true_edge, uint32_t drawn_edge) {
  picture *p = calloc(1, sizeof *p);
  p->camera = look((const double[3]){0, 0, 0}, (const double[3]){0, 0, -1}, 60.0, (double)WIDTH / HEIGHT);
  p->view = (truth_view){.camera = &p->camera, .width = WIDTH, .height = HEIGHT, .surfaces = p->surfaces};
  p->light = (scene_light){.direction = {0, 0, -1}};
  for (uint32_t i = 0; i < PIXELS; i++) {
    p->surfaces[i] = (truth_surface){.view_depth = view_depth, .normal = {0, 0, 1}};
    p->visibility[i] = i % WIDTH >= true_edge;
    p->mask[i] = i % WIDTH >= drawn_edge;
    p->depth[i] = (float)view_depth;
  }
  p->frame = (metrics_frame){.view = &p->view,
                             .light = &p->light,
                             .shadow_distance = 100.0,
                             .visibility = p->visibility,
                             .mask = p->mask,
                             .view_depth = p->depth};
  return p;
}

static metrics measure(picture *p) {
  metrics m;
  assert_int_equal(metrics_measure(&m, &p->frame, p->kinds), 0);
  return m;
}

static void assert_near(double value, double expected, double tolerance) {
  if (!(fabs(value - expected) <= tolerance))
    fail_msg("%.9g is not %.9g", value, expected);
}

/* ---- parts ---- */

static void distances_are_exact(void **state) {
  (void)state;
  enum { W = 61, H = 47 };
  uint8_t marked[W * H];
  int64_t squares[W * H];
  uint32_t seed = 3;
  for (int round = 0; round < 20; round++) {
    for (int i = 0; i < W * H; i++)
      marked[i] = random_unit(&seed) < (round % 5 == 0 ? 0.0006 : 0.05);
    metrics_distances(marked, W, H, squares);
    for (int y = 0; y < H; y++)
      for (int x = 0; x < W; x++) {
        int64_t nearest = INT64_MAX;
        for (int j = 0; j < H; j++)
          for (int i = 0; i < W; i++)
            if (marked[j * W + i]) {
              const int64_t square = (int64_t)(x - i) * (x - i) + (int64_t)(y - j) * (y - j);
              nearest = square < nearest ? square : nearest;
            }
        assert_true(squares[y * W + x] == nearest);
      }
  }
}

static void least_spheres_are_least(void **state) {
  (void)state;
  double one[1][3] = {{3, 4, 5}}, two[2][3] = {{0, 0, 0}, {0, 6, 0}};
  double flat[3][3] = {{0, 0, 0}, {10, 0, 0}, {5, 1, 0}}; /* obtuse: the long side's middle */
  double cube[8][3], frustum[8][3];
  for (int i = 0; i < 8; i++)
    for (int axis = 0; axis < 3; axis++) {
      cube[i][axis] = 7.0 + (i >> axis & 1 ? 2.0 : -2.0);
      frustum[i][axis] = axis == 2 ? (i & 4 ? 10.0 : 1.0) : (i >> axis & 1 ? 1.0 : -1.0) * (i & 4 ? 10.0 : 1.0);
    }
  assert_near(metrics_sphere_radius(one, 1), 0.0, 1e-12);
  assert_near(metrics_sphere_radius(two, 2), 3.0, 1e-12);
  assert_near(metrics_sphere_radius(flat, 3), 5.0, 1e-12);
  assert_near(metrics_sphere_radius(cube, 8), sqrt(12.0), 1e-9);
  /* wide: the far face's circle is enough */
  assert_near(metrics_sphere_radius(frustum, 8), 10.0 * sqrt(2.0), 1e-9);
  for (int i = 0; i < 8; i++)
    for (int axis = 0; axis < 2; axis++)
      frustum[i][axis] *= 0.1;
  /* narrow: the middle lies on the axis, as far from both faces' corners */
  const double near = 0.1 * sqrt(2.0), far = sqrt(2.0), center = (100.0 + far * far - 1.0 - near * near) / 18.0;
  assert_near(metrics_sphere_radius(frustum, 8), sqrt(far * far + (10.0 - center) * (10.0 - center)), 1e-9);
}

/* The slices' ends and texels of a symmetric camera, worked out by hand. */
static void reference_texels_are_as_defined(void **state) {
  (void)state;
  const camera from = look((const double[3]){5e6, 2, 9}, (const double[3]){5e6, 1, -3}, 60.0, (double)WIDTH / HEIGHT);
  metrics_reference reference;
  metrics_reference_make(&reference, &from, WIDTH, HEIGHT, 100.0);
  double near = 0.1;
  const double up = tan(30.0 * 3.14159265358979323846 / 180.0), slope = up * sqrt(1.0 + 2.5 * 2.5);
  for (int slice = 0; slice < 4; slice++) {
    const double share = (slice + 1) / 4.0;
    const double far = 0.75 * 0.1 * pow(1000.0, share) + 0.25 * (0.1 + 99.9 * share);
    const double center = fmin(far, 0.5 * (near + far) * (1.0 + slope * slope));
    const double radius = sqrt(slope * slope * far * far + (far - center) * (far - center));
    assert_near(reference.far_depth[slice], far, 1e-9 * far);
    assert_near(reference.texel[slice], 2.0 * radius / 2048.0, 1e-9 * radius);
    const double depth = 0.5 * (near + far);
    assert_near(metrics_reference_texel_px(&reference, depth), 2.0 * radius / 2048.0 * (HEIGHT / 2.0) / up / depth,
                1e-9);
    near = far;
  }
}

/* ---- shares ---- */

static void moved_edge_is_measured(void **state) {
  (void)state;
  picture *p = make_picture(50.0, 100, 103);
  const metrics m = measure(p);
  assert_int_equal(m.pixels, PIXELS);
  assert_near(m.lit, 0.5, 1e-12);
  assert_near(m.false_shadow, 3.0 / WIDTH, 1e-12);
  assert_near(m.false_lit, 0.0, 0.0);
  assert_near(m.rmse, sqrt(3.0 / WIDTH), 1e-12);
  assert_near(m.mean, -3.0 / WIDTH, 1e-12);
  assert_near(m.mean_absolute, 3.0 / WIDTH, 1e-12);
  assert_near(m.edge_px, 3.0, 1e-12);
  assert_int_equal(m.edge_true_px, HEIGHT);
  assert_int_equal(m.edge_drawn_px, HEIGHT);
  assert_int_equal(m.edge_true_alone_px + m.edge_drawn_alone_px, 0);
  free(p);
  p = make_picture(50.0, 103, 100);
  const metrics other = measure(p);
  assert_near(other.false_lit, 3.0 / WIDTH, 1e-12);
  assert_near(other.false_shadow, 0.0, 0.0);
  assert_near(other.mean, 3.0 / WIDTH, 1e-12);
  free(p);
}

/* Pixels lie 0.5, 1.5, 2.5 ... px from the edge; beyond 2 px and 1.5 texels they are acne or leak. */
static void far_errors_are_acne_and_leak(void **state) {
  (void)state;
  const double depths[] = {1.0, 5.0, 20.0, 99.0};
  bool texels_decided = false;
  for (int i = 0; i < 4; i++) {
    picture *p = make_picture(depths[i], 100, 109);
    metrics_reference reference;
    p->frame.shadow_distance = 2000.0;
    metrics_reference_make(&reference, &p->camera, WIDTH, HEIGHT, 2000.0);
    const double reach = fmax(2.0, 1.5 * metrics_reference_texel_px(&reference, depths[i]));
    uint32_t beyond = 0;
    for (int k = 0; k < 9; k++)
      beyond += k + 0.5 > reach;
    const metrics m = measure(p);
    assert_near(m.acne, beyond / (double)WIDTH, 1e-12);
    assert_near(m.leak, 0.0, 0.0);
    texels_decided = texels_decided || reach > 2.5;
    uint32_t kinds = 0;
    for (uint32_t k = 0; k < PIXELS; k++)
      kinds += p->kinds[k] == METRICS_ACNE;
    assert_int_equal(kinds, beyond * HEIGHT);
    free(p);
    p = make_picture(depths[i], 109, 100);
    p->frame.shadow_distance = 2000.0;
    assert_near(measure(p).leak, beyond / (double)WIDTH, 1e-12);
    free(p);
  }
  assert_true(texels_decided);
}

/* The drawn edge is missing, or a second one is added far away. */
static void edges_without_partner_are_told_apart(void **state) {
  (void)state;
  picture *p = make_picture(50.0, 100, 0);
  metrics m = measure(p);
  assert_near(m.edge_px, 16.0, 0.0);
  assert_int_equal(m.edge_true_alone_px, HEIGHT);
  assert_near(m.leak, (100 - 2) / (double)WIDTH, 1e-12);
  free(p);
  p = make_picture(50.0, 100, 100);
  for (uint32_t i = 0; i < PIXELS; i++)
    if (i % WIDTH >= 160)
      p->mask[i] = 0.0f;
  m = measure(p);
  /* drawn edges: one in place, one 60 px off, which counts 16 */
  assert_near(m.edge_px, 0.5 * (0.0 + 8.0), 1e-12);
  assert_int_equal(m.edge_drawn_px, 2 * HEIGHT);
  assert_int_equal(m.edge_drawn_alone_px, HEIGHT);
  assert_near(m.acne, 40.0 / WIDTH, 1e-12);
  free(p);
  p = make_picture(50.0, 0, 0);
  m = measure(p);
  assert_true(m.edge_px < 0.0);
  json_t *object = metrics_to_json(&m);
  assert_true(json_is_null(json_object_get(object, "edge")));
  assert_true(json_real_value(json_object_get(object, "lit")) == 1.0);
  json_decref(object);
  free(p);
}

static void soft_visibility_is_compared(void **state) {
  (void)state;
  picture *p = make_picture(50.0, 0, 0);
  for (uint32_t i = 0; i < PIXELS; i++) {
    p->visibility[i] = 0.5f; /* counts as lit */
    p->mask[i] = i % 2 ? 0.7f : 0.4f;
  }
  const metrics m = measure(p);
  assert_near(m.lit, 1.0, 0.0);
  assert_near(m.false_shadow, 0.5, 0.0);
  assert_near(m.rmse, sqrt(0.5 * (0.04 + 0.01)), 1e-7);
  assert_near(m.mean, 0.05, 1e-7);
  assert_near(m.mean_absolute, 0.15, 1e-7);
  free(p);
}

/* ---- the set S ---- */

static void only_measurable_pixels_count(void **state) {
  (void)state;
  picture *p = make_picture(50.0, 0, WIDTH); /* all shadowed, though lit */
  for (uint32_t i = 0; i < PIXELS; i++) {
    truth_surface *surface = &p->surfaces[i];
    const float facing = i % WIDTH < 10 ? -0.5f : i % WIDTH < 30 ? 0.01f : 0.03f;
    surface->normal[0] = sqrtf(1.0f - facing * facing);
    surface->normal[2] = facing;
    if (i % WIDTH >= 190)
      *surface = (truth_surface){.view_depth = -1.0, .triangle = TRUTH_NOTHING};
    else if (i % WIDTH >= 180)
      surface->view_depth = 100.5;
    else if (i % WIDTH == 179)
      p->depth[i] = (float)(50.0 * 1.0012);
    else if (i % WIDTH >= 160)
      p->depth[i] = (float)(50.0 * 0.9992);
  }
  const metrics m = measure(p);
  assert_int_equal(m.pixels, (179 - 30) * HEIGHT);
  assert_int_equal(m.grazing_pixels, 20 * HEIGHT);
  assert_int_equal(m.depth_pixels, HEIGHT);
  assert_near(m.false_shadow, 1.0, 0.0);
  assert_near(m.grazing_false_shadow, 1.0, 0.0);
  assert_near(m.grazing_false_lit, 0.0, 0.0);
  for (uint32_t i = 0; i < PIXELS; i++)
    p->surfaces[i].normal[2] = -0.5f;
  metrics none;
  assert_int_equal(metrics_measure(&none, &p->frame, p->kinds), 2);
  free(p);
}

/* Up to a hundredth may be drawn elsewhere; with one pixel more there are no figures, for what is wrong is not in them. */
static void a_depth_that_is_not_the_true_one_is_told(void **state) {
  (void)state;
  static const float wrongs[] = {INFINITY, NAN, 0.0f, -50.0f, 50.0f * 0.9985f};
  for (size_t i = 0; i < sizeof wrongs / sizeof wrongs[0]; i++) {
    picture *p = make_picture(50.0, WIDTH / 2, WIDTH / 2);
    for (int pixel = 0; pixel < PIXELS / 100; pixel++)
      p->depth[pixel * 50] = wrongs[i];
    assert_int_equal(measure(p).depth_pixels, PIXELS / 100);
    p->depth[1] = wrongs[i];
    metrics m;
    assert_int_equal(metrics_measure(&m, &p->frame, p->kinds), 1);
    /* What the light does not reach was not asked for */
    for (int pixel = 0; pixel < PIXELS; pixel++)
      p->surfaces[pixel].normal[2] = p->depth[pixel] == 50.0f ? 1.0f : -1.0f;
    assert_int_equal(measure(p).depth_pixels, 0);
    free(p);
  }
}

static void frames_are_pooled_by_pixels(void **state) {
  (void)state;
  const metrics frames[2] = {
      {.pixels = 100, .false_lit = 0.1, .rmse = 0.3, .edge_px = 2.0, .edge_true_px = 30, .grazing_pixels = 0},
      {.pixels = 300, .false_lit = 0.02, .rmse = 0.1, .edge_px = -1.0, .grazing_pixels = 7, .grazing_false_lit = 0.5}};
  metrics pooled;
  metrics_pool(&pooled, frames, 2);
  assert_int_equal(pooled.pixels, 400);
  assert_near(pooled.false_lit, 0.04, 1e-12);
  assert_near(pooled.rmse, sqrt((9.0 + 3.0) / 400.0), 1e-12);
  assert_near(pooled.edge_px, 2.0, 1e-12);
  assert_near(pooled.grazing_false_lit, 0.5, 1e-12);
}

/* ---- flicker ---- */

static void flicker_counts_what_should_stay(void **state) {
  (void)state;
  picture *p = make_picture(50.0, 0, 0);
  metrics ignored = measure(p);
  (void)ignored;
  camera second = look((const double[3]){0, 0, 10}, (const double[3]){0, 0, -1}, 60.0, (double)WIDTH / HEIGHT);
  float later[PIXELS], later_truth[PIXELS], cascades[2][PIXELS];
  uint8_t seen[PIXELS];
  for (uint32_t i = 0; i < PIXELS; i++) {
    const uint32_t column = i % WIDTH;
    seen[i] = column >= 20;
    later[i] = p->mask[i] - (column < 60 ? 3.0f / 255.0f : column < 100 ? 1.0f / 255.0f : 0.0f);
    later_truth[i] = column >= 50 && column < 60 ? 0.0f : 1.0f;
    cascades[0][i] = 1.0f / 255.0f;
    cascades[1][i] = column < 150 ? 1.0f / 255.0f : 2.0f / 255.0f;
  }
  const flicker_pair pair = {.view = &p->view,
                             .kinds = p->kinds,
                             .seen = seen,
                             .second = &second,
                             .second_light = &p->light,
                             .shadow_distance = 100.0,
                             .cascades = {cascades[0], cascades[1]},
                             .visibility = {p->visibility, later_truth},
                             .masks = {p->mask, later}};
  flicker f = {0};
  flicker_add(&f, &pair);
  assert_int_equal(f.points, (150 - 20) * HEIGHT);
  assert_int_equal(f.changed, (50 - 20) * HEIGHT);
  assert_int_equal(f.crossing, 50 * HEIGHT);
  assert_int_equal(f.crossing_changed, 0);
  free(p);
}

/* ---- lines of a path ---- */

static void elements_know_their_lines(void **state) {
  (void)state;
  char path[] = "/tmp/csm-list-XXXXXX";
  const int descriptor = mkstemp(path);
  FILE *file = fdopen(descriptor, "w");
  fputs("[\n  \"a, [\\\" \",\n{\"b\": [1,\n2]}\n,\n\n7 ]\n", file);
  fclose(file);
  json_list list;
  assert_int_equal(json_list_load(&list, "a list", path), 0);
  assert_int_equal(list.count, 3);
  assert_int_equal(list.elements[0].line, 2);
  assert_int_equal(list.elements[1].line, 3);
  assert_int_equal(list.elements[2].line, 7);
  json_list_free(&list);
  remove(path);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(distances_are_exact),
      cmocka_unit_test(least_spheres_are_least),
      cmocka_unit_test(reference_texels_are_as_defined),
      cmocka_unit_test(moved_edge_is_measured),
      cmocka_unit_test(far_errors_are_acne_and_leak),
      cmocka_unit_test(edges_without_partner_are_told_apart),
      cmocka_unit_test(soft_visibility_is_compared),
      cmocka_unit_test(only_measurable_pixels_count),
      cmocka_unit_test(a_depth_that_is_not_the_true_one_is_told),
      cmocka_unit_test(frames_are_pooled_by_pixels),
      cmocka_unit_test(flicker_counts_what_should_stay),
      cmocka_unit_test(elements_know_their_lines),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
