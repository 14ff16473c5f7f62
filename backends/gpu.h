/*
 * gpu.h: a small GPU, second edition. What a backend is, seen from the front: a driver that makes objects and records
 * commands, and knows nothing of shadows. gpu_calls.h has the calls as functions.
 *
 * The front checks everything before it calls. A backend may take its arguments for sound, and fails only for what the
 * device does. Create functions do all reservation. Recording functions cannot fail; `end` and `wait` report a lost
 * device. The null backend tells of every breach of the rules that stand here.
 *
 * Conventions. Clip z lies in [0,1], clip y points up, texel row 0 is at clip y = +1. Front faces are counter-clockwise
 * seen with clip y up. Depth outside [0,1] is clamped, not clipped, unless a program asks for it.
 *
 * Registers, as HLSL has them, all in space 0:
 *   b0 to b1      constants, each at a dynamic offset of an upload buffer
 *   t0 to t7      textures
 *   t8 to t11     buffers that shaders read: StructuredBuffer, ByteAddressBuffer
 *   t12 to t15    and those that they read as rows of four whole numbers: Buffer<uint4>
 *   u0 to u3      images that shaders write: RWTexture2D, RWTexture2DArray
 *   u4 to u7      buffers that shaders write: RWStructuredBuffer, without a counter
 *   s0 to s3      samplers
 *   ATTRIBUTE0 .. vertex inputs, in order of location
 * Every stage sees constants, and buffers that are read. Pixel and compute shaders alone see textures, samplers, and
 * what is written. In SPIR-V a register's binding is its number plus 0 for b, 16 for t, 32 for u, 48 for s.
 *
 * States. A backend tracks the state of each buffer and of each {layer, level} of an image while it records, in
 * recording order, and puts barriers where the next use needs them:
 *   - Copies, clears, passes' targets and dispatches take what they use into the state for it by themselves.
 *   - A pass holds no barriers. pass_begin makes every buffer readable in the ways of its usage, and makes what
 *     gpu_pass_info.stores names writable. Textures must be made readable before it: by `end` of an earlier recording,
 *     or by make_readable.
 *   - One {layer, level} may be read while another of the same image is written.
 *   - Frames in flight are ordered too: copy_buffer may overwrite vertices that an earlier recording draws.
 * Every image that was written in a recording rests readable by shaders when `end` returns, if it has
 * GPU_IMAGE_SAMPLED, and every buffer, if it has GPU_BUFFER_READ (Direct3D 12: in COMMON, out of which reading promotes
 * it). What was never written, or was discarded, must not be read.
 */
#ifndef GPU_H
#define GPU_H

#include "csm/csm_base.h"
#include <stdbool.h>

/* ---- objects: each backend defines its own ---- */
typedef struct gpu_device gpu_device;
typedef struct gpu_buffer gpu_buffer;
typedef struct gpu_image gpu_image;
typedef struct gpu_view gpu_view;
typedef struct gpu_target gpu_target;
typedef struct gpu_program gpu_program;
typedef struct gpu_bindings gpu_bindings;

/* ---- formats ---- */

typedef enum gpu_format {
  GPU_FORMAT_NONE,
  GPU_FORMAT_D32_FLOAT,
  GPU_FORMAT_D16_UNORM,
  GPU_FORMAT_R8_UNORM,
  GPU_FORMAT_R16_UNORM,
  GPU_FORMAT_RG16_UNORM,
  GPU_FORMAT_R16_FLOAT,
  GPU_FORMAT_RG16_FLOAT,
  GPU_FORMAT_RGBA16_FLOAT,
  GPU_FORMAT_R32_FLOAT,
  GPU_FORMAT_RG32_FLOAT,
  GPU_FORMAT_RGB32_FLOAT, /* attributes alone */
  GPU_FORMAT_RGBA32_FLOAT,
  GPU_FORMAT_R32_UINT,
  GPU_FORMAT_COUNT
} gpu_format;

