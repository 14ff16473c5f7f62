/*
 * switch.c: a context moves between backends while it draws. CSM_SWITCHES=1000 in the environment makes the long run of
 * it; the usual one is short.
 */
#include "support.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { width = 96, height = 64, pixels = width * height };

typedef struct fixture {
  record record;
  csm_context *context;
  csm_cascades *cascades[2]; /* two suns */
  csm_view *view;
  support_scene scene;
  csm_mesh_info supplied; /* what the supply callback gives */
  csm_result supply_result;
  uint32_t supplies;
} fixture;

static const char *other_backend(void) {
  const char *mine = support_backend();
  return !strcmp(mine, "vulkan") ? "d3d12" : !strcmp(mine, "d3d12") ? "vulkan" : mine;
}

static void open_fixture(fixture *f, uint32_t flags, csm_supply_function supply) {
  memset(f, 0, sizeof *f);
  csm_create_info info = support_create_info(&f->record);
  info.flags = flags | (getenv("CSM_SWITCHES") ? 0 : info.flags); /* the validation layer keeps memory of its own */
  info.supply = supply;
  assert_int_equal(csm_create(&info, &f->context), CSM_SUCCESS);
  csm_config config = support_config();
  support_scene_make(&f->scene, f->context);
  f->view = support_view(f->context);
  for (int i = 0; i < 2; ++i) {
    config.resolution = i ? 128 : 256;
    assert_int_equal(csm_cascades_create(f->context, &config, &f->cascades[i]), CSM_SUCCESS);
  }
}

static csm_create_info to(fixture *f, const char *backend) {
  csm_create_info info = support_create_info(&f->record);
  info.flags = getenv("CSM_SWITCHES") ? 0 : info.flags;
  info.backend = backend;
  return info;
}

/* The masks of both suns at a step of the camera's path, one after the other. */
static void draw(fixture *f, int step, float masks[2 * pixels]) {
  shot shot = f->scene.shot;
  shot.camera.view[12] += 0.05 * (step % 40);
  for (int i = 0; i < 2; ++i) {
    shot.light.direction[0] = i ? -0.3 : 0.4;
    assert_int_equal(csm_render_cascades(f->cascades[i], shot_frame(&shot)), CSM_SUCCESS);
    assert_int_equal(shot_resolve(&shot, f->view, f->cascades[i], width, height), CSM_SUCCESS);
    float *read = support_image(f->context, f->view, CSM_READ_MASK, width, height);
    memcpy(masks + i * pixels, read, pixels * sizeof *read);
    free(read);
  }
}

static void check_masks(const float *before, const float *after) {
  uint32_t differ = 0, dark = 0;
  for (int i = 0; i < 2 * pixels; ++i) {
    const float difference = before[i] - after[i];
    differ += difference > 1.0f / 255 + 1e-6f || difference < -1.0f / 255 - 1e-6f;
    dark += after[i] == 0;
  }
  assert_true(differ <= 2 * pixels / 10000);
  assert_true(dark > 50 || !strcmp(support_backend(), "null"));
}

static uint32_t open_files(void) {
  DIR *folder = opendir("/proc/self/fd");
  assert_non_null(folder);
  uint32_t count = 0;
  while (readdir(folder))
    ++count;
  closedir(folder);
  return count;
}

static long resident_kib(void) {
  FILE *file = fopen("/proc/self/statm", "r");
  long pages = 0;
  assert_non_null(file);
  assert_int_equal(fscanf(file, "%*s %ld", &pages), 1);
  fclose(file);
  return pages * 4;
}

