/* The loader against stub backends: see stubs/meson.build. STUBS is the folder they are built in. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "abi/loader.h"

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { NEWEST_TRIED = 6 };

static char scratch[] = P_tmpdir "/csm-loader-XXXXXX"; /* a folder of this test's own */

static void copy_file(const char *to, const char *from, size_t most) {
  static char bytes[1 << 20];
  FILE *in = fopen(from, "rb");
  assert_non_null(in);
  size_t size = fread(bytes, 1, sizeof bytes, in);
  assert_true(feof(in));
  fclose(in);
  FILE *out = fopen(to, "wb");
  assert_non_null(out);
  size = size < most ? size : most;
  assert_int_equal(fwrite(bytes, 1, size, out), size);
  assert_int_equal(fclose(out), 0);
}

static const char *in_scratch(const char *name) {
  static char path[PATH_MAX];
  snprintf(path, sizeof path, "%s/%s", scratch, name);
  return path;
}

static int make_scratch(void **state) {
  (void)state;
  return mkdtemp(scratch) && chdir(scratch) == 0 ? 0 : -1;
}

static int remove_scratch(void **state) {
  (void)state;
  char command[PATH_MAX];
  snprintf(command, sizeof command, "rm -rf '%s'", scratch);
  return chdir("/") == 0 ? system(command) : -1;
}

static void expect_name(const char *name, const char *from) {
  loader_library library;
  char error[1024] = "";
  assert_int_equal(loader_open(&library, name, error, sizeof error), CSM_SUCCESS);
  assert_string_equal(error, "");
  assert_string_equal(library.backend->name, from);
  loader_close(&library);
  assert_null(library.handle);
  assert_null(library.backend);
}

/* Opening fails with `expected`, leaves nothing loaded, and the text holds `text`. */
static void expect_error(const char *name, csm_result expected, const char *text) {
  loader_library library;
  char error[1024] = "";
  assert_int_equal(loader_open(&library, name, error, sizeof error), expected);
  assert_null(library.handle);
  assert_null(library.backend);
  if (!strstr(error, text))
    fail_msg("\"%s\" is not in \"%s\"", text, error);
  if (library.path[0])
    assert_null(dlopen(library.path, RTLD_LAZY | RTLD_NOLOAD));
  loader_close(&library);
}

static void test_every_pair_of_ranges(void **state) {
  (void)state;
  static const gpu_backend table;
  for (uint32_t code = 0; code < 7 * 7 * 7 * 7 * 2; code++) {
    const gpu_handshake answer = {.front_oldest = code % 7,
                                  .front_newest = code / 7 % 7,
                                  .backend_oldest = code / 49 % 7,
                                  .backend_newest = code / 343 % 7,
                                  .backend = code / 2401 ? &table : NULL};
    if (answer.front_oldest > answer.front_newest)
      continue;
    int32_t newest_common = -1;
    for (uint32_t version = 0; version <= NEWEST_TRIED; version++)
      if (version >= answer.front_oldest && version <= answer.front_newest && version >= answer.backend_oldest &&
          version <= answer.backend_newest)
        newest_common = (int32_t)version;
    csm_result expected = CSM_SUCCESS;
    if (answer.backend_oldest > answer.backend_newest)
      expected = CSM_ERROR_BACKEND_BROKEN;
    else if (newest_common < 0)
      expected = answer.backend_newest < answer.front_oldest ? CSM_ERROR_BACKEND_TOO_OLD : CSM_ERROR_BACKEND_TOO_NEW;
    else if (!answer.backend)
      expected = CSM_ERROR_BACKEND_BROKEN;
    uint32_t version = 99;
    assert_int_equal(loader_negotiate(&answer, &version), expected);
    assert_int_equal(version, expected == CSM_SUCCESS ? newest_common : 0);
  }
}

static void test_names(void **state) {
  (void)state;
  expect_name("good", "beside"); /* beside libcsm comes first */
  expect_name("installed", "installed");
  expect_name("wide", "beside");
  expect_name(STUBS "/libcsm-good.so", "beside");
  expect_name(STUBS "/installed/libcsm-good.so", "installed");
}

static void test_path_is_kept(void **state) {
  (void)state;
  loader_library library;
  char error[64];
  assert_int_equal(loader_open(&library, "good", error, sizeof error), CSM_SUCCESS);
  assert_string_equal(library.path, STUBS "/libcsm-good.so");
  loader_close(&library);
}

static void test_wrong_names(void **state) {
  (void)state;
  const char *const names[] = {"", "Good", "good.so", "go od", "..", "\xc3\xa9", "good\n"};
  for (size_t i = 0; i < sizeof names / sizeof names[0]; i++)
    expect_error(names[i], CSM_ERROR_INVALID_VALUE, "neither a backend's name nor a path");
}