static inline bool gpu_format_is_depth(gpu_format format) {
  return format == GPU_FORMAT_D32_FLOAT || format == GPU_FORMAT_D16_UNORM;
}

/* Of a texel, or of an attribute. */
static inline uint32_t gpu_format_bytes(gpu_format format) {
  static const uint8_t bytes[GPU_FORMAT_COUNT] = {
      [GPU_FORMAT_D32_FLOAT] = 4,  [GPU_FORMAT_D16_UNORM] = 2,    [GPU_FORMAT_R8_UNORM] = 1,
      [GPU_FORMAT_R16_UNORM] = 2,  [GPU_FORMAT_RG16_UNORM] = 4,   [GPU_FORMAT_R16_FLOAT] = 2,
      [GPU_FORMAT_RG16_FLOAT] = 4, [GPU_FORMAT_RGBA16_FLOAT] = 8, [GPU_FORMAT_R32_FLOAT] = 4,
      [GPU_FORMAT_RG32_FLOAT] = 8, [GPU_FORMAT_RGB32_FLOAT] = 12, [GPU_FORMAT_RGBA32_FLOAT] = 16,
      [GPU_FORMAT_R32_UINT] = 4,
  };
  return format < GPU_FORMAT_COUNT ? bytes[format] : 0;
}

/* Whether vertices may have it: every colour of at least 4 bytes. */
static inline bool gpu_format_is_attribute(gpu_format format) {
  return !gpu_format_is_depth(format) && gpu_format_bytes(format) >= 4;
}

/* ---- devices ---- */

/* What the front lends a device for its lifetime. */
typedef struct gpu_host {
  void *user;
  csm_allocate_function allocate; /* never NULL; memory is not zeroed */
  csm_release_function release;
  csm_log_function log; /* never NULL */
} gpu_host;

/* The numbers of CSM_DEVICE_* of csm.h. */
typedef enum gpu_device_type {
  GPU_DEVICE_OTHER,
  GPU_DEVICE_INTEGRATED,
  GPU_DEVICE_DISCRETE,
  GPU_DEVICE_VIRTUAL,
  GPU_DEVICE_CPU
} gpu_device_type;

/* What a device can do with images of a format. */
enum {
  GPU_CAN_SAMPLE = 1u << 0,
  GPU_CAN_FILTER = 1u << 1, /* linear, trilinear and anisotropic samplers */
  GPU_CAN_DRAW = 1u << 2,   /* a target, of colour or of depth */
  GPU_CAN_STORE = 1u << 3,  /* an image that shaders write */
  GPU_CAN_LOAD = 1u << 4,   /* and one that they read through the same register */
  GPU_CAN_ATOMIC = 1u << 5  /* interlocked functions on such an image */
};

typedef struct gpu_capabilities {
  uint32_t formats[GPU_FORMAT_COUNT]; /* GPU_CAN_* */
  uint32_t max_anisotropy;            /* of GPU_SAMPLER_ANISOTROPIC_CLAMP; 1: program_create refuses that sampler */
  uint64_t max_texels_size;           /* bytes of one buffer that shaders read as rows */
  uint32_t max_buffers;               /* that a program reads and writes, together */
  bool compute;                       /* compute programs and dispatches */
  bool indirect;                      /* indirect draws and dispatches */
  bool pixel_stores;                  /* pixel shaders write images and buffers */
  bool bias_clamp;                    /* gpu_raster_bias.clamp other than 0 */
  bool timestamps;
  bool dynamic_rendering; /* Vulkan: passes are dynamic rendering, not render passes */
} gpu_capabilities;

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
  uint32_t type; /* gpu_device_type */
  uint32_t max_image_size;
  uint32_t max_image_layers;
  uint64_t max_buffer_size;     /* the most bytes that one buffer may take */
  uint64_t max_allocation_size; /* and one image */
  uint64_t memory_size;         /* of the heap that images live in */
  char name[256];
  char driver[256];
  gpu_needs required, optional;
  gpu_capabilities can;
} gpu_device_info;

