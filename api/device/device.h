/*
 * device.h: an opened backend with everything that lies on it. One file for each thing that a device owns: device.c
 * (itself), memory.c, retire.c, ring.c (memory that changes per frame), recording.c (frames in flight and their times),
 * geometry.c (meshes in pages), alpha_images.c, programs.c. It knows nothing of cascades.
 */
#ifndef DEVICE_H
#define DEVICE_H

#include "device/host.h"
#include "device/programs.h"
#include "gpu_calls.h"

enum { DEVICE_MAX_SLOTS = 8, DEVICE_MAX_TIMINGS = 16, DEVICE_MAX_SHAPES = 32 };

typedef struct device device;

/* ---- things that are freed once the GPU is done with them ---- */

typedef struct retired {
  struct retired *next;
  uint64_t serial; /* the last frame that may use it */
  void (*destroy)(device *device, struct retired *self);
} retired;

/* ---- shapes of vertices ---- */

/* What programs that draw a mesh depend on. */
typedef struct mesh_vertices {
  uint32_t stride;
  uint32_t uv_stride; /* 0: opaque */
} mesh_vertices;

/* Shapes never go, so that an index stays what it is. The first is that of copied opaque meshes. */
typedef struct device_shapes {
  uint32_t count;
  mesh_vertices vertices[DEVICE_MAX_SHAPES];
} device_shapes;

/* ---- geometry ---- */

enum { MESH_RAYS_NONE = 0xffffffffu };

/* What rays need to know of a mesh; rows are of the pool of trees. */
typedef struct mesh_rays {
  uint32_t node_row, node_count;
  uint32_t triangle_row, triangle_count;
  uint32_t uv_row; /* MESH_RAYS_NONE: it is opaque */
  uint32_t alpha_row, alpha_size[2], alpha_wrap[2];
  float alpha_cutoff;
  double grid_scale[3], grid_offset[3]; /* from its space, as positions are stored, to the grid of its nodes */
  double reach;                         /* the largest coordinate of a position */
  double cost;                          /* the sum of its nodes' areas, as a share of the first one's */
} mesh_rays;

/* Where a mesh lies, by its index in the plan's scene. */
typedef struct mesh_place {
  gpu_buffer *vertices, *indices;
  uint64_t vertex_offset, index_offset;
  uint32_t index_count, index_size;
  uint32_t shape;             /* index into device_shapes */
  bool two_sided, watertight; /* no face of it is culled; its back faces need not be drawn */
  uint64_t uv_offset;         /* in the vertices' buffer; read only with an alpha mask */
  gpu_bindings *alpha_mask;   /* of an alpha-tested mesh, else NULL */
  const mesh_rays *rays;      /* NULL: it cannot be traced */
} mesh_place;

/* A device buffer that pieces are taken of: pages.h. */
typedef struct page {
  struct page *next;
  gpu_buffer *buffer;
  uint64_t size;
  struct page_piece *free;
} page;

/* See tree_pool.h. */
typedef struct tree_pool {
  bool wanted;       /* meshes get trees: CSM_CREATE_RAYS */
  page page;         /* size 0: none yet */
  retired *outgrown; /* the buffer before, which the next recording copies; NULL: none */
  uint64_t bytes;    /* that are placed */
} tree_pool;

/* See uploads.h. */
typedef struct uploads {
  struct upload *items;
  uint32_t count, capacity;
  struct staging *filling; /* that the items lie in, newest first */
  struct staging *idle;    /* that frames are done with */
  uint64_t frames;         /* counts them, for the age of what is idle */
} uploads;

/* Arrays are by the mesh's index. */
typedef struct geometry {
  page *pages;
  uploads uploads;
  struct geometry_place **places; /* where each mesh lies; NULL: nowhere */
  mesh_place *meshes;             /* as draws want them */
  uint32_t capacity;
  uint64_t bytes;
} geometry;

/* Alpha masks on the device, by the mask's index. */
typedef struct alpha_image alpha_image;
typedef struct alpha_images {
  alpha_image **images;
  uint32_t capacity;
  uint32_t due; /* that are not uploaded yet */
} alpha_images;

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

/* Who gets what a recording measured: `count` times in nanoseconds, once its frame is done. */
typedef struct timing_sink {
  void (*take)(void *user, const uint64_t *nanoseconds, uint32_t count);
  void *user; /* NULL: nobody */
} timing_sink;

