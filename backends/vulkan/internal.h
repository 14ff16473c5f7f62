/*
 * internal.h: what the files of the Vulkan backend share. It is made for Vulkan 1.1 core. VK_EXT_debug_utils,
 * VK_EXT_memory_budget and dynamic rendering are used where they are on.
 *
 * A device is opened in two steps. Its handles are obtained: own.c opens them, engine.c takes an engine's. Then they
 * are used. An engine's device has no queue here: nothing is submitted, and nothing waited for.
 */
#ifndef VULKAN_INTERNAL_H
#define VULKAN_INTERNAL_H

#include "../gpu.h"
#include "../lent.h"
#include "functions.h"

#include "csm/csm_vulkan.h"

#define VULKAN_MAX_SLOTS 8
#define VULKAN_LOADS (GPU_LOAD_CLEAR + 1)
#define VULKAN_DEPTHS (GPU_FORMAT_D16_UNORM + 1) /* depth formats, and none */

/* ---- memory.c ---- */
typedef struct vulkan_block vulkan_block;
typedef struct vulkan_span vulkan_span;

/* A piece of device memory. All zero is none. */
typedef struct vulkan_memory {
  VkDeviceMemory handle;
  uint64_t offset, size;
  void *mapped; /* NULL unless host-visible */
  vulkan_block *block;
  vulkan_span *span;
  bool engine; /* from the engine's allocator: then no block and no span, but the engine's own handle */
  void *engine_handle;
} vulkan_memory;

/* What memory is for: an image, or a buffer of a kind. */
typedef struct vulkan_memory_request {
  VkMemoryRequirements needs;
  gpu_buffer_kind kind;
  VkImage image;
  VkBuffer buffer;
  const char *name; /* of an allocation that is not shared */
} vulkan_memory_request;

csm_result vulkan_memory_allocate(gpu_device *device, const vulkan_memory_request *request, vulkan_memory *out);
void vulkan_memory_release(gpu_device *device, vulkan_memory *memory);
/* The type that memory of this kind is taken from, or UINT32_MAX. Host-visible kinds are coherent: Vulkan promises such
   a type for every buffer, so nothing is ever flushed or invalidated. */
uint32_t vulkan_memory_type(const gpu_device *device, uint32_t allowed_types, gpu_buffer_kind kind);

/* ---- objects ---- */

/* How a {layer, level} of an image is used, or was last. */
typedef struct vulkan_use {
  VkImageLayout layout;
  VkPipelineStageFlags stages;
  VkAccessFlags access;
  bool ready; /* a barrier towards this use was recorded, and the use has not taken place */
} vulkan_use;

struct gpu_buffer {
  VkBuffer handle;
  VkBufferView texels; /* of all of it, if it is made to be read so */
  vulkan_memory memory;
  gpu_buffer_kind kind;
  uint64_t size;
  bool borrowed;                     /* an engine's: neither destroyed nor copied */
  uint64_t epoch;                    /* of the transfers in the range below */
  uint64_t copied_begin, copied_end; /* what copies have read or written since the last barrier between transfers */
};

struct gpu_image {
  VkImage handle;
  VkImageView view;             /* what shaders see of all of it; none without GPU_IMAGE_SAMPLED */
  VkImageLayout sampled_layout; /* while shaders see it */
  bool borrowed;                /* an engine's view, of an image whose state is the engine's: no handle, no states */
  vulkan_memory memory;
  gpu_format format;
  uint32_t width, height, layer_count, level_count;
  bool array; /* shaders see one */
  VkImageAspectFlags aspect;
  bool used; /* in the current recording, and in its list */
  gpu_image *next_used;
  vulkan_use *before;  /* each {layer, level}'s state before the current recording; valid if used */
  vulkan_use states[]; /* and now: by layer, then level */
};

struct gpu_view {
  VkImageView handle;
  gpu_image *image;
  gpu_range range; /* without counts of 0 */
};

typedef struct vulkan_attachment {
  gpu_image *image; /* NULL: none */
  VkImageView view;
  gpu_range range; /* one {layer, level} */
} vulkan_attachment;

struct gpu_target {
  vulkan_attachment depth, color;
  VkFramebuffer framebuffer; /* none with dynamic rendering */
  uint32_t width, height;
};