typedef struct gpu_open_info {
  const gpu_host *host;
  const char *device_name; /* part of a name, or NULL for the best: discrete, integrated, virtual, CPU */
  bool validate;           /* turn the driver stack's validation on; messages go to host->log as errors or warnings */
  bool names;              /* an own Vulkan device names its objects and marks its passes */
  uint32_t slots;          /* recordings in flight, 1 to 8 */
  const void *native;      /* the engine's device (csm_vulkan_device, csm_d3d12_device), or NULL to open an own one; its
                              struct_size and what it points at are the backend's to check */
  char *error;             /* receives a text when opening fails */
  size_t error_size;
} gpu_open_info;

/* ---- buffers ---- */

typedef enum gpu_buffer_kind {
  GPU_BUFFER_DEVICE,  /* vertices and indices; written by copy_buffer, and by shaders with GPU_BUFFER_WRITE */
  GPU_BUFFER_UPLOAD,  /* mapped for writing: copy source, vertices, constants (256-byte aligned offsets) */
  GPU_BUFFER_READBACK /* mapped for reading: copy destination, and nothing else */
} gpu_buffer_kind;

/* What a buffer is for besides what its kind says. */
enum {
  GPU_BUFFER_READ = 1u << 0,     /* by shaders, at t8 and on */
  GPU_BUFFER_WRITE = 1u << 1,    /* by shaders, at u4 and on; of kind DEVICE */
  GPU_BUFFER_INDIRECT = 1u << 2, /* arguments of draws and dispatches */
  GPU_BUFFER_TEXELS =
      1u << 3 /* with READ: at t12 and on, too; its size is a multiple of 16, and at most max_texels_size */
};

typedef struct gpu_buffer_info {
  const char *name;
  gpu_buffer_kind kind;
  uint64_t size;
  uint32_t usage; /* GPU_BUFFER_READ, WRITE, INDIRECT, TEXELS */
} gpu_buffer_info;

/* The engine's own buffers of a mesh, taken in; the two may be one. */
typedef struct gpu_geometry {
  gpu_buffer *vertices, *indices;
  uint64_t vertex_offset, index_offset;
  uint64_t uv_offset; /* in the vertices' buffer */
  uint32_t vertex_stride, uv_stride;
  /* The front checks uvs by these, since it knows whether they are read: the device's largest stride, and the size of
     the vertices' buffer in bytes, 0 where the API does not tell. */
  uint32_t largest_stride;
  uint64_t vertices_size;
} gpu_geometry;

/* ---- images ---- */

enum {
  GPU_IMAGE_TARGET = 1u << 0,
  GPU_IMAGE_SAMPLED = 1u << 1,
  GPU_IMAGE_COPY_SOURCE = 1u << 2,
  GPU_IMAGE_COPY_TARGET = 1u << 3,
  GPU_IMAGE_STORED = 1u << 4 /* written by shaders, at u0 and on; no depth */
};

typedef struct gpu_image_info {
  const char *name;
  gpu_format format;
  uint32_t usage; /* GPU_IMAGE_* */
  uint32_t width, height, layers;
  bool array;      /* shaders see it as an array, even with one layer; several layers are always one */
  uint32_t levels; /* 0 means 1; level n has half the size of level n - 1, rounded down, at least 1 */
} gpu_image_info;

/* The width or height of a level. */
static inline uint32_t gpu_level_size(uint32_t size, uint32_t level) {
  return size >> level ? size >> level : 1;
}

/* Layers and levels of an image. A count of 0: all from the first on. */
typedef struct gpu_range {
  uint32_t first_layer, layer_count;
  uint32_t first_level, level_count;
} gpu_range;

/* A piece of an image, in texels from its top left: a rectangle, and one of one {layer, level}. */
typedef struct gpu_rect {
  uint32_t x, y, width, height;
} gpu_rect;

typedef struct gpu_region {
  uint32_t layer, x, y, width, height;
  uint32_t level; /* x, y, width and height are its own texels */
} gpu_region;

