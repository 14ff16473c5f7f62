#include "rig_vulkan.h"

#include "rig_vulkan_faults.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define VALIDATION "VK_LAYER_KHRONOS_validation"

/* How an engine's device is opened. */
typedef struct device_wish {
  uint32_t version;
  bool rich;    /* depthBiasClamp, shaders that write masks, and debug utils */
  bool clamps;  /* depthClamp is on */
  bool lends;   /* memory, a pipeline cache and dynamic rendering; shaders that write masks */
  bool failing; /* shaders write masks, so that all may fail */
} device_wish;

/* As Godot 4.6 opens one: 1.2 without any of its features. */
static const device_wish typical = {.version = VK_API_VERSION_1_2, .rich = true, .clamps = true};
static const device_wish bare = {.version = VK_API_VERSION_1_1, .clamps = true};
static const device_wish modern = {.version = VK_API_VERSION_1_3, .clamps = true, .lends = true};
static const device_wish failing = {.version = VK_API_VERSION_1_1, .clamps = true, .failing = true};
static const device_wish clipping = {.version = VK_API_VERSION_1_1};

void rig_vulkan_must(VkResult result, const char *what) {
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
  rig *rig = user;
  __atomic_fetch_add(&rig->messages, 1, __ATOMIC_RELAXED);
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

static void open_instance(rig *rig, device_wish wish) {
  const bool validation = has_validation();
  const VkDebugReportCallbackCreateInfoEXT report = {.sType = VK_STRUCTURE_TYPE_DEBUG_REPORT_CALLBACK_CREATE_INFO_EXT,
                                                     .flags = VK_DEBUG_REPORT_ERROR_BIT_EXT |
                                                              VK_DEBUG_REPORT_WARNING_BIT_EXT,
                                                     .pfnCallback = count_message,
                                                     .pUserData = rig};
  const VkValidationFeatureEnableEXT enabled[] = {VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
  const VkValidationFeaturesEXT features = {.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
                                            .pNext = &report,
                                            .enabledValidationFeatureCount = 1,
                                            .pEnabledValidationFeatures = enabled};
  const VkApplicationInfo application = {
      .sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .pApplicationName = "an engine", .apiVersion = wish.version};
  const char *const layers[] = {VALIDATION};
  const char *extensions[2];
  uint32_t count = 0;
  if (validation)
    extensions[count++] = VK_EXT_DEBUG_REPORT_EXTENSION_NAME;
  if (wish.rich)
    extensions[count++] = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
  const VkInstanceCreateInfo create = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                       .pNext = validation ? &features : NULL,
                                       .pApplicationInfo = &application,
                                       .enabledLayerCount = validation,
                                       .ppEnabledLayerNames = layers,
                                       .enabledExtensionCount = count,
                                       .ppEnabledExtensionNames = extensions};
  rig_vulkan_must(vkCreateInstance(&create, NULL, &rig->instance), "vkCreateInstance");
  if (!validation)
    return;
  const PFN_vkCreateDebugReportCallbackEXT listen =
      (PFN_vkCreateDebugReportCallbackEXT)vkGetInstanceProcAddr(rig->instance, "vkCreateDebugReportCallbackEXT");
  rig_vulkan_must(listen(rig->instance, &report, NULL, &rig->reporter), "vkCreateDebugReportCallbackEXT");
}

static uint32_t graphics_family(VkPhysicalDevice physical) {
  VkQueueFamilyProperties families[16];
  uint32_t count = 16;
  vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families);
  for (uint32_t i = 0; i < count; ++i)
    if (families[i].queueFlags & VK_QUEUE_GRAPHICS_BIT)
      return i;
  rig_vulkan_must(VK_ERROR_FEATURE_NOT_PRESENT, "a graphics queue");
  return 0;
}

static void open_device(rig *rig, device_wish wish) {
  uint32_t count = 1;
  const VkResult found = vkEnumeratePhysicalDevices(rig->instance, &count, &rig->physical);
  rig_vulkan_must(count == 1 && found >= 0 ? VK_SUCCESS : VK_ERROR_INITIALIZATION_FAILED, "a Vulkan device");
  rig->family = graphics_family(rig->physical);
  rig->features =
      (VkPhysicalDeviceFeatures){.depthClamp = wish.clamps,
                                 .depthBiasClamp = wish.rich,
                                 .shaderStorageImageExtendedFormats = wish.rich || wish.lends || wish.failing};
  const float priority = 1;
  const VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                         .queueFamilyIndex = rig->family,
                                         .queueCount = 1,
                                         .pQueuePriorities = &priority};
  const VkPhysicalDeviceVulkan13Features rendering = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES,
                                                      .dynamicRendering = VK_TRUE};
  const VkDeviceCreateInfo create = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                     .pNext = wish.lends ? &rendering : NULL,
                                     .queueCreateInfoCount = 1,
                                     .pQueueCreateInfos = &queue,
                                     .pEnabledFeatures = &rig->features};
  rig_vulkan_must(vkCreateDevice(rig->physical, &create, NULL, &rig->device), "vkCreateDevice");
  vkGetDeviceQueue(rig->device, rig->family, 0, &rig->queue);
  vkGetPhysicalDeviceMemoryProperties(rig->physical, &rig->memory);
}

