/* What lies in a store's folder may be anybody's: links, pipes, and truths that are none. */
#include "support.h"
#include "truth/store.h"
#include <dirent.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

enum { SIDE = 8, PIXELS = SIDE * SIDE, HEADER = 32 };

/* A store with one truth in its folder. */
typedef struct fixture {
  char folder[32], path[400], elsewhere[64];
  scene scene;
  camera from;
  truth_surface kept[PIXELS], found[PIXELS];
} fixture;

/* Asks for the view; returns how many truths were cast. */
static uint32_t ask_store(fixture *f, truth_surface *surfaces) {
  truth_store store;
  const truth_view view = {.camera = &f->from, .width = SIDE, .height = SIDE, .surfaces = surfaces};
  memset(surfaces, 0, PIXELS * sizeof *surfaces);
  assert_int_equal(truth_store_open(&store, &f->scene, false, f->folder), 0);
  assert_int_equal(truth_store_view(&store, &view), 0);
  const uint32_t cast = store.cast;
  truth_store_close(&store);
  return cast;
}

static void setup(fixture *f) {
  static const float ground[4][3] = {{-3, 0, -3}, {-3, 0, 3}, {3, 0, 3}, {3, 0, -3}};
  const double nowhere[3] = {0, 0, 0};
  struct dirent **entries;
  *f = (fixture){.folder = "/tmp/csm-store-XXXXXX", .elsewhere = "/tmp/csm-elsewhere-XXXXXX"};
  assert_non_null(mkdtemp(f->folder));
  close(mkstemp(f->elsewhere));
  add_quad(&f->scene, ground, nowhere);
  f->from = look((const double[3]){2, 3, 2}, nowhere, 50.0, 1.0);
  assert_int_equal(ask_store(f, f->kept), 1);
  const int count = scandir(f->folder, &entries, NULL, alphasort);
  for (int i = 0; i < count; i++) {
    if (entries[i]->d_name[0] != '.')
      snprintf(f->path, sizeof f->path, "%s/%s", f->folder, entries[i]->d_name);
    free(entries[i]);
  }
  free(entries);
  assert_int_equal(ask_store(f, f->found), 0);
}

/* The truth is cast again, kept in a file of the folder's own, and found. */
static void expect_mended(fixture *f) {
  struct stat status;
  assert_int_equal(ask_store(f, f->found), 1);
  assert_memory_equal(f->found, f->kept, sizeof f->kept);
  assert_int_equal(lstat(f->path, &status), 0);
  assert_true(S_ISREG(status.st_mode));
  assert_int_equal(ask_store(f, f->found), 0);
  assert_memory_equal(f->found, f->kept, sizeof f->kept);
}

static void teardown(fixture *f) {
  unlink(f->path);
  unlink(f->elsewhere);
  assert_int_equal(rmdir(f->folder), 0);
  scene_free(&f->scene);
}

/* The store's own, as whoever forges a file would make it. */
static uint64_t checksum(const uint8_t *bytes, size_t size) {
  uint64_t hash = 14695981039346656037u;
  for (size_t i = 0; i < size; i += 8) {
    uint64_t word;
    memcpy(&word, bytes + i, sizeof word);
    hash = (hash ^ word) * 0x100000001b3u;
    hash ^= hash >> 29;
  }
  return hash;
}

static void forged_triangles_are_cast_again(void **state) {
  (void)state;
  fixture f;
  uint8_t bytes[HEADER + PIXELS * 4];
  const uint32_t forged[] = {2, 1000000, UINT32_MAX - 1};
  setup(&f);
  for (int i = 0; i < 3; i++) {
    FILE *file = fopen(f.path, "r+b");
    assert_non_null(file);
    assert_int_equal(fread(bytes, 1, sizeof bytes, file), sizeof bytes);
    memcpy(bytes + HEADER + 4 * (PIXELS / 2), &forged[i], sizeof forged[i]);
    const uint64_t check = checksum(bytes + HEADER, sizeof bytes - HEADER);
    memcpy(bytes + HEADER - sizeof check, &check, sizeof check);
    rewind(file);
    assert_int_equal(fwrite(bytes, 1, sizeof bytes, file), sizeof bytes);
    fclose(file);
    expect_mended(&f);
  }
  teardown(&f);
}

static void a_pipe_is_not_waited_for(void **state) {
  (void)state;
  fixture f;
  setup(&f);
  unlink(f.path);
  assert_int_equal(mkfifo(f.path, 0600), 0);
  expect_mended(&f);
  teardown(&f);
}

/* What a link leads to is neither read nor written. */
static void a_link_is_not_followed(void **state) {
  (void)state;
  fixture f;
  struct stat status;
  setup(&f);
  assert_int_equal(rename(f.path, f.elsewhere), 0);
  assert_int_equal(symlink(f.elsewhere, f.path), 0);
  expect_mended(&f);
  assert_int_equal(truncate(f.elsewhere, 0), 0);
  unlink(f.path);
  assert_int_equal(symlink(f.elsewhere, f.path), 0);
  expect_mended(&f);
  assert_int_equal(stat(f.elsewhere, &status), 0);
  assert_int_equal(status.st_size, 0);
  teardown(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(forged_triangles_are_cast_again),
      cmocka_unit_test(a_pipe_is_not_waited_for),
      cmocka_unit_test(a_link_is_not_followed),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
