/* truth_test.c: the truth against closed forms, and against brute force in doubles. */
#include "base/linear.h"
#include "support.h"
#include "truth/geometry.h"
#include "truth/store.h"
#include "truth/sun_disc.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <cmocka.h>

#define WIDTH ANSWER_WIDTH
#define HEIGHT ANSWER_HEIGHT
#define PI 3.14159265358979323846

static const double nowhere[3] = {0, 0, 0};
static const float ground[4][3] = {{-20, 0, -20}, {-20, 0, 20}, {20, 0, 20}, {20, 0, -20}};

static size_t pixel_at(uint32_t column, uint32_t row) {
  return (size_t)row * WIDTH + column;
}

/* ---- a box over a plane, hard sun ---- */

/* How deep a ray passes through a box: above 0 it meets it. */
static double slab_depth(const double from[3], const double direction[3], const float low[3], const float high[3]) {
  double enter = 0.0, leave = INFINITY;
  for (int axis = 0; axis < 3; axis++) {
    const double a = (low[axis] - from[axis]) / direction[axis], b = (high[axis] - from[axis]) / direction[axis];
    enter = fmax(enter, fmin(a, b));
    leave = fmin(leave, fmax(a, b));
  }
  return leave - enter;
}

static void check_box_shadow(const double offset[3]) {
  const float low[3] = {-1.0f, 1.0f, -1.5f}, high[3] = {1.0f, 2.25f, 0.5f};
  scene s = {0};
  add_quad(&s, ground, offset);
  add_box(&s, low, high, offset);
  const double eye[3] = {offset[0] + 3.0, offset[1] + 6.0, offset[2] + 7.0};
  const camera from = look(eye, offset, 50.0, (double)WIDTH / HEIGHT);
  const scene_light light = {.direction = {0.5, -0.8, 0.3}};
  answer a;
  ask(&a, &s, &from, &(truth_asked){&light, INFINITY, 1}, false);
  uint32_t shadowed = 0, lit = 0;
  for (uint32_t row = 0; row < HEIGHT; row++)
    for (uint32_t column = 0; column < WIDTH; column++) {
      const truth_surface *surface = &a.view.surfaces[pixel_at(column, row)];
      double origin[3], direction[3], point[3];
      if (surface->triangle > 1)
        continue;
      brute_ray(&a.view, column, row, origin, direction);
      vec_subtract(origin, origin, offset);
      const double along = -origin[1] / direction[1];
      for (int axis = 0; axis < 3; axis++)
        point[axis] = origin[axis] + along * direction[axis];
      assert_true(fabs(surface->view_depth - (along * vec_dot(direction, from.forward) + 0.1)) < 1e-5);
      assert_true(surface->normal[1] > 0.9999f && !surface->behind);
      const double towards[3] = {-0.5, 0.8, -0.3};
      const double depth = slab_depth(point, towards, low, high);
      if (fabs(depth) < 1e-4)
        continue;
      assert_true(a.visibility[pixel_at(column, row)] == (depth > 0.0 ? 0.0f : 1.0f));
      shadowed += depth > 0.0;
      lit += depth < 0.0;
    }
  assert_true(shadowed > 500 && lit > 5000);
  answer_free(&a);
  scene_free(&s);
}

static void box_casts_its_shadow(void **state) {
  (void)state;
  check_box_shadow(nowhere);
}

static void box_casts_its_shadow_far_from_zero(void **state) {
  (void)state;
  check_box_shadow((const double[3]){1e7 + 3.7, -2e6 + 0.3, -1e7 - 11.1});
}

/* ---- a straight edge under a round sun ---- */

/* The share of a disc that lies beyond a line at `distance` from its middle, in radii. */
static double disc_share(double distance) {
  if (fabs(distance) >= 1.0)
    return distance < 0.0 ? 1.0 : 0.0;
  return (acos(distance) - distance * sqrt(1.0 - distance * distance)) / PI;
}