static void there_and_back(void **state) {
  (void)state;
  const char *asked = getenv("CSM_SWITCHES");
  const int switches = asked ? atoi(asked) : 6;
  fixture f;
  open_fixture(&f, CSM_CREATE_KEEP_GEOMETRY, NULL);
  static float before[2 * pixels], after[2 * pixels];
  int64_t blocks = 0;
  uint32_t files = 0;
  long first_kib = 0;
  for (int i = 0; i < switches; ++i) {
    draw(&f, i, before);
    const csm_create_info info = to(&f, i % 2 ? support_backend() : other_backend());
    assert_int_equal(csm_switch_backend(f.context, &info), CSM_SUCCESS);
    /* Nothing of the old device's is handed out as if it were the new one's. */
    csm_binding binding = {.struct_size = sizeof binding};
    f.record.quiet = true;
    assert_int_equal(csm_bind(f.cascades[0], &binding), CSM_ERROR_INVALID_STATE);
    f.record.quiet = false;
    --f.record.errors;
    draw(&f, i, after);
    check_masks(before, after);
    if (i == 3) { /* both backends have been there and back */
      blocks = f.record.blocks;
      files = open_files();
      first_kib = resident_kib();
    }
    if (i > 3 && i % 2) {
      assert_int_equal(f.record.blocks, blocks);
      assert_int_equal(open_files(), files);
    }
  }
  if (asked)
    printf("%d switches: resident memory %ld KiB after the fourth, %ld KiB after the last\n", switches, first_kib,
           resident_kib());
  support_close(f.context, &f.record);
}

/* Each allocation in turn fails while switching: the old backend draws on as before. */
static void a_switch_may_fail_anywhere(void **state) {
  (void)state;
  fixture f;
  open_fixture(&f, CSM_CREATE_KEEP_GEOMETRY, NULL);
  static float before[2 * pixels], after[2 * pixels];
  draw(&f, 0, before);
  f.record.quiet = true;
  csm_result result;
  int64_t failures = 0;
  bool roomy = false;
  do {
    const int64_t blocks = f.record.blocks;
    csm_create_info info = to(&f, other_backend());
    info.flags = 0;
    f.record.allocations_left = failures++;
    result = csm_switch_backend(f.context, &info);
    f.record.allocations_left = -1;
    if (!result)
      break;
    assert_true(result == CSM_ERROR_OUT_OF_MEMORY || result == CSM_ERROR_OUT_OF_DEVICE_MEMORY);
    assert_true(f.record.blocks <= blocks + !roomy); /* room that the next try has already */
    roomy |= f.record.blocks > blocks;
    if (failures % 8 == 1) {
      draw(&f, 0, after);
      assert_memory_equal(before, after, sizeof before);
    }
  } while (result);
  assert_true(failures > 10);
  draw(&f, 0, after);
  check_masks(before, after);
  support_close(f.context, &f.record);
}

static void a_bad_switch_changes_nothing(void **state) {
  (void)state;
  fixture f;
  open_fixture(&f, CSM_CREATE_KEEP_GEOMETRY, NULL);
  static float before[2 * pixels], after[2 * pixels];
  draw(&f, 0, before);
  f.record.quiet = true;
  csm_create_info info = to(&f, "nope");
  assert_int_equal(csm_switch_backend(f.context, &info), CSM_ERROR_BACKEND_NOT_FOUND);
  info = to(&f, "/proc/self/status");
  assert_int_equal(csm_switch_backend(f.context, &info), CSM_ERROR_BACKEND_BROKEN);
  info = to(&f, other_backend()), info.device = "no such device";
  assert_int_equal(csm_switch_backend(f.context, &info), CSM_ERROR_NO_DEVICE);
  info = to(&f, other_backend()), info.memory_limit = 1000;
  assert_int_equal(csm_switch_backend(f.context, &info), CSM_ERROR_LIMIT_EXCEEDED);
  info = to(&f, other_backend()), info.struct_size = 0;
  assert_int_equal(csm_switch_backend(f.context, &info), CSM_ERROR_STRUCT_SIZE);
  info = to(&f, NULL);
  assert_int_equal(csm_switch_backend(f.context, &info), CSM_ERROR_NULL_POINTER);
  draw(&f, 0, after);
  assert_memory_equal(before, after, sizeof before);
  support_close(f.context, &f.record);
}

/* ---- what is kept from frame to frame ---- */

/* A scene that stays, whose moments are kept, with a view that has a history. */
typedef struct keeper {
  csm_context *context;
  csm_cascades *cascades;
  csm_view *view;
  csm_scene *scene;
  csm_instance_id ids[SUPPORT_INSTANCES];
  support_scene shown;
} keeper;

