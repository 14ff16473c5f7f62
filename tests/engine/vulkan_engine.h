/*
 * vulkan_engine.h: as much of an engine as tests need: a Vulkan device of its own, with validation, frames in flight,
 * images and buffers. What must not fail ends the program with a text.
 */
#ifndef VULKAN_ENGINE_H
#define VULKAN_ENGINE_H

#include "csm/csm_vulkan.h"

#include <stdbool.h>
#include <vulkan/vulkan.h>

typedef enum vulkan_engine_kind {
  VULKAN_ENGINE_TYPICAL, /* as Godot 4.6 opens one: 1.2 without any of its features, depthBiasClamp, debug utils */
  VULKAN_ENGINE_BARE,    /* 1.1, depthClamp, and nothing else */
  VULKAN_ENGINE_MODERN,  /* 1.3 with dynamic rendering, a pipeline cache, and an allocator of its own */
  VULKAN_ENGINE_CLIPPING /* 1.1 without depthClamp: csm cannot use it */
} vulkan_engine_kind;

enum { VULKAN_ENGINE_FRAMES = 3 };

typedef struct vulkan_engine {
  VkInstance instance;
  VkPhysicalDevice physical;
  VkDevice device;
  VkQueue queue;
  uint32_t family;
  VkPhysicalDeviceMemoryProperties memory;
  VkPhysicalDeviceFeatures features; /* enabled */
  csm_vulkan_device native;          /* what csm gets */
  VkPipelineCache cache;             /* of a modern engine, as are these: */
  uint32_t pieces, most_pieces;      /* of memory that csm has now, and had at most */

  VkDebugReportCallbackEXT reporter;
  uint32_t messages; /* errors and warnings of validation, which are printed; with its synchronization checks */

  /* frames, by number modulo VULKAN_ENGINE_FRAMES */
  struct {
    VkCommandPool pool;
    VkCommandBuffer commands;
    VkFence fence;
  } frames[VULKAN_ENGINE_FRAMES];
  uint64_t frame; /* the last that was begun, from 1 */
  uint64_t done;  /* the last that the GPU is done with */
} vulkan_engine;

/* Pipelines that a modern engine's device made without its cache, and with it, since the program began. */
uint32_t vulkan_engine_uncached(void);
uint32_t vulkan_engine_cached(void);

void vulkan_engine_open(vulkan_engine *engine, vulkan_engine_kind kind);
void vulkan_engine_close(vulkan_engine *engine);

/* Begins the next frame's command buffer, and ends it; it is not submitted yet, so csm cannot count on its being done.
 */
VkCommandBuffer vulkan_engine_begin(vulkan_engine *engine);
void vulkan_engine_end(vulkan_engine *engine);
/* Submits the frames up to and with `frame`, in their order, and waits for them. */
void vulkan_engine_run(vulkan_engine *engine, uint64_t frame);

typedef struct engine_buffer {
  VkBuffer handle;
  VkDeviceMemory memory;
  void *mapped;
  uint64_t size;
} engine_buffer;

/* A mapped, coherent buffer for vertices, indices and copies. */
engine_buffer vulkan_engine_buffer(vulkan_engine *engine, uint64_t size);
void vulkan_engine_buffer_destroy(vulkan_engine *engine, engine_buffer *buffer);

typedef struct engine_image {
  VkImage handle;
  VkDeviceMemory memory;
  csm_vulkan_image native;
} engine_image;

/* A 2D image to sample, of tightly packed texels, resting in `layout`. Runs all frames that were recorded. */
engine_image vulkan_engine_image(vulkan_engine *engine, VkFormat format, uint32_t width, uint32_t height,
                                 VkImageLayout layout, const void *texels, uint64_t size);
void vulkan_engine_image_destroy(vulkan_engine *engine, engine_image *image);

/* Copies a layer of csm's image, at rest before and after, as an engine does that samples it in compute shaders. */
void vulkan_engine_copy(VkCommandBuffer commands, VkImage from, VkImageAspectFlags aspect, uint32_t layer,
                        uint32_t width, uint32_t height, const engine_buffer *to, uint64_t offset);

#endif
