/*
 * gpu.h: a small GPU. What a backend is, seen from the front: a driver that makes objects and records commands, and
 * knows nothing of shadows.
 *
 * The front checks everything before it calls; a backend may take its arguments for sound, and fails only for what the
 * device does. All reservation is done by create functions; recording functions cannot fail, and a lost device is
 * reported by `end` and `wait`.
 *
 * Conventions: clip z in [0,1], clip y up, texel row 0 at clip y = +1 (Vulkan: a viewport of negative height with
 * y = top + height). Front faces are counter-clockwise seen with clip y up. Depth outside [0,1] is clamped, not
 * clipped, unless a program asks for it. Shaders see HLSL registers: b# constants, t# textures, s# samplers,
 * vertex inputs ATTRIBUTE0, ATTRIBUTE1 ... in order of location.
 *
 * A backend tracks each image's and buffer's state while it records, in recording order, and puts barriers where the
 * next use needs them. Every image that was written in a recording rests readable by shaders when `end` returns, if it
 * has GPU_IMAGE_SAMPLED.
 */
#ifndef GPU_H
#define GPU_H

#include "csm/csm_base.h"
#include <stdbool.h>

/* ---- objects: each backend defines its own ---- */
typedef struct gpu_device gpu_device;
typedef struct gpu_buffer gpu_buffer;
typedef struct gpu_image gpu_image;
typedef struct gpu_program gpu_program;
typedef struct gpu_bindings gpu_bindings;
typedef struct gpu_target gpu_target;

/* ---- descriptions ---- */

/* What the front lends a device for its lifetime. */
typedef struct gpu_host {
  void *user;
  csm_allocate_function allocate; /* never NULL; memory is not zeroed */
  csm_release_function release;
  csm_log_function log; /* never NULL */
} gpu_host;

/* What an engine must enable on its own device, or may: lists of names, each of which ends with NULL; NULL: none. They
   are static. */
typedef struct gpu_needs {
  const char *const *instance_extensions; /* as the API spells them, like the next two */
  const char *const *device_extensions;
  const char *const *features;
  const char *const *others; /* what has no name: formats, queues, run times */
  uint32_t api_version;      /* Vulkan: as VK_API_VERSION_1_1; else 0 */
  uint32_t feature_level;    /* Direct3D 12: as D3D_FEATURE_LEVEL_11_0; else 0 */
} gpu_needs;

typedef struct gpu_device_info {
  uint32_t type; /* CSM_DEVICE_* of csm.h */
  uint32_t max_image_size;
  uint32_t max_image_layers;
  uint64_t max_buffer_size;
  uint64_t max_allocation_size; /* the most bytes that one image or buffer may take */
  uint64_t memory_size;         /* of the heap that images live in */
  char name[256];
  char driver[256];
  gpu_needs required, optional;
} gpu_device_info;

typedef struct gpu_open_info {
  const gpu_host *host;
  const char *device_name; /* part of a name, or NULL for the best: discrete, integrated, virtual, CPU */
  bool validate;           /* turn the driver stack's validation on; messages go to host->log as errors or warnings */
  uint32_t slots;          /* recordings in flight, 1 to 8 */
  const void *native;      /* the engine's device (csm_vulkan_device, csm_d3d12_device), or NULL to open an own one; its
                              struct_size and what it points at are the backend's to check */
  char *error;             /* receives a text when opening fails */
  size_t error_size;
} gpu_open_info;

typedef enum gpu_format {
  GPU_FORMAT_NONE,
  GPU_FORMAT_D32_FLOAT,
  GPU_FORMAT_D16_UNORM,
  GPU_FORMAT_R8_UNORM,
  GPU_FORMAT_RG32_FLOAT,  /* colour and vertex attributes */
  GPU_FORMAT_RGB32_FLOAT, /* vertex attributes */
  GPU_FORMAT_RGBA32_FLOAT
} gpu_format;

