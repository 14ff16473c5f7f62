#include "vulkan_engine.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define VALIDATION "VK_LAYER_KHRONOS_validation"

static void must(VkResult result, const char *what) {
  if (result == VK_SUCCESS)
    return;
  fprintf(stderr, "engine: %s: VkResult %d\n", what, (int)result);
  abort();
}

/* ---- the device ---- */

/* Tells of the debug report extension, not of debug utils, which csm would take for the engine's. */
static VKAPI_ATTR VkBool32 VKAPI_CALL count_message(VkDebugReportFlagsEXT flags, VkDebugReportObjectTypeEXT type,
                                                    uint64_t object, size_t location, int32_t code, const char *layer,
                                                    const char *message, void *user) {
  (void)flags, (void)type, (void)object, (void)location, (void)code, (void)layer;
  vulkan_engine *engine = user;
  __atomic_fetch_add(&engine->messages, 1, __ATOMIC_RELAXED);
  fprintf(stderr, "engine: %s\n", message);
  return VK_FALSE;
}

static bool has_validation(void) {
  VkLayerProperties layers[32];
  uint32_t count = 32;
  vkEnumerateInstanceLayerProperties(&count, layers);
  for (uint32_t i = 0; i < count; ++i)
    if (!strcmp(layers[i].layerName, VALIDATION))
      return true;
  return false;
}

static uint32_t version_of(vulkan_engine_kind kind) {
  switch (kind) {
  case VULKAN_ENGINE_TYPICAL:
    return VK_API_VERSION_1_2;
  case VULKAN_ENGINE_MODERN:
    return VK_API_VERSION_1_3;
  default:
    return VK_API_VERSION_1_1;
  }
}

static void open_instance(vulkan_engine *engine, vulkan_engine_kind kind) {
  const bool validation = has_validation();
  const VkDebugReportCallbackCreateInfoEXT report = {.sType = VK_STRUCTURE_TYPE_DEBUG_REPORT_CALLBACK_CREATE_INFO_EXT,
                                                     .flags = VK_DEBUG_REPORT_ERROR_BIT_EXT |
                                                              VK_DEBUG_REPORT_WARNING_BIT_EXT,
                                                     .pfnCallback = count_message,
                                                     .pUserData = engine};
  const VkValidationFeatureEnableEXT enabled[] = {VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
  const VkValidationFeaturesEXT features = {.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
                                            .pNext = &report,
                                            .enabledValidationFeatureCount = 1,
                                            .pEnabledValidationFeatures = enabled};
  const VkApplicationInfo application = {
      .sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .pApplicationName = "an engine", .apiVersion = version_of(kind)};
  const char *const layers[] = {VALIDATION};
  const char *extensions[2];
  uint32_t count = 0;
  if (validation)
    extensions[count++] = VK_EXT_DEBUG_REPORT_EXTENSION_NAME;
  if (kind == VULKAN_ENGINE_TYPICAL)
    extensions[count++] = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
  const VkInstanceCreateInfo create = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                       .pNext = validation ? &features : NULL,
                                       .pApplicationInfo = &application,
                                       .enabledLayerCount = validation,
                                       .ppEnabledLayerNames = layers,
                                       .enabledExtensionCount = count,
                                       .ppEnabledExtensionNames = extensions};
  must(vkCreateInstance(&create, NULL, &engine->instance), "vkCreateInstance");
  if (!validation)
    return;
  const PFN_vkCreateDebugReportCallbackEXT listen =
      (PFN_vkCreateDebugReportCallbackEXT)vkGetInstanceProcAddr(engine->instance, "vkCreateDebugReportCallbackEXT");
  must(listen(engine->instance, &report, NULL, &engine->reporter), "vkCreateDebugReportCallbackEXT");
}

static uint32_t graphics_family(VkPhysicalDevice physical) {
  VkQueueFamilyProperties families[16];
  uint32_t count = 16;
  vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families);
  for (uint32_t i = 0; i < count; ++i)
    if (families[i].queueFlags & VK_QUEUE_GRAPHICS_BIT)
      return i;
  must(VK_ERROR_FEATURE_NOT_PRESENT, "a graphics queue");
  return 0;
}

