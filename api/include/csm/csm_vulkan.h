/*
 * csm_vulkan.h: an engine's own Vulkan device, its images and its buffers.
 *
 * csm records into the engine's command buffer, which is primary, open, belongs to queue_family, and is outside a
 * render pass. It submits nothing and waits for nothing: the engine submits what was recorded, in the order of
 * recording, to one queue. A recording leaves changed, for graphics: the pipeline and all dynamic state, descriptor
 * sets and push constants, vertex buffers 0 to 2, and the index buffer; for compute: the pipeline, descriptor sets and
 * push constants; nothing else.
 *
 * The maps and the mask rest in VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, owned by queue_family, and each recording
 * makes what it wrote visible to vertex, fragment and compute shaders that follow in the queue. An engine may sample them
 * there, and leaves them in that layout.
 */
#ifndef CSM_VULKAN_H
#define CSM_VULKAN_H

#include "csm_base.h"
#include <vulkan/vulkan_core.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What csm wants memory for. It is bound to `image` or `buffer`, of which the other is VK_NULL_HANDLE. */
typedef struct csm_vulkan_memory_request {
  uint32_t struct_size;
  uint32_t memory_type_bits; /* as VkMemoryRequirements has it */
  uint64_t size, alignment;
  VkImage image;
  VkBuffer buffer;
  uint32_t required;  /* VkMemoryPropertyFlags that the memory type must have; HOST_VISIBLE: to be mapped */
  uint32_t preferred; /* and those that it should */
  const char *name;   /* for debuggers */
} csm_vulkan_memory_request;

/* What the engine gives. */
typedef struct csm_vulkan_memory {
  VkDeviceMemory memory;
  uint64_t offset; /* a multiple of the alignment */
  void *mapped;    /* the piece's first byte, mapped until it is freed; NULL unless HOST_VISIBLE was required */
  void *handle;    /* the engine's own, given back when the piece is freed */
} csm_vulkan_memory;

/* Called inside csm's own calls that create, on the same thread. Must not call back into csm. VK_SUCCESS, or the error
   of vkAllocateMemory that comes closest, with nothing given. A NULL memory is OUT_OF_DEVICE_MEMORY. A piece that breaks
   the rules above is freed, and DEVICE. */
typedef VkResult(CSM_CALL *csm_vulkan_allocate_function)(void *user, const csm_vulkan_memory_request *request,
                                                         csm_vulkan_memory *out);
/* Takes back a piece, once nothing is bound to it and the GPU is done with it. Must not call back into csm. */
typedef void(CSM_CALL *csm_vulkan_free_function)(void *user, const csm_vulkan_memory *memory);

typedef struct csm_vulkan_device {
  uint32_t struct_size;
  uint32_t api_version; /* what the instance and the device were made for: VK_API_VERSION_1_1 or later */
  VkInstance instance;
  VkPhysicalDevice physical_device;
  VkDevice device;
  uint32_t queue_family; /* of the command buffers that csm records into: graphics */
  uint32_t reserved;     /* 0 */
  PFN_vkGetInstanceProcAddr get_instance_proc_addr;
  const char *const *extensions; /* device extensions that are enabled */
  uint32_t extension_count;
  uint32_t reserved2;                       /* 0 */
  const VkPhysicalDeviceFeatures *features; /* features that are enabled; NULL means none */
  /* Fields from here on may be left 0. The cache and the allocator outlive the context. */
  VkPipelineCache pipeline_cache; /* pipelines are made with it, on the thread that calls csm */
  uint32_t dynamic_rendering;     /* 1: its feature is enabled, and csm's passes use it; 0: they use render passes */
  uint32_t reserved3;             /* 0 */
  csm_vulkan_allocate_function allocate_memory; /* all device memory; NULL: vkAllocateMemory. Both, or neither */
  csm_vulkan_free_function free_memory;
  void *memory_user;
} csm_vulkan_device;

/*
 * An image to sample: the camera's depth, normals, or motion. It is readable by fragment shaders when the recording runs, and
 * stays in its layout. The view is 2D, of one layer, and of the depth aspect for depth.
 */
typedef struct csm_vulkan_image {
  uint32_t struct_size;
  uint32_t layout; /* VkImageLayout: SHADER_READ_ONLY_OPTIMAL, DEPTH_STENCIL_READ_ONLY_OPTIMAL or GENERAL */
  VkImageView view;
  /* VkFormat. Depth: D16, X8_D24, D24, D32, the same with S8, R16 and R32 as SFLOAT, R16_UNORM. Normals: RGBA8 and RGBA16
     as UNORM or SNORM, RGBA16 and RGBA32 as SFLOAT, R32G32B32_SFLOAT, B8G8R8A8_UNORM, A2B10G10R10_UNORM. Motion: RG16,
     RG32, RGBA16 and RGBA32 as SFLOAT. */
  uint32_t format;
  uint32_t width, height;
  uint32_t reserved; /* 0 */
} csm_vulkan_image;

/* A mesh in the engine's own buffers, used with VK_BUFFER_USAGE_VERTEX_BUFFER_BIT and INDEX_BUFFER_BIT. */
typedef struct csm_vulkan_mesh {
  uint32_t struct_size;
  uint32_t vertex_stride; /* bytes, a multiple of 4, at least 12 */
  VkBuffer vertices;
  uint64_t vertex_offset; /* of the first position: three floats */
  VkBuffer indices;
  uint64_t index_offset;
  uint64_t uv_offset; /* of the first pair of floats, in `vertices`; read only for a mesh with an alpha mask */
  uint32_t uv_stride; /* bytes, a multiple of 4, at least 8 */
  uint32_t reserved;  /* 0 */
} csm_vulkan_mesh;

#ifdef __cplusplus
}
#endif
#endif