/* The sun stands at the zenith; a roof at height 10 covers x < 0. */
static void straight_edge_has_its_penumbra(void **state) {
  (void)state;
  const float roof[4][3] = {{-20, 10, -20}, {-20, 10, 20}, {0, 10, 20}, {0, 10, -20}};
  const double disc_deg = 4.0, radius = disc_deg * PI / 360.0;
  scene s = {0};
  add_quad(&s, ground, nowhere);
  add_quad(&s, roof, nowhere);
  const camera from = look((const double[3]){0, 3, 0.01}, nowhere, 30.0, (double)WIDTH / HEIGHT);
  answer a;
  ask(&a, &s, &from, &(truth_asked){&(scene_light){.direction = {0, -1, 0}, .disc_deg = disc_deg}, INFINITY, 1024},
      false);
  double largest = 0.0, sum = 0.0;
  uint32_t count = 0;
  for (uint32_t row = 0; row < HEIGHT; row++)
    for (uint32_t column = 0; column < WIDTH; column++) {
      double origin[3], direction[3];
      brute_ray(&a.view, column, row, origin, direction);
      const double x = origin[0] - origin[1] / direction[1] * direction[0];
      const double expected = disc_share(-atan(x / 10.0) / radius);
      const double error = a.visibility[pixel_at(column, row)] - expected;
      largest = fmax(largest, fabs(error));
      sum += error;
      count += expected > 0.01 && expected < 0.99;
    }
  assert_true(count > 3000);
  assert_true(largest < 0.012);
  assert_true(fabs(sum / (WIDTH * HEIGHT)) < 5e-4);
  assert_int_equal(a.convergence.samples, 1024);
  assert_true(a.convergence.pixels > 3000);
  assert_true(a.convergence.rms_half > 0.0 && a.convergence.rms_half < a.convergence.rms_quarter);
  assert_true(a.convergence.rms_quarter < 0.01 && a.convergence.largest_half < 0.02);
  answer_free(&a);
  scene_free(&s);
}

/* What halves of a pixel's rays differ by tells what all of them miss. */
static void noise_is_told_to_a_factor_of_two(void **state) {
  (void)state;
  const float roof[4][3] = {{-20, 10, -20}, {-20, 10, 20}, {0, 10, 20}, {0, 10, -20}};
  const double disc_deg = 4.0, radius = disc_deg * PI / 360.0;
  scene s = {0};
  add_quad(&s, ground, nowhere);
  add_quad(&s, roof, nowhere);
  const camera from = look((const double[3]){0, 3, 0.01}, nowhere, 30.0, (double)WIDTH / HEIGHT);
  for (uint32_t samples = 16; samples <= 1024; samples *= 4) {
    answer a;
    ask(&a, &s, &from, &(truth_asked){&(scene_light){.direction = {0, -1, 0}, .disc_deg = disc_deg}, INFINITY, samples},
        false);
    double squares = 0.0;
    for (uint32_t row = 0; row < HEIGHT; row++)
      for (uint32_t column = 0; column < WIDTH; column++) {
        double origin[3], direction[3];
        brute_ray(&a.view, column, row, origin, direction);
        const double x = origin[0] - origin[1] / direction[1] * direction[0];
        const double error = a.visibility[pixel_at(column, row)] - disc_share(-atan(x / 10.0) / radius);
        squares += error * error;
      }
    assert_true(squares > 0.0);
    assert_true(sqrt(squares) <= 2.0 * a.convergence.rms_half * sqrt((double)a.convergence.pixels));
    answer_free(&a);
  }
  scene_free(&s);
}