static void open_device(vulkan_engine *engine, vulkan_engine_kind kind) {
  uint32_t count = 1;
  const VkResult found = vkEnumeratePhysicalDevices(engine->instance, &count, &engine->physical);
  must(count == 1 && found >= 0 ? VK_SUCCESS : VK_ERROR_INITIALIZATION_FAILED, "a Vulkan device");
  engine->family = graphics_family(engine->physical);
  engine->features = (VkPhysicalDeviceFeatures){.depthClamp = kind != VULKAN_ENGINE_CLIPPING,
                                                .depthBiasClamp = kind == VULKAN_ENGINE_TYPICAL};
  const float priority = 1;
  const VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                         .queueFamilyIndex = engine->family,
                                         .queueCount = 1,
                                         .pQueuePriorities = &priority};
  const VkPhysicalDeviceVulkan13Features rendering = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES,
                                                      .dynamicRendering = VK_TRUE};
  const VkDeviceCreateInfo create = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                     .pNext = kind == VULKAN_ENGINE_MODERN ? &rendering : NULL,
                                     .queueCreateInfoCount = 1,
                                     .pQueueCreateInfos = &queue,
                                     .pEnabledFeatures = &engine->features};
  must(vkCreateDevice(engine->physical, &create, NULL, &engine->device), "vkCreateDevice");
  vkGetDeviceQueue(engine->device, engine->family, 0, &engine->queue);
  vkGetPhysicalDeviceMemoryProperties(engine->physical, &engine->memory);
}

/* ---- what a modern engine lends ---- */

static uint32_t cached, uncached;

uint32_t vulkan_engine_cached(void) {
  return __atomic_load_n(&cached, __ATOMIC_RELAXED);
}

uint32_t vulkan_engine_uncached(void) {
  return __atomic_load_n(&uncached, __ATOMIC_RELAXED);
}

static VKAPI_ATTR VkResult VKAPI_CALL create_pipelines(VkDevice device, VkPipelineCache cache, uint32_t count,
                                                       const VkGraphicsPipelineCreateInfo *infos,
                                                       const VkAllocationCallbacks *allocator, VkPipeline *out) {
  __atomic_fetch_add(cache ? &cached : &uncached, count, __ATOMIC_RELAXED);
  return vkCreateGraphicsPipelines(device, cache, count, infos, allocator, out);
}

static PFN_vkVoidFunction VKAPI_CALL device_function(VkDevice device, const char *name) {
  return strcmp(name, "vkCreateGraphicsPipelines") ? vkGetDeviceProcAddr(device, name)
                                                   : (PFN_vkVoidFunction)create_pipelines;
}

static PFN_vkVoidFunction VKAPI_CALL instance_function(VkInstance instance, const char *name) {
  return strcmp(name, "vkGetDeviceProcAddr") ? vkGetInstanceProcAddr(instance, name)
                                             : (PFN_vkVoidFunction)device_function;
}

static uint32_t find_type(const vulkan_engine *engine, uint32_t allowed, VkMemoryPropertyFlags flags) {
  uint32_t type = 0;
  while (type < engine->memory.memoryTypeCount &&
         (!(allowed >> type & 1) || (engine->memory.memoryTypes[type].propertyFlags & flags) != flags))
    ++type;
  return type < engine->memory.memoryTypeCount ? type : UINT32_MAX;
}

/* Each piece begins somewhere in its allocation, as it does with an allocator that shares. */
static VkResult CSM_CALL lend_memory(void *user, const csm_vulkan_memory_request *request, csm_vulkan_memory *out) {
  vulkan_engine *engine = user;
  uint32_t type = find_type(engine, request->memory_type_bits, request->required | request->preferred);
  if (type == UINT32_MAX)
    type = find_type(engine, request->memory_type_bits, request->required);
  if (type == UINT32_MAX || request->struct_size != sizeof *request || !request->image == !request->buffer)
    return VK_ERROR_UNKNOWN;
  const VkMemoryAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                     .allocationSize = request->alignment + request->size,
                                     .memoryTypeIndex = type};
  VkResult result = vkAllocateMemory(engine->device, &info, NULL, &out->memory);
  void *mapped = NULL;
  if (result == VK_SUCCESS && (request->required & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT))
    result = vkMapMemory(engine->device, out->memory, 0, VK_WHOLE_SIZE, 0, &mapped);
  out->offset = request->alignment;
  out->mapped = mapped ? (char *)mapped + out->offset : NULL;
  out->handle = engine;
  if (++engine->pieces > engine->most_pieces)
    engine->most_pieces = engine->pieces;
  return result;
}