static inline bool gpu_format_is_depth(gpu_format format) {
  return format == GPU_FORMAT_D32_FLOAT || format == GPU_FORMAT_D16_UNORM;
}

/* Of a texel, or of an attribute. */
static inline uint32_t gpu_format_bytes(gpu_format format) {
  switch (format) {
  case GPU_FORMAT_R8_UNORM:
    return 1;
  case GPU_FORMAT_D16_UNORM:
    return 2;
  case GPU_FORMAT_D32_FLOAT:
    return 4;
  case GPU_FORMAT_RG32_FLOAT:
    return 8;
  case GPU_FORMAT_RGB32_FLOAT:
    return 12;
  case GPU_FORMAT_RGBA32_FLOAT:
    return 16;
  case GPU_FORMAT_NONE:
    break;
  }
  return 0;
}

typedef enum gpu_buffer_kind {
  GPU_BUFFER_DEVICE,  /* vertices and indices; written by copy_buffer */
  GPU_BUFFER_UPLOAD,  /* mapped for writing: copy source, vertices, constants (256-byte aligned offsets) */
  GPU_BUFFER_READBACK /* mapped for reading: copy destination */
} gpu_buffer_kind;

/* The engine's own buffers of a mesh, taken in; the two may be one. */
typedef struct gpu_geometry {
  gpu_buffer *vertices, *indices;
  uint64_t vertex_offset, index_offset;
  uint64_t uv_offset; /* in the vertices' buffer */
  uint32_t vertex_stride, uv_stride;
} gpu_geometry;

/* What an engine's image turned out to be. */
typedef struct gpu_imported {
  uint32_t width, height;
  bool unorm; /* its texels are normalised integers */
} gpu_imported;

typedef struct gpu_buffer_info {
  const char *name;
  gpu_buffer_kind kind;
  uint64_t size;
} gpu_buffer_info;

enum {
  GPU_IMAGE_TARGET = 1u << 0,
  GPU_IMAGE_SAMPLED = 1u << 1,
  GPU_IMAGE_COPY_SOURCE = 1u << 2,
  GPU_IMAGE_COPY_TARGET = 1u << 3
};

typedef struct gpu_image_info {
  const char *name;
  gpu_format format;
  uint32_t usage; /* GPU_IMAGE_* */
  uint32_t width, height, layers;
  bool array; /* shaders see it as an array, even with one layer */
} gpu_image_info;

/* A piece of an image, in texels from its top left: a rectangle, and one of one layer. */
typedef struct gpu_rect {
  uint32_t x, y, width, height;
} gpu_rect;

typedef struct gpu_region {
  uint32_t layer, x, y, width, height;
} gpu_region;

/* What an engine's shaders sample: VkImage, VkImageView (of all layers) and VkSamplers, or ID3D12Resource*. */
typedef struct gpu_native_image {
  uint64_t image, view;
  uint64_t sampler;          /* GPU_SAMPLER_COMPARE_LESS_EQUAL; D3D12: 0, as below */
  uint64_t sampler_reversed; /* GPU_SAMPLER_COMPARE_GREATER_EQUAL */
} gpu_native_image;

/* What an engine needs to record draws of its own into the pass that is open. */
typedef struct gpu_native_pass {
  void *command_buffer;  /* VkCommandBuffer, ID3D12GraphicsCommandList* */
  uint64_t render_pass;  /* VkRenderPass; subpass 0 */
  uint64_t depth_view;   /* D3D12: the depth view's CPU descriptor */
  uint32_t depth_format; /* VkFormat, DXGI_FORMAT */
} gpu_native_pass;

/* One recording. */
typedef struct gpu_record_info {
  uint32_t slot;
  void *native; /* the engine's command buffer or list, open and outside a render pass; NULL on an own device */
  bool first;   /* the slot's first recording since its earlier frame was done; false: it adds to the same frame */
} gpu_record_info;

/* What draws go into: one layer of a depth image, or one of a colour image, or both. */
typedef struct gpu_target_info {
  const char *name;
  gpu_image *depth; /* may be NULL */
  uint32_t depth_layer;
  gpu_image *color; /* may be NULL */
  uint32_t color_layer;
} gpu_target_info;