static void sun_is_spread_evenly(void **state) {
  (void)state;
  const scene_light light = {.direction = {0.3, -0.2, 0.9}, .disc_deg = 20.0};
  truth_sun sun;
  truth_sun_make(&sun, &light, 256);
  double middle[3] = {-0.3, 0.2, -0.9}, mean_height = 0.0;
  vec_normalize(middle);
  double sum[3] = {0};
  for (uint32_t i = 0; i < sun.set_count * sun.samples; i++) {
    const double along = vec_dot(sun.directions[i], middle);
    assert_true(fabs(vec_length(sun.directions[i]) - 1.0) < 1e-12);
    assert_true(along >= cos(10.0 * PI / 180.0) - 1e-12);
    mean_height += along;
    for (int axis = 0; axis < 3; axis++)
      sum[axis] += sun.directions[i][axis];
  }
  /* Even in solid angle: heights on the cap are even, and the mean points to its middle. */
  const double total = (double)sun.set_count * sun.samples;
  assert_true(fabs(mean_height / total - 0.5 * (1.0 + cos(10.0 * PI / 180.0))) < 2e-5);
  assert_true(fabs(vec_length(sum) / total - mean_height / total) < 1e-5);
  truth_sun_free(&sun);
}

/* ---- brute force ---- */

static uint32_t compare_with_brute_force(const scene *s, const camera *from, const scene_light *light) {
  brute b;
  answer a;
  uint32_t differing = 0, seen = 0, shadowed = 0;
  double towards[3] = {-light->direction[0], -light->direction[1], -light->direction[2]};
  brute_make(&b, s);
  ask(&a, s, from, &(truth_asked){light, INFINITY, 1}, false);
  for (uint32_t row = 0; row < HEIGHT; row++)
    for (uint32_t column = 0; column < WIDTH; column++) {
      const truth_surface *surface = &a.view.surfaces[pixel_at(column, row)];
      double origin[3], direction[3], point[3], distance, away;
      brute_ray(&a.view, column, row, origin, direction);
      const uint32_t triangle = brute_nearest(&b, origin, direction, TRUTH_NOTHING, &distance);
      if (triangle != surface->triangle) {
        differing++;
        continue;
      }
      if (triangle == TRUTH_NOTHING)
        continue;
      for (int axis = 0; axis < 3; axis++)
        point[axis] = origin[axis] + distance * direction[axis];
      double seen_from[3];
      vec_subtract(seen_from, point, from->position);
      assert_true(fabs(surface->view_depth - vec_dot(seen_from, from->forward)) < 1e-4);
      const bool lit =
          truth_facing(surface, light) > 0.0 && brute_nearest(&b, point, towards, triangle, &away) == TRUTH_NOTHING;
      differing += a.visibility[pixel_at(column, row)] != (lit ? 1.0f : 0.0f);
      seen++;
      shadowed += !lit;
    }
  assert_true(seen > WIDTH * HEIGHT / 20 && shadowed > seen / 20 && shadowed < seen);
  answer_free(&a);
  brute_free(&b);
  return differing;
}

/* Off-centre; forward depth with an infinite far plane; left-handed; mirrored; orthographic. */
static uint32_t make_cameras(camera *out, const double eye[3], const double at[3]) {
  const camera plain = look(eye, at, 60.0, (double)WIDTH / HEIGHT);
  double view[16], projection[16];
  uint32_t count = 0;
  out[count++] = plain;

  memcpy(projection, plain.projection, sizeof projection);
  projection[8] = 0.3;
  projection[9] = -0.2;
  assert_null(camera_from_matrices(&out[count++], plain.view, projection, NULL));

  memcpy(projection, plain.projection, sizeof projection);
  projection[10] = -1.0;
  projection[14] = -0.1;
  assert_null(camera_from_matrices(&out[count++], plain.view, projection, NULL));

  memcpy(view, plain.view, sizeof view);
  memcpy(projection, plain.projection, sizeof projection);
  for (int column = 0; column < 4; column++)
    view[column * 4 + 2] = -view[column * 4 + 2];
  projection[10] = -projection[10];
  projection[11] = 1.0;
  assert_null(camera_from_matrices(&out[count++], view, projection, NULL));

  const double flat[16] = {0.15, 0, 0, 0, 0, 0.2, 0, 0, 0, 0, -1.0 / 40.0, 0, 0.1, -0.1, 0, 1};
  assert_null(camera_from_matrices(&out[count++], plain.view, flat, NULL));
  return count;
}

