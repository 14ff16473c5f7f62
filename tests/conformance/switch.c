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
  const int switches = asked ? atoi(asked) : 8;
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
    assert_int_equal(f.record.blocks, blocks);
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

  f.record.quiet = true;
  info = to(&f, other_backend());
  f.supply_result = CSM_ERROR_OUT_OF_MEMORY;
  assert_int_equal(csm_switch_backend(f.context, &info), CSM_ERROR_OUT_OF_MEMORY);
  f.supply_result = CSM_SUCCESS;
  f.supplied.index_count = 6;
  assert_int_equal(csm_switch_backend(f.context, &info), CSM_ERROR_INVALID_VALUE);
  f.supplied = triangle();
  f.supplied.positions = NULL;
  assert_int_equal(csm_switch_backend(f.context, &info), CSM_ERROR_NULL_POINTER);
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

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(there_and_back),
      cmocka_unit_test(a_switch_may_fail_anywhere),
      cmocka_unit_test(a_bad_switch_changes_nothing),
      cmocka_unit_test(geometry_is_supplied_again),
      cmocka_unit_test(geometry_that_nobody_has_stays),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
