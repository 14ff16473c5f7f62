/*
 * null.h: what the files of the null backend share. It draws nothing, and writes a line to the host's log for every
 * command, at CSM_LOG_TRACE, so that tests read what a frame records. Buffers are real memory. A breach of gpu.h's
 * rules is logged at CSM_LOG_ERROR.
 */
#ifndef CSM_BACKEND_NULL_H
#define CSM_BACKEND_NULL_H

#include "gpu.h"

enum { NULL_MAX_SLOTS = 8, NULL_NAME_SIZE = 64, NULL_OFFSET_ALIGNMENT = 256, NULL_PLACEMENT_ALIGNMENT = 512 };

/* How a {layer, level} is used, or was last. */
typedef enum null_use { NULL_UNUSED, NULL_READABLE, NULL_TARGET, NULL_COPIED, NULL_STORED } null_use;

typedef struct null_piece {
  null_use use;
  bool defined; /* it was written, and not discarded since */
} null_piece;

/* The recordings are numbered from 1; the last one that used an object, or 0. */
typedef uint64_t null_used;

struct gpu_buffer {
  null_used used;
  char name[NULL_NAME_SIZE];
  gpu_buffer_info info;
  uint8_t *memory;
};

struct gpu_image {
  null_used used;
  char name[NULL_NAME_SIZE];
  gpu_image_info info;
  gpu_image *next_touched; /* in the current recording */
  bool touched;
  null_piece pieces[]; /* by layer, then level */
};

struct gpu_view {
  null_used used;
  gpu_image *image;
  gpu_range range; /* without counts of 0 */
};

struct gpu_target {
  null_used used;
  char name[NULL_NAME_SIZE];
  gpu_target_info info;
  uint32_t width, height;
};

struct gpu_program {
  null_used used;
  char name[NULL_NAME_SIZE];
  gpu_program_info info;
};

struct gpu_bindings {
  null_used used;
  char name[NULL_NAME_SIZE];
  gpu_bindings_info info;
};

/* A frame in flight. */
typedef struct null_slot {
  null_used in_flight; /* its last recording, until that is waited for */
  uint64_t taken;      /* bit k: timestamp k of its frame */
} null_slot;

struct gpu_device {
  gpu_host host;
  uint32_t slot_count;
  null_slot slots[NULL_MAX_SLOTS];
  bool recording, in_pass, bound;
  uint32_t slot; /* of the current recording, like the next */
  uint32_t open_markers;
  null_used serial;
  gpu_image *touched;
  /* of the pass that is open */
  gpu_pass_info pass;
  gpu_rect area;
  const gpu_program *program;
};

/* ---- backend.c ---- */
__attribute__((format(printf, 2, 3))) void null_record(gpu_device *device, const char *format, ...);
/* Tells of a breach unless the rule is kept; gives `kept` back. */
bool null_require(gpu_device *device, bool kept, const char *rule);
/* The current recording uses an object. */
void null_use_now(const gpu_device *device, null_used *used);
/* Tells of a breach if a recording that is open, or in flight, uses an object that is destroyed or written. */
void null_require_unused(gpu_device *device, null_used used, const char *rule);
void *null_make(gpu_device *device, size_t size); /* zeroed */
void null_release(gpu_device *device, void *object);
void null_set_name(char to[NULL_NAME_SIZE], const char *name);
void null_describe(const gpu_device *device, gpu_device_info *out);

/* ---- resource.c ---- */
/* Whether a piece of a width, a height or a count lies in it, and is one. */
bool null_spans(uint32_t size, uint32_t first, uint32_t count);
bool null_holds(const gpu_buffer *buffer, uint64_t offset, uint64_t size);
uint32_t null_levels(const gpu_image *image);
/* The range without counts of 0; NULL is all of the image. */
gpu_range null_range(const gpu_image *image, const gpu_range *range);
bool null_overlap(const gpu_range *a, const gpu_range *b);
null_piece *null_piece_at(gpu_image *image, uint32_t layer, uint32_t level);