/* What an engine's image is to hold. A depth has one channel, normals have three or four, motion two or four floats. */
typedef enum gpu_texels { GPU_TEXELS_DEPTH, GPU_TEXELS_NORMALS, GPU_TEXELS_MOTION } gpu_texels;

/* What numbers texels are: normalised integers from 0 to 1, or from -1 to 1. */
typedef enum gpu_numbers { GPU_NUMBERS_FLOAT, GPU_NUMBERS_UNORM, GPU_NUMBERS_SNORM } gpu_numbers;

/* What an engine's image turned out to be. */
typedef struct gpu_imported {
  uint32_t width, height;
  gpu_numbers numbers;
  uint32_t bits; /* of a component; of a float, those of its significand, the hidden one included */
} gpu_imported;

/* What an engine's shaders sample: VkImage, VkImageView (of all layers and levels) and VkSamplers, or ID3D12Resource*.
 */
typedef struct gpu_native_image {
  uint64_t image, view;
  uint64_t sampler;                 /* GPU_SAMPLER_COMPARE_LESS_EQUAL; D3D12: 0, as below */
  uint64_t sampler_reversed;        /* GPU_SAMPLER_COMPARE_GREATER_EQUAL */
  uint64_t sampler_repeat;          /* GPU_SAMPLER_COMPARE_LESS_EQUAL_REPEAT */
  uint64_t sampler_repeat_reversed; /* GPU_SAMPLER_COMPARE_GREATER_EQUAL_REPEAT */
} gpu_native_image;

/* A part of an image as shaders see it: an array if the image is one, for Direct3D 12 has no other views of an array's
   layers. A shader's level 0 and layer 0 are the first of the range. */
typedef struct gpu_view_info {
  const char *name;
  gpu_image *image; /* with GPU_IMAGE_SAMPLED or GPU_IMAGE_STORED, and not an engine's */
  gpu_range range;  /* one level, if it is to be written */
} gpu_view_info;

/* What draws go into: one {layer, level} of a depth image, or of a colour image, or of both in one size. */
typedef struct gpu_target_info {
  const char *name;
  gpu_image *depth; /* may be NULL */
  uint32_t depth_layer;
  gpu_image *color; /* may be NULL */
  uint32_t color_layer;
  uint32_t depth_level, color_level;
} gpu_target_info;

/* ---- programs ---- */

typedef struct gpu_code {
  const void *spirv;
  size_t spirv_size;
  const void *dxbc;
  size_t dxbc_size;
} gpu_code;

typedef struct gpu_stream {
  uint32_t stride; /* a multiple of 4 */
  bool per_instance;
} gpu_stream;

typedef struct gpu_attribute {
  gpu_format format; /* see gpu_format_is_attribute */
  uint32_t stream;
  uint32_t offset; /* a multiple of 4 */
} gpu_attribute;

/* All clamp to the edge, but for those that repeat. */
typedef enum gpu_sampler {
  GPU_SAMPLER_POINT_CLAMP,           /* the nearest texel of the nearest level */
  GPU_SAMPLER_LINEAR_CLAMP,          /* linear in the nearest level */
  GPU_SAMPLER_TRILINEAR_CLAMP,       /* linear, and between levels */
  GPU_SAMPLER_ANISOTROPIC_CLAMP,     /* the same, with up to GPU_MAX_ANISOTROPY samples, or the device's fewer */
  GPU_SAMPLER_COMPARE_LESS_EQUAL,    /* linear, of the first level; 1 where reference <= texel */
  GPU_SAMPLER_COMPARE_GREATER_EQUAL, /* the same; 1 where reference >= texel */
  GPU_SAMPLER_POINT_REPEAT,
  GPU_SAMPLER_COMPARE_LESS_EQUAL_REPEAT,
  GPU_SAMPLER_COMPARE_GREATER_EQUAL_REPEAT,
  GPU_SAMPLER_COUNT
} gpu_sampler;

