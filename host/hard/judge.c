/* judge.c: masks against the truth, and against each other. */
#include "base/host.h"
#include "base/linear.h"
#include "hard/hard.h"
#include "truth/store.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define WORST_SCALE 4u /* pixels for each of those */
#define WORST_SIDE 64u /* pixels of the picture around the worst one */

/* ---- truth ---- */

void hard_truth_free(hard_truth *truth) {
  free(truth->view.surfaces);
  free(truth->visibility);
  free(truth->silhouette_squares);
  free(truth->edge_squares);
  *truth = (hard_truth){0};
}

/* What a pixel sees: where, and how far the neighbouring pixel's point can lie on the same plane. */
typedef struct seen_point {
  bool seen;
  double place[3]; /* relative to the camera */
  double span;
} seen_point;

static seen_point point_of(const hard_truth *truth, const camera_rays *rays, uint32_t column, uint32_t row) {
  const truth_surface *surface = &truth->view.surfaces[(size_t)row * truth->view.width + column];
  seen_point point = {.seen = surface->triangle != TRUTH_NOTHING};
  if (!point.seen)
    return point;
  const double x = camera_pixel_x(rays, column), y = camera_pixel_y(rays, row);
  double beside[3], origin[3], ray[3], reach, normal[3];
  for (int i = 0; i < 3; i++)
    normal[i] = surface->normal[i];
  camera_ray(rays, x, y, origin, ray, &reach);
  camera_point(rays, &truth->camera, x, y, surface->view_depth, point.place);
  camera_point(rays, &truth->camera, x + 2.0 / rays->width, y + 2.0 / rays->height, surface->view_depth, beside);
  vec_subtract(beside, beside, point.place);
  point.span = vec_length(beside) / fmax(fabs(vec_dot(ray, normal)), 1e-6);
  return point;
}

/* Neighbours lie on surfaces that join where their points are no farther apart than what their planes span. The sky is
 * one with itself. */
static bool joined(const seen_point *a, const seen_point *b) {
  double apart[3];
  if (!a->seen || !b->seen)
    return a->seen == b->seen;
  vec_subtract(apart, a->place, b->place);
  return vec_length(apart) <= 2.0 * (a->span + b->span);
}

/* Marks both of two neighbours. */
static void mark_pair(uint8_t *marked, size_t a, size_t b, bool edge) {
  if (edge)
    marked[a] = marked[b] = 1;
}

static void find_edges(hard_truth *truth) {
  const uint32_t width = truth->view.width, height = truth->view.height;
  const size_t pixels = (size_t)width * height;
  uint8_t *silhouettes = host_allocate(pixels, 1), *edges = host_allocate(pixels, 1);
  seen_point *points = host_allocate(pixels, sizeof *points);
  camera_rays rays;
  camera_rays_make(&rays, &truth->camera, width, height);
  for (size_t i = 0; i < pixels; i++)
    points[i] = point_of(truth, &rays, (uint32_t)(i % width), (uint32_t)(i / width));
  for (size_t i = 0; i < pixels; i++) {
    const size_t right = i % width + 1 < width ? i + 1 : i, below = i + width < pixels ? i + width : i;
    const float *lit = truth->visibility;
    mark_pair(silhouettes, i, right, !joined(&points[i], &points[right]));
    mark_pair(silhouettes, i, below, !joined(&points[i], &points[below]));
    mark_pair(edges, i, right, (lit[i] >= 0.5f) != (lit[right] >= 0.5f));
    mark_pair(edges, i, below, (lit[i] >= 0.5f) != (lit[below] >= 0.5f));
  }
  metrics_distances(silhouettes, width, height, truth->silhouette_squares);
  metrics_distances(edges, width, height, truth->edge_squares);
  free(points);
  free(edges);
  free(silhouettes);
}

