/* recordings.c: breaches in a recording, and what is written down of one. */
#include "null_test.h"

#include <string.h>

/* What is done, and what is told of it. A row finds the images as the rows before it left them. */
typedef struct row {
  void (*act)(fixture *f);
  const char *breach;
} row;

/* ---- pieces of recordings ---- */

static const gpu_rect nothing = {0};

static void clear_level(fixture *f, uint32_t level) {
  gpu_pass_begin(f->g, &(gpu_pass_info){.target = f->level_targets[level], .color_load = GPU_LOAD_CLEAR});
  gpu_pass_end(f->g);
}

static void begin_level_1(fixture *f, gpu_load load) {
  gpu_pass_begin(f->g, &(gpu_pass_info){.target = f->level_1, .color_load = load});
}

static void begin_target(fixture *f) {
  gpu_pass_begin(f->g,
                 &(gpu_pass_info){.target = f->target, .depth_load = GPU_LOAD_CLEAR, .color_load = GPU_LOAD_CLEAR});
}

/* Binds in a pass over level 1. */
static void bind_in_pass(fixture *f, gpu_program *program, gpu_bindings *bindings, const gpu_bindings *stores) {
  gpu_pass_begin(f->g, &(gpu_pass_info){.target = f->level_1, .color_load = GPU_LOAD_CLEAR, .stores = stores});
  gpu_pass_program(f->g, program);
  gpu_pass_bind(f->g, bindings, (const uint32_t[]){0});
  gpu_pass_end(f->g);
}

static const gpu_draw one_triangle = {.count = 3, .instance_count = 1};

static void draw_in_pass(fixture *f, gpu_draw draw) {
  begin_target(f);
  gpu_pass_program(f->g, f->drawing);
  if (!draw.streams[0])
    draw.streams[0] = f->upload;
  gpu_pass_draw(f->g, &draw);
  gpu_pass_end(f->g);
}

static void dispatch(fixture *f, gpu_bindings *bindings, uint32_t groups) {
  gpu_dispatch(f->g, &(gpu_dispatch_info){.program = f->computing,
                                          .bindings = bindings,
                                          .offsets = (const uint32_t[]){0},
                                          .groups = {groups, 1, 1}});
}

static void run_rows(fixture *f, const row *rows, size_t count) {
  for (size_t i = 0; i < count; i++) {
    rows[i].act(f);
    if (strcmp(f->breach, rows[i].breach ? rows[i].breach : ""))
      print_error("row %zu\n", i);
    expect(f, rows[i].breach);
  }
}

/* ---- passes ---- */

static void keeps_the_unwritten(fixture *f) {
  begin_level_1(f, GPU_LOAD_KEEP);
  gpu_pass_end(f->g);
}

static void keeps_the_discarded(fixture *f) {
  begin_level_1(f, GPU_LOAD_DISCARD);
  gpu_pass_end(f->g);
  keeps_the_unwritten(f);
}

static void keeps_what_is_around_the_discarded(fixture *f) {
  clear_level(f, 1);
  gpu_pass_begin(f->g,
                 &(gpu_pass_info){.target = f->level_1, .color_load = GPU_LOAD_DISCARD, .area = {0, 0, WIDTH / 2, 4}});
  gpu_pass_end(f->g);
  keeps_the_unwritten(f);
}

static void reads_the_unwritten(fixture *f) {
  bind_in_pass(f, f->reading, f->reads, NULL);
}

static void reads_the_discarded(fixture *f) {
  clear_level(f, 0);
  gpu_pass_begin(f->g, &(gpu_pass_info){.target = f->level_targets[0], .color_load = GPU_LOAD_DISCARD});
  gpu_pass_end(f->g);
  gpu_make_readable(f->g, f->texture, NULL);
  bind_in_pass(f, f->reading, f->reads, NULL);
}

static void reads_what_is_not_readable(fixture *f) {
  clear_level(f, 0);
  bind_in_pass(f, f->reading, f->reads, NULL);
}

