/*
 * device.h: one opened backend with everything that lies on it. A context has one, and for a while those that it was
 * switched away from. One file for each thing that a device owns: device.c (itself and its programs), memory.c,
 * retire.c, recording.c (slots and the ring, which is memory that changes per frame), geometry.c (meshes in pages).
 */
#ifndef DEVICE_H
#define DEVICE_H

#include "loader.h"
#include "passes/passes.h"

enum { DEVICE_MAX_SLOTS = 8, DEVICE_MAX_TIMINGS = 8, DEVICE_MAX_SHAPES = 32 };

typedef struct device device;

/* ---- things that are freed once the GPU is done with them ---- */

typedef struct retired {
  struct retired *next;
  uint64_t serial; /* the last frame that may use it */
  void (*destroy)(device *device, struct retired *self);
} retired;

/* ---- geometry ---- */

/* By mesh slot of the context, as are its bounds. */
typedef struct geometry {
  struct geometry_page *pages;
  struct geometry_staging *staging; /* newest first */
  struct geometry_upload *uploads;  /* not yet recorded */
  struct geometry_place **places;   /* where each mesh lies; NULL: nowhere */
  pass_mesh *meshes;                /* as passes want them */
  uint32_t capacity;
  uint64_t bytes;
} geometry;

/* Shapes of vertices, and the programs that draw each into a camera's depth. The first is that of copied opaque meshes.
 */
typedef struct depth_programs {
  uint32_t count;
  pass_vertices vertices[DEVICE_MAX_SHAPES];
  gpu_program *camera[2][DEVICE_MAX_SHAPES]; /* plain, reversed */
} depth_programs;

/* Programs that draw casters as some cascades' configuration has them drawn. */
typedef struct caster_programs {
  retired retired;
  struct caster_programs *next;
  uint32_t users;
  pass_casters casters;
  gpu_program *programs[3][DEVICE_MAX_SHAPES]; /* by gpu_cull */
} caster_programs;

/* An alpha mask, by slot of the context. */
typedef struct alpha_mask_image alpha_mask_image;
typedef struct alpha_mask_images {
  alpha_mask_image **images;
  uint32_t capacity;
  uint32_t due; /* that are not uploaded yet */
} alpha_mask_images;

/* ---- recordings ---- */

typedef struct ring_range {
  gpu_buffer *buffer;
  uint64_t offset;
  void *memory;
} ring_range;

typedef struct ring_buffer {
  retired retired;
  gpu_buffer *buffer;
  uint64_t size, used;
} ring_buffer;

/* What a recording measured, and for whom. */
typedef struct timing {
  csm_cascades *cascades;
  uint32_t first, count; /* of its timestamps */
  bool mask;
} timing;

/* A frame in flight. On an own device every recording is one. */
typedef struct frame_slot {
  uint64_t serial;   /* the frame that used it last */
  ring_buffer *ring; /* NULL: none yet */
  uint32_t stamps;   /* timestamps taken */
  uint32_t timing_count;
  timing timings[DEVICE_MAX_TIMINGS];
} frame_slot;

/* The frame that the next recording belongs to. */
typedef struct next_frame {
  uint64_t serial;
  uint32_t slot;
  bool fresh; /* its first recording */
} next_frame;

/* As many as the table of variants can ask for, and a view. */
enum { MASK_KEYS = 128 };

typedef struct mask_entry {
  uint64_t key;
  gpu_program *program;
} mask_entry;

struct device {
  csm_context *context; /* whose callbacks and errors it uses */
  device *next;         /* of those switched away from */
  gpu_host host;        /* what the backend was lent: must not move */
  loader_library library;
  pass_gpu gpu;
  gpu_device_info info;
  bool own; /* else an engine's */
  bool lost;
  uint64_t memory_limit, memory_used;

  uint32_t slot_count, slot; /* the current one */
  uint64_t serial;           /* of the newest frame */
  uint64_t done;             /* frames up to this one are done */
  next_frame prepared;
  frame_slot slots[DEVICE_MAX_SLOTS];
  retired *retired;

  geometry geometry;
  alpha_mask_images alpha_masks;
  depth_programs programs;
  caster_programs *casters;
  mask_entry masks[MASK_KEYS]; /* what configurations and views have asked for */
  uint32_t mask_count;
  gpu_program *tiles_programs[2];         /* small and large tiles; likewise */
};

/* ---- device.c ---- */