static void CSM_CALL take_memory_back(void *user, const csm_vulkan_memory *memory) {
  vulkan_engine *engine = user;
  must(memory->handle == engine ? VK_SUCCESS : VK_ERROR_UNKNOWN, "the engine's own handle");
  vkFreeMemory(engine->device, memory->memory, NULL);
  --engine->pieces;
}

static void lend(vulkan_engine *engine) {
  const VkPipelineCacheCreateInfo create = {.sType = VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO};
  must(vkCreatePipelineCache(engine->device, &create, NULL, &engine->cache), "vkCreatePipelineCache");
  engine->native.get_instance_proc_addr = instance_function;
  engine->native.pipeline_cache = engine->cache;
  engine->native.dynamic_rendering = 1;
  engine->native.allocate_memory = lend_memory;
  engine->native.free_memory = take_memory_back;
  engine->native.memory_user = engine;
}

void vulkan_engine_open(vulkan_engine *engine, vulkan_engine_kind kind) {
  *engine = (vulkan_engine){0};
  open_instance(engine, kind);
  open_device(engine, kind);
  for (uint32_t i = 0; i < VULKAN_ENGINE_FRAMES; ++i) {
    const VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                          .queueFamilyIndex = engine->family};
    must(vkCreateCommandPool(engine->device, &pool, NULL, &engine->frames[i].pool), "vkCreateCommandPool");
    const VkCommandBufferAllocateInfo commands = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                                  .commandPool = engine->frames[i].pool,
                                                  .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                                  .commandBufferCount = 1};
    must(vkAllocateCommandBuffers(engine->device, &commands, &engine->frames[i].commands), "vkAllocateCommandBuffers");
    const VkFenceCreateInfo fence = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    must(vkCreateFence(engine->device, &fence, NULL, &engine->frames[i].fence), "vkCreateFence");
  }
  engine->native = (csm_vulkan_device){.struct_size = sizeof engine->native,
                                       .api_version = version_of(kind),
                                       .instance = engine->instance,
                                       .physical_device = engine->physical,
                                       .device = engine->device,
                                       .queue_family = engine->family,
                                       .get_instance_proc_addr = vkGetInstanceProcAddr,
                                       .features = &engine->features};
  if (kind == VULKAN_ENGINE_MODERN)
    lend(engine);
}

void vulkan_engine_close(vulkan_engine *engine) {
  vulkan_engine_run(engine, engine->frame);
  for (uint32_t i = 0; i < VULKAN_ENGINE_FRAMES; ++i) {
    vkDestroyFence(engine->device, engine->frames[i].fence, NULL);
    vkDestroyCommandPool(engine->device, engine->frames[i].pool, NULL);
  }
  vkDestroyPipelineCache(engine->device, engine->cache, NULL);
  vkDestroyDevice(engine->device, NULL);
  if (engine->reporter)
    ((PFN_vkDestroyDebugReportCallbackEXT)vkGetInstanceProcAddr(engine->instance, "vkDestroyDebugReportCallbackEXT"))(
        engine->instance, engine->reporter, NULL);
  vkDestroyInstance(engine->instance, NULL);
}

/* ---- frames ---- */