csm_result null_buffer_create(gpu_device *device, const gpu_buffer_info *info, gpu_buffer **out);
void null_buffer_destroy(gpu_device *device, gpu_buffer *buffer);
void *null_buffer_memory(gpu_buffer *buffer);
uint64_t null_buffer_native(const gpu_buffer *buffer);
csm_result null_image_create(gpu_device *device, const gpu_image_info *info, gpu_image **out);
void null_image_destroy(gpu_device *device, gpu_image *image);
uint64_t null_image_bytes(const gpu_image *image);
void null_image_native(const gpu_device *device, const gpu_image *image, gpu_native_image *out);
void null_image_describe(gpu_device *device, const gpu_image *image, uint64_t descriptor);
csm_result null_image_import(gpu_device *device, const void *native, gpu_texels texels, gpu_image **out,
                             gpu_imported *about);
csm_result null_geometry_import(gpu_device *device, const void *native, gpu_geometry *out);
csm_result null_view_create(gpu_device *device, const gpu_view_info *info, gpu_view **out);
void null_view_destroy(gpu_device *device, gpu_view *view);
csm_result null_target_create(gpu_device *device, const gpu_target_info *info, gpu_target **out);
void null_target_destroy(gpu_device *device, gpu_target *target);
csm_result null_target_native(gpu_device *device, gpu_format depth, gpu_format color, gpu_native_target *out);

/* ---- program.c ---- */
bool null_same_shape(const gpu_program *a, const gpu_program *b);
/* What bindings have at t0 and on, as a view of a range. */
gpu_view null_texture(const gpu_bindings *bindings, uint32_t index);
csm_result null_program_create(gpu_device *device, const gpu_program_info *info, gpu_program **out);
void null_program_destroy(gpu_device *device, gpu_program *program);
csm_result null_bindings_create(gpu_device *device, const gpu_bindings_info *info, gpu_bindings **out);
void null_bindings_write(gpu_device *device, gpu_bindings *bindings, const gpu_bindings_info *info);
void null_bindings_destroy(gpu_device *device, gpu_bindings *bindings);

/* ---- record.c: what stands outside passes ---- */
csm_result null_begin(gpu_device *device, const gpu_record_info *info);
void null_marker_begin(gpu_device *device, const char *name);
void null_marker_end(gpu_device *device);
void null_timestamp(gpu_device *device, uint32_t index);
void null_copy_buffer(gpu_device *device, gpu_buffer *to, uint64_t to_offset, gpu_buffer *from, uint64_t from_offset,
                      uint64_t size);
void null_copy_image(gpu_device *device, gpu_buffer *to, uint64_t offset, uint32_t row_bytes, gpu_image *image,
                     const gpu_region *from);
void null_copy_to_image(gpu_device *device, gpu_image *image, const gpu_region *to, gpu_buffer *from, uint64_t offset,
                        uint32_t row_bytes);
void null_clear_depth(gpu_device *device, gpu_image *image, float depth);
void null_make_readable(gpu_device *device, gpu_image *image, const gpu_range *range);
void null_dispatch(gpu_device *device, const gpu_dispatch_info *info);
csm_result null_end(gpu_device *device);
csm_result null_wait(gpu_device *device, uint32_t slot);
csm_result null_timestamps(gpu_device *device, uint32_t slot, uint32_t first, uint32_t count, uint64_t *nanoseconds);
/* Checks what a draw or dispatch reads arguments from; `words` is how many there are. */
void null_check_arguments(gpu_device *device, const gpu_buffer *buffer, uint64_t offset, uint32_t words,
                          const char *rule);
/* Offsets of constants, and where each reaches to. */
void null_check_offsets(gpu_device *device, const gpu_bindings *bindings, const uint32_t *offsets);
void null_touch(gpu_device *device, gpu_image *image);
/* Bindings are used, and all that they bind. */
void null_use_bindings(const gpu_device *device, gpu_bindings *bindings);

/* ---- pass.c ---- */
void null_pass_begin(gpu_device *device, const gpu_pass_info *info);
void null_pass_area(gpu_device *device, const gpu_rect *area);
void null_pass_end(gpu_device *device);
void null_pass_program(gpu_device *device, gpu_program *program);
void null_pass_bind(gpu_device *device, gpu_bindings *bindings, const uint32_t *offsets);
void null_pass_draw(gpu_device *device, const gpu_draw *draw);
void null_pass_native(gpu_device *device, gpu_native_pass *out);

#endif
