/* test_picture.c: lines by known pixels, what the colours of the views say, and when views agree. */
#include "picture/lines.h"
#include "picture/picture.h"
#include "stage/compare.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

static const float white[3] = {1.0f, 1.0f, 1.0f};

/* The picture of one line as text: a row of '#', '+' (dim) and '.' after the other. */
static void expect_line(const line_style *style, const double from[3], const double to[3], const char *expected) {
  image picture;
  char text[5 * 8 + 1] = {0};
  image_create(&picture, 8, 5);
  picture_line(&picture, style, from, to);
  for (int i = 0; i < 5 * 8; i++) {
    const uint8_t value = picture.pixels[3 * i];
    assert_true(value == picture.pixels[3 * i + 1] && value == picture.pixels[3 * i + 2]);
    text[i] = value == 255 ? '#' : value > 0 ? '+' : '.';
  }
  assert_string_equal(text, expected);
  image_free(&picture);
}

static void lines_are_where_they_should_be(void **state) {
  (void)state;
  const line_style thin = {.color = white, .width = 1}, bold = {.color = white, .width = 3};
  expect_line(&thin, (double[3]){1, 2}, (double[3]){5, 2},
              "................"
              ".#####.."
              "................");
  expect_line(&thin, (double[3]){4, 3}, (double[3]){1, 0},
              ".#......"
              "..#....."
              "...#...."
              "....#..."
              "........");
  expect_line(&thin, (double[3]){2, -1e9}, (double[3]){2, 1e9},
              "..#....."
              "..#....."
              "..#....."
              "..#....."
              "..#.....");
  expect_line(&thin, (double[3]){0, 1}, (double[3]){7, 3},
              "........"
              "##......"
              "..####.."
              "......##"
              "........");
  expect_line(&bold, (double[3]){-3, 0}, (double[3]){3, 0},
              "####...."
              "####...."
              "........"
              "................");
  expect_line(&thin, (double[3]){3, 3}, (double[3]){3, 3},
              "................"
              "........"
              "...#...."
              "........");
  expect_line(&thin, (double[3]){-5, 9}, (double[3]){20, 9}, "........................................");
  expect_line(&thin, (double[3]){9, -9}, (double[3]){9, 9}, "........................................");
}

/* A line goes away from the viewer, behind a surface that ends at the fifth column. */
static void surfaces_hide_lines(void **state) {
  (void)state;
  float nearest[5 * 8];
  for (int i = 0; i < 5 * 8; i++)
    nearest[i] = i % 8 < 5 ? 2.5f : INFINITY;
  line_style style = {.color = white, .width = 1, .nearest = nearest, .hidden = 0.4f};
  expect_line(&style, (double[3]){0, 0, 0}, (double[3]){7, 0, 7},
              "###++###"
              "................................");
  style.hidden = 0.0f;
  expect_line(&style, (double[3]){0, 0, 0}, (double[3]){7, 0, 7},
              "###..###"
              "................................");
}

/* ---- colours ---- */

enum { shades = 6 };

typedef struct sample {
  scene scene;
  scene_light light;
  camera camera;
  trace_surface surfaces[shades];
  picture_view view;
} sample;

static void make_sample(sample *s) {
  *s = (sample){.scene.haze_distance = INFINITY, .light.direction = {0, -1, 0}};
  for (int i = 0; i < shades; i++)
    s->surfaces[i] = (trace_surface){
        .view_depth = 5.0, .distance = 5.0, .normal = {0, 1, 0}, .color = {0.5f, 0.5f, 0.5f}, .ray = {0, 0, -1}};
  s->view = (picture_view){.scene = &s->scene,
                           .light = &s->light,
                           .camera = &s->camera,
                           .width = shades,
                           .height = 1,
                           .surfaces = s->surfaces};
}

static void density_is_blue_white_and_red(void **state) {
  (void)state;
  sample s;
  make_sample(&s);
  const float values[shades] = {1, 104, 128, 152, 255, 0};
  float density[shades];
  for (int i = 0; i < shades; i++)
    density[i] = values[i] / 255.0f;
  image picture;
  picture_shown(&picture, &s.view, NULL, CSM_SHOW_DENSITY, density);
  const uint8_t(*p)[3] = (const uint8_t(*)[3])picture.pixels;
  assert_true(p[0][2] > p[0][0] + 60 && p[0][2] > p[0][1] + 60);
  assert_true(p[1][2] > p[1][0] + 20 && p[1][0] > p[0][0]); /* between */
  assert_true(p[2][0] > 180 && p[2][0] == p[2][1] && p[2][1] == p[2][2]);
  assert_true(p[3][0] > p[3][2] + 20 && p[3][2] > p[4][2]);
  assert_true(p[4][0] > p[4][1] + 60 && p[4][0] > p[4][2] + 60);
  assert_true(p[5][0] < 70 && p[5][1] < 70 && p[5][2] < 70);
  image_free(&picture);
}