VkCommandBuffer vulkan_engine_begin(vulkan_engine *engine) {
  if (++engine->frame > VULKAN_ENGINE_FRAMES)
    vulkan_engine_run(engine, engine->frame - VULKAN_ENGINE_FRAMES);
  const uint64_t slot = engine->frame % VULKAN_ENGINE_FRAMES;
  must(vkResetCommandPool(engine->device, engine->frames[slot].pool, 0), "vkResetCommandPool");
  const VkCommandBufferBeginInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                         .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
  must(vkBeginCommandBuffer(engine->frames[slot].commands, &info), "vkBeginCommandBuffer");
  return engine->frames[slot].commands;
}

void vulkan_engine_end(vulkan_engine *engine) {
  must(vkEndCommandBuffer(engine->frames[engine->frame % VULKAN_ENGINE_FRAMES].commands), "vkEndCommandBuffer");
}

void vulkan_engine_run(vulkan_engine *engine, uint64_t frame) {
  while (engine->done < frame) {
    const uint64_t slot = ++engine->done % VULKAN_ENGINE_FRAMES;
    const VkSubmitInfo submit = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
                                 .commandBufferCount = 1,
                                 .pCommandBuffers = &engine->frames[slot].commands};
    must(vkQueueSubmit(engine->queue, 1, &submit, engine->frames[slot].fence), "vkQueueSubmit");
    must(vkWaitForFences(engine->device, 1, &engine->frames[slot].fence, VK_TRUE, UINT64_MAX), "vkWaitForFences");
    must(vkResetFences(engine->device, 1, &engine->frames[slot].fence), "vkResetFences");
  }
}

/* ---- buffers and images ---- */

static VkDeviceMemory allocate(vulkan_engine *engine, const VkMemoryRequirements *needs, VkMemoryPropertyFlags flags) {
  const VkMemoryAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                     .allocationSize = needs->size,
                                     .memoryTypeIndex = find_type(engine, needs->memoryTypeBits, flags)};
  VkDeviceMemory memory;
  must(vkAllocateMemory(engine->device, &info, NULL, &memory), "vkAllocateMemory");
  return memory;
}

engine_buffer vulkan_engine_buffer(vulkan_engine *engine, uint64_t size) {
  engine_buffer buffer = {.size = size};
  const VkBufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                   .size = size,
                                   .usage = VK_BUFFER_USAGE_VERTEX_BUFFER_BIT | VK_BUFFER_USAGE_INDEX_BUFFER_BIT |
                                            VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT};
  must(vkCreateBuffer(engine->device, &info, NULL, &buffer.handle), "vkCreateBuffer");
  VkMemoryRequirements needs;
  vkGetBufferMemoryRequirements(engine->device, buffer.handle, &needs);
  buffer.memory = allocate(engine, &needs, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
  must(vkBindBufferMemory(engine->device, buffer.handle, buffer.memory, 0), "vkBindBufferMemory");
  must(vkMapMemory(engine->device, buffer.memory, 0, VK_WHOLE_SIZE, 0, &buffer.mapped), "vkMapMemory");
  memset(buffer.mapped, 0, size);
  return buffer;
}

void vulkan_engine_buffer_destroy(vulkan_engine *engine, engine_buffer *buffer) {
  vkDestroyBuffer(engine->device, buffer->handle, NULL);
  vkFreeMemory(engine->device, buffer->memory, NULL);
  *buffer = (engine_buffer){0};
}

static void barrier(VkCommandBuffer commands, const VkImageMemoryBarrier *change, VkPipelineStageFlags from,
                    VkPipelineStageFlags to) {
  VkImageMemoryBarrier complete = *change;
  complete.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER;
  complete.srcQueueFamilyIndex = complete.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  vkCmdPipelineBarrier(commands, from, to, 0, 0, NULL, 0, NULL, 1, &complete);
}

