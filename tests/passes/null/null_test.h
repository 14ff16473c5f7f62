/* null_test.h: what the tests of the null backend share: a device with an object of each kind, and what it told. */
#ifndef NULL_TEST_H
#define NULL_TEST_H

#include "gpu_calls.h"

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

enum { WIDTH = 64, HEIGHT = 32, LAYERS = 2, LEVELS = 3, BUFFER_SIZE = 1 << 16 };

#define COUNT_OF(array) (sizeof(array) / sizeof *(array))

typedef struct fixture {
  gpu_host host;
  gpu g;
  gpu_image *depth, *color, *texture;         /* the texture has levels, is sampled, stored to, drawn into and copied */
  gpu_view *levels[LEVELS];                   /* of the texture */
  gpu_target *target, *level_targets[LEVELS]; /* depth and colour; levels of the texture */
  gpu_target *level_1;                        /* one of these */
  gpu_buffer *upload, *device, *other, *readback;
  gpu_program *drawing, *drawing_level, *reading, *storing, *computing, *plain_computing;
  gpu_bindings *reads, *reads_all, *stores, *computes;
  char command[256], breach[256]; /* the last command, and the first breach */
} fixture;

extern const gpu_program_info null_drawing, null_computing;

/* The first breach told since the last call, or none for NULL. */
void expect(fixture *f, const char *breach);

/* Each a test of cmocka's: of objects, and of recordings. */
void test_buffers(void **state); /* objects.c */
void test_images(void **state);
void test_views(void **state);
void test_targets(void **state);
void test_programs(void **state);
void test_bindings(void **state);
void test_capabilities(void **state);
void test_recordings(void **state); /* recordings.c */
void test_passes(void **state);
void test_commands(void **state);
void test_stamps(void **state);
void test_lives(void **state);

#endif