static void reads_another_level(fixture *f) {
  clear_level(f, 0);
  gpu_make_readable(f->g, f->texture, &(gpu_range){0, 1, 0, 1});
  bind_in_pass(f, f->reading, f->reads, NULL);
}

static void reads_its_target(fixture *f) {
  for (uint32_t level = 0; level < LEVELS; level++)
    clear_level(f, level);
  gpu_make_readable(f->g, f->texture, NULL);
  bind_in_pass(f, f->reading, f->reads_all, NULL);
}

static void stores_untold(fixture *f) {
  bind_in_pass(f, f->storing, f->stores, NULL);
}

static void stores_as_told(fixture *f) {
  bind_in_pass(f, f->storing, f->stores, f->stores);
}

static void stores_to_its_target(fixture *f) {
  gpu_pass_begin(f->g, &(gpu_pass_info){.target = f->level_1, .color_load = GPU_LOAD_CLEAR, .stores = f->computes});
  gpu_pass_end(f->g);
}

static void draws_from_what_it_stores(fixture *f) {
  begin_level_1(f, GPU_LOAD_CLEAR);
  gpu_pass_end(f->g);
  gpu_pass_begin(f->g, &(gpu_pass_info){.target = f->level_1, .stores = f->stores});
  gpu_pass_program(f->g, f->storing);
  gpu_pass_bind(f->g, f->stores, NULL);
  gpu_pass_draw(f->g, &(gpu_draw){.streams = {f->device}, .count = 3, .instance_count = 1});
  gpu_pass_end(f->g);
}

static void begins_in_a_pass(fixture *f) {
  begin_target(f);
  begin_target(f);
  gpu_pass_end(f->g);
}

static void begins_beyond(fixture *f) {
  gpu_pass_begin(f->g, &(gpu_pass_info){
                           .target = f->level_1, .color_load = GPU_LOAD_CLEAR, .area = {1, 0, WIDTH / 2, HEIGHT / 2}});
  gpu_pass_end(f->g);
}

static void area_beyond_the_pass(fixture *f) {
  gpu_pass_begin(f->g, &(gpu_pass_info){.target = f->target,
                                        .depth_load = GPU_LOAD_CLEAR,
                                        .color_load = GPU_LOAD_CLEAR,
                                        .area = {8, 8, 16, 16}});
  gpu_pass_area(f->g, &(gpu_rect){8, 8, 16, 17});
  gpu_pass_end(f->g);
}

static void area_within(fixture *f) {
  begin_target(f);
  gpu_pass_area(f->g, &(gpu_rect){1, 2, WIDTH - 1, HEIGHT - 2});
  assert_string_equal(f->command, "area 1 2 63 30");
  gpu_pass_end(f->g);
}

static void area_of_nothing(fixture *f) {
  begin_target(f);
  gpu_pass_area(f->g, &nothing);
  gpu_pass_end(f->g);
}

static void area_wrapped(fixture *f) {
  begin_target(f);
  gpu_pass_area(f->g, &(gpu_rect){UINT32_MAX, 0, 2, 1});
  gpu_pass_end(f->g);
}

static void area_outside(fixture *f) {
  gpu_pass_area(f->g, &nothing);
}

static void program_of_other_formats(fixture *f) {
  begin_level_1(f, GPU_LOAD_CLEAR);
  gpu_pass_program(f->g, f->drawing);
  gpu_pass_end(f->g);
}

static void program_that_computes(fixture *f) {
  begin_level_1(f, GPU_LOAD_CLEAR);
  gpu_pass_program(f->g, f->plain_computing);
  gpu_pass_end(f->g);
}

static void binds_another_shape(fixture *f) {
  bind_in_pass(f, f->drawing_level, f->reads, NULL);
}