static csm_config kept_config(uint32_t filter) {
  csm_config config = support_config();
  config.filter = filter;
  config.moment_exponent = 20; /* a blur shows */
  config.moment_blur_texels = 3;
  config.moment_levels = 3;
  config.moment_sampling = CSM_SAMPLING_TRILINEAR;
  config.caster_set = CSM_CASTER_SET_VIEW; /* tiles that are seen are made, and stay */
  config.history = CSM_HISTORY_ON;
  return config;
}

static void keeper_open(keeper *k, csm_context *context, const csm_config *config) {
  *k = (keeper){.context = context, .view = support_view(context)};
  support_scene_make(&k->shown, context);
  k->shown.shot.light.angular_diameter = 0.05;
  assert_int_equal(csm_cascades_create(context, config, &k->cascades), CSM_SUCCESS);
  assert_int_equal(csm_scene_create(context, &k->scene), CSM_SUCCESS);
  const csm_scene_batch batch = {
      .struct_size = sizeof batch, .count = SUPPORT_INSTANCES, .ids = k->ids, .instances = k->shown.instances};
  assert_int_equal(csm_scene_add(k->scene, &batch), CSM_SUCCESS);
}

/* At each step another box has been moved, and the camera looks elsewhere. */
static void keeper_step(keeper *k, int step) {
  double matrix[16];
  memcpy(matrix, k->shown.instances[1 + step % SUPPORT_BOXES].transform, sizeof matrix);
  matrix[12] += 0.7;
  const csm_scene_batch moved = {
      .struct_size = sizeof moved, .count = 1, .ids = &k->ids[1 + step % SUPPORT_BOXES], .matrices = matrix};
  assert_int_equal(csm_scene_move(k->scene, &moved), CSM_SUCCESS);
  support_look_at(k->shown.shot.camera.view, (const double[3]){-3.0 + 2.5 * step, 4, 6}, (const double[3]){0, 0, -9});
}

static float *keeper_draw(keeper *k, uint32_t show) {
  csm_frame frame = *shot_frame(&k->shown.shot);
  frame.instances = NULL;
  frame.instance_count = 0;
  frame.scene = k->scene;
  const csm_mask_info mask = {
      .struct_size = sizeof mask, .frame = &frame, .width = width, .height = height, .show = show};
  assert_int_equal(csm_render_cascades(k->cascades, &frame), CSM_SUCCESS);
  assert_int_equal(csm_resolve_mask(k->view, k->cascades, &mask), CSM_SUCCESS);
  return support_image(k->context, k->view, CSM_READ_MASK, width, height);
}

/* The same steps in a context that has no past, on the backend that the other one has come to: its first frame after a
   switch, the frame whose moments are kept, and what the history holds. */
static void compare_with_fresh(keeper *k, const csm_config *config, const char *backend, int step) {
  record record = {.backend = backend, .allocations_left = -1};
  keeper fresh;
  keeper_open(&fresh, support_open_with(&record, CSM_CREATE_RAYS), config);
  for (int i = 0; i <= step; ++i)
    keeper_step(&fresh, i);
  for (int frame = 0; frame < 3; ++frame) {
    const uint32_t show = frame == 2 ? CSM_SHOW_HISTORY : CSM_SHOW_VISIBILITY;
    float *mine = keeper_draw(k, show), *its = keeper_draw(&fresh, show);
    for (int i = 0; i < pixels; ++i)
      if (mine[i] != its[i])
        fail_msg("step %d, frame %d, pixel %d: %g, not %g", step, frame, i, mine[i], its[i]);
    free(mine);
    free(its);
  }
  support_close(fresh.context, &record);
}