#define GPU_MAX_ANISOTROPY 16

typedef enum gpu_cull { GPU_CULL_NONE, GPU_CULL_BACK, GPU_CULL_FRONT } gpu_cull;

typedef enum gpu_compare {
  GPU_COMPARE_NONE, /* depth is neither tested nor written */
  GPU_COMPARE_LESS,
  GPU_COMPARE_GREATER,
  GPU_COMPARE_ALWAYS /* depth is written without a test */
} gpu_compare;

/*
 * What the rasterizer adds to depth, before the depth test: constant * r + slope * m. m is how much depth changes from
 * texel to texel at most. r is one unit in the last place of the triangle's largest depth for a D32. For a D16 it is
 * one unit, or two where the device takes it so, as Vulkan allows (lavapipe does, and with it vkd3d). A clamp above 0
 * is the most that is added, one below 0 the least. All zero: nothing is added.
 */
typedef struct gpu_raster_bias {
  int32_t constant;
  float slope;
  float clamp; /* other than 0 only where the device can */
} gpu_raster_bias;

#define GPU_MAX_STREAMS 3
#define GPU_MAX_ATTRIBUTES 8
#define GPU_MAX_CONSTANTS 2
#define GPU_MAX_TEXTURES 8
#define GPU_MAX_BUFFERS 4
#define GPU_MAX_TEXEL_BUFFERS 4
#define GPU_TEXEL_SIZE 16
#define GPU_MAX_STORES 4 /* of images, and of buffers */
#define GPU_MAX_SAMPLERS 4
#define GPU_FIRST_BUFFER 8        /* t8 */
#define GPU_FIRST_TEXEL_BUFFER 12 /* t12 */
#define GPU_FIRST_STORE_BUFFER 4  /* u4 */

/* A program that draws, or one that computes. The latter has no streams, attributes and formats. */
typedef struct gpu_program_info {
  const char *name;
  gpu_code vertex;
  gpu_code pixel;   /* spirv_size 0: none */
  gpu_code compute; /* instead of the two above */
  uint32_t stream_count;
  gpu_stream streams[GPU_MAX_STREAMS];
  uint32_t attribute_count;
  gpu_attribute attributes[GPU_MAX_ATTRIBUTES];
  uint32_t constants_count;                    /* b0.. */
  uint32_t constants_sizes[GPU_MAX_CONSTANTS]; /* bytes visible at each */
  uint32_t texture_count;                      /* t0.. */
  uint32_t buffer_count;                       /* t8.. */
  uint32_t texel_buffer_count;                 /* t12.. */
  uint32_t store_image_count;                  /* u0..; a program with a colour target has none: u0 is taken then */
  uint32_t store_buffer_count;                 /* u4.. */
  uint32_t sampler_count;                      /* s0.. */
  gpu_sampler samplers[GPU_MAX_SAMPLERS];
  gpu_format depth_format; /* NONE: no depth target */
  gpu_format color_format; /* NONE: no colour target */
  gpu_compare depth_compare;
  bool depth_clip; /* clip at depth 0 and 1 instead of clamping */
  gpu_cull cull;
  gpu_raster_bias raster_bias;
} gpu_program_info;

/* A part of a buffer as shaders see it. */
typedef struct gpu_buffer_part {
  gpu_buffer *buffer;
  uint64_t offset; /* a multiple of 256, and of stride */
  uint64_t size;   /* a multiple of 4, and of stride; 0: up to the buffer's end */
  uint32_t stride; /* of a structured buffer's elements, a multiple of 4; 0: a ByteAddressBuffer, which is only read */
} gpu_buffer_part;

/* What a program reads and writes. Good for every program of the same shape: it draws or computes alike, and has the
   same counts of textures, buffers and stores, the same constants in number and size, and the same samplers. Nothing that
   is written may be read through the same bindings. */