/* A program that reads level 0 as f->reading does, but for a sampler or a constant. */
static void binds_beside(fixture *f, gpu_program_info more) {
  gpu_program_info info = null_drawing;
  gpu_program *program = NULL;
  info.depth_format = GPU_FORMAT_NONE;
  info.depth_compare = GPU_COMPARE_NONE;
  info.color_format = GPU_FORMAT_R32_FLOAT;
  info.texture_count = 1;
  info.constants_count = more.constants_count;
  info.constants_sizes[0] = more.constants_sizes[0];
  info.sampler_count = more.sampler_count;
  info.samplers[0] = more.samplers[0];
  gpu_program_create(f->g, &info, &program);
  info.constants_sizes[0] *= 2;
  info.samplers[0] = GPU_SAMPLER_LINEAR_CLAMP;
  gpu_program *other = NULL;
  gpu_program_create(f->g, &info, &other);
  gpu_bindings *bindings = NULL;
  gpu_bindings_create(
      f->g,
      &(gpu_bindings_info){
          .name = "beside", .program = other, .constants = {f->upload}, .texture_views = {f->levels[0]}},
      &bindings);
  bind_in_pass(f, program, bindings, NULL);
  gpu_end(f->g);
  gpu_wait(f->g, 0);
  gpu_bindings_destroy(f->g, bindings);
  gpu_program_destroy(f->g, other);
  gpu_program_destroy(f->g, program);
  gpu_begin(f->g, &(gpu_record_info){.first = true});
}

static void binds_other_samplers(fixture *f) {
  binds_beside(f, (gpu_program_info){.sampler_count = 1, .samplers = {GPU_SAMPLER_POINT_CLAMP}});
}

static void binds_other_constants(fixture *f) {
  binds_beside(f, (gpu_program_info){.constants_count = 1, .constants_sizes = {256}});
}

static void forgets_what_was_bound(fixture *f) {
  clear_level(f, 0);
  gpu_make_readable(f->g, f->texture, &(gpu_range){0, 1, 0, 1});
  begin_level_1(f, GPU_LOAD_CLEAR);
  gpu_pass_program(f->g, f->reading);
  gpu_pass_bind(f->g, f->reads, NULL);
  gpu_pass_program(f->g, f->reading);
  gpu_pass_draw(f->g, &(gpu_draw){.streams = {f->upload}, .count = 3, .instance_count = 1});
  gpu_pass_end(f->g);
}

void test_passes(void **state) {
  static const char unwritten[] = "pass_bind: a texture was never written, or was discarded";
  static const char kept[] = "pass_begin: it keeps what was never written, or was discarded";
  const row rows[] = {
      {keeps_the_unwritten, kept},
      {keeps_the_discarded, kept},
      {keeps_what_is_around_the_discarded, NULL},
      {reads_the_unwritten, unwritten},
      {reads_the_discarded, unwritten},
      {reads_what_is_not_readable, "pass_bind: a texture is not readable: make_readable goes before the pass"},
      {reads_another_level, NULL},
      {reads_its_target, "pass_bind: a texture is the pass's target"},
      {stores_untold, "pass_bind: it stores to what pass_begin was not told of"},
      {stores_as_told, NULL},
      {stores_to_its_target, "pass_begin: it stores to its target"},
      {draws_from_what_it_stores, "pass_draw: it reads a buffer that the pass stores to"},
      {begins_in_a_pass, "pass_begin: not between begin and end, or in a pass"},
      {begins_beyond, "pass_begin: beyond the target, or empty"},
      {area_beyond_the_pass, "pass_area: beyond the pass's area, or empty"},
      {area_within, NULL},
      {area_of_nothing, "pass_area: beyond the pass's area, or empty"},
      {area_wrapped, "pass_area: beyond the pass's area, or empty"},
      {area_outside, "pass_area: no pass is open"},
      {program_of_other_formats, "pass_program: made for targets of other formats"},
      {program_that_computes, "pass_program: the program computes"},
      {binds_another_shape, "pass_bind: no pass is open, or bindings of a program of another shape"},
      {binds_other_samplers, "pass_bind: no pass is open, or bindings of a program of another shape"},
      {binds_other_constants, "pass_bind: no pass is open, or bindings of a program of another shape"},
      {forgets_what_was_bound, "pass_draw: nothing is bound"},
  };
  run_rows(*state, rows, COUNT_OF(rows));
}