static void upload(vulkan_engine *engine, const engine_image *image, VkImageAspectFlags aspect, const void *texels,
                   uint64_t size) {
  engine_buffer staging = vulkan_engine_buffer(engine, size);
  memcpy(staging.mapped, texels, size);
  const VkCommandBuffer commands = vulkan_engine_begin(engine);
  const VkImageSubresourceRange range = {.aspectMask = aspect, .levelCount = 1, .layerCount = 1};
  barrier(commands,
          &(VkImageMemoryBarrier){.dstAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT,
                                  .newLayout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                                  .image = image->handle,
                                  .subresourceRange = range},
          VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT);
  const VkBufferImageCopy region = {.imageSubresource = {.aspectMask = aspect, .layerCount = 1},
                                    .imageExtent = {image->native.width, image->native.height, 1}};
  vkCmdCopyBufferToImage(commands, staging.handle, image->handle, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region);
  barrier(commands,
          &(VkImageMemoryBarrier){.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT,
                                  .dstAccessMask = VK_ACCESS_SHADER_READ_BIT,
                                  .oldLayout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                                  .newLayout = (VkImageLayout)image->native.layout,
                                  .image = image->handle,
                                  .subresourceRange = range},
          VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT);
  vulkan_engine_end(engine);
  vulkan_engine_run(engine, engine->frame);
  vulkan_engine_buffer_destroy(engine, &staging);
}

engine_image vulkan_engine_image(vulkan_engine *engine, VkFormat format, uint32_t width, uint32_t height,
                                 VkImageLayout layout, const void *texels, uint64_t size) {
  engine_image image = {
      .native = {
          .struct_size = sizeof image.native, .layout = layout, .format = format, .width = width, .height = height}};
  const VkImageAspectFlags aspect =
      format == VK_FORMAT_D32_SFLOAT ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
  const VkImageCreateInfo create = {
      .sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
      .imageType = VK_IMAGE_TYPE_2D,
      .format = format,
      .extent = {width, height, 1},
      .mipLevels = 1,
      .arrayLayers = 1,
      .samples = VK_SAMPLE_COUNT_1_BIT,
      .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT |
               (aspect == VK_IMAGE_ASPECT_DEPTH_BIT ? VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT : 0)};
  must(vkCreateImage(engine->device, &create, NULL, &image.handle), "vkCreateImage");
  VkMemoryRequirements needs;
  vkGetImageMemoryRequirements(engine->device, image.handle, &needs);
  image.memory = allocate(engine, &needs, 0);
  must(vkBindImageMemory(engine->device, image.handle, image.memory, 0), "vkBindImageMemory");
  const VkImageViewCreateInfo view = {.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                      .image = image.handle,
                                      .viewType = VK_IMAGE_VIEW_TYPE_2D,
                                      .format = format,
                                      .subresourceRange = {.aspectMask = aspect, .levelCount = 1, .layerCount = 1}};
  must(vkCreateImageView(engine->device, &view, NULL, &image.native.view), "vkCreateImageView");
  upload(engine, &image, aspect, texels, size);
  return image;
}

void vulkan_engine_image_destroy(vulkan_engine *engine, engine_image *image) {
  vkDestroyImageView(engine->device, image->native.view, NULL);
  vkDestroyImage(engine->device, image->handle, NULL);
  vkFreeMemory(engine->device, image->memory, NULL);
  *image = (engine_image){0};
}

void vulkan_engine_copy(VkCommandBuffer commands, VkImage from, VkImageAspectFlags aspect, uint32_t layer,
                        uint32_t width, uint32_t height, const engine_buffer *to, uint64_t offset) {
  VkImageMemoryBarrier change = {
      .srcAccessMask = VK_ACCESS_SHADER_READ_BIT,
      .dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT,
      .oldLayout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
      .newLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
      .image = from,
      .subresourceRange = {.aspectMask = aspect, .levelCount = 1, .baseArrayLayer = layer, .layerCount = 1}};
  barrier(commands, &change, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT);
  const VkBufferImageCopy region = {
      .bufferOffset = offset,
      .imageSubresource = {.aspectMask = aspect, .baseArrayLayer = layer, .layerCount = 1},
      .imageExtent = {width, height, 1}};
  vkCmdCopyImageToBuffer(commands, from, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, to->handle, 1, &region);
  change.srcAccessMask = 0;
  change.dstAccessMask = VK_ACCESS_SHADER_READ_BIT;
  change.oldLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
  change.newLayout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
  barrier(commands, &change, VK_PIPELINE_STAGE_TRANSFER_BIT,
          VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT | VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT);
}