static void nothing_is_kept_from_another_device(void **state) {
  (void)state;
  static const uint32_t filters[] = {CSM_FILTER_VSM, CSM_FILTER_EVSM4, CSM_FILTER_VSSM, CSM_FILTER_EXACT_SOFT};
  for (size_t i = 0; i < sizeof filters / sizeof *filters; ++i) {
    fixture f = {0};
    keeper k;
    csm_create_info info = support_create_info(&f.record);
    info.flags |= CSM_CREATE_KEEP_GEOMETRY | CSM_CREATE_RAYS;
    assert_int_equal(csm_create(&info, &f.context), CSM_SUCCESS);
    const csm_config config = kept_config(filters[i]);
    keeper_open(&k, f.context, &config);
    for (int step = 0; step < 3; ++step) { /* away, back, and to the same again */
      const char *backend = step == 0 ? other_backend() : support_backend();
      keeper_step(&k, step);
      free(keeper_draw(&k, CSM_SHOW_VISIBILITY));
      const csm_create_info next = to(&f, backend);
      assert_int_equal(csm_switch_backend(f.context, &next), CSM_SUCCESS);
      compare_with_fresh(&k, &config, backend, step);
    }
    support_close(f.context, &f.record);
  }
}

/* ---- geometry that is supplied again ---- */

static const float positions[9] = {-1, 1, -1, 1, 1, -1, 0, 1, 1};
static const uint16_t indices[3] = {0, 2, 1};

static csm_mesh_info triangle(void) {
  return (csm_mesh_info){.struct_size = sizeof(csm_mesh_info),
                         .positions = positions,
                         .vertex_count = 3,
                         .indices = indices,
                         .index_count = 3,
                         .index_size = 2};
}

/* The record is the fixture's first member, so the callbacks' user is both. */
static csm_result CSM_CALL supply(void *user, csm_mesh mesh, csm_mesh_info *info) {
  fixture *f = user;
  assert_true(mesh != 0 && info->struct_size == sizeof *info);
  ++f->supplies;
  *info = f->supplied;
  return f->supply_result;
}

/* What a supply callback may answer, none of which is a mesh of the old shape. */
typedef struct wrong_supply {
  const char *what;
  csm_result answer;
  uint32_t offset, size; /* of a field of csm_mesh_info */
  uint64_t value;
  csm_result expected;
} wrong_supply;

static void refuse_wrong_supplies(fixture *f, const csm_create_info *info) {
#define FIELD_OF(field) offsetof(csm_mesh_info, field), sizeof(((csm_mesh_info *)0)->field)
  static const uint16_t beyond[3] = {0, 2, 3};
  const wrong_supply cases[] = {
      {"an error", CSM_ERROR_OUT_OF_MEMORY, FIELD_OF(struct_size), sizeof(csm_mesh_info), CSM_ERROR_INVALID_STATE},
      {"no error, but not success", 1, FIELD_OF(struct_size), sizeof(csm_mesh_info), CSM_ERROR_INVALID_STATE},
      {"the largest result", INT32_MAX, FIELD_OF(struct_size), sizeof(csm_mesh_info), CSM_ERROR_INVALID_STATE},
      {"a lost device", CSM_ERROR_DEVICE_LOST, FIELD_OF(struct_size), sizeof(csm_mesh_info), CSM_ERROR_INVALID_STATE},
      {"no size", CSM_SUCCESS, FIELD_OF(struct_size), 0, CSM_ERROR_STRUCT_SIZE},
      {"a size that is absurd", CSM_SUCCESS, FIELD_OF(struct_size), 0x7ffffffc, CSM_ERROR_STRUCT_SIZE},
      {"a size that is odd", CSM_SUCCESS, FIELD_OF(struct_size), sizeof(csm_mesh_info) - 3, CSM_ERROR_STRUCT_SIZE},
      {"more indices", CSM_SUCCESS, FIELD_OF(index_count), 6, CSM_ERROR_INVALID_VALUE},
      {"more vertices", CSM_SUCCESS, FIELD_OF(vertex_count), 4, CSM_ERROR_INVALID_VALUE},
      {"wider indices", CSM_SUCCESS, FIELD_OF(index_size), 4, CSM_ERROR_INVALID_VALUE},
      {"other flags", CSM_SUCCESS, FIELD_OF(flags), CSM_MESH_TWO_SIDED, CSM_ERROR_INVALID_VALUE},
      {"an alpha mask", CSM_SUCCESS, FIELD_OF(alpha_mask), 7, CSM_ERROR_INVALID_VALUE},
      {"no positions", CSM_SUCCESS, FIELD_OF(positions), 0, CSM_ERROR_NULL_POINTER},
      {"an index out of range", CSM_SUCCESS, FIELD_OF(indices), (uintptr_t)beyond, CSM_ERROR_INVALID_INDEX},
  };
#undef FIELD_OF
  f->record.quiet = true;
  for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
    const int64_t blocks = f->record.blocks;
    f->supplied = triangle();
    f->supply_result = cases[i].answer;
    memcpy((char *)&f->supplied + cases[i].offset, &cases[i].value, cases[i].size);
    const csm_result result = csm_switch_backend(f->context, info);
    if (result != cases[i].expected)
      fail_msg("%s: %s (%s), not %s", cases[i].what, csm_result_name(result), csm_last_error(f->context),
               csm_result_name(cases[i].expected));
    assert_true(csm_last_error(f->context)[0] && f->record.blocks <= blocks + 2); /* room for the next try */
  }
  f->supply_result = CSM_SUCCESS;
}

