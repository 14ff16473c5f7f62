/*
 * context.h: what the front keeps. One file for each thing that a context owns: memory.c, retire.c, geometry.c (meshes
 * in pages), ring.c (memory that changes per frame), cascades.c (settings and maps), frame.c, mask.c.
 */
#ifndef CONTEXT_H
#define CONTEXT_H

#include "loader.h"
#include "passes/passes.h"
#include "structs.h"

enum { CONTEXT_MAX_SLOTS = 8, CONTEXT_FILTERS = 2 };

/* ---- things that are freed once the GPU is done with them ---- */

typedef struct retired {
  struct retired *next;
  uint64_t serial; /* the last recording that may use it */
  void (*destroy)(csm_context *context, struct retired *self);
} retired;

/* ---- geometry ---- */

typedef struct mesh_slot {
  uint32_t generation; /* of the handle; even: free */
  uint32_t next_free;
  struct geometry_range *range;
} mesh_slot;

typedef struct geometry {
  struct geometry_page *pages;
  struct geometry_staging *staging; /* newest first */
  struct geometry_upload *uploads;  /* not yet recorded */
  mesh_slot *slots;
  pass_mesh *meshes;   /* by slot, as passes want them */
  plan_bounds *bounds; /* by slot, as the plan wants them */
  uint32_t slot_count, slot_capacity, first_free;
  uint64_t bytes;
} geometry;

/* ---- the ring ---- */

typedef struct ring_range {
  gpu_buffer *buffer;
  uint64_t offset;
  void *memory;
} ring_range;

typedef struct ring_slot {
  gpu_buffer *buffer;
  uint64_t size, used;
} ring_slot;

/* What a slot's last recording measured, and for whom; read when the slot is next waited for. */
typedef struct slot_timing {
  csm_cascades *cascades; /* NULL: nothing */
  uint32_t count;
  bool mask;
} slot_timing;

/* ---- the context ---- */

struct csm_context {
  csm_allocate_function allocate;
  csm_release_function release;
  csm_log_function log;
  void *user;
  gpu_host host; /* what the device was lent: must not move */

  loader_library library;
  pass_gpu gpu;
  gpu_device_info info;
  uint64_t memory_limit, memory_used;
  bool lost;
  char error[512];

  uint32_t slot_count;
  uint64_t serial; /* of the newest recording; recording s uses slot s % slot_count */
  ring_slot ring[CONTEXT_MAX_SLOTS];
  slot_timing timing[CONTEXT_MAX_SLOTS];
  retired *retired;

  geometry geometry;
  csm_cascades *cascades; /* all of them */
  gpu_program *cascade_program;
  gpu_program *camera_programs[2]; /* plain, reversed */
  gpu_program *mask_programs[CONTEXT_FILTERS];

  void *scratch; /* instances that a mask's camera sees */
  size_t scratch_size;
};

/* ---- errors.c ---- */

/* Records and logs an error, marks the context lost if it says so, and returns `result`. */
csm_result context_fail(csm_context *context, csm_result result, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
/* context_fail for a result of a backend's, with the name of what was tried; CSM_SUCCESS passes through. */
csm_result context_check(csm_context *context, csm_result result, const char *what);
/* context_fail for a struct that struct_read or struct_check refused. */
csm_result context_check_struct(csm_context *context, csm_result result, const char *name);
/* DEVICE_LOST once the context is lost. */
csm_result context_usable(csm_context *context);

/* ---- memory.c ---- */

void *context_allocate(csm_context *context, size_t size); /* zeroed; fails with an error set */
void context_release(csm_context *context, void *memory);
/* Makes *memory at least `size` bytes, losing what it held; keeps it as it was on failure. */
csm_result context_grow(csm_context *context, void **memory, size_t *capacity, size_t size);

/* Device objects, counted against the memory limit. */
csm_result context_buffer(csm_context *context, const gpu_buffer_info *info, gpu_buffer **out);
void context_buffer_free(csm_context *context, gpu_buffer *buffer, uint64_t size);
csm_result context_image(csm_context *context, const gpu_image_info *info, gpu_image **out);
void context_image_free(csm_context *context, gpu_image *image);

/* ---- retire.c ---- */

/* Hands a thing over to be destroyed once every recording made so far is done. */
void retire(csm_context *context, retired *thing, void (*destroy)(csm_context *, retired *));
/* Destroys what no recording up to `serial` uses any more. */
void retire_collect(csm_context *context, uint64_t serial);

/* ---- recording.c ---- */

/*
 * Waits for the slot of the next recording, and reserves `ring_size` bytes of its ring. Nothing is recorded yet, so a
 * failure leaves everything as it was.
 */
csm_result recording_prepare(csm_context *context, uint64_t ring_size, ring_range *range);
/* Begins the prepared recording, with the uploads that are due. */
csm_result recording_begin(csm_context *context);
csm_result recording_end(csm_context *context);
/* The slot of the newest recording. */
uint32_t recording_slot(const csm_context *context);
/* Waits until every recording is done, and takes over what they measured. */
csm_result recording_finish(csm_context *context);
void recording_destroy(csm_context *context);

/* ---- geometry.c ---- */

/* Index of a live mesh, or UINT32_MAX. */
uint32_t geometry_find(const geometry *geometry, csm_mesh mesh);
/* Records the copies of meshes that are not uploaded yet; their staging memory goes with this recording. */
void geometry_record(csm_context *context);
void geometry_destroy(csm_context *context);

/* ---- scene.c ---- */

/* Bytes that scene_read needs for so many instances. */
size_t scene_size(uint32_t instance_count);
/* Checks a frame's instances and copies them into `memory`. */
csm_result scene_read(csm_context *context, const csm_frame *frame, void *memory, plan_scene *scene);
/* Reads and checks a frame's struct but for its instances. */
csm_result frame_read(csm_context *context, const csm_frame *in, csm_frame *out);

#endif