static void brute_force_agrees(void **state) {
  (void)state;
  uint32_t most = 0;
  for (uint32_t seed = 1; seed <= 3; seed++) {
    const double offset[3] = {seed == 2 ? 8e6 : 0.0, 0.0, seed == 3 ? -1e7 : 0.0};
    const double eye[3] = {offset[0] + 5.0, offset[1] + 4.0, offset[2] + 6.0};
    const scene_light light = {.direction = {0.4 * seed - 1.0, -1.0, 0.35}};
    camera cameras[5];
    scene s = {0};
    add_random(&s, 250, 3.0, 2.0, seed, offset);
    const uint32_t count = make_cameras(cameras, eye, offset);
    for (uint32_t i = 0; i < count; i++) {
      const uint32_t differing = compare_with_brute_force(&s, &cameras[i], &light);
      most = differing > most ? differing : most;
    }
    scene_free(&s);
  }
  print_message("brute force: at most %u of %u pixels differ\n", most, WIDTH * HEIGHT);
  assert_true(most <= 2);
}

/* Every share that is measured with the truth, against that with brute force in its place. */
static void brute_force_measures_alike(void **state) {
  (void)state;
  double largest = 0.0;
  for (uint32_t seed = 11; seed <= 13; seed++) {
    scene s = {0};
    add_quad(&s, ground, nowhere);
    add_random(&s, 120, 3.0, 1.6, seed, (const double[3]){0, 3.2, 0});
    const camera from = look((const double[3]){6, 7, 8}, (const double[3]){0, 1, 0}, 55.0, (double)WIDTH / HEIGHT);
    const scene_light light = {.direction = {0.3, -0.9, 0.2}};
    answer a;
    brute b;
    ask(&a, &s, &from, &(truth_asked){&light, INFINITY, 1}, false);
    brute_make(&b, &s);
    float *visibility = calloc(WIDTH * HEIGHT, sizeof *visibility), *mask = calloc(WIDTH * HEIGHT, sizeof *mask);
    float *depth = calloc(WIDTH * HEIGHT, sizeof *depth);
    uint8_t *kinds = calloc(WIDTH * HEIGHT, 1);
    for (uint32_t row = 0; row < HEIGHT; row++)
      for (uint32_t column = 0; column < WIDTH; column++) {
        double origin[3], direction[3], point[3], distance, away;
        const size_t pixel = pixel_at(column, row);
        brute_ray(&a.view, column, row, origin, direction);
        const uint32_t triangle = brute_nearest(&b, origin, direction, TRUTH_NOTHING, &distance);
        mask[pixel] = (column / 3 + row / 5) % 4 ? a.visibility[pixel] : 1.0f - a.visibility[pixel];
        if (triangle == TRUTH_NOTHING)
          continue;
        for (int axis = 0; axis < 3; axis++)
          point[axis] = origin[axis] + distance * direction[axis];
        visibility[pixel] =
            brute_nearest(&b, point, (const double[3]){-0.3, 0.9, -0.2}, triangle, &away) == TRUTH_NOTHING;
        depth[pixel] = (float)(distance * vec_dot(direction, from.forward) + 0.1);
      }
    metrics ours, brutes;
    metrics_frame frame = {.view = &a.view,
                           .light = &light,
                           .shadow_distance = 40.0,
                           .visibility = a.visibility,
                           .mask = mask,
                           .view_depth = depth};
    assert_int_equal(metrics_measure(&ours, &frame, kinds), 0);
    frame.visibility = visibility;
    assert_int_equal(metrics_measure(&brutes, &frame, kinds), 0);
    assert_true(ours.pixels > 8000 && ours.false_lit > 0.01 && ours.false_shadow > 0.01 && ours.leak > 0.0);
    const double differences[] = {ours.false_lit - brutes.false_lit, ours.false_shadow - brutes.false_shadow,
                                  ours.rmse - brutes.rmse,           ours.acne - brutes.acne,
                                  ours.leak - brutes.leak,           ours.lit - brutes.lit};
    for (size_t i = 0; i < sizeof differences / sizeof differences[0]; i++)
      largest = fmax(largest, fabs(differences[i]));
    free(visibility);
    free(mask);
    free(depth);
    free(kinds);
    answer_free(&a);
    brute_free(&b);
    scene_free(&s);
  }
  print_message("brute force: the largest difference of a share is %g\n", largest);
  assert_true(largest <= 1.0 / 8000.0);
}

