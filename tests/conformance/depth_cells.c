/*
 * depth_cells.c: maps that are drawn for what this frame's depth shows give the masks that whole maps give, for cameras of
 * every kind; and a depth of anything else is refused by name, and changes nothing.
 */
#include "support.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 90, HEIGHT = 70, BOXES = 60, INSTANCES = BOXES + 1 };

typedef struct fixture {
  record record; /* first: what callbacks get */
  csm_context *context;
  csm_scene *scene;
  csm_instance_id ids[INSTANCES];
  csm_cascades *all, *seen; /* of what casts into the maps, and of what can shade what is seen */
  csm_config config;
  csm_view *view, *other; /* what is seen; where whole maps are resolved */
} fixture;

static double scattered(uint32_t *state, double low, double high) {
  *state = *state * 1664525u + 1013904223u;
  return low + (high - low) * (*state >> 8) / (double)(1u << 24);
}

static void fill_scene(fixture *f) {
  csm_instance instances[INSTANCES];
  const csm_mesh box = support_box(f->context, 2);
  uint32_t state = 7;
  instances[0] = support_instance(support_square(f->context), 0, 0, 0, 80, 1, 80);
  for (int i = 1; i < INSTANCES; ++i)
    instances[i] =
        support_instance(box, scattered(&state, -60, 60), scattered(&state, 0, 8), scattered(&state, -60, 60),
                         scattered(&state, 0.3, 3), scattered(&state, 0.3, 6), scattered(&state, 0.3, 3));
  const csm_scene_batch batch = {
      .struct_size = sizeof batch, .count = INSTANCES, .ids = f->ids, .instances = instances};
  assert_int_equal(csm_scene_create(f->context, &f->scene), CSM_SUCCESS);
  assert_int_equal(csm_scene_add(f->scene, &batch), CSM_SUCCESS);
}

static void configure(fixture *f) {
  f->config.caster_set = CSM_CASTER_SET_MAP;
  assert_int_equal(csm_cascades_configure(f->all, &f->config), CSM_SUCCESS);
  f->config.caster_set = CSM_CASTER_SET_VIEW;
  assert_int_equal(csm_cascades_configure(f->seen, &f->config), CSM_SUCCESS);
}

static void setup(fixture *f) {
  memset(f, 0, sizeof *f);
  f->context = support_open_with(&f->record, CSM_CREATE_KEEP_GEOMETRY);
  f->config = support_config();
  f->config.resolution = 256;
  f->config.shadow_distance = 80;
  f->config.depth_mode = CSM_DEPTH_SCENE; /* ranges that do not follow casters */
  assert_int_equal(csm_cascades_create(f->context, &f->config, &f->all), CSM_SUCCESS);
  assert_int_equal(csm_cascades_create(f->context, &f->config, &f->seen), CSM_SUCCESS);
  configure(f);
  f->view = support_view(f->context);
  f->other = support_view(f->context);
  fill_scene(f);
}

static shot shot_of(const fixture *f) {
  shot shot = shot_make(NULL, 0);
  shot.frame.scene = f->scene;
  memcpy(shot.light.direction, (const double[]){0.8, -0.6, 0.25}, sizeof shot.light.direction);
  support_look_at(shot.camera.view, (const double[]){-20, 7, 40}, (const double[]){0, 0, 0});
  support_perspective(shot.camera.projection, 50, WIDTH / (double)HEIGHT, 0.25, 300);
  return shot;
}

static csm_result reduce(const fixture *f, shot *shot) {
  const csm_mask_info info = {.struct_size = sizeof info, .frame = shot_frame(shot), .width = WIDTH, .height = HEIGHT};
  return csm_reduce_depth(f->view, &info);
}

static csm_result render(const fixture *f, shot *shot) {
  shot->frame.depth_view = f->view;
  return csm_render_cascades(f->seen, shot_frame(shot));
}

static csm_stats stats_of(csm_cascades *cascades) {
  csm_stats stats = {.struct_size = sizeof stats};
  assert_int_equal(csm_get_stats(cascades, &stats), CSM_SUCCESS);
  return stats;
}

static uint64_t casters_of(const csm_stats *stats) {
  uint64_t casters = 0;
  for (uint32_t i = 0; i < stats->cascade_count; ++i)
    casters += stats->cascades[i].casters_drawn;
  return casters;
}