/* ---- draws and dispatches ---- */

static void draws(fixture *f) {
  draw_in_pass(f, one_triangle);
}

static void draws_nothing(fixture *f) {
  draw_in_pass(f, (gpu_draw){.count = 3});
}

static void draws_from_readback(fixture *f) {
  draw_in_pass(f, (gpu_draw){.streams = {f->readback}, .count = 3, .instance_count = 1});
}

static void draws_odd_indices(fixture *f) {
  draw_in_pass(f, (gpu_draw){.indices = f->device, .index_size = 3, .count = 3, .instance_count = 1});
}

static void draws_indices_beyond(fixture *f) {
  draw_in_pass(
      f, (gpu_draw){
             .indices = f->device, .index_offset = BUFFER_SIZE - 4, .index_size = 2, .count = 3, .instance_count = 1});
}

static void draws_arguments(fixture *f) {
  draw_in_pass(f, (gpu_draw){.arguments = f->other, .arguments_offset = BUFFER_SIZE - 16});
}

static void draws_arguments_beyond(fixture *f) {
  draw_in_pass(
      f,
      (gpu_draw){.indices = f->device, .index_size = 4, .arguments = f->other, .arguments_offset = BUFFER_SIZE - 16});
}

static void draws_arguments_of_no_use(fixture *f) {
  draw_in_pass(f, (gpu_draw){.arguments = f->upload});
}

static void draws_arguments_and_an_offset(fixture *f) {
  draw_in_pass(f, (gpu_draw){.indices = f->device, .index_size = 4, .index_offset = 4, .arguments = f->other});
}

static void dispatches(fixture *f) {
  clear_level(f, 0);
  dispatch(f, f->computes, 1);
}

static void dispatches_from_the_unwritten(fixture *f) {
  dispatch(f, f->computes, 1);
}

static void dispatches_in_a_pass(fixture *f) {
  clear_level(f, 0);
  begin_target(f);
  dispatch(f, f->computes, 1);
  gpu_pass_end(f->g);
}

static void dispatches_no_groups(fixture *f) {
  clear_level(f, 0);
  dispatch(f, f->computes, 0);
}

static void dispatches_unbound(fixture *f) {
  dispatch(f, NULL, 1);
}

static void dispatches_another_shape(fixture *f) {
  dispatch(f, f->reads, 1);
}

static void dispatches_a_drawing(fixture *f) {
  gpu_dispatch(f->g, &(gpu_dispatch_info){.program = f->drawing, .groups = {1, 1, 1}});
}

static void dispatches_its_own_arguments(fixture *f) {
  clear_level(f, 0);
  gpu_dispatch(f->g, &(gpu_dispatch_info){.program = f->computing,
                                          .bindings = f->computes,
                                          .offsets = (const uint32_t[]){0},
                                          .arguments = f->device});
}

static void dispatches_arguments_beyond(fixture *f) {
  gpu_dispatch(f->g, &(gpu_dispatch_info){
                         .program = f->plain_computing, .arguments = f->device, .arguments_offset = BUFFER_SIZE - 8});
}

static void dispatches_constants_beyond(fixture *f) {
  clear_level(f, 0);
  gpu_dispatch(f->g, &(gpu_dispatch_info){.program = f->computing,
                                          .bindings = f->computes,
                                          .offsets = (const uint32_t[]){BUFFER_SIZE},
                                          .groups = {1, 1, 1}});
}