struct gpu_program {
  VkDescriptorSetLayout set_layout;
  VkPipelineLayout layout;
  VkPipeline pipeline;
  uint32_t stream_count;
  uint32_t constants_count, texture_count, buffer_count, texel_buffer_count;
  uint32_t store_image_count, store_buffer_count, sampler_count;
  uint32_t constants_sizes[GPU_MAX_CONSTANTS];
};

/* An image's range as bindings have it. */
typedef struct vulkan_bound {
  gpu_image *image;
  gpu_range range;
} vulkan_bound;

struct gpu_bindings {
  VkDescriptorPool pool;
  VkDescriptorSet set; /* none if the program reads nothing */
  VkPipelineLayout layout;
  uint32_t constants_count, texture_count, store_image_count, store_buffer_count;
  bool buffers; /* it reads or writes some */
  vulkan_bound textures[GPU_MAX_TEXTURES];
  vulkan_bound store_images[GPU_MAX_STORES];
};

/* One frame in flight. All but the queries are there on an own device alone. */
typedef struct vulkan_slot {
  VkCommandPool pool;
  VkCommandBuffer commands;
  VkFence fence;
  VkQueryPool queries; /* none if the queue has no timestamps */
  bool submitted;      /* and not known to be done */
} vulkan_slot;

/* What touches buffers on the device's own memory. */
typedef enum vulkan_work { VULKAN_COPIES, VULKAN_DRAWS, VULKAN_DISPATCHES, VULKAN_WORKS } vulkan_work;

struct gpu_device {
  gpu_lent lent;

  /* handles: obtained by own.c or engine.c */
  bool own;      /* else an engine's */
  void *library; /* own.c's, as are the messenger and the queue */
  vulkan_functions vk;
  VkInstance instance;
  VkDebugUtilsMessengerEXT messenger;
  VkPhysicalDevice physical;
  VkDevice handle;
  VkQueue queue;
  uint32_t queue_family;
  VkPipelineCache pipeline_cache;               /* the engine's, or none */
  csm_vulkan_allocate_function allocate_memory; /* the engine's, or NULL */
  csm_vulkan_free_function free_memory;
  void *memory_user;
  VkPhysicalDeviceFeatures features; /* that are enabled, of those that matter here */
  bool usable;                       /* its functions are loaded */
  bool debug;                        /* objects are named, and passes marked, by VK_EXT_debug_utils */
  bool driver_properties;            /* VK_KHR_driver_properties may be asked */
  bool memory_budget;                /* VK_EXT_memory_budget is on */
  bool dynamic_rendering;            /* is on: passes use it */

  /* what the device is */
  gpu_device_info info;
  VkPhysicalDeviceMemoryProperties memory;
  uint32_t max_stride;     /* of vertices, in bytes */
  vulkan_use read;         /* by shaders: the state in which images rest */
  uint64_t timestamp_mask; /* 0: no timestamps */
  double timestamp_period_ns;

  /* what is made on it */
  vulkan_block *blocks;
  VkSampler samplers[GPU_SAMPLER_COUNT]; /* none: the device has not got it */
  VkRenderPass passes[VULKAN_DEPTHS][GPU_FORMAT_COUNT][VULKAN_LOADS][VULKAN_LOADS]; /* of depth, of colour */
  vulkan_slot slots[VULKAN_MAX_SLOTS];
  uint32_t slot_count;

  /* the current recording */
  vulkan_slot *slot;
  VkCommandBuffer commands;
  gpu_image *used_images; /* a list */
  const gpu_target *target;
  uint32_t stream_count; /* of the pass's program */

  /* the state of all buffers, in recording order */
  uint64_t epoch;                  /* counts barriers between transfers */
  uint32_t buffer_usage;           /* of all buffers that were ever made */
  uint32_t written[VULKAN_WORKS];  /* written[w] bit k: work w wrote, and work k has had no barrier since */
  uint32_t accessed[VULKAN_WORKS]; /* accessed[w] bit k: work w read or wrote, and a write by k needs a barrier */
  bool readback_written;           /* in the current recording */
  bool recording_lost;             /* a recording, with its barriers, was never submitted */
};

/* ---- device.c ---- */
/* The csm_result of a VkResult; a failure is reported with the name of the function that failed. */
csm_result vulkan_check(const gpu_device *device, VkResult result, const char *function);
/* The same for a call that makes an object: after a failure its handle (64 bits) is undefined, and set to none here. */
csm_result vulkan_made(const gpu_device *device, VkResult result, void *handle, const char *function);
/* Names a Vulkan object for debuggers. */
void vulkan_name(const gpu_device *device, VkObjectType type, uint64_t handle, const char *name);

