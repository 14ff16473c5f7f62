/*
 * internal.h: what the files of the D3D12 backend share: Direct3D 12 of feature level 11_0, from a run time that
 * runtime.h describes.
 *
 * A device is opened in two steps: it is obtained (own.c opens it, engine.c takes an engine's), and then used. An
 * engine's device has no queue here: nothing is submitted, and nothing waited for.
 */
#ifndef D3D12_INTERNAL_H
#define D3D12_INTERNAL_H

#include "../gpu.h"
#include "../lent.h"
#include "csm/csm_d3d12.h"
#include "runtime.h"

#define D3D12_MAX_SLOTS 8
#define D3D12_MAX_BARRIERS 16
#define D3D12_FILL_SIZE (128u << 10) /* of each part of gpu_device.fill: stays in a core's cache */

/* Every state in which shaders of any stage read. */
#define D3D12_STATE_READABLE                                                                                           \
  (D3D12_RESOURCE_STATE_PIXEL_SHADER_RESOURCE | D3D12_RESOURCE_STATE_NON_PIXEL_SHADER_RESOURCE)

/* The parts of gpu_device.fill: texels of depth 0 in either format, and of depth 1 in each. */
enum { D3D12_FILL_ZERO, D3D12_FILL_ONE_D32, D3D12_FILL_ONE_D16, D3D12_FILL_PARTS };

/* The most descriptors of one block, in this order: textures, buffers, store images, store buffers. */
enum { D3D12_MAX_BLOCK = GPU_MAX_TEXTURES + GPU_MAX_BUFFERS + 2 * GPU_MAX_STORES };

/* What ExecuteIndirect reads: the structs of gpu.h. */
typedef enum d3d12_command { D3D12_DRAW, D3D12_DRAW_INDEXED, D3D12_DISPATCH, D3D12_COMMANDS } d3d12_command;

/* D3D12SerializeRootSignature. */
typedef HRESULT(WINAPI *d3d12_serializer)(const D3D12_ROOT_SIGNATURE_DESC *signature,
                                          D3D_ROOT_SIGNATURE_VERSION version, ID3DBlob **blob, ID3DBlob **error);

/* ---- objects ---- */

/* A resource and what it lies in. */
typedef struct d3d12_resource {
  ID3D12Resource *handle;
  csm_d3d12_memory memory; /* the engine's; no heap: a committed resource */
  uint64_t bytes;
} d3d12_resource;

struct gpu_buffer {
  d3d12_resource resource;
  gpu_buffer_kind kind;
  bool borrowed; /* an engine's: it keeps its state */
  uint64_t size;
  D3D12_GPU_VIRTUAL_ADDRESS address;
  void *mapped;
  D3D12_RESOURCE_STATES state;
  D3D12_RESOURCE_STATES readable;    /* all in which draws and dispatches may read it, by its usage */
  uint64_t copied_begin, copied_end; /* the bytes that copies wrote since the last barrier; end 0: none */
  bool used;                         /* in the current recording, and in its list */
  gpu_buffer *next_used;
};

struct gpu_image {
  d3d12_resource resource;
  bool borrowed;
  gpu_format format;
  DXGI_FORMAT view_format; /* as shaders read it */
  bool sampled, array;
  uint32_t width, height, layer_count, level_count;
  ID3D12DescriptorHeap *clear_heap; /* depth: a view of all layers for each level */
  bool used;
  gpu_image *next_used;
  D3D12_RESOURCE_STATES *before;  /* each {layer, level}'s state before the current recording; valid if used */
  D3D12_RESOURCE_STATES states[]; /* and now: level + layer * level_count */
};

struct gpu_view {
  gpu_image *image;
  gpu_range range; /* no count is 0 */
};

typedef struct d3d12_attachment {
  gpu_image *image;           /* NULL: none */
  ID3D12DescriptorHeap *heap; /* one view */
  gpu_range range;            /* one {layer, level} */
} d3d12_attachment;

struct gpu_target {
  d3d12_attachment depth, color;
  uint32_t width, height;
};

struct gpu_program {
  ID3D12RootSignature *signature;
  ID3D12PipelineState *pipeline;
  uint32_t constants_count, texture_count, buffer_count, texel_buffer_count, store_image_count, store_buffer_count;
  uint32_t stream_count;
  uint32_t strides[GPU_MAX_STREAMS];
};

/* A shader-visible heap of descriptors, of which blocks are taken from the first on. */
typedef struct d3d12_page d3d12_page;
struct d3d12_page {
  ID3D12DescriptorHeap *heap;
  uint32_t size, taken;
  d3d12_page *next; /* a smaller one, which is full */
};