static void open_frames(rig *rig) {
  for (uint32_t i = 0; i < RIG_FRAMES; ++i) {
    const VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                          .queueFamilyIndex = rig->family};
    rig_vulkan_must(vkCreateCommandPool(rig->device, &pool, NULL, &rig->frames[i].pool), "vkCreateCommandPool");
    const VkCommandBufferAllocateInfo commands = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                                  .commandPool = rig->frames[i].pool,
                                                  .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                                  .commandBufferCount = RIG_LISTS};
    rig_vulkan_must(vkAllocateCommandBuffers(rig->device, &commands, rig->frames[i].commands),
                    "vkAllocateCommandBuffers");
    const VkFenceCreateInfo fence = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    rig_vulkan_must(vkCreateFence(rig->device, &fence, NULL, &rig->frames[i].fence), "vkCreateFence");
  }
}

static rig *open_rig(device_wish wish) {
  rig *rig = calloc(1, sizeof *rig);
  if (!rig)
    abort();
  open_instance(rig, wish);
  open_device(rig, wish);
  open_frames(rig);
  rig->native = (csm_vulkan_device){.struct_size = sizeof rig->native,
                                    .api_version = wish.version,
                                    .instance = rig->instance,
                                    .physical_device = rig->physical,
                                    .device = rig->device,
                                    .queue_family = rig->family,
                                    .get_instance_proc_addr =
                                        wish.failing ? faults_get_instance_proc_addr : vkGetInstanceProcAddr,
                                    .features = &rig->features};
  if (wish.lends)
    rig_vulkan_lend(rig);
  return rig;
}

rig *rig_open(rig_kind kind) {
  return open_rig(kind == RIG_TYPICAL ? typical : kind == RIG_BARE ? bare : kind == RIG_MODERN ? modern : failing);
}

rig *rig_vulkan_open_clipping(void) {
  return open_rig(clipping);
}

void rig_close(rig *rig) {
  rig_run(rig, rig->frame);
  for (uint32_t i = 0; i < RIG_FRAMES; ++i) {
    vkDestroyFence(rig->device, rig->frames[i].fence, NULL);
    vkDestroyCommandPool(rig->device, rig->frames[i].pool, NULL);
  }
  vkDestroyPipelineCache(rig->device, rig->cache, NULL);
  vkDestroyDevice(rig->device, NULL);
  if (rig->reporter)
    ((PFN_vkDestroyDebugReportCallbackEXT)vkGetInstanceProcAddr(rig->instance, "vkDestroyDebugReportCallbackEXT"))(
        rig->instance, rig->reporter, NULL);
  vkDestroyInstance(rig->instance, NULL);
  const uint32_t messages = rig->messages, pieces = rig->lent.pieces;
  free(rig);
  assert_int_equal(messages, 0);
  assert_int_equal(pieces, 0);
}

void rig_give(const rig *rig, csm_create_info *info) {
  info->vulkan = &rig->native;
}

rig_lent *rig_lent_memory(rig *rig) {
  return &rig->lent;
}

uint32_t rig_messages(const rig *rig) {
  return rig->messages;
}

/* ---- frames ---- */

uint64_t rig_frame(const rig *rig) {
  return rig->frame;
}

uint64_t rig_done(const rig *rig) {
  return rig->done;
}

static VkCommandBuffer open_next(rig *rig) {
  const uint64_t slot = rig->frame % RIG_FRAMES;
  rig_vulkan_must(rig->frames[slot].count < RIG_LISTS ? VK_SUCCESS : VK_NOT_READY, "a frame has too many lists");
  const VkCommandBuffer commands = rig->frames[slot].commands[rig->frames[slot].count++];
  const VkCommandBufferBeginInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                         .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
  rig_vulkan_must(vkBeginCommandBuffer(commands, &info), "vkBeginCommandBuffer");
  return commands;
}

void *rig_begin(rig *rig) {
  const uint64_t slot = ++rig->frame % RIG_FRAMES;
  rig_vulkan_must(rig->done + RIG_FRAMES >= rig->frame ? VK_SUCCESS : VK_NOT_READY, "too many frames in flight");
  rig_vulkan_must(vkResetCommandPool(rig->device, rig->frames[slot].pool, 0), "vkResetCommandPool");
  rig->frames[slot].count = 0;
  return open_next(rig);
}

void *rig_commands(const rig *rig) {
  const uint64_t slot = rig->frame % RIG_FRAMES;
  return rig->frames[slot].count ? rig->frames[slot].commands[rig->frames[slot].count - 1] : NULL;
}

void rig_end(rig *rig) {
  rig_vulkan_must(vkEndCommandBuffer(rig_commands(rig)), "vkEndCommandBuffer");
}

void *rig_split(rig *rig) {
  rig_end(rig);
  return open_next(rig);
}

void rig_run(rig *rig, uint64_t frame) {
  while (rig->done < frame) {
    const uint64_t slot = ++rig->done % RIG_FRAMES;
    for (uint32_t i = 0; i < rig->frames[slot].count; ++i) {
      const VkSubmitInfo submit = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
                                   .commandBufferCount = 1,
                                   .pCommandBuffers = &rig->frames[slot].commands[i]};
      const bool last = i + 1 == rig->frames[slot].count;
      rig_vulkan_must(vkQueueSubmit(rig->queue, 1, &submit, last ? rig->frames[slot].fence : VK_NULL_HANDLE),
                      "vkQueueSubmit");
    }
    if (!rig->frames[slot].count)
      continue;
    rig_vulkan_must(vkWaitForFences(rig->device, 1, &rig->frames[slot].fence, VK_TRUE, UINT64_MAX), "vkWaitForFences");
    rig_vulkan_must(vkResetFences(rig->device, 1, &rig->frames[slot].fence), "vkResetFences");
  }
}

void rig_drop(rig *rig) {
  rig->frames[rig->frame % RIG_FRAMES].count = 0;
}