csm_result vulkan_query(const gpu_open_info *info, gpu_device_info *out);
csm_result vulkan_open(const gpu_open_info *info, gpu_device **out);
void vulkan_close(gpu_device *device);

/* ---- describe.c: what a device is ---- */
extern const gpu_needs vulkan_required, vulkan_optional; /* needs.c */
/* What it lacks, with these features enabled, that csm cannot do without; NULL if nothing. */
const char *vulkan_lacks(const gpu_device *device, VkPhysicalDevice physical, const VkPhysicalDeviceFeatures *features);
/* What a queue family can do; 0 if there is none. `timestamp_bits` may be NULL. */
VkQueueFlags vulkan_queue_flags(const gpu_device *device, VkPhysicalDevice physical, uint32_t family,
                                uint32_t *timestamp_bits);
csm_result vulkan_describe_physical(gpu_device *device);
void vulkan_describe(const gpu_device *device, gpu_device_info *out);
uint64_t vulkan_memory_available(gpu_device *device);

/* ---- format.c ---- */
VkFormat vulkan_format(gpu_format format);
/* Fills in info.can.formats. */
void vulkan_describe_formats(gpu_device *device);

/* ---- own.c: an own device's handles ---- */
csm_result vulkan_own_select(gpu_device *device, const gpu_open_info *info); /* library, instance, physical device */
csm_result vulkan_own_open(gpu_device *device);                              /* then the device */
void vulkan_own_close(gpu_device *device);                                   /* whatever of it there is */

/* ---- engine.c: an engine's handles, images and buffers ---- */
csm_result vulkan_engine_take(gpu_device *device, const void *native); /* csm_vulkan_device; checks it */
csm_result vulkan_image_import(gpu_device *device, const void *native, gpu_texels texels, gpu_image **out,
                               gpu_imported *about);
csm_result vulkan_geometry_import(gpu_device *device, const void *native, gpu_geometry *out);

/* ---- resource.c: buffers, images and views ---- */
csm_result vulkan_buffer_create(gpu_device *device, const gpu_buffer_info *info, gpu_buffer **out);
void vulkan_buffer_destroy(gpu_device *device, gpu_buffer *buffer);
void *vulkan_buffer_memory(gpu_buffer *buffer);
uint64_t vulkan_buffer_native(const gpu_buffer *buffer);
csm_result vulkan_image_create(gpu_device *device, const gpu_image_info *info, gpu_image **out);
void vulkan_image_destroy(gpu_device *device, gpu_image *image);
uint64_t vulkan_image_bytes(const gpu_image *image);
void vulkan_image_native(const gpu_device *device, const gpu_image *image, gpu_native_image *out);
void vulkan_image_describe(gpu_device *device, const gpu_image *image, uint64_t descriptor);
csm_result vulkan_view_create(gpu_device *device, const gpu_view_info *info, gpu_view **out);
void vulkan_view_destroy(gpu_device *device, gpu_view *view);
/* The range without counts of 0; NULL is all of the image. */
gpu_range vulkan_range(const gpu_image *image, const gpu_range *range);
VkImageSubresourceRange vulkan_subresources(const gpu_image *image, const gpu_range *range);
/* What shaders see of a range, or what a target draws into: that is no array. */
csm_result vulkan_image_view(gpu_device *device, const gpu_view_info *info, bool array, VkImageView *out);

/* ---- target.c ---- */
csm_result vulkan_target_create(gpu_device *device, const gpu_target_info *info, gpu_target **out);
void vulkan_target_destroy(gpu_device *device, gpu_target *target);
csm_result vulkan_target_native(gpu_device *device, gpu_format depth, gpu_format color, gpu_native_target *out);
/* Makes the render passes over targets of these formats, one for each load operation; the device keeps them. None with
   dynamic rendering. */
csm_result vulkan_passes_create(gpu_device *device, gpu_format depth, gpu_format color);

/* ---- program.c ---- */
csm_result vulkan_samplers_create(gpu_device *device);
csm_result vulkan_program_create(gpu_device *device, const gpu_program_info *info, gpu_program **out);
void vulkan_program_destroy(gpu_device *device, gpu_program *program);
/* ---- pipeline.c ---- */
csm_result vulkan_pipeline_create(gpu_device *device, gpu_program *program, const gpu_program_info *info);