/* Opens the backend that `info` names, which is checked; *out is NULL after an error, whose text the context has. */
csm_result device_open(csm_context *context, const csm_create_info *info, device **out);
/* Destroys everything at once. The GPU must be done with it, or be lost; an own one is waited for. */
void device_close(device *device);
/* The index of the programs for vertices, made if they are not there. Errors: those of creation, LIMIT_EXCEEDED. */
csm_result device_programs(device *device, pass_vertices vertices, uint32_t *index);
/* Makes the programs that masks of a configuration need, where they are not there. Errors: those of creation. */
csm_result device_mask_programs(device *device, const csm_config *config);
/* The program of a key that was made, or NULL. */
gpu_program *device_mask_program(const device *device, uint64_t key);
/* Likewise the one that draws views of the mask. */
csm_result device_view_program(device *device);

/* ---- caster_programs.c ---- */

/* The programs for a configuration, made if no cascades have them; to be given back. Errors: those of creation. */
csm_result caster_programs_take(device *device, const csm_config *config, caster_programs **out);
/* NULL is allowed. */
void caster_programs_give_back(device *device, caster_programs *programs);
csm_result caster_programs_add_shape(device *device, caster_programs *programs, uint32_t shape);
void caster_programs_remove_shape(device *device, caster_programs *programs, uint32_t shape);
void caster_programs_destroy(device *device);

/* ---- memory.c ---- */

/* Device objects, counted against the memory limit. The free functions take NULL. */
csm_result device_buffer(device *device, const gpu_buffer_info *info, gpu_buffer **out);
void device_buffer_free(device *device, gpu_buffer *buffer, uint64_t size);
csm_result device_image(device *device, const gpu_image_info *info, gpu_image **out);
void device_image_free(device *device, gpu_image *image);
/* From one row of an image to the next where it lies in a buffer, in bytes: as copies want it. */
uint32_t device_row_bytes(uint32_t width, gpu_format format);
/* An image of one layer to be drawn into, sampled and read, and the target on it; neither is left if one fails. */
csm_result device_drawn_image(device *device, const char *name, gpu_format format, uint32_t width, uint32_t height,
                              gpu_image **image, gpu_target **target);

/* ---- retire.c ---- */

/* Hands a thing over to be destroyed once every frame recorded so far is done. */
void retire(device *device, retired *thing, void (*destroy)(struct device *, retired *));
/* Destroys what no frame after `done` uses. */
void retire_collect(device *device);

/* ---- recording.c ---- */

/*
 * Finds the slot for the next recording, waiting for it on an own device, and reserves `ring_size` bytes of its ring.
 * Nothing is recorded yet, so a failure leaves everything as it was. `frame` is an engine's frame number.
 */
csm_result recording_prepare(device *device, uint64_t frame, uint64_t ring_size, ring_range *range);
/* Begins the prepared recording, with the uploads that are due. `native` is the engine's command buffer. */
csm_result recording_begin(device *device, void *native);
csm_result recording_end(device *device);
/* Reserves timestamps of the current recording, to be delivered to `cascades`; false if there are no more. */
bool recording_expect_timing(device *device, csm_cascades *cascades, uint32_t count, bool mask, uint32_t *first);
/* Nobody is interested in what was measured for these cascades any more. */
void recording_forget_timing(device *device, const csm_cascades *cascades);
/* Own device: waits until every recording is done, and takes over what they measured. Else does nothing. */
csm_result recording_finish(device *device);
/* Engine's device: frames up to `frame` are done. */
csm_result recording_retire(device *device, uint64_t frame);
void recording_destroy(device *device);

/* ---- geometry.c ---- */

/* Makes room for meshes in `capacity` slots. */
csm_result geometry_reserve(device *device, uint32_t capacity);
/* Places a checked mesh in a slot below the capacity: copies it to staging, or takes in an engine's buffers. */
csm_result geometry_add(device *device, uint32_t slot, const csm_mesh_info *info);
/* Frees a slot's place once the GPU is done with it. */
void geometry_remove(device *device, uint32_t slot);
/* Records the copies of meshes that are not uploaded yet. */
void geometry_record(device *device);
void geometry_destroy(device *device);

/* ---- alpha_mask.c ---- */

/* Makes room for textures in `capacity` slots. */
csm_result alpha_mask_reserve(device *device, uint32_t capacity);
/* Makes a checked texture in a slot below the capacity; its texels wait in staging. */
csm_result alpha_mask_add(device *device, uint32_t slot, const csm_alpha_mask_info *info);
/* Frees it once the GPU is done with it. */
void alpha_mask_remove(device *device, uint32_t slot);
gpu_image *alpha_mask_texture(const device *device, uint32_t slot);
/* Records the copies of textures that are not uploaded yet. */
void alpha_mask_record(device *device);
void alpha_mask_destroy(device *device);

#endif