/* What bindings have of a page: as many descriptors as their program's shape needs. */
typedef struct d3d12_block d3d12_block;
struct d3d12_block {
  const d3d12_page *page;
  uint32_t first, size;
  d3d12_block *next; /* a free one of the same size */
};

struct gpu_bindings {
  gpu_bindings_info info; /* name and program are NULL: neither need live as long */
  uint32_t constants_count, texture_count, buffer_count, texel_buffer_count, store_image_count, store_buffer_count;
  d3d12_block *block; /* NULL: no table */
  D3D12_GPU_DESCRIPTOR_HANDLE table;
};

/* One frame in flight, on an own device. */
typedef struct d3d12_slot {
  ID3D12CommandAllocator *allocator;
  ID3D12GraphicsCommandList *list;
  uint64_t fence_value; /* reached when the slot's last recording is done; 0: there was none */
} d3d12_slot;

/* What is bound while a pass is recorded, so that draws bind only what changes. */
typedef struct d3d12_bound {
  const gpu_program *program;
  const gpu_buffer *streams[GPU_MAX_STREAMS];
  uint64_t stream_offsets[GPU_MAX_STREAMS];
  const gpu_buffer *indices;
  uint32_t index_size;
} d3d12_bound;

struct gpu_device {
  gpu_lent lent;

  /* obtained by own.c or engine.c */
  bool own; /* else an engine's */
  const d3d12_traits *traits;
  d3d12_runtime *runtime; /* own.c's, as are the queue and its fence */
  ID3D12Device *handle;
  ID3D12CommandQueue *queue;
  ID3D12Fence *fence;
  uint64_t fence_value;
  d3d12_serializer serialize;                  /* the engine's, as is the allocator */
  csm_d3d12_allocate_function allocate_memory; /* NULL: resources are committed ones */
  csm_d3d12_free_function free_memory;
  void *memory_user;

  gpu_device_info info;
  d3d12_slot slots[D3D12_MAX_SLOTS];
  uint32_t slot_count;

  /* Shader-visible descriptors: a list, of which the first has room; and free blocks by size */
  d3d12_page *pages;
  d3d12_block *free_blocks[D3D12_MAX_BLOCK + 1];
  uint32_t descriptor_size;

  ID3D12CommandSignature *command_signatures[D3D12_COMMANDS];

  /* D3D12_FILL_PARTS of texels, to clear depths by copies where the CPU is the device; else NULL */
  gpu_buffer *fill;

  /* GPU_MAX_TIMESTAMPS for each slot */
  ID3D12QueryHeap *queries;
  gpu_buffer *query_results;
  uint64_t ticks_per_second;

  /* the current recording */
  ID3D12GraphicsCommandList *list;
  uint32_t slot;
  uint32_t timestamps_begin, timestamps_end; /* those taken lie between */
  uint32_t barrier_count;
  D3D12_RESOURCE_BARRIER barriers[D3D12_MAX_BARRIERS];
  gpu_buffer *used_buffers; /* lists */
  gpu_image *used_images;
  const gpu_target *target;
  const ID3D12DescriptorHeap *heap; /* csm's that is set in the list; NULL: none */
  d3d12_bound bound;
};

/* ---- device.c ---- */
/* The csm_result of an HRESULT; a failure is reported with the name of the function that failed. */
csm_result d3d12_check(const gpu_device *device, HRESULT hr, const char *function);
/* Names an ID3D12Object for debuggers; NULL is no name. */
void d3d12_name(void *object, const char *name);
/* Gives up a reference to a COM object; takes NULL. */
void d3d12_unref(void *object);

csm_result d3d12_query(const gpu_open_info *info, gpu_device_info *out);
csm_result d3d12_open(const gpu_open_info *info, gpu_device **out);
void d3d12_close(gpu_device *device);

/* ---- describe.c: what a device is ---- */
bool d3d12_has_feature_level(ID3D12Device *handle);
/* What Direct3D 12 tells of an engine's device. */
void d3d12_describe_handle(gpu_device *device);
/* What every device of feature level 11_0 can. */
void d3d12_describe_level(gpu_capabilities *out);
void d3d12_describe(const gpu_device *device, gpu_device_info *out);
uint64_t d3d12_memory_available(gpu_device *device);