typedef struct timing {
  timing_sink sink;
  uint32_t first, count; /* of its timestamps */
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

struct device {
  host *host;
  gpu_host lent;  /* what the backend was lent: must not move */
  char said[256]; /* by the backend, of its last error; empty: nothing since the last device_check */
  gpu gpu;
  gpu_device_info info;
  bool own; /* else an engine's */
  bool lost;
  uint64_t memory_limit, memory_used;

  uint32_t slot_count, slot; /* the current one */
  uint64_t serial;           /* of the newest frame */
  uint64_t done;             /* frames up to this one are done */
  next_frame prepared;
  fenv_t floats; /* the caller's, while a recording is open: see gpu_calls.h */
  frame_slot slots[DEVICE_MAX_SLOTS];
  retired *retired, *retired_last; /* oldest first; the last one is there if any is */

  geometry geometry;
  alpha_images alpha_images;
  tree_pool trees;
  device_shapes shapes;
  programs programs;
};

/* ---- device.c ---- */

typedef struct device_open_info {
  host *host;
  const gpu_backend *backend;
  const char *device_name; /* as in gpu_open_info, as are the next three */
  bool validate;
  bool names;
  const void *native;    /* the engine's device, or NULL */
  uint64_t memory_limit; /* 0: what the device allows */
  uint32_t slots;        /* 0: 3 */
  bool trees;            /* meshes get trees, for rays */
} device_open_info;

/* *out is NULL after an error, whose text the host has. */
csm_result device_open(const device_open_info *info, device **out);
/* Destroys everything at once. The GPU must be done with it, or be lost; an own one is waited for. */
void device_close(device *device);
/* host_fail for a backend's result, with what was tried and what the backend said of it; a lost device is marked.
   CSM_SUCCESS passes through. */
csm_result device_check(device *device, csm_result result, const char *what);
/* The index of a shape, added if it is new. Errors: LIMIT_EXCEEDED. */
csm_result device_shape(device *device, mesh_vertices vertices, uint32_t *index);

/* ---- memory.c ---- */

/* Device objects, counted against the memory limit. The free functions take NULL. */
csm_result device_buffer(device *device, const gpu_buffer_info *info, gpu_buffer **out);
void device_buffer_free(device *device, gpu_buffer *buffer, uint64_t size);
csm_result device_image(device *device, const gpu_image_info *info, gpu_image **out);
void device_image_free(device *device, gpu_image *image);
/* From one row of an image to the next where it lies in a buffer, in bytes: as copies want it. */
uint32_t device_row_bytes(uint32_t width, gpu_format format);
/* An image of one layer to be drawn into, sampled and read, and the target on it; neither is left if one fails. `wanted`
   has name, format, width, height, and what else it is used for. */
csm_result device_drawn_image(device *device, const gpu_image_info *wanted, gpu_image **image, gpu_target **target);

/* ---- retire.c ---- */

/* Hands a thing over to be destroyed once every frame recorded so far is done. Things go in the order in which they
   came: bindings are retired before what they bind. */
void retire(device *device, retired *thing, void (*destroy)(struct device *, retired *));
/* Destroys what no frame after `done` uses. */
void retire_collect(device *device);

/* ---- ring.c ---- */

enum { RING_ALIGNMENT = 256 };

/* A piece of a slot's ring. */
csm_result ring_reserve(device *device, frame_slot *slot, uint64_t size, ring_range *range);
/* Bytes of all rings. */
uint64_t ring_bytes(const device *device);
void ring_destroy(device *device);

/* ---- recording.c ---- */

/*
 * Finds the slot for the next recording, waiting for it on an own device, and reserves `ring_size` bytes of its ring.
 * Nothing is recorded yet, so a failure leaves everything as it was. `frame` is an engine's frame number.
 */
csm_result recording_prepare(device *device, uint64_t frame, uint64_t ring_size, ring_range *range);
/* Begins the prepared recording, with the uploads that are due. `native` is the engine's command buffer. */
csm_result recording_begin(device *device, void *native);
csm_result recording_end(device *device);
/* Reserves timestamps of the current recording, from *first on; false if there are no more. */
bool recording_expect_timing(device *device, const timing_sink *sink, uint32_t count, uint32_t *first);
/* What was measured for a sink's user goes nowhere. */
void recording_forget_timing(device *device, const void *user);
/* Waits until a frame is done, on an own device. Errors: INVALID_STATE (an engine's frame is not retired), those of
   waiting. */
csm_result recording_wait(device *device, uint64_t serial);
/* Own device: waits until every recording is done, and takes over what they measured. Else does nothing. */
csm_result recording_finish(device *device);
/* Engine's device: frames up to `frame` are done. */
csm_result recording_retire(device *device, uint64_t frame);

/* ---- geometry.c, alpha_images.c: what a recording begins with ---- */

/* Records the copies of meshes that are not uploaded yet. */
void geometry_record(device *device);
void geometry_destroy(device *device);
/* Records the copies of alpha masks that are not uploaded yet. */
void alpha_images_record(device *device);
void alpha_images_destroy(device *device);

#endif