/* ---- bindings.c ---- */
/* The layout of the set that a program reads, and of its pipeline. */
csm_result vulkan_layouts_create(gpu_device *device, gpu_program *program, const gpu_program_info *info);
csm_result vulkan_bindings_create(gpu_device *device, const gpu_bindings_info *info, gpu_bindings **out);
void vulkan_bindings_write(gpu_device *device, gpu_bindings *bindings, const gpu_bindings_info *info);
void vulkan_bindings_destroy(gpu_device *device, gpu_bindings *bindings);

/* ---- slot.c ---- */
csm_result vulkan_slot_create(gpu_device *device, vulkan_slot *slot);
void vulkan_slot_destroy(gpu_device *device, vulkan_slot *slot);
csm_result vulkan_begin(gpu_device *device, const gpu_record_info *info);
csm_result vulkan_end(gpu_device *device);
csm_result vulkan_wait(gpu_device *device, uint32_t slot);
csm_result vulkan_timestamps(gpu_device *device, uint32_t slot, uint32_t first, uint32_t count, uint64_t *nanoseconds);

/* ---- state.c ---- */
extern const vulkan_use vulkan_use_overwrite, vulkan_use_copy, vulkan_use_depth, vulkan_use_color,
    vulkan_use_dispatch_store, vulkan_use_draw_store;
/* Puts the barriers that a use of these layers and levels needs. `discard`: what they hold is not wanted. */
void vulkan_image_prepare(gpu_device *device, gpu_image *image, const gpu_range *range, const vulkan_use *next,
                          bool discard);
/* The same, for a use that takes place now. */
void vulkan_image_use(gpu_device *device, gpu_image *image, const gpu_range *range, const vulkan_use *next,
                      bool discard);
/* Ends what a recording did: images and buffers that shaders read rest readable between recordings. */
void vulkan_rest(gpu_device *device);
/* `recorded` false: the recording's uses will not take place. */
void vulkan_release_used(gpu_device *device, bool recorded);
void vulkan_memory_barrier(gpu_device *device, VkPipelineStageFlags from, VkAccessFlags written,
                           VkPipelineStageFlags to, VkAccessFlags access);
/* Puts the barriers that work of a kind needs, which reads buffers of the device's own memory, and writes some or none.
 */
void vulkan_use_buffers(gpu_device *device, vulkan_work work, bool writes);
/* A copy is about to read or write this range. */
void vulkan_copy_range(gpu_device *device, gpu_buffer *buffer, uint64_t offset, uint64_t size);

/* ---- record.c: what stands outside passes ---- */
void vulkan_marker_begin(gpu_device *device, const char *name);
void vulkan_marker_end(gpu_device *device);
void vulkan_timestamp(gpu_device *device, uint32_t index);
void vulkan_copy_buffer(gpu_device *device, gpu_buffer *to, uint64_t to_offset, gpu_buffer *from, uint64_t from_offset,
                        uint64_t size);
void vulkan_copy_image(gpu_device *device, gpu_buffer *to, uint64_t offset, uint32_t row_bytes, gpu_image *image,
                       const gpu_region *from);
void vulkan_copy_to_image(gpu_device *device, gpu_image *image, const gpu_region *to, gpu_buffer *from, uint64_t offset,
                          uint32_t row_bytes);
void vulkan_clear_depth(gpu_device *device, gpu_image *image, float depth);
void vulkan_make_readable(gpu_device *device, gpu_image *image, const gpu_range *range);
void vulkan_dispatch(gpu_device *device, const gpu_dispatch_info *info);

/* ---- pass.c ---- */
void vulkan_pass_begin(gpu_device *device, const gpu_pass_info *info);
void vulkan_pass_area(gpu_device *device, const gpu_rect *area);
void vulkan_pass_end(gpu_device *device);
void vulkan_pass_program(gpu_device *device, gpu_program *program);
void vulkan_pass_bind(gpu_device *device, gpu_bindings *bindings, const uint32_t *offsets);
void vulkan_pass_draw(gpu_device *device, const gpu_draw *draw);
void vulkan_pass_native(gpu_device *device, gpu_native_pass *out);

#endif