/* What a dispatch stored to is written, but no texture until it is made one. */
static void reads_what_a_dispatch_wrote(fixture *f) {
  clear_level(f, 0);
  dispatch(f, f->computes, 1);
  clear_level(f, 2);
  gpu_make_readable(f->g, f->texture, &(gpu_range){0, 1, 0, 0});
  gpu_copy_image(f->g, f->readback, 0, 256, f->texture, &(gpu_region){.width = 32, .height = 16, .level = 1});
}

void test_commands(void **state) {
  const row rows[] = {
      {draws, NULL},
      {draws_nothing, "pass_draw: draws nothing"},
      {draws_from_readback, "pass_draw: from a readback buffer"},
      {draws_odd_indices, "pass_draw: index_size is not 2 or 4"},
      {draws_indices_beyond, "pass_draw: indices beyond the buffer's end"},
      {draws_arguments, NULL},
      {draws_arguments_beyond, "pass_draw: no arguments, or beyond their end"},
      {draws_arguments_of_no_use, "pass_draw: no arguments, or beyond their end"},
      {draws_arguments_and_an_offset, "pass_draw: arguments beside an index_offset"},
      {dispatches_from_the_unwritten, "dispatch: a texture was never written, or was discarded"},
      {dispatches, NULL},
      {dispatches_in_a_pass, "dispatch: not between begin and end, or in a pass"},
      {dispatches_no_groups, "dispatch: no groups, or over 65535"},
      {dispatches_unbound, "dispatch: nothing is bound"},
      {dispatches_another_shape, "dispatch: bindings of a program of another shape"},
      {dispatches_a_drawing, "dispatch: the program draws"},
      {dispatches_its_own_arguments, "dispatch: it writes its own arguments"},
      {dispatches_arguments_beyond, "dispatch: no arguments, or beyond their end"},
      {dispatches_constants_beyond, "constants: beyond the buffer's end"},
      {reads_what_a_dispatch_wrote, NULL},
  };
  run_rows(*state, rows, COUNT_OF(rows));
}

/* ---- copies and clears ---- */

typedef struct copy_row {
  gpu_image *image;
  uint64_t offset;
  gpu_region region;
  const char *breach;
} copy_row;

static void test_copies_out(fixture *f) {
  const copy_row rows[] = {
      {f->color, 512, {0, 1, 2, 3, 4, 0}, NULL},
      {f->depth, 0, {1, 0, 0, WIDTH, HEIGHT, 0}, NULL},
      {f->texture, 0, {0, 1, 0, 31, 16, 1}, NULL},
      {f->depth, 0, {1, 0, 0, WIDTH, HEIGHT - 1, 0}, "copy_image: a part of a layer of depths"},
      {f->color, 0, {1, 0, 0, 1, 1, 0}, "copy_image: no such layer or level"},
      {f->texture, 0, {0, 0, 0, 1, 1, LEVELS}, "copy_image: no such layer or level"},
      {f->color, 0, {0, WIDTH, 0, 1, 1, 0}, "copy_image: beyond the image, or empty"},
      {f->color, 0, {0, 0, HEIGHT - 1, 1, 2, 0}, "copy_image: beyond the image, or empty"},
      {f->texture, 0, {0, 0, 0, 33, 1, 1}, "copy_image: beyond the image, or empty"},
      {f->color, 0, {0, 0, 0, 1, 0, 0}, "copy_image: beyond the image, or empty"},
      {f->color, 256, {0, 0, 0, 1, 1, 0}, "copy_image: offset is not a multiple of 512"},
      {f->color, BUFFER_SIZE, {0, 0, 0, 1, 1, 0}, "copy_image: beyond a row's or the buffer's end"},
      {f->texture, 0, {1, 0, 0, 1, 1, 0}, "copy_image: what was never written, or was discarded"},
  };
  for (size_t i = 0; i < COUNT_OF(rows); i++) {
    gpu_copy_image(f->g, f->readback, rows[i].offset, 512, rows[i].image, &rows[i].region);
    expect(f, rows[i].breach);
  }
  gpu_copy_image(f->g, f->readback, 512, 512, f->color, &(gpu_region){0, 1, 2, 3, 4, 0});
  assert_string_equal(f->command, "copy_image readback 512 512 colour 0 0 1 2 3 4");
  gpu_copy_image(f->g, f->device, 0, 512, f->color, &(gpu_region){0, 0, 0, 1, 1, 0});
  expect(f, "copy_image: to no readback buffer");
}