typedef struct gpu_bindings_info {
  const char *name;
  const gpu_program *program;
  gpu_buffer *constants[GPU_MAX_CONSTANTS];  /* upload buffers */
  gpu_image *textures[GPU_MAX_TEXTURES];     /* all of each */
  gpu_view *texture_views[GPU_MAX_TEXTURES]; /* not NULL: it takes the place of textures[i] */
  gpu_buffer_part buffers[GPU_MAX_BUFFERS];
  gpu_buffer *texel_buffers[GPU_MAX_TEXEL_BUFFERS]; /* all of each */
  gpu_view *store_images[GPU_MAX_STORES];
  gpu_buffer_part store_buffers[GPU_MAX_STORES];
} gpu_bindings_info;

/* ---- recording ---- */

/* One recording. */
typedef struct gpu_record_info {
  uint32_t slot;
  void *native; /* the engine's command buffer or list, open and outside a render pass; NULL on an own device */
  bool first;   /* the slot's first recording since its earlier frame was done; false: it adds to the same frame */
} gpu_record_info;

typedef enum gpu_load {
  GPU_LOAD_KEEP,
  GPU_LOAD_DISCARD, /* undefined until drawn */
  GPU_LOAD_CLEAR
} gpu_load;

/* Load operations and the area's bounds hold for the area alone: what lies outside it is kept. */
typedef struct gpu_pass_info {
  gpu_target *target;
  gpu_load depth_load, color_load;
  float clear_depth;
  float clear_color[4];       /* of an R32_UINT: a whole number below 2^24 */
  gpu_rect area;              /* all zero: the whole target */
  gpu_rect clip_space;        /* what clip space covers, though nothing is drawn outside the area; all zero: the area */
  const gpu_bindings *stores; /* what the pass's draws write besides its target; NULL: nothing */
} gpu_pass_info;

/* What pipelines for a pass are made with. */
typedef struct gpu_native_target {
  uint32_t depth_format, color_format; /* VkFormat, DXGI_FORMAT; 0: none */
  uint64_t render_pass; /* VkRenderPass, subpass 0: compatible with the pass's; dynamic rendering, D3D12: 0 */
  bool dynamic_rendering;
} gpu_native_target;

/* What an engine needs to record draws of its own into the pass that is open. */
typedef struct gpu_native_pass {
  void *command_buffer; /* VkCommandBuffer, ID3D12GraphicsCommandList* */
  uint64_t depth_view;  /* D3D12: the depth view's CPU descriptor */
  gpu_native_target target;
} gpu_native_pass;

/* What lies in a buffer of indirect arguments. The first instance is 0. */
typedef struct gpu_indirect_draw {
  uint32_t count, instance_count, first, first_instance;
} gpu_indirect_draw;

typedef struct gpu_indirect_indexed {
  uint32_t count, instance_count;
  uint32_t first; /* from the index buffer's beginning: gpu_draw.index_offset must be 0 */
  int32_t vertex_offset;
  uint32_t first_instance;
} gpu_indirect_indexed;

typedef struct gpu_indirect_dispatch {
  uint32_t groups[3];
} gpu_indirect_dispatch;

typedef struct gpu_draw {
  gpu_buffer *streams[GPU_MAX_STREAMS]; /* may be NULL beyond the program's stream_count */
  uint64_t stream_offsets[GPU_MAX_STREAMS];
  gpu_buffer *indices; /* NULL: not indexed, count is vertices */
  uint64_t index_offset;
  uint32_t index_size; /* 2 or 4 */
  uint32_t count;
  uint32_t instance_count;   /* the first instance is always 0: move the stream's offset instead */
  gpu_buffer *arguments;     /* gpu_indirect_indexed or gpu_indirect_draw, instead of the two counts; NULL: none */
  uint64_t arguments_offset; /* a multiple of 4 */
} gpu_draw;

typedef struct gpu_dispatch_info {
  gpu_program *program;
  gpu_bindings *bindings;    /* NULL: the program reads and writes nothing */
  const uint32_t *offsets;   /* as pass_bind's */
  uint32_t groups[3];        /* 1 to 65535 each */
  gpu_buffer *arguments;     /* gpu_indirect_dispatch, instead of groups; NULL: none */
  uint64_t arguments_offset; /* a multiple of 4 */
} gpu_dispatch_info;