/* ---- surfaces ---- */

/* A tilted plane of 20 by 20 quads, 0.37 by 0.41 each, every triangle twice, once for each side. */
static void add_tilted_grid(scene *s) {
  float(*corners)[9] = calloc(2 * 800, sizeof *corners);
  uint32_t count = 0;
  for (int i = 0; i < 20; i++)
    for (int j = 0; j < 20; j++) {
      float quad[4][3];
      for (int k = 0; k < 4; k++) {
        quad[k][0] = 0.37f * (float)(i + k / 2);
        quad[k][2] = 0.41f * (float)(j + (k == 1 || k == 2));
        quad[k][1] = 0.3f * quad[k][0] + 0.1f * quad[k][2];
      }
      const int chosen[2][3] = {{0, 1, 2}, {0, 2, 3}};
      for (int t = 0; t < 2; t++, count += 2)
        for (int k = 0; k < 3; k++) {
          memcpy(corners[count] + 3 * k, quad[chosen[t][k]], 3 * sizeof(float));
          memcpy(corners[count + 1] + 3 * k, quad[chosen[t][2 - k]], 3 * sizeof(float));
        }
    }
  add_triangles(s, (const float(*)[9])corners, count, nowhere);
  free(corners);
}

/*
 * Two triangles in one place do not shadow each other, and neither do neighbours in a plane; not even where every
 * pixel's centre lies on the edges between them, as the second camera's do.
 */
static void surface_does_not_shadow_itself(void **state) {
  (void)state;
  scene s = {0};
  add_tilted_grid(&s);
  camera cameras[2] = {look((const double[3]){4, 9, 4.2}, (const double[3]){3.7, 1, 4}, 40.0, (double)WIDTH / HEIGHT)};
  const double down[16] = {1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, -20, 1};
  const double right = WIDTH * 0.37 / 20.0, top = HEIGHT * 0.41 / 20.0; /* a twentieth of a quad each pixel */
  const double flat[16] = {2.0 / right,
                           0,
                           0,
                           0,
                           0,
                           2.0 / top,
                           0,
                           0,
                           0,
                           0,
                           -0.05,
                           0,
                           -1.0 - 1.0 / WIDTH - 20.0 / WIDTH,
                           1.0 - 1.0 / HEIGHT + 20.0 / HEIGHT,
                           -0.5,
                           1};
  assert_null(camera_from_matrices(&cameras[1], down, flat, NULL));
  for (int i = 0; i < 2; i++)
    for (int turn = 0; turn < 8; turn++) {
      answer a;
      uint32_t seen = 0;
      const scene_light light = {.direction = {cos(turn), -0.5, sin(turn)}};
      ask(&a, &s, &cameras[i], &(truth_asked){&light, INFINITY, 1}, false);
      for (size_t k = 0; k < WIDTH * HEIGHT; k++) {
        seen += a.view.surfaces[k].triangle != TRUTH_NOTHING;
        assert_true(a.visibility[k] == 1.0f);
      }
      assert_true(seen > WIDTH * HEIGHT / 2);
      answer_free(&a);
    }
  scene_free(&s);
}

/* A mirrored instance's winding is turned round, which does not put it seen from behind. */
static void mirrored_instances_face_right(void **state) {
  (void)state;
  scene s = {0};
  add_box(&s, (const float[3]){-1, -1, -1}, (const float[3]){1, 1, 1}, nowhere);
  for (size_t i = 0; i < s.instance_count; i++)
    s.instances[i].transform[0] = -1.0;
  const camera outside = look((const double[3]){3, 4, 5}, nowhere, 40.0, (double)WIDTH / HEIGHT);
  const camera inside = look(nowhere, (const double[3]){1, 0.2, 0.1}, 40.0, (double)WIDTH / HEIGHT);
  for (int within = 0; within < 2; within++) {
    answer a;
    ask(&a, &s, within ? &inside : &outside, &(truth_asked){&(scene_light){.direction = {0, -1, 0}}, INFINITY, 1},
        false);
    for (size_t i = 0; i < WIDTH * HEIGHT; i++)
      if (a.view.surfaces[i].triangle != TRUTH_NOTHING)
        assert_int_equal(a.view.surfaces[i].behind, within);
    assert_true(a.view.surfaces[pixel_at(WIDTH / 2, HEIGHT / 2)].triangle != TRUTH_NOTHING);
    answer_free(&a);
  }
  scene_free(&s);
}