static void test_missing(void **state) {
  (void)state;
  expect_error("absent", CSM_ERROR_BACKEND_NOT_FOUND, "libcsm-absent.so in " STUBS " or " STUBS "/installed");
  expect_error("/nowhere/libcsm-good.so", CSM_ERROR_BACKEND_NOT_FOUND, "/nowhere/libcsm-good.so");
  static char endless[2 * PATH_MAX];
  memset(endless, 'a', sizeof endless - 1);
  expect_error(endless, CSM_ERROR_BACKEND_NOT_FOUND, "aaaa");
  memset(endless, '/', sizeof endless - 1);
  expect_error(endless, CSM_ERROR_BACKEND_NOT_FOUND, "////");
}

static void test_versions(void **state) {
  (void)state;
  expect_error("old", CSM_ERROR_BACKEND_TOO_OLD,
               STUBS "/libcsm-old.so is too old: it speaks versions 0 to 1, this csm speaks 2 to 2");
  expect_error("new", CSM_ERROR_BACKEND_TOO_NEW,
               STUBS "/libcsm-new.so is too new: it speaks versions 3 to 7, this csm speaks 2 to 2");
}

static void test_liars(void **state) {
  (void)state;
  const char *const names[] = {"silent", "backwards", "tableless", "gap", "nameless"};
  for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
    char path[PATH_MAX];
    snprintf(path, sizeof path, STUBS "/libcsm-%s.so is broken", names[i]);
    expect_error(names[i], CSM_ERROR_BACKEND_BROKEN, path);
  }
  expect_error("entryless", CSM_ERROR_BACKEND_BROKEN, "has no " GPU_HANDSHAKE_SYMBOL);
}

static void test_not_a_library(void **state) {
  (void)state;
  FILE *text = fopen(in_scratch("libcsm-text.so"), "w");
  assert_non_null(text);
  fputs("This is no library.\n", text);
  fclose(text);
  expect_error(in_scratch("libcsm-text.so"), CSM_ERROR_BACKEND_BROKEN, "libcsm-text.so does not load");

  FILE *empty = fopen(in_scratch("libcsm-empty.so"), "w");
  assert_non_null(empty);
  fclose(empty);
  expect_error(in_scratch("libcsm-empty.so"), CSM_ERROR_BACKEND_BROKEN, "libcsm-empty.so does not load");

  for (size_t size = 512; size <= 8192; size += 1536) { /* the dynamic linker alone would die of the longer ones */
    copy_file(in_scratch("libcsm-cut.so"), STUBS "/libcsm-good.so", size);
    expect_error(in_scratch("libcsm-cut.so"), CSM_ERROR_BACKEND_BROKEN, "libcsm-cut.so does not load");
  }

  assert_int_equal(mkdir(in_scratch("libcsm-folder.so"), 0700), 0);
  expect_error(in_scratch("libcsm-folder.so"), CSM_ERROR_BACKEND_BROKEN, "libcsm-folder.so does not load");
}

static void test_never_the_current_folder(void **state) {
  (void)state;
  copy_file(in_scratch("libcsm-decoy.so"), STUBS "/libcsm-good.so", SIZE_MAX);
  assert_int_equal(access("libcsm-decoy.so", F_OK), 0);
  expect_error("decoy", CSM_ERROR_BACKEND_NOT_FOUND, "libcsm-decoy.so");
  expect_name("./libcsm-decoy.so", "beside"); /* a path says so itself */
}

/* Loaded by a relative path, the loader still knows its folder after a chdir. */
static void test_relative_load(void **state) {
  (void)state;
  assert_int_equal(mkdir(in_scratch("near"), 0700), 0);
  copy_file(in_scratch("near/libprobe.so"), STUBS "/libloader-probe.so", SIZE_MAX);
  copy_file(in_scratch("near/libcsm-near.so"), STUBS "/libcsm-good.so", SIZE_MAX);
  void *probe = dlopen("near/libprobe.so", RTLD_NOW | RTLD_LOCAL);
  assert_non_null(probe);
  assert_int_equal(chdir("/"), 0);
  const void *symbol = dlsym(probe, "loader_open");
  assert_non_null(symbol);
  csm_result (*open_near)(loader_library *, const char *, char *, size_t);
  memcpy(&open_near, &symbol, sizeof open_near);
  loader_library library;
  char error[1024] = "";
  assert_int_equal(open_near(&library, "near", error, sizeof error), CSM_SUCCESS);
  assert_string_equal(library.path, in_scratch("near/libcsm-near.so"));
  loader_close(&library);
  dlclose(probe);
  assert_int_equal(chdir(scratch), 0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_every_pair_of_ranges),
      cmocka_unit_test(test_names),
      cmocka_unit_test(test_path_is_kept),
      cmocka_unit_test(test_wrong_names),
      cmocka_unit_test(test_missing),
      cmocka_unit_test(test_versions),
      cmocka_unit_test(test_liars),
      cmocka_unit_test(test_not_a_library),
      cmocka_unit_test(test_never_the_current_folder),
      cmocka_unit_test(test_relative_load),
  };
  return cmocka_run_group_tests(tests, make_scratch, remove_scratch);
}