/* Both ways; adds how many casters each draws. */
static void compare(const fixture *f, shot *shot, uint64_t casters[2]) {
  shot->frame.depth_view = NULL;
  assert_int_equal(csm_render_cascades(f->all, shot_frame(shot)), CSM_SUCCESS);
  assert_int_equal(shot_resolve(shot, f->other, f->all, WIDTH, HEIGHT), CSM_SUCCESS);
  assert_int_equal(reduce(f, shot), CSM_SUCCESS);
  assert_int_equal(render(f, shot), CSM_SUCCESS);
  assert_int_equal(shot_resolve(shot, f->view, f->seen, WIDTH, HEIGHT), CSM_SUCCESS);
  float *whole = support_image(f->context, f->other, CSM_READ_MASK, WIDTH, HEIGHT);
  float *by_depth = support_image(f->context, f->view, CSM_READ_MASK, WIDTH, HEIGHT);
  assert_memory_equal(whole, by_depth, WIDTH * HEIGHT * sizeof *whole);
  free(whole);
  free(by_depth);
  const csm_stats all = stats_of(f->all), seen = stats_of(f->seen);
  assert_int_equal(all.cells_by, CSM_CELLS_ALL);
  assert_int_equal(seen.cells_by, CSM_CELLS_DEPTH);
  casters[0] += casters_of(&all);
  casters[1] += casters_of(&seen);
}

/* ---- cameras ---- */

static void orthographic(csm_camera *camera) {
  const double near = -20, far = 150, depth = far - near;
  const double projection[16] = {1 / 30.0, 0, 0, 0, 0, 1 / 22.0, 0, 0, 0, 0, -1 / depth, 0, 0, 0, -near / depth, 1};
  memcpy(camera->projection, projection, sizeof projection);
  camera->reversed = CSM_REVERSED_NO;
}

/* A near plane that cuts aslant. */
static void oblique(csm_camera *camera) {
  camera->projection[2] += 0.2;
  camera->projection[6] -= 0.1;
}

enum { KINDS = 6 };

static void take_camera(csm_camera *camera, int kind) {
  const double aspect = WIDTH / (double)HEIGHT;
  switch (kind) {
  case 1:
    support_perspective(camera->projection, 70, aspect, 0.1, 0); /* infinite, reversed */
    break;
  case 2:
    orthographic(camera);
    break;
  case 3:
    oblique(camera);
    break;
  case 4:
    camera->projection[8] += 0.4; /* off-centre */
    camera->projection[0] *= -1;  /* and mirrored */
    break;
  case 5:
    support_look_at(camera->view, (const double[]){5, 30, 9}, (const double[]){5.5, 0, 3});
    break;
  default:
    break;
  }
}

static void masks_are_those_of_whole_maps(void **state) {
  (void)state;
  static const uint32_t filters[] = {CSM_FILTER_PCF_3X3, CSM_FILTER_PCF_7X7, CSM_FILTER_PCSS};
  static fixture f;
  uint64_t casters[2] = {0, 0};
  setup(&f);
  for (uint32_t i = 0; i < 3 * KINDS; ++i) {
    shot shot = shot_of(&f);
    take_camera(&shot.camera, (int)(i % KINDS));
    f.config.filter = filters[i / KINDS];
    f.config.selection = i % 3;
    f.config.blend_mode = (i + i / 3) % 3;
    f.config.bias_normal_texels = i % 2 ? 2 : 0;
    f.config.map_layout = i / KINDS == 1 && i % KINDS != 2 ? CSM_LAYOUT_PAGES : CSM_LAYOUT_ARRAY;
    if (i % KINDS == 0)
      configure(&f);
    shot.light.angular_diameter = 0.01;
    compare(&f, &shot, casters);
  }
  assert_true(casters[1] < casters[0] * 3 / 4);
  support_close(f.context, &f.record);
}

/* The next light sees by the same depth, and so does the next frame as long as all stays as it is. */
static void a_depth_counts_until_something_changes(void **state) {
  (void)state;
  static fixture f;
  uint64_t casters[2] = {0, 0};
  setup(&f);
  shot shot = shot_of(&f);
  compare(&f, &shot, casters);
  shot.light.direction[0] = -0.3;
  assert_int_equal(render(&f, &shot), CSM_SUCCESS);
  assert_int_equal(stats_of(f.seen).cells_by, CSM_CELLS_DEPTH);
  assert_int_equal(csm_scene_remove(f.scene, 1, &f.ids[3]), CSM_SUCCESS);
  f.record.quiet = true;
  assert_int_equal(render(&f, &shot), CSM_ERROR_INVALID_STATE);
  assert_int_equal(reduce(&f, &shot), CSM_SUCCESS);
  assert_int_equal(render(&f, &shot), CSM_SUCCESS);
  compare(&f, &shot, casters);
  csm_create_info info = support_create_info(&f.record);
  info.backend = support_backend();
  assert_int_equal(csm_switch_backend(f.context, &info), CSM_SUCCESS);
  assert_int_equal(render(&f, &shot), CSM_ERROR_INVALID_STATE);
  compare(&f, &shot, casters);
  support_close(f.context, &f.record);
}

/* ---- misuse ---- */