static void geometry_is_supplied_again(void **state) {
  (void)state;
  fixture f;
  memset(&f, 0, sizeof f);
  csm_create_info info = support_create_info(&f.record);
  info.supply = supply;
  assert_int_equal(csm_create(&info, &f.context), CSM_SUCCESS);
  csm_mesh mesh;
  f.supplied = triangle();
  assert_int_equal(csm_mesh_create(f.context, &f.supplied, &mesh), CSM_SUCCESS);
  csm_config config = support_config();
  for (int i = 0; i < 2; ++i)
    assert_int_equal(csm_cascades_create(f.context, &config, &f.cascades[i]), CSM_SUCCESS);
  support_scene_make(&f.scene, NULL);
  f.view = support_view(f.context);
  for (int i = 0; i < SUPPORT_INSTANCES; ++i)
    f.scene.instances[i].mesh = mesh;
  static float before[2 * pixels], after[2 * pixels];
  draw(&f, 0, before);

  info = to(&f, other_backend());
  refuse_wrong_supplies(&f, &info);
  draw(&f, 0, after);
  assert_memory_equal(before, after, sizeof before);

  f.supplied = triangle();
  f.supplies = 0;
  assert_int_equal(csm_switch_backend(f.context, &info), CSM_SUCCESS);
  assert_int_equal(f.supplies, 1);
  draw(&f, 0, after);
  check_masks(before, after);
  support_close(f.context, &f.record);
}

/* What the context's copy of a mesh says of its faces is what it said: a leaf whose back is turned to the light casts
   though backs are left out, before a switch and after it. */
static void a_switch_keeps_two_sided_leaves(void **state) {
  (void)state;
  fixture f;
  open_fixture(&f, CSM_CREATE_KEEP_GEOMETRY, NULL);
  csm_mesh_info info = triangle();
  csm_mesh leaves[2];
  for (uint32_t sides = 0; sides < 2; ++sides) {
    info.flags = sides ? CSM_MESH_TWO_SIDED : 0;
    assert_int_equal(csm_mesh_create(f.context, &info, &leaves[sides]), CSM_SUCCESS);
  }
  csm_config config = support_config();
  config.cascade_count = 1;
  config.face_culling = CSM_FACE_CULLING_BACK;
  assert_int_equal(csm_cascades_configure(f.cascades[0], &config), CSM_SUCCESS);
  uint32_t covered[2][2] = {{0}};
  for (int switched = 0; switched < 2; ++switched) {
    for (uint32_t sides = 0; sides < 2; ++sides) {
      const csm_instance turned = support_instance(leaves[sides], 0, 0, 0, 4, -1, 4);
      shot shot = f.scene.shot;
      shot.frame.instances = &turned;
      shot.frame.instance_count = 1;
      assert_int_equal(csm_render_cascades(f.cascades[0], shot_frame(&shot)), CSM_SUCCESS);
      float *map = support_map(f.context, f.cascades[0], 0, 256);
      for (int i = 0; i < 256 * 256; ++i)
        covered[switched][sides] += map[i] < 1;
      free(map);
    }
    const csm_create_info next = to(&f, other_backend());
    assert_int_equal(csm_switch_backend(f.context, &next), CSM_SUCCESS);
  }
  if (strcmp(support_backend(), "null")) {
    assert_true(covered[0][0] == 0 && covered[0][1] > 50);
    assert_true(covered[1][0] == 0 && covered[1][1] == covered[0][1]);
  }
  support_close(f.context, &f.record);
}