static void test_copies_in(fixture *f) {
  const copy_row rows[] = {
      {f->texture, 0, {1, 3, 4, 5, 6, 1}, NULL},
      {f->texture, 0, {1, 0, 0, 33, 1, 1}, "copy_to_image: beyond the image, or empty"},
      {f->texture, 0, {LAYERS, 0, 0, 1, 1, 0}, "copy_to_image: no such layer or level"},
      {f->texture, 100, {0, 0, 0, 1, 1, 0}, "copy_to_image: offset is not a multiple of 512"},
      {f->color, 0, {0, 0, 0, 1, 1, 0}, "copy_to_image: the image is not made to be copied to"},
  };
  for (size_t i = 0; i < COUNT_OF(rows); i++) {
    gpu_copy_to_image(f->g, rows[i].image, &rows[i].region, f->upload, rows[i].offset, 512);
    expect(f, rows[i].breach);
  }
  gpu_copy_to_image(f->g, f->texture, &rows[0].region, f->device, 0, 512);
  expect(f, "copy_to_image: from no upload buffer");
}

static void test_buffer_copies(fixture *f) {
  gpu_copy_buffer(f->g, f->device, 0, f->upload, 0, 16);
  expect(f, NULL);
  gpu_copy_buffer(f->g, f->device, 0, f->device, 64, 16);
  expect(f, "copy_buffer: from a buffer to itself");
  gpu_copy_buffer(f->g, f->upload, 0, f->device, 0, 16);
  expect(f, "copy_buffer: to an upload buffer, or from a readback buffer");
  gpu_copy_buffer(f->g, f->device, BUFFER_SIZE - 8, f->upload, 0, 16);
  expect(f, "copy_buffer: beyond a buffer's end, or empty");
}

void test_recordings(void **state) {
  fixture *f = *state;
  gpu_clear_depth(f->g, f->depth, 0);
  assert_string_equal(f->command, "clear_depth depth 0");
  expect(f, NULL);
  gpu_clear_depth(f->g, f->color, 0);
  expect(f, "clear_depth: the image has no depths");
  gpu_make_readable(f->g, f->texture, &(gpu_range){0, 1, LEVELS, 1});
  expect(f, "make_readable: no such layers or levels");
  gpu_pass_begin(
      f->g, &(gpu_pass_info){
                .target = f->target, .color_load = GPU_LOAD_CLEAR, .clear_color = {0.5f, 1}, .area = {1, 2, 3, 4}});
  assert_string_equal(f->command, "pass_begin target depth keep colour 0.5 1 0 0 area 1 2 3 4");
  gpu_pass_end(f->g);
  expect(f, NULL);
  clear_level(f, 1);
  test_copies_out(f);
  test_copies_in(f);
  test_buffer_copies(f);
}

/* ---- timestamps, markers and slots ---- */

static void stamps(fixture *f) {
  gpu_timestamp(f->g, 3);
}

static void stamps_beyond(fixture *f) {
  gpu_timestamp(f->g, GPU_MAX_TIMESTAMPS);
}

static void stamps_in_a_pass(fixture *f) {
  begin_target(f);
  gpu_timestamp(f->g, 4);
  gpu_pass_end(f->g);
}

static void marks_in_a_pass(fixture *f) {
  begin_target(f);
  gpu_marker_begin(f->g, "pass");
  gpu_pass_end(f->g);
  gpu_marker_end(f->g);
}