int hard_cast(hard_run *run, const camera *from, const scene_light *light, hard_truth *out) {
  const host_setup *setup = run->setup;
  const size_t pixels = (size_t)setup->width * setup->height;
  hard_truth_free(out);
  *out = (hard_truth){.camera = *from,
                      .light = *light,
                      .shadow_distance = setup->shadow_distance,
                      .view = {.camera = &out->camera,
                               .width = setup->width,
                               .height = setup->height,
                               .surfaces = host_allocate(pixels, sizeof *out->view.surfaces)},
                      .visibility = host_allocate(pixels, sizeof *out->visibility),
                      .silhouette_squares = host_allocate(pixels, sizeof *out->silhouette_squares),
                      .edge_squares = host_allocate(pixels, sizeof *out->edge_squares)};
  if (!run->truth)
    run->truth = truth_create(&setup->scene, true);
  truth_store store = {.caster = run->truth}; /* keeps nothing */
  truth_convergence convergence;
  const truth_asked asked = {.light = light, .max_depth = setup->shadow_distance, .samples = 256};
  int code = truth_store_view(&store, &out->view);
  if (code == 0)
    code = truth_store_visibility(&store, &out->view, &asked, out->visibility, &convergence);
  if (code == 0)
    find_edges(out);
  return code;
}

float *hard_true_depth(const hard_truth *truth) {
  const truth_view *view = &truth->view;
  float *depth = host_allocate((size_t)view->width * view->height, sizeof *depth);
  camera_rays rays;
  camera_rays_make(&rays, &truth->camera, view->width, view->height);
  for (size_t i = 0; i < (size_t)view->width * view->height; i++) {
    const double x = camera_pixel_x(&rays, (uint32_t)(i % view->width));
    const double y = camera_pixel_y(&rays, (uint32_t)(i / view->width));
    double point[4], clip[4];
    depth[i] = truth->camera.reversed ? 0.0f : 1.0f;
    if (view->surfaces[i].triangle == TRUTH_NOTHING)
      continue;
    camera_point(&rays, &truth->camera, x, y, view->surfaces[i].view_depth, point);
    mat_transform(point, truth->camera.view, (const double[3]){point[0], point[1], point[2]}, 0.0);
    mat_transform(clip, truth->camera.projection, point, 1.0);
    depth[i] = (float)(clip[2] / clip[3]);
  }
  return depth;
}

float (*hard_true_normals(const hard_truth *truth))[4] {
  const size_t pixels = (size_t)truth->view.width * truth->view.height;
  float(*normals)[4] = host_allocate(pixels, sizeof *normals);
  for (size_t i = 0; i < pixels; i++)
    memcpy(normals[i], truth->view.surfaces[i].normal, sizeof truth->view.surfaces[i].normal);
  return normals;
}

int hard_draw_normals(hard_run *run, const hard_truth *truth, hard_picture *out) {
  float(*normals)[4] = hard_true_normals(truth);
  const hard_inputs inputs = {.normals = (const float(*)[4])normals};
  const int code = hard_draw_engine(run, &inputs, &truth->camera, &truth->light, out);
  free(normals);
  return code;
}

/* ---- pictures of the worst ---- */

/* What is around pixel `at` of two pictures, if that is worse than all before. */
static void keep_worst(hard_run *run, double severity, size_t at, uint32_t width, uint32_t height,
                       const float *const pictures[2], const char *what) {
  hard_worst *worst = &run->worst;
  if (worst->expected && severity <= worst->severity)
    return;
  free(worst->expected);
  free(worst->drawn);
  *worst = (hard_worst){.severity = severity,
                        .width = width < WORST_SIDE ? width : WORST_SIDE,
                        .height = height < WORST_SIDE ? height : WORST_SIDE};
  snprintf(worst->what, sizeof worst->what, "%s", what);
  const size_t count = (size_t)worst->width * worst->height;
  worst->expected = host_allocate(count, sizeof *worst->expected);
  worst->drawn = host_allocate(count, sizeof *worst->drawn);
  const int64_t middle_x = (int64_t)(at % width), middle_y = (int64_t)(at / width);
  int64_t left = middle_x - worst->width / 2, top = middle_y - worst->height / 2;
  left = left < 0 ? 0 : left > (int64_t)(width - worst->width) ? (int64_t)(width - worst->width) : left;
  top = top < 0 ? 0 : top > (int64_t)(height - worst->height) ? (int64_t)(height - worst->height) : top;
  for (uint32_t y = 0; y < worst->height; y++) {
    const size_t from = (size_t)(top + y) * width + (size_t)left, to = (size_t)y * worst->width;
    memcpy(worst->expected + to, pictures[0] + from, worst->width * sizeof(float));
    memcpy(worst->drawn + to, pictures[1] + from, worst->width * sizeof(float));
  }
}

static void fill_square(image *out, uint32_t x, uint32_t y, const float color[3]) {
  for (uint32_t j = 0; j < WORST_SCALE; j++)
    for (uint32_t i = 0; i < WORST_SCALE; i++)
      image_set(out, x * WORST_SCALE + i, y * WORST_SCALE + j, color);
}