static void expect(const fixture *f, csm_result result, csm_result expected, const char *says) {
  assert_int_equal(result, expected);
  if (!strstr(csm_last_error(f->context), says))
    fail_msg("\"%s\" does not say \"%s\"", csm_last_error(f->context), says);
}

static void refuses_to_reduce(const fixture *f) {
  shot shot = shot_of(f);
  csm_mask_info info = {.struct_size = sizeof info, .frame = shot_frame(&shot), .width = WIDTH, .height = HEIGHT};
  assert_int_equal(csm_reduce_depth(NULL, &info), CSM_ERROR_NULL_POINTER);
  expect(f, csm_reduce_depth(f->view, NULL), CSM_ERROR_NULL_POINTER, "csm_mask_info");
  info.width = 0;
  expect(f, csm_reduce_depth(f->view, &info), CSM_ERROR_INVALID_VALUE, "size");
  info.width = WIDTH;
  info.camera_depth = &shot;
  expect(f, csm_reduce_depth(f->view, &info), CSM_ERROR_UNSUPPORTED, "camera_depth");
  info.camera_depth = NULL;
  shot.frame.scene = NULL;
  expect(f, csm_reduce_depth(f->view, &info), CSM_ERROR_INVALID_VALUE, "scene");
  shot.frame.scene = f->scene;
  shot.camera.view[0] = NAN;
  expect(f, csm_reduce_depth(f->view, &info), CSM_ERROR_NOT_FINITE, "view");
}

static void refuses_other_depths(const fixture *f) {
  shot good = shot_of(f), wrong = good;
  csm_scene *scene;
  expect(f, render(f, &good), CSM_ERROR_INVALID_STATE, "no depth");
  assert_int_equal(reduce(f, &good), CSM_SUCCESS);
  wrong.camera.view[12] += 1e-9;
  expect(f, render(f, &wrong), CSM_ERROR_INVALID_VALUE, "another camera");
  wrong = good;
  wrong.camera.projection[8] += 0.01;
  expect(f, render(f, &wrong), CSM_ERROR_INVALID_VALUE, "another camera");
  wrong = good;
  wrong.camera.projection[0] = NAN;
  expect(f, render(f, &wrong), CSM_ERROR_NOT_FINITE, "projection");
  wrong = good;
  wrong.frame.scene = NULL;
  expect(f, render(f, &wrong), CSM_ERROR_INVALID_VALUE, "no scene");
  assert_int_equal(csm_scene_create(f->context, &scene), CSM_SUCCESS);
  wrong.frame.scene = scene;
  expect(f, render(f, &wrong), CSM_ERROR_INVALID_VALUE, "another scene");
  assert_int_equal(csm_scene_destroy(scene), CSM_SUCCESS);
  wrong = good;
  wrong.frame.depth_view = (csm_view *)f->context;
  expect(f, csm_render_cascades(f->seen, shot_frame(&wrong)), CSM_ERROR_INVALID_HANDLE, "depth_view");
  assert_int_equal(render(f, &good), CSM_SUCCESS);
}

/* The maps hold what the depth's picture needs, and no more. */
static void refuses_other_masks(const fixture *f) {
  shot good = shot_of(f), wrong = good;
  assert_int_equal(reduce(f, &good), CSM_SUCCESS);
  assert_int_equal(render(f, &good), CSM_SUCCESS);
  expect(f, shot_resolve(&good, f->view, f->seen, WIDTH + 1, HEIGHT), CSM_ERROR_INVALID_VALUE, "a depth of 90 x 70");
  wrong.camera.view[12] += 0.5;
  expect(f, shot_resolve(&wrong, f->view, f->seen, WIDTH, HEIGHT), CSM_ERROR_INVALID_VALUE, "another camera");
  assert_int_equal(shot_resolve(&good, f->view, f->seen, WIDTH, HEIGHT), CSM_SUCCESS);
  good.frame.depth_view = NULL;
  assert_int_equal(csm_render_cascades(f->seen, shot_frame(&good)), CSM_SUCCESS);
  assert_int_equal(stats_of(f->seen).cells_by, CSM_CELLS_RECEIVERS);
  assert_int_equal(shot_resolve(&wrong, f->view, f->seen, WIDTH + 1, HEIGHT), CSM_SUCCESS);
}

static void misuse_is_told_by_name(void **state) {
  (void)state;
  static fixture f;
  uint64_t casters[2] = {0, 0};
  setup(&f);
  f.record.quiet = true;
  refuses_to_reduce(&f);
  refuses_other_depths(&f);
  refuses_other_masks(&f);
  shot shot = shot_of(&f);
  compare(&f, &shot, casters);
  support_close(f.context, &f.record);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(masks_are_those_of_whole_maps),
                                     cmocka_unit_test(a_depth_counts_until_something_changes),
                                     cmocka_unit_test(misuse_is_told_by_name)};
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