/* ---- alpha ---- */

static void alpha_mask_is_bilinear_and_wraps(void **state) {
  (void)state;
  uint8_t alpha[] = {0, 255, 51, 102};
  scene_alpha_mask o = {.alpha = alpha, .width = 2, .height = 2};
  assert_true(fabs(scene_alpha_mask_at(&o, (const double[2]){0.25, 0.25}) - 0.0) < 1e-12);
  assert_true(fabs(scene_alpha_mask_at(&o, (const double[2]){0.75, 0.25}) - 1.0) < 1e-12);
  assert_true(fabs(scene_alpha_mask_at(&o, (const double[2]){0.25, 0.75}) - 0.2) < 1e-12);
  assert_true(fabs(scene_alpha_mask_at(&o, (const double[2]){0.5, 0.5}) - 0.4) < 1e-12);
  /* at the left border, between the last column and the first */
  assert_true(fabs(scene_alpha_mask_at(&o, (const double[2]){0.0, 0.25}) - 0.5) < 1e-12);
  assert_true(fabs(scene_alpha_mask_at(&o, (const double[2]){-2.25, 3.25}) - 1.0) < 1e-12);
  o.wrap[0] = SCENE_WRAP_CLAMP;
  assert_true(fabs(scene_alpha_mask_at(&o, (const double[2]){-3.0, 0.25}) - 0.0) < 1e-12);
  assert_true(fabs(scene_alpha_mask_at(&o, (const double[2]){7.0, 0.25}) - 1.0) < 1e-12);
  o.wrap[0] = SCENE_WRAP_MIRROR;
  assert_true(fabs(scene_alpha_mask_at(&o, (const double[2]){1.25, 0.25}) - 1.0) < 1e-12);
  for (scene_wrap mode = SCENE_WRAP_REPEAT; mode <= SCENE_WRAP_CLAMP; mode++) { /* wherever a file says */
    const double wild[] = {1e18, -1e18, 1e30, -1e300, INFINITY, -INFINITY, NAN};
    scene_alpha_mask odd = o;
    odd.wrap[0] = odd.wrap[1] = mode;
    for (int i = 0; i < 7; i++) {
      const double opacity = scene_alpha_mask_at(&odd, (const double[2]){wild[i], wild[6 - i]});
      assert_true(opacity >= 0.0 && opacity <= 1.0);
    }
  }
  assert_true(fabs(scene_alpha_mask_at(&o, (const double[2]){-0.25, 0.25}) - 0.0) < 1e-12);
}