#define GPU_MAX_TIMESTAMPS 64

/* ---- the table ---- */

#define GPU_INTERFACE_VERSION 2u

/* Whose handles and structs `native` means. */
typedef enum gpu_api { GPU_API_NULL, GPU_API_VULKAN, GPU_API_D3D12 } gpu_api;

typedef struct gpu_backend {
  const char *name; /* "vulkan" */
  gpu_api api;

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
  uint64_t (*buffer_native)(const gpu_buffer *buffer); /* VkBuffer, or ID3D12Resource* */
  /* The format can what the usage asks (gpu_capabilities.formats). */
  csm_result (*image_create)(gpu_device *device, const gpu_image_info *info, gpu_image **out);
  void (*image_destroy)(gpu_device *device, gpu_image *image);
  uint64_t (*image_bytes)(const gpu_image *image); /* device memory that it takes */
  void (*image_native)(const gpu_device *device, const gpu_image *image, gpu_native_image *out);
  /* D3D12: writes a shader resource view of the whole image to an engine's CPU descriptor. Vulkan: nothing. */
  void (*image_describe)(gpu_device *device, const gpu_image *image, uint64_t descriptor);
  /* The engine's own image to sample (csm_vulkan_image, csm_d3d12_image). It is in a state that shaders read, and stays
     in it. Its format holds such texels. Destroyed like any other. Errors: those of creation, NULL_POINTER, STRUCT_SIZE,
     INVALID_VALUE. */
  csm_result (*image_import)(gpu_device *device, const void *native, gpu_texels texels, gpu_image **out,
                             gpu_imported *about);
  /* The engine's own vertices and indices (csm_vulkan_mesh, csm_d3d12_mesh), readable as such while they are drawn.
     Both buffers are destroyed like any other, the indices' only if it is another one. Errors: as image_import. */
  csm_result (*geometry_import)(gpu_device *device, const void *native, gpu_geometry *out);
  /* A view goes before its image, a target before its images. Bindings that bind what is gone are written or destroyed
     before they are used. */
  csm_result (*view_create)(gpu_device *device, const gpu_view_info *info, gpu_view **out);
  void (*view_destroy)(gpu_device *device, gpu_view *view);
  csm_result (*target_create)(gpu_device *device, const gpu_target_info *info, gpu_target **out);
  void (*target_destroy)(gpu_device *device, gpu_target *target);
  /* What pass_native will tell of passes over targets of these formats. Errors: those of creation. */
  csm_result (*target_native)(gpu_device *device, gpu_format depth, gpu_format color, gpu_native_target *out);
  /* Also UNSUPPORTED: what gpu_capabilities says that the device cannot (a raster bias with a clamp, anisotropy,
     compute, stores by a pixel shader, so many buffers). */
  csm_result (*program_create)(gpu_device *device, const gpu_program_info *info, gpu_program **out);
  void (*program_destroy)(gpu_device *device, gpu_program *program);
  csm_result (*bindings_create)(gpu_device *device, const gpu_bindings_info *info, gpu_bindings **out);
  /* Makes bindings that no recording in flight uses read and write other things. Cannot fail. */
  void (*bindings_write)(gpu_device *device, gpu_bindings *bindings, const gpu_bindings_info *info);
  void (*bindings_destroy)(gpu_device *device, gpu_bindings *bindings);

  /* Bytes of device memory that this process may still take, as the driver says; UINT64_MAX if it does not. */
  uint64_t (*memory_available)(gpu_device *device);

  /* Recording. On an own device `begin` waits until the slot's earlier recording is done. On an engine's nothing is
     ever waited for, and the front sees to it that the slot is free. Errors: DEVICE_LOST, DEVICE, OUT_OF_MEMORY,
     OUT_OF_DEVICE_MEMORY. */
  csm_result (*begin)(gpu_device *device, const gpu_record_info *info);
  /* Markers and timestamps stand outside passes. A recording ends each marker that it begins. */
  void (*marker_begin)(gpu_device *device, const char *name);
  void (*marker_end)(gpu_device *device);
  void (*timestamp)(gpu_device *device, uint32_t index); /* below GPU_MAX_TIMESTAMPS, each once for a frame's slot */

  /* ---- outside passes ---- */

  /* Between buffers: `to` of kind DEVICE or READBACK, `from` of kind UPLOAD or DEVICE, and not the same buffer. Earlier
     frames in flight may still read `to`. */
  void (*copy_buffer)(gpu_device *device, gpu_buffer *to, uint64_t to_offset, gpu_buffer *from, uint64_t from_offset,
                      uint64_t size);
  /* A region to a readback buffer: its row r begins at offset + r * row_bytes, offset a multiple of 512, row_bytes one
     of 256. Of a depth image it is a whole {layer, level}, for Direct3D 12 copies no part of one. */
  void (*copy_image)(gpu_device *device, gpu_buffer *to, uint64_t offset, uint32_t row_bytes, gpu_image *image,
                     const gpu_region *from);
  /* A region of an image that is no depth, from an upload buffer with rows as above; the rest of it is kept. */
  void (*copy_to_image)(gpu_device *device, gpu_image *image, const gpu_region *to, gpu_buffer *from, uint64_t offset,
                        uint32_t row_bytes);
  /* Every layer and level of a depth image, the cheapest way that the API offers; 0 and 1 are what it is cheapest for.
   */
  void (*clear_depth)(gpu_device *device, gpu_image *image, float depth);
  /* Makes layers and levels readable by shaders in the passes that follow. */
  void (*make_readable)(gpu_device *device, gpu_image *image, const gpu_range *range);
  /* Runs a compute program. What the dispatches, draws and copies before it wrote is there, and what it writes is there
     for those after it. */
  void (*dispatch)(gpu_device *device, const gpu_dispatch_info *info);

  /* ---- passes ---- */

  /* Begins a pass. Up to pass_end nothing else than what stands here is recorded. */
  void (*pass_begin)(gpu_device *device, const gpu_pass_info *info);
  /* Restricts what follows to a part of the pass's area: clip space covers the part, texel row 0 of it at clip y = +1,
     and nothing is drawn outside it. In the target's texels. pass_begin covers the pass's area, or its clip_space. */
  void (*pass_area)(gpu_device *device, const gpu_rect *area);
  void (*pass_end)(gpu_device *device);
  /* Forgets what was bound. */
  void (*pass_program)(gpu_device *device, gpu_program *program);
  /* `offsets`: one for each of the program's constants, a multiple of 256. No texture is the pass's target. */
  void (*pass_bind)(gpu_device *device, gpu_bindings *bindings, const uint32_t *offsets);
  void (*pass_draw)(gpu_device *device, const gpu_draw *draw);
  /* What an engine needs to draw into the open pass itself. Viewport and scissor cover the last pass_area's. What the
     engine binds is forgotten with the next pass_program, what it makes of viewport and scissor with the next
     pass_area. */
  void (*pass_native)(gpu_device *device, gpu_native_pass *out);

  /* Ends the recording, and submits it on an own device; an engine's command buffer stays open. Errors: DEVICE_LOST,
     DEVICE, OUT_OF_MEMORY. */
  csm_result (*end)(gpu_device *device);
  /* Waits for the slot's last recording. Own device only. Errors: DEVICE_LOST. */
  csm_result (*wait)(gpu_device *device, uint32_t slot);
  /* Reads `count` timestamps of the slot's finished recordings from index `first` on, in nanoseconds. All were taken,
     that at `first` before the others. Errors: DEVICE_LOST, UNSUPPORTED (nothing was measured: the queue has no
     timestamps, or an engine did not submit the recording). */
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