typedef struct gpu_code {
  const void *spirv;
  size_t spirv_size;
  const void *dxbc;
  size_t dxbc_size;
} gpu_code;

typedef struct gpu_stream {
  uint32_t stride;
  bool per_instance;
} gpu_stream;

typedef struct gpu_attribute {
  gpu_format format;
  uint32_t stream;
  uint32_t offset;
} gpu_attribute;

typedef enum gpu_sampler {
  GPU_SAMPLER_POINT_CLAMP,
  GPU_SAMPLER_LINEAR_CLAMP,
  GPU_SAMPLER_COMPARE_LESS_EQUAL,   /* linear, clamped; 1 where reference <= texel */
  GPU_SAMPLER_COMPARE_GREATER_EQUAL /* the same; 1 where reference >= texel */
} gpu_sampler;

typedef enum gpu_cull { GPU_CULL_NONE, GPU_CULL_BACK, GPU_CULL_FRONT } gpu_cull;

typedef enum gpu_compare {
  GPU_COMPARE_NONE,
  GPU_COMPARE_LESS,
  GPU_COMPARE_GREATER
} gpu_compare; /* NONE: no depth test */

/*
 * What the rasterizer adds to depth, before the depth test: constant * r + slope * m. m is how much depth changes from
 * texel to texel at most. r is one unit in the last place of the triangle's largest depth for a D32, and one unit of a
 * D16, or two where the device takes it so, as Vulkan allows (lavapipe does, and with it vkd3d). A clamp above 0 is the
 * most that is added, one below 0 the least. All zero: nothing is added.
 */
typedef struct gpu_raster_bias {
  int32_t constant;
  float slope;
  float clamp; /* other than 0 only where the device can */
} gpu_raster_bias;

#define GPU_MAX_STREAMS 3
#define GPU_MAX_ATTRIBUTES 8
#define GPU_MAX_CONSTANTS 2
#define GPU_MAX_TEXTURES 4
#define GPU_MAX_SAMPLERS 4

typedef struct gpu_program_info {
  const char *name;
  gpu_code vertex;
  gpu_code pixel; /* spirv_size 0: none */
  uint32_t stream_count;
  gpu_stream streams[GPU_MAX_STREAMS];
  uint32_t attribute_count;
  gpu_attribute attributes[GPU_MAX_ATTRIBUTES];
  uint32_t constants_count;                    /* b0..: each at a dynamic offset of an upload buffer */
  uint32_t constants_sizes[GPU_MAX_CONSTANTS]; /* bytes visible at each */
  uint32_t texture_count;                      /* t0.. */
  uint32_t sampler_count;                      /* s0.. */
  gpu_sampler samplers[GPU_MAX_SAMPLERS];
  gpu_format depth_format;   /* NONE: no depth target */
  gpu_format color_format;   /* NONE: no colour target */
  gpu_compare depth_compare; /* writes depth unless NONE */
  bool depth_clip;           /* clip at depth 0 and 1 instead of clamping */
  gpu_cull cull;
  gpu_raster_bias raster_bias;
} gpu_program_info;

/* What a program reads: constants from one upload buffer each, and textures. Good for every program of the same shape:
   the same counts of constants, textures and samplers. */
typedef struct gpu_bindings_info {
  const char *name;
  const gpu_program *program;
  gpu_buffer *constants[GPU_MAX_CONSTANTS];
  gpu_image *textures[GPU_MAX_TEXTURES];
} gpu_bindings_info;

typedef struct gpu_draw {
  gpu_buffer *streams[GPU_MAX_STREAMS]; /* may be NULL beyond the program's stream_count */
  uint64_t stream_offsets[GPU_MAX_STREAMS];
  gpu_buffer *indices; /* NULL: not indexed, count is vertices */
  uint64_t index_offset;
  uint32_t index_size; /* 2 or 4 */
  uint32_t count;
  uint32_t instance_count; /* the first instance is always 0: move the stream's offset instead */
} gpu_draw;