/* A leaf over the ground whose texture is opaque in its left half: the seam lies at u = 0.5. */
static void cut_out_leaf_casts_what_is_left(void **state) {
  (void)state;
  static const float leaf[2][9] = {{-1, 1, -1, -1, 1, 1, 1, 1, 1}, {-1, 1, -1, 1, 1, 1, 1, 1, -1}};
  static const float uvs[12] = {0, 0, 0, 1, 1, 1, 0, 0, 1, 1, 1, 0};
  scene s = {0};
  add_quad(&s, ground, nowhere);
  scene_material material = {.alpha_tested = true};
  material.alpha_mask = (scene_alpha_mask){.alpha = malloc(4 * 4), .width = 4, .height = 4, .cutoff = 0.5};
  material.alpha_mask.wrap[0] = material.alpha_mask.wrap[1] = SCENE_WRAP_CLAMP;
  for (int i = 0; i < 16; i++)
    material.alpha_mask.alpha[i] = i % 4 < 2 ? 255 : 0;
  scene_mesh *mesh = add_triangles(&s, leaf, 2, nowhere);
  mesh->material = scene_add_material(&s, &material);
  mesh->uvs = malloc(sizeof uvs);
  memcpy(mesh->uvs, uvs, sizeof uvs);
  const camera from = look((const double[3]){0.01, 0.5, 3.0}, nowhere, 60.0, (double)WIDTH / HEIGHT);
  for (int alpha_test = 0; alpha_test < 2; alpha_test++) {
    answer a;
    uint32_t shadowed[2] = {0};
    ask(&a, &s, &from, &(truth_asked){&(scene_light){.direction = {0, -1, 0}}, INFINITY, 1}, alpha_test);
    for (uint32_t row = 0; row < HEIGHT; row++)
      for (uint32_t column = 0; column < WIDTH; column++) {
        double origin[3], direction[3];
        brute_ray(&a.view, column, row, origin, direction);
        const double along = -origin[1] / direction[1];
        const double x = origin[0] + along * direction[0], z = origin[2] + along * direction[2];
        if (a.view.surfaces[pixel_at(column, row)].triangle > 1 || fabs(x) < 1e-3)
          continue;
        const bool under = fabs(z) < 1.0 && x > -1.0 && x < (alpha_test ? 0.0 : 1.0);
        assert_true(a.visibility[pixel_at(column, row)] == (under ? 0.0f : 1.0f));
        shadowed[x > 0.0] += under;
      }
    assert_true(shadowed[0] > 100);
    assert_int_equal(shadowed[1] > 100, !alpha_test);
    answer_free(&a);
  }
  scene_free(&s);
}

/* ---- a second camera ---- */

static void second_camera_sees_past_nothing(void **state) {
  (void)state;
  scene s = {0};
  const float wall[4][3] = {{-1, 0, 0}, {1, 0, 0}, {1, 2, 0}, {-1, 2, 0}};
  add_quad(&s, ground, nowhere);
  add_quad(&s, wall, nowhere);
  const camera first = look((const double[3]){0, 8, 0.01}, nowhere, 60.0, (double)WIDTH / HEIGHT);
  const camera second = look((const double[3]){0, 1, 6}, (const double[3]){0, 0.5, 0}, 70.0, (double)WIDTH / HEIGHT);
  answer a;
  ask(&a, &s, &first, &(truth_asked){&(scene_light){.direction = {0, -1, 0}}, INFINITY, 1}, false);
  uint8_t *seen = malloc(WIDTH * HEIGHT);
  truth *caster = truth_create(&s, false);
  assert_int_equal(truth_seen(caster, &a.view, &second, seen), 0);
  uint32_t hidden = 0, shown = 0;
  for (uint32_t row = 0; row < HEIGHT; row++)
    for (uint32_t column = 0; column < WIDTH; column++) {
      double origin[3], direction[3];
      brute_ray(&a.view, column, row, origin, direction);
      const double along = -origin[1] / direction[1];
      const double x = origin[0] + along * direction[0], z = origin[2] + along * direction[2];
      if (a.view.surfaces[pixel_at(column, row)].triangle > 1)
        continue;
      /* Behind the wall, as the second eye at (0, 1, 6) sees it, the ground is hidden where the sight line crosses it.
       */
      const double across = x * 6.0 / (6.0 - z);
      const bool behind = z < 0.0 && fabs(across) < 1.0;
      if (fabs(fabs(across) - 1.0) < 1e-3 || fabs(z) < 1e-3)
        continue;
      double local[3] = {x, -1.0, z - 6.0}, clip[4], world[3] = {x, 0.0, z};
      double matrix[16];
      (void)local;
      mat_multiply(matrix, second.projection, second.view);
      mat_transform(clip, matrix, world, 1.0);
      const bool inside = clip[3] > 0.0 && fabs(clip[0]) < clip[3] && fabs(clip[1]) < clip[3] && clip[2] < clip[3];
      assert_int_equal(seen[pixel_at(column, row)], inside && !behind);
      hidden += inside && behind;
      shown += inside && !behind;
    }
  assert_true(hidden > 300 && shown > 300);
  truth_destroy(caster);
  free(seen);
  answer_free(&a);
  scene_free(&s);
}