static void geometry_that_nobody_has_stays(void **state) {
  (void)state;
  fixture f;
  open_fixture(&f, 0, NULL);
  f.record.quiet = true;
  const csm_create_info info = to(&f, other_backend());
  assert_int_equal(csm_switch_backend(f.context, &info), CSM_ERROR_INVALID_STATE);
  static float masks[2 * pixels];
  draw(&f, 0, masks);
  support_close(f.context, &f.record);
}

static uint32_t pages_drawn(const fixture *f) {
  csm_stats stats = {.struct_size = sizeof stats};
  assert_int_equal(csm_get_stats(f->cascades[0], &stats), CSM_SUCCESS);
  assert_true(stats.pages_valid > 0 && stats.pages_drawn <= stats.pages_valid);
  return stats.pages_drawn == stats.pages_valid ? UINT32_MAX : stats.pages_drawn;
}

/* A box, half a metre to one side or the other. */
static void move_box(csm_scene *scene, const fixture *f, csm_instance_id *ids, double by) {
  double moved[16];
  memcpy(moved, f->scene.instances[1].transform, sizeof moved);
  moved[12] += by;
  const csm_scene_batch batch = {.struct_size = sizeof batch, .count = 1, .ids = &ids[1], .matrices = moved};
  assert_int_equal(csm_scene_move(scene, &batch), CSM_SUCCESS);
}

/* Another device holds none of them, and the first one, when it is back, none of those that it had. */
static void pages_are_made_anew(void **state) {
  (void)state;
  static float before[2 * pixels], after[2 * pixels];
  fixture f;
  csm_scene *scene;
  csm_instance_id ids[SUPPORT_INSTANCES];
  csm_config config = support_config();
  open_fixture(&f, CSM_CREATE_KEEP_GEOMETRY, NULL);
  const csm_scene_batch all = {
      .struct_size = sizeof all, .count = SUPPORT_INSTANCES, .ids = ids, .instances = f.scene.instances};
  assert_int_equal(csm_scene_create(f.context, &scene), CSM_SUCCESS);
  assert_int_equal(csm_scene_add(scene, &all), CSM_SUCCESS);
  f.scene.shot.frame.instances = NULL;
  f.scene.shot.frame.instance_count = 0;
  f.scene.shot.frame.scene = scene;
  config.map_layout = CSM_LAYOUT_PAGES;
  config.caster_set = CSM_CASTER_SET_VIEW;
  for (int i = 0; i < 2; ++i)
    assert_int_equal(csm_cascades_configure(f.cascades[i], &config), CSM_SUCCESS);
  for (int i = 0; i < 3; ++i) {
    draw(&f, 0, before);
    assert_int_equal(pages_drawn(&f), UINT32_MAX);
    draw(&f, 0, before);
    assert_int_equal(pages_drawn(&f), 0);
    move_box(scene, &f, ids, i % 2 ? 0.5 : -0.5);
    draw(&f, 0, before);
    assert_in_range(pages_drawn(&f), 1, 4096);
    const csm_create_info info = to(&f, i % 2 ? support_backend() : other_backend());
    assert_int_equal(csm_switch_backend(f.context, &info), CSM_SUCCESS);
    draw(&f, 0, after);
    assert_int_equal(pages_drawn(&f), UINT32_MAX);
    check_masks(before, after);
    assert_int_equal(csm_cascades_configure(f.cascades[0], &config), CSM_SUCCESS);
  }
  support_close(f.context, &f.record);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(there_and_back),
      cmocka_unit_test(a_switch_may_fail_anywhere),
      cmocka_unit_test(a_bad_switch_changes_nothing),
      cmocka_unit_test(nothing_is_kept_from_another_device),
      cmocka_unit_test(geometry_is_supplied_again),
      cmocka_unit_test(a_switch_keeps_two_sided_leaves),
      cmocka_unit_test(geometry_that_nobody_has_stays),
      cmocka_unit_test(pages_are_made_anew),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