#define GPU_MAX_TIMESTAMPS 64

/* ---- the table ---- */

#define GPU_INTERFACE_VERSION 1u

typedef struct gpu_backend {
  const char *name; /* "vulkan" */

  /* Describes the device that `open` would take. Errors: NO_DEVICE, DEVICE, OUT_OF_MEMORY. */
  csm_result (*query)(const gpu_open_info *info, gpu_device_info *out);
  /* Errors: NO_DEVICE, UNSUPPORTED, DEVICE, OUT_OF_MEMORY, OUT_OF_DEVICE_MEMORY; info->error gets a text. */
  csm_result (*open)(const gpu_open_info *info, gpu_device **out);
  /* Waits for an own device; every object must have been destroyed. */
  void (*close)(gpu_device *device);
  void (*describe)(const gpu_device *device, gpu_device_info *out);

  /* Creation. Errors: OUT_OF_MEMORY, OUT_OF_DEVICE_MEMORY, DEVICE_LOST, DEVICE; *out is NULL then. Destruction takes
     NULL, and is called only when no recording in flight uses the object. */
  csm_result (*buffer_create)(gpu_device *device, const gpu_buffer_info *info, gpu_buffer **out);
  void (*buffer_destroy)(gpu_device *device, gpu_buffer *buffer);
  void *(*buffer_memory)(gpu_buffer *buffer); /* where an upload or readback buffer is mapped, for its lifetime */
  csm_result (*image_create)(gpu_device *device, const gpu_image_info *info, gpu_image **out);
  void (*image_destroy)(gpu_device *device, gpu_image *image);
  uint64_t (*image_bytes)(const gpu_image *image); /* device memory that it takes */
  void (*image_native)(const gpu_device *device, const gpu_image *image, gpu_native_image *out);
  /* D3D12: writes a shader resource view of the whole image to an engine's CPU descriptor. Vulkan: nothing. */
  void (*image_describe)(gpu_device *device, const gpu_image *image, uint64_t descriptor);
  /* The engine's own image to sample (csm_vulkan_image, csm_d3d12_image): it is in a state that shaders read, and stays
     in it. Destroyed like any other. Errors: those of creation,
     NULL_POINTER, STRUCT_SIZE, INVALID_VALUE. */
  csm_result (*image_import)(gpu_device *device, const void *native, gpu_image **out, gpu_imported *about);
  /* The engine's own vertices and indices (csm_vulkan_mesh, csm_d3d12_mesh), readable as such while they are drawn.
     Both buffers are destroyed like any other, the indices' only if it is another one. Errors: as image_import. */
  csm_result (*geometry_import)(gpu_device *device, const void *native, gpu_geometry *out);
  csm_result (*target_create)(gpu_device *device, const gpu_target_info *info, gpu_target **out);
  void (*target_destroy)(gpu_device *device, gpu_target *target);
  /* Also UNSUPPORTED: the device cannot clamp the raster bias. */
  csm_result (*program_create)(gpu_device *device, const gpu_program_info *info, gpu_program **out);
  void (*program_destroy)(gpu_device *device, gpu_program *program);
  csm_result (*bindings_create)(gpu_device *device, const gpu_bindings_info *info, gpu_bindings **out);
  /* Makes bindings that no recording in flight uses read other things. Cannot fail. */
  void (*bindings_write)(gpu_device *device, gpu_bindings *bindings, const gpu_bindings_info *info);
  void (*bindings_destroy)(gpu_device *device, gpu_bindings *bindings);

  /* Bytes of device memory that this process may still take, as the driver says; UINT64_MAX if it does not. */
  uint64_t (*memory_available)(gpu_device *device);

  /* Recording. On an own device `begin` waits until the slot's earlier recording is done; on an engine's, nothing is
     ever waited for, and the front sees to it that the slot is free. Errors: DEVICE_LOST, DEVICE, OUT_OF_MEMORY,
     OUT_OF_DEVICE_MEMORY. */
  csm_result (*begin)(gpu_device *device, const gpu_record_info *info);
  void (*marker_begin)(gpu_device *device, const char *name);
  void (*marker_end)(gpu_device *device);
  void (*timestamp)(gpu_device *device, uint32_t index); /* below GPU_MAX_TIMESTAMPS, each once for a frame's slot */
  void (*copy_buffer)(gpu_device *device, gpu_buffer *to, uint64_t to_offset, gpu_buffer *from, uint64_t from_offset,
                      uint64_t size);
  /* A region to a readback buffer: its row r begins at offset + r * row_bytes, offset a multiple of 512, row_bytes one
     of 256. Of a depth image it is a whole layer, for Direct3D 12 copies no part of one. */
  void (*copy_image)(gpu_device *device, gpu_buffer *to, uint64_t offset, uint32_t row_bytes, gpu_image *image,
                     const gpu_region *from);
  /* A whole image of one layer, from an upload buffer with rows as above. */
  void (*copy_to_image)(gpu_device *device, gpu_image *to, gpu_buffer *from, uint64_t offset, uint32_t row_bytes);
  /* Every layer of a depth image, the cheapest way that the API offers; 0 and 1 are what it is cheapest for. */
  void (*clear_depth)(gpu_device *device, gpu_image *image, float depth);
  /* Begins a render pass over the whole target; what it holds is kept, but colour is undefined until drawn. */
  void (*pass_begin)(gpu_device *device, gpu_target *target);
  /* Restricts what follows in the open pass to a part of its target: clip space covers the area, texel row 0 of it at
     clip y = +1, and nothing is drawn outside it. */
  void (*pass_area)(gpu_device *device, const gpu_rect *area);
  void (*pass_end)(gpu_device *device);
  void (*pass_program)(gpu_device *device, gpu_program *program);
  /* `offsets`: one for each of the program's constants, a multiple of 256. Textures must have been drawn before. */
  void (*pass_bind)(gpu_device *device, gpu_bindings *bindings, const uint32_t *offsets);
  void (*pass_draw)(gpu_device *device, const gpu_draw *draw);
  /* What an engine needs to draw into the open pass itself. Viewport and scissor cover the pass's area, which is the
     whole target unless pass_area was called; what the engine binds is forgotten with the next pass_program, what it
     makes of viewport and scissor with the next pass_area. */
  void (*pass_native)(gpu_device *device, gpu_native_pass *out);
  /* Makes an image readable by shaders in the passes that follow; outside a pass. */
  void (*make_readable)(gpu_device *device, gpu_image *image);
  /* Ends the recording, and submits it on an own device; an engine's command buffer stays open. Errors: DEVICE_LOST,
     DEVICE, OUT_OF_MEMORY. */
  csm_result (*end)(gpu_device *device);
  /* Waits for the slot's last recording. Own device only. Errors: DEVICE_LOST. */
  csm_result (*wait)(gpu_device *device, uint32_t slot);
  /* Reads `count` timestamps of the slot's finished recordings from index `first` on, in nanoseconds. Errors:
     DEVICE_LOST, UNSUPPORTED (the queue has none). */
  csm_result (*timestamps)(gpu_device *device, uint32_t slot, uint32_t first, uint32_t count, uint64_t *nanoseconds);
} gpu_backend;

/*
 * The one symbol that a backend's library exports. The front says which interface versions it speaks; the backend
 * writes its own range always, and the table for the newest common one, or NULL if there is none.
 */
#define GPU_HANDSHAKE_SYMBOL "csm_backend_handshake"
typedef struct gpu_handshake {
  uint32_t front_oldest, front_newest;     /* in */
  uint32_t backend_oldest, backend_newest; /* out */
  const gpu_backend *backend;              /* out */
} gpu_handshake;
typedef void (*gpu_handshake_function)(gpu_handshake *handshake);

#endif