/* ---- the store ---- */

static void store_finds_what_it_kept(void **state) {
  (void)state;
  char folder[] = "/tmp/csm-store-XXXXXX", command[64];
  assert_non_null(mkdtemp(folder));
  scene s = {0};
  add_quad(&s, ground, nowhere);
  add_random(&s, 40, 2.0, 1.0, 5, (const double[3]){0, 2.5, 0});
  const camera from = look((const double[3]){4, 6, 5}, nowhere, 50.0, (double)WIDTH / HEIGHT);
  const scene_light lights[2] = {{.direction = {0.3, -1, 0.1}}, {.direction = {0.3, -1, 0.1}, .disc_deg = 3.0}};
  float *visibility[3];
  truth_surface *surfaces[3];
  for (int i = 0; i < 3; i++) {
    visibility[i] = calloc(WIDTH * HEIGHT, sizeof(float));
    surfaces[i] = calloc(WIDTH * HEIGHT, sizeof(truth_surface));
    truth_store store;
    truth_convergence convergence;
    const truth_view view = {.camera = &from, .width = WIDTH, .height = HEIGHT, .surfaces = surfaces[i]};
    assert_int_equal(truth_store_open(&store, &s, false, folder), 0);
    assert_int_equal(truth_store_view(&store, &view), 0);
    assert_int_equal(
        truth_store_visibility(&store, &view, &(truth_asked){&lights[0], 50.0, 1}, visibility[i], &convergence), 0);
    assert_int_equal(store.cast, i == 1 ? 0 : 2);
    assert_int_equal(store.loaded, i == 1 ? 2 : 0);
    if (i == 1) { /* another light is another truth; then the scene changes */
      float *other = calloc(WIDTH * HEIGHT, sizeof *other);
      assert_int_equal(truth_store_visibility(&store, &view, &(truth_asked){&lights[1], 50.0, 64}, other, &convergence),
                       0);
      assert_true(convergence.pixels > 0);
      const scene_light wider = {.direction = {0.3, -1, 0.1}, .disc_deg = 4.0};
      assert_int_equal(truth_store_visibility(&store, &view, &(truth_asked){&wider, 50.0, 64}, other, &convergence), 0);
      assert_int_equal(truth_store_visibility(&store, &view, &(truth_asked){&lights[0], 40.0, 1}, other, &convergence),
                       0);
      assert_int_equal(store.cast, 3);
      free(other);
      s.meshes[0].positions[1] = 0.25f;
    }
    truth_store_close(&store);
  }
  assert_memory_equal(visibility[0], visibility[1], WIDTH * HEIGHT * sizeof(float));
  for (size_t i = 0; i < WIDTH * HEIGHT; i++)
    assert_true(surfaces[0][i].view_depth == surfaces[1][i].view_depth);
  for (int i = 0; i < 3; i++) {
    free(visibility[i]);
    free(surfaces[i]);
  }
  snprintf(command, sizeof command, "rm -r '%s'", folder);
  assert_int_equal(system(command), 0);
  scene_free(&s);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(box_casts_its_shadow),
      cmocka_unit_test(box_casts_its_shadow_far_from_zero),
      cmocka_unit_test(straight_edge_has_its_penumbra),
      cmocka_unit_test(noise_is_told_to_a_factor_of_two),
      cmocka_unit_test(sun_is_spread_evenly),
      cmocka_unit_test(brute_force_agrees),
      cmocka_unit_test(brute_force_measures_alike),
      cmocka_unit_test(surface_does_not_shadow_itself),
      cmocka_unit_test(mirrored_instances_face_right),
      cmocka_unit_test(alpha_mask_is_bilinear_and_wraps),
      cmocka_unit_test(cut_out_leaf_casts_what_is_left),
      cmocka_unit_test(second_camera_sees_past_nothing),
      cmocka_unit_test(store_finds_what_it_kept),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