/* ---- format.c ---- */
DXGI_FORMAT d3d12_format(gpu_format format);
/* What a resource is made in, and copied in, so that it may hold depths and be read as well. */
DXGI_FORMAT d3d12_resource_format(gpu_format format);
/* As shaders read it. */
DXGI_FORMAT d3d12_view_format(gpu_format format);
/* Fills in info.can.formats of an engine's device. */
void d3d12_describe_formats(gpu_device *device);

/* ---- own.c: an own device ---- */
csm_result d3d12_own_select(gpu_device *device, const gpu_open_info *info); /* run time and adapter */
csm_result d3d12_own_open(gpu_device *device);                              /* then device, queue and fence */
void d3d12_own_close(gpu_device *device);                                   /* whatever of it there is */

/* ---- engine.c: an engine's device, images and buffers ---- */
csm_result d3d12_engine_take(gpu_device *device, const void *native); /* csm_d3d12_device; checks it */
csm_result d3d12_image_import(gpu_device *device, const void *native, gpu_texels texels, gpu_image **out,
                              gpu_imported *about);
csm_result d3d12_geometry_import(gpu_device *device, const void *native, gpu_geometry *out);

/* ---- memory.c ---- */
/* Makes a resource in the state, in memory of its own or in the engine's. */
csm_result d3d12_resource_create(gpu_device *device, D3D12_HEAP_TYPE heap, const D3D12_RESOURCE_DESC *description,
                                 D3D12_RESOURCE_STATES state, const char *name, d3d12_resource *out);
void d3d12_resource_destroy(gpu_device *device, d3d12_resource *resource);

/* ---- resource.c: buffers, images and views ---- */
csm_result d3d12_buffer_create(gpu_device *device, const gpu_buffer_info *info, gpu_buffer **out);
void d3d12_buffer_destroy(gpu_device *device, gpu_buffer *buffer);
void *d3d12_buffer_memory(gpu_buffer *buffer);
uint64_t d3d12_buffer_native(const gpu_buffer *buffer);
csm_result d3d12_image_create(gpu_device *device, const gpu_image_info *info, gpu_image **out);
void d3d12_image_destroy(gpu_device *device, gpu_image *image);
uint64_t d3d12_image_bytes(const gpu_image *image);
void d3d12_image_native(const gpu_device *device, const gpu_image *image, gpu_native_image *out);
void d3d12_image_describe(gpu_device *device, const gpu_image *image, uint64_t descriptor);
csm_result d3d12_view_create(gpu_device *device, const gpu_view_info *info, gpu_view **out);
void d3d12_view_destroy(gpu_device *device, gpu_view *view);
/* The range without counts of 0; NULL is all of the image. */
gpu_range d3d12_range(const gpu_image *image, const gpu_range *range);
/* Writes what shaders read, or write, of an image to a descriptor. */
void d3d12_view_read(gpu_device *device, const gpu_view *view, D3D12_CPU_DESCRIPTOR_HANDLE descriptor);
void d3d12_view_store(gpu_device *device, const gpu_view *view, D3D12_CPU_DESCRIPTOR_HANDLE descriptor);
/* Texels to clear depths by copies with. */
csm_result d3d12_fill_create(gpu_device *device);

/* ---- target.c ---- */
csm_result d3d12_target_create(gpu_device *device, const gpu_target_info *info, gpu_target **out);
void d3d12_target_destroy(gpu_device *device, gpu_target *target);
csm_result d3d12_target_native(gpu_device *device, gpu_format depth, gpu_format color, gpu_native_target *out);
/* A depth view of the range's layers for each level of it, in a heap of their own. */
csm_result d3d12_depth_views_create(gpu_device *device, const gpu_image *image, gpu_range range,
                                    ID3D12DescriptorHeap **out);
D3D12_CPU_DESCRIPTOR_HANDLE d3d12_depth_view(gpu_device *device, ID3D12DescriptorHeap *heap, uint32_t index);

/* ---- program.c ---- */
D3D12_STATIC_SAMPLER_DESC d3d12_sampler(const gpu_device *device, gpu_sampler sampler, uint32_t shader_register);
csm_result d3d12_command_signatures_create(gpu_device *device);
csm_result d3d12_program_create(gpu_device *device, const gpu_program_info *info, gpu_program **out);
void d3d12_program_destroy(gpu_device *device, gpu_program *program);

/* ---- pipeline.c ---- */
csm_result d3d12_pipeline_create(gpu_device *device, gpu_program *program, const gpu_program_info *info);