static void visibility_color(float color[3], float visibility) {
  color[0] = color[1] = color[2] = 0.05f + 0.75f * visibility;
}

void hard_worst_picture(image *out, const hard_worst *worst) {
  static const float left_out[3] = {0.1f, 0.12f, 0.17f}, dark[3] = {0.05f, 0.1f, 1.0f}, lit[3] = {1.0f, 0.08f, 0.05f};
  image_create(out, (2 * worst->width + 1) * WORST_SCALE, worst->height * WORST_SCALE);
  for (uint32_t y = 0; y < worst->height; y++)
    for (uint32_t x = 0; x < worst->width; x++) {
      const size_t i = (size_t)y * worst->width + x;
      const float expected = worst->expected[i], drawn = worst->drawn[i];
      float right[3], seen[3];
      visibility_color(right, expected);
      visibility_color(seen, drawn);
      const float *wrong = drawn - expected > 0.5f ? lit : expected - drawn > 0.5f ? dark : seen;
      fill_square(out, x, y, isnan(expected) ? left_out : right);
      fill_square(out, worst->width + 1 + x, y, wrong);
    }
}

/* ---- judging ---- */

static bool within(int64_t square, double margin) {
  return (double)square < margin * margin;
}

static bool is_judged(const hard_truth *truth, size_t i, hard_margin margin) {
  const truth_surface *surface = &truth->view.surfaces[i];
  return surface->triangle != TRUTH_NOTHING && surface->view_depth <= truth->shadow_distance &&
         truth_facing(surface, &truth->light) > margin.cosine &&
         !within(truth->silhouette_squares[i], margin.silhouette_px) && !within(truth->edge_squares[i], margin.edge_px);
}

hard_count hard_judge(hard_run *run, const hard_truth *truth, const float *mask, hard_margin margin) {
  const size_t pixels = (size_t)truth->view.width * truth->view.height;
  hard_count count = {0};
  double squares = 0.0, largest = 0.0;
  size_t worst = pixels / 2 + truth->view.width / 2; /* the middle, where nothing is wrong */
  float *expected = host_allocate(pixels, sizeof *expected);
  for (size_t i = 0; i < pixels; i++) {
    expected[i] = is_judged(truth, i, margin) ? truth->visibility[i] : NAN;
    if (isnan(expected[i]))
      continue;
    const double error = (double)mask[i] - truth->visibility[i];
    count.judged++;
    count.lit += truth->visibility[i] >= 0.5f;
    count.false_dark += !(error >= -0.5);
    count.false_lit += error > 0.5;
    squares += error * error;
    if (!(fabs(error) <= largest)) {
      largest = fabs(error);
      worst = i;
    }
  }
  count.rms = count.judged ? sqrt(squares / (double)count.judged) : 0.0;
  keep_worst(run, (double)(count.false_dark + count.false_lit) + largest, worst, truth->view.width, truth->view.height,
             (const float *const[]){expected, mask}, "the truth, and what was drawn");
  free(expected);
  return count;
}

int hard_measure(metrics *out, const hard_truth *truth, const hard_picture *drawn) {
  uint8_t *kinds = host_allocate((size_t)drawn->width * drawn->height, 1);
  const metrics_frame frame = {.view = &truth->view,
                               .light = &truth->light,
                               .shadow_distance = truth->shadow_distance,
                               .visibility = truth->visibility,
                               .mask = drawn->mask,
                               .view_depth = drawn->view_depth};
  const int code = metrics_measure(out, &frame, kinds);
  free(kinds);
  return code;
}

hard_difference hard_compare(hard_run *run, const hard_picture *expected, const hard_picture *drawn, double tolerance) {
  const size_t pixels = (size_t)expected->width * expected->height;
  hard_difference difference = {0};
  size_t worst = pixels / 2 + expected->width / 2; /* the middle, where nothing differs */
  for (size_t i = 0; i < pixels; i++) {
    const double apart = fabs((double)expected->mask[i] - drawn->mask[i]);
    difference.pixels += !(apart <= tolerance);
    if (!(apart <= difference.largest)) {
      difference.largest = apart;
      worst = i;
    }
  }
  keep_worst(run, (double)difference.pixels + difference.largest, worst, expected->width, expected->height,
             (const float *const[]){expected->mask, drawn->mask}, "what it should be like, and what was drawn");
  return difference;
}