/* White at eight texels; what has none is grey, and darker than what has. */
static void penumbrae_are_blue_white_and_red(void **state) {
  (void)state;
  sample s;
  make_sample(&s);
  const float values[shades] = {1, 128, 176, 224, 255, 0};
  float penumbra[shades];
  for (int i = 0; i < shades; i++)
    penumbra[i] = values[i] / 255.0f;
  image picture;
  picture_shown(&picture, &s.view, NULL, CSM_SHOW_PENUMBRA, penumbra);
  const uint8_t(*p)[3] = (const uint8_t(*)[3])picture.pixels;
  assert_memory_equal(p[0], p[1], 3); /* a texel, and less */
  assert_true(p[1][2] > p[1][0] + 60 && p[1][2] > p[1][1] + 60);
  assert_true(p[2][0] > 180 && p[2][0] == p[2][1] && p[2][1] == p[2][2]);
  assert_memory_equal(p[3], p[4], 3); /* 64 texels, and more */
  assert_true(p[4][0] > p[4][1] + 60 && p[4][0] > p[4][2] + 60);
  assert_true(p[5][0] == p[5][1] && p[5][1] == p[5][2] && p[5][0] + 20 < p[2][0]);
  image_free(&picture);
}

static void cascades_have_colors_and_beyond_is_grey(void **state) {
  (void)state;
  sample s;
  make_sample(&s);
  const float mask[shades] = {1, 1, 1, 1, 1, 1};
  float cascades[shades];
  for (int i = 0; i < shades; i++)
    cascades[i] = (float)i / 255.0f;
  image picture;
  picture_shown(&picture, &s.view, mask, CSM_SHOW_CASCADE, cascades);
  const uint8_t(*p)[3] = (const uint8_t(*)[3])picture.pixels;
  assert_true(p[0][0] == p[0][1] && p[0][1] == p[0][2]);
  assert_true(p[1][0] > p[1][1] + 60); /* red, green, blue */
  assert_true(p[2][1] > p[2][0] + 60);
  assert_true(p[3][2] > p[3][0] + 60);
  for (int a = 0; a < shades; a++)
    for (int b = 0; b < a; b++)
      assert_memory_not_equal(p[a], p[b], 3);
  image_free(&picture);
}

/* ---- agreement ---- */

/* On one device not one pixel may differ; on two a few may. Who casts must be the same. */
static void views_agree_to_the_bit(void **state) {
  (void)state;
  static float zeros[200 * 100], views[2][STAGE_VIEWS][200 * 100];
  uint8_t casters[2][2] = {{1, 3}, {1, 3}};
  host_setup setup = {.width = 200, .height = 100, .scene.instance_count = 2};
  stage stages[2] = {{.setup = &setup}, {.setup = &setup}};
  stage_frame frames[2] = {{.mask = zeros, .camera_depth = zeros}, {.mask = zeros, .camera_depth = zeros}};
  agreement result;
  compare_frames(&result, &stages[0], &frames[0], &stages[1], &frames[1]);
  assert_true(result.agrees && !result.has_views);
  for (int i = 0; i < 2; i++) {
    frames[i].casters = casters[i];
    for (int v = 0; v < STAGE_VIEWS; v++)
      frames[i].views[v] = views[i][v];
  }
  compare_frames(&result, &stages[0], &frames[0], &stages[1], &frames[1]);
  assert_true(result.agrees && result.has_views);
  views[1][1][7] = 1.0f / 255.0f;
  compare_frames(&result, &stages[0], &frames[0], &stages[1], &frames[1]);
  assert_false(result.agrees);
  assert_int_equal(result.views[1], 1);
  snprintf(stages[1].device, sizeof stages[1].device, "another");
  compare_frames(&result, &stages[0], &frames[0], &stages[1], &frames[1]);
  assert_true(result.agrees);
  casters[1][1] = 2;
  compare_frames(&result, &stages[0], &frames[0], &stages[1], &frames[1]);
  assert_false(result.agrees);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(lines_are_where_they_should_be),   cmocka_unit_test(surfaces_hide_lines),
      cmocka_unit_test(density_is_blue_white_and_red),    cmocka_unit_test(cascades_have_colors_and_beyond_is_grey),
      cmocka_unit_test(penumbrae_are_blue_white_and_red), cmocka_unit_test(views_agree_to_the_bit),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