/* ---- bindings.c ---- */
/* The first page, and in the end all of them. */
csm_result d3d12_descriptors_create(gpu_device *device);
void d3d12_descriptors_destroy(gpu_device *device);
csm_result d3d12_signature_create(gpu_device *device, gpu_program *program, const gpu_program_info *info);
csm_result d3d12_bindings_create(gpu_device *device, const gpu_bindings_info *info, gpu_bindings **out);
void d3d12_bindings_write(gpu_device *device, gpu_bindings *bindings, const gpu_bindings_info *info);
void d3d12_bindings_destroy(gpu_device *device, gpu_bindings *bindings);

/* ---- slot.c ---- */
csm_result d3d12_slot_create(gpu_device *device, d3d12_slot *slot);
void d3d12_slot_destroy(d3d12_slot *slot);
csm_result d3d12_queries_create(gpu_device *device);
csm_result d3d12_begin(gpu_device *device, const gpu_record_info *info);
csm_result d3d12_end(gpu_device *device);
csm_result d3d12_wait(gpu_device *device, uint32_t slot);
csm_result d3d12_timestamps(gpu_device *device, uint32_t slot, uint32_t first, uint32_t count, uint64_t *nanoseconds);

/* ---- state.c ---- */
/* Records the barriers that were gathered, before a command that depends on them. */
void d3d12_flush_barriers(gpu_device *device);
/* Takes a range of an image, NULL for all, into a state. Where shaders have written it, they write again in order. */
void d3d12_image_use(gpu_device *device, gpu_image *image, const gpu_range *part, D3D12_RESOURCE_STATES state);
/* Makes a part of a buffer the next copy's destination. */
void d3d12_buffer_use_target(gpu_device *device, gpu_buffer *buffer, uint64_t begin, uint64_t size);
void d3d12_buffer_use_source(gpu_device *device, gpu_buffer *buffer);
/* A draw or a dispatch reads a buffer in a state, which Direct3D 12 promotes it to where it rests. */
void d3d12_buffer_use_read(gpu_device *device, gpu_buffer *buffer, D3D12_RESOURCE_STATES state);
void d3d12_buffer_use_store(gpu_device *device, gpu_buffer *buffer);
/* Takes what shaders write through the bindings into the state for it. */
void d3d12_use_stores(gpu_device *device, const gpu_bindings *bindings);
/* Makes every buffer readable that this recording has written. */
void d3d12_settle_buffers(gpu_device *device);
/* Brings all that the recording used to the states that it rests in. */
void d3d12_rest(gpu_device *device);
/* `recorded` false: the recording's barriers will not take place. */
void d3d12_release_used(gpu_device *device, bool recorded);

/* ---- record.c: outside passes ---- */
void d3d12_marker_begin(gpu_device *device, const char *name);
void d3d12_marker_end(gpu_device *device);
void d3d12_timestamp(gpu_device *device, uint32_t index);
void d3d12_copy_buffer(gpu_device *device, gpu_buffer *to, uint64_t to_offset, gpu_buffer *from, uint64_t from_offset,
                       uint64_t size);
void d3d12_copy_image(gpu_device *device, gpu_buffer *to, uint64_t offset, uint32_t row_bytes, gpu_image *image,
                      const gpu_region *from);
void d3d12_copy_to_image(gpu_device *device, gpu_image *image, const gpu_region *to, gpu_buffer *from, uint64_t offset,
                         uint32_t row_bytes);
/* Whether a depth is cleared by copies. */
bool d3d12_clears_by_copies(const gpu_device *device, float depth);
/* Clears a part of a depth image, which is in COPY_DEST, by copies. */
void d3d12_fill_depth(gpu_device *device, gpu_image *image, const gpu_region *region, float depth);
void d3d12_clear_depth(gpu_device *device, gpu_image *image, float depth);
void d3d12_make_readable(gpu_device *device, gpu_image *image, const gpu_range *range);
void d3d12_dispatch(gpu_device *device, const gpu_dispatch_info *info);

/* ---- pass.c ---- */
void d3d12_pass_begin(gpu_device *device, const gpu_pass_info *info);
void d3d12_pass_area(gpu_device *device, const gpu_rect *area);
void d3d12_pass_end(gpu_device *device);
void d3d12_pass_program(gpu_device *device, gpu_program *program);
/* Sets the heap that bindings lie in, where the list has another. */
void d3d12_set_heap(gpu_device *device, const gpu_bindings *bindings);
void d3d12_pass_bind(gpu_device *device, gpu_bindings *bindings, const uint32_t *offsets);
void d3d12_pass_draw(gpu_device *device, const gpu_draw *draw);
void d3d12_pass_native(gpu_device *device, gpu_native_pass *out);

#endif