static void ends_no_marker(fixture *f) {
  gpu_marker_end(f->g);
}

static void again(fixture *f, bool first) {
  gpu_end(f->g);
  gpu_begin(f->g, &(gpu_record_info){.first = first});
}

static void ends_with_a_marker(fixture *f) {
  gpu_marker_begin(f->g, "open");
  again(f, false);
}

static void stamps_again_in_a_frame(fixture *f) {
  again(f, false);
  gpu_timestamp(f->g, 3);
}

static void stamps_in_the_next_frame(fixture *f) {
  again(f, true);
  gpu_timestamp(f->g, 3);
}

static void stamps_outside(fixture *f) {
  gpu_end(f->g);
  gpu_timestamp(f->g, 5);
  gpu_begin(f->g, &(gpu_record_info){.first = false});
}

static void begins_in_no_slot(fixture *f) {
  gpu_end(f->g);
  gpu_begin(f->g, &(gpu_record_info){.slot = 1});
}

static void waits_for_no_slot(fixture *f) {
  gpu_wait(f->g, 1);
}

static void reads_its_stamp(fixture *f) {
  uint64_t nanoseconds[2];
  assert_int_equal(gpu_timestamps(f->g, 0, 3, 1, nanoseconds), CSM_SUCCESS);
  assert_int_equal(nanoseconds[0], 3000000);
}

static void reads_more_stamps(fixture *f) {
  uint64_t nanoseconds[2];
  gpu_timestamps(f->g, 0, 3, 2, nanoseconds);
}

void test_stamps(void **state) {
  const row rows[] = {
      {stamps, NULL},
      {stamps, "timestamp: taken before in this frame"},
      {stamps_beyond, "timestamp: no such index"},
      {stamps_again_in_a_frame, "timestamp: taken before in this frame"},
      {stamps_in_the_next_frame, NULL},
      {reads_its_stamp, NULL},
      {reads_more_stamps, "timestamps: one was not taken"},
      {stamps_in_a_pass, "timestamp: not between begin and end, or in a pass"},
      {stamps_outside, "timestamp: not between begin and end, or in a pass"},
      {marks_in_a_pass, "marker_begin: not between begin and end, or in a pass"},
      {ends_no_marker, "marker_end: no marker is open"},
      {ends_with_a_marker, "end: a marker is open"},
      {begins_in_no_slot, "begin: no such slot"},
      {waits_for_no_slot, "wait: no such slot"},
  };
  run_rows(*state, rows, COUNT_OF(rows));
}

/* ---- what a recording uses ---- */

/* Destroyed while a recording is open, or in flight; and when it is waited for. */
void test_lives(void **state) {
  fixture *f = *state;
  gpu_buffer *buffers[3] = {NULL};
  for (size_t i = 0; i < COUNT_OF(buffers); i++) {
    gpu_buffer_create(f->g, &(gpu_buffer_info){.name = "b", .kind = GPU_BUFFER_DEVICE, .size = 16}, &buffers[i]);
    gpu_copy_buffer(f->g, buffers[i], 0, f->upload, 0, 16);
  }
  gpu_buffer_destroy(f->g, buffers[0]);
  expect(f, "buffer_destroy: a recording uses it");
  clear_level(f, 0);
  gpu_make_readable(f->g, f->texture, NULL);
  bind_in_pass(f, f->reading, f->reads, NULL);
  expect(f, NULL);
  gpu_bindings_write(f->g, f->reads, &(gpu_bindings_info){.program = f->reading, .texture_views = {f->levels[0]}});
  expect(f, "bindings_write: a recording uses them");
  gpu_end(f->g);
  gpu_buffer_destroy(f->g, buffers[1]);
  expect(f, "buffer_destroy: a recording uses it");
  gpu_wait(f->g, 0);
  gpu_buffer_destroy(f->g, buffers[2]);
  expect(f, NULL);
  gpu_begin(f->g, &(gpu_record_info){.first = true});
}
