#include "rig_vulkan_faults.h"

#include "rig.h"

#include <string.h>

rig_vulkan_faults faults;

/* ---- faults ---- */

/* What an output holds after an error is undefined, so it is set to something that nobody can destroy. */
#define POISON ((void *)(uintptr_t)0xdeadbeef)

static bool fails(const char *name, VkResult *result) {
  *result = VK_SUCCESS;
  if (++faults.calls != faults.fail_at)
    return false;
  faults.failed = name;
  faults.lost |= faults.result == VK_ERROR_DEVICE_LOST;
  *result = faults.result;
  return true;
}

/* Of functions that a lost device fails for ever. */
static bool fails_or_lost(const char *name, VkResult *result) {
  if (fails(name, result))
    return true;
  *result = faults.lost ? VK_ERROR_DEVICE_LOST : VK_SUCCESS;
  return faults.lost;
}

/* ---- objects ---- */

#define PLAIN_OBJECTS(X)                                                                                               \
  X(Buffer)                                                                                                            \
  X(Image)                                                                                                             \
  X(ImageView)                                                                                                         \
  X(Sampler)                                                                                                           \
  X(RenderPass)                                                                                                        \
  X(Framebuffer)                                                                                                       \
  X(ShaderModule)                                                                                                      \
  X(DescriptorSetLayout)                                                                                               \
  X(PipelineLayout)                                                                                                    \
  X(DescriptorPool)                                                                                                    \
  X(CommandPool)                                                                                                       \
  X(Fence)                                                                                                             \
  X(QueryPool)

#define OBJECTS(X) PLAIN_OBJECTS(X) X(DeviceMemory) X(Pipeline) X(Device) X(Instance)

#define LIVE(type) live_##type,
enum { OBJECTS(LIVE) live_count };
#define NAME(type) #type,
static const char *const names[] = {OBJECTS(NAME)};
static int64_t live[live_count];

const char *rig_leak(void) {
  for (int type = 0; type < live_count; ++type)
    if (live[type])
      return names[type];
  return faults.allocated ? "allocation" : NULL;
}

#define WRAP(type)                                                                                                     \
  static VKAPI_ATTR VkResult VKAPI_CALL create_##type(VkDevice device, const Vk##type##CreateInfo *info,               \
                                                      const VkAllocationCallbacks *allocator, Vk##type *out) {         \
    VkResult result;                                                                                                   \
    *out = (Vk##type)POISON;                                                                                           \
    if (fails("vkCreate" #type, &result))                                                                              \
      return result;                                                                                                   \
    result = vkCreate##type(device, info, allocator, out);                                                             \
    live[live_##type] += result == VK_SUCCESS;                                                                         \
    return result;                                                                                                     \
  }                                                                                                                    \
  static VKAPI_ATTR void VKAPI_CALL destroy_##type(VkDevice device, Vk##type object,                                   \
                                                   const VkAllocationCallbacks *allocator) {                           \
    live[live_##type] -= object != VK_NULL_HANDLE;                                                                     \
    vkDestroy##type(device, object, allocator);                                                                        \
  }
PLAIN_OBJECTS(WRAP)

static VKAPI_ATTR VkResult VKAPI_CALL create_pipelines(VkDevice device, VkPipelineCache cache, uint32_t count,
                                                       const VkGraphicsPipelineCreateInfo *infos,
                                                       const VkAllocationCallbacks *allocator, VkPipeline *out) {
  VkResult result;
  memset(out, 0, count * sizeof *out); /* Vulkan promises that */
  if (fails("vkCreateGraphicsPipelines", &result))
    return result;
  result = vkCreateGraphicsPipelines(device, cache, count, infos, allocator, out);
  live[live_Pipeline] += result == VK_SUCCESS ? count : 0;
  return result;
}

static VKAPI_ATTR VkResult VKAPI_CALL create_compute(VkDevice device, VkPipelineCache cache, uint32_t count,
                                                     const VkComputePipelineCreateInfo *infos,
                                                     const VkAllocationCallbacks *allocator, VkPipeline *out) {
  VkResult result;
  memset(out, 0, count * sizeof *out);
  if (fails("vkCreateComputePipelines", &result))
    return result;
  result = vkCreateComputePipelines(device, cache, count, infos, allocator, out);
  live[live_Pipeline] += result == VK_SUCCESS ? count : 0;
  return result;
}

static VKAPI_ATTR void VKAPI_CALL destroy_pipeline(VkDevice device, VkPipeline pipeline,
                                                   const VkAllocationCallbacks *allocator) {
  live[live_Pipeline] -= pipeline != VK_NULL_HANDLE;
  vkDestroyPipeline(device, pipeline, allocator);
}

static VKAPI_ATTR VkResult VKAPI_CALL create_instance(const VkInstanceCreateInfo *info,
                                                      const VkAllocationCallbacks *allocator, VkInstance *out) {
  VkResult result;
  *out = POISON;
  if (fails("vkCreateInstance", &result))
    return result;
  result = vkCreateInstance(info, allocator, out);
  live[live_Instance] += result == VK_SUCCESS;
  return result;
}

static VKAPI_ATTR void VKAPI_CALL destroy_instance(VkInstance instance, const VkAllocationCallbacks *allocator) {
  live[live_Instance] -= instance != VK_NULL_HANDLE;
  vkDestroyInstance(instance, allocator);
}

/* The driver may not know the budget extension that it is said to have. */
static VKAPI_ATTR VkResult VKAPI_CALL create_device(VkPhysicalDevice physical, const VkDeviceCreateInfo *info,
                                                    const VkAllocationCallbacks *allocator, VkDevice *out) {
  VkResult result;
  *out = POISON;
  if (fails("vkCreateDevice", &result))
    return result;
  const char *extensions[8];
  VkDeviceCreateInfo known = *info;
  known.ppEnabledExtensionNames = extensions;
  known.enabledExtensionCount = 0;
  for (uint32_t i = 0; i < info->enabledExtensionCount; ++i)
    if (!faults.tells_budget || strcmp(info->ppEnabledExtensionNames[i], VK_EXT_MEMORY_BUDGET_EXTENSION_NAME))
      extensions[known.enabledExtensionCount++] = info->ppEnabledExtensionNames[i];
  result = vkCreateDevice(physical, &known, allocator, out);
  live[live_Device] += result == VK_SUCCESS;
  return result;
}

static VKAPI_ATTR void VKAPI_CALL destroy_device(VkDevice device, const VkAllocationCallbacks *allocator) {
  live[live_Device] -= device != VK_NULL_HANDLE;
  vkDestroyDevice(device, allocator);
}

/* ---- memory ---- */

enum { most_allocations = 256 };
static struct {
  VkDeviceMemory handle;
  uint64_t size;
} allocations[most_allocations];

static void count_memory(VkDeviceMemory handle, uint64_t size) {
  for (int i = 0; i < most_allocations; ++i)
    if (!allocations[i].handle) {
      allocations[i].handle = handle;
      allocations[i].size = size;
      break;
    }
  ++live[live_DeviceMemory];
  faults.allocated += size;
  if (faults.most < faults.allocated)
    faults.most = faults.allocated;
}

static VKAPI_ATTR VkResult VKAPI_CALL allocate_memory(VkDevice device, const VkMemoryAllocateInfo *info,
                                                      const VkAllocationCallbacks *allocator, VkDeviceMemory *out) {
  VkResult result;
  *out = POISON;
  if (fails("vkAllocateMemory", &result))
    return result;
  result = vkAllocateMemory(device, info, allocator, out);
  if (result == VK_SUCCESS)
    count_memory(*out, info->allocationSize);
  return result;
}

static VKAPI_ATTR void VKAPI_CALL free_memory(VkDevice device, VkDeviceMemory memory,
                                              const VkAllocationCallbacks *allocator) {
  for (int i = 0; memory && i < most_allocations; ++i)
    if (allocations[i].handle == memory) {
      faults.allocated -= allocations[i].size;
      allocations[i].handle = VK_NULL_HANDLE;
      break;
    }
  live[live_DeviceMemory] -= memory != VK_NULL_HANDLE;
  vkFreeMemory(device, memory, allocator);
}

static VKAPI_ATTR VkResult VKAPI_CALL map_memory(VkDevice device, VkDeviceMemory memory, VkDeviceSize offset,
                                                 VkDeviceSize size, VkMemoryMapFlags flags, void **out) {
  VkResult result;
  *out = POISON;
  return fails("vkMapMemory", &result) ? result : vkMapMemory(device, memory, offset, size, flags, out);
}

static VKAPI_ATTR void VKAPI_CALL get_memory_properties2(VkPhysicalDevice physical,
                                                         VkPhysicalDeviceMemoryProperties2 *out) {
  vkGetPhysicalDeviceMemoryProperties(physical, &out->memoryProperties);
  VkPhysicalDeviceMemoryBudgetPropertiesEXT *told = out->pNext;
  if (!told || told->sType != VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MEMORY_BUDGET_PROPERTIES_EXT)
    return;
  for (uint32_t heap = 0; heap < VK_MAX_MEMORY_HEAPS; ++heap) {
    told->heapBudget[heap] = faults.budget;
    told->heapUsage[heap] = faults.used + faults.allocated;
  }
}

/* ---- other calls ---- */

static VKAPI_ATTR VkResult VKAPI_CALL bind_buffer(VkDevice device, VkBuffer buffer, VkDeviceMemory memory,
                                                  VkDeviceSize offset) {
  VkResult result;
  return fails("vkBindBufferMemory", &result) ? result : vkBindBufferMemory(device, buffer, memory, offset);
}

static VKAPI_ATTR VkResult VKAPI_CALL bind_image(VkDevice device, VkImage image, VkDeviceMemory memory,
                                                 VkDeviceSize offset) {
  VkResult result;
  return fails("vkBindImageMemory", &result) ? result : vkBindImageMemory(device, image, memory, offset);
}

static VKAPI_ATTR VkResult VKAPI_CALL allocate_sets(VkDevice device, const VkDescriptorSetAllocateInfo *info,
                                                    VkDescriptorSet *out) {
  VkResult result;
  memset(out, 0, info->descriptorSetCount * sizeof *out); /* Vulkan promises that */
  return fails("vkAllocateDescriptorSets", &result) ? result : vkAllocateDescriptorSets(device, info, out);
}

static VKAPI_ATTR VkResult VKAPI_CALL allocate_commands(VkDevice device, const VkCommandBufferAllocateInfo *info,
                                                        VkCommandBuffer *out) {
  VkResult result;
  memset(out, 0, info->commandBufferCount * sizeof *out); /* Vulkan promises that */
  return fails("vkAllocateCommandBuffers", &result) ? result : vkAllocateCommandBuffers(device, info, out);
}

static VKAPI_ATTR VkResult VKAPI_CALL reset_pool(VkDevice device, VkCommandPool pool, VkCommandPoolResetFlags flags) {
  VkResult result;
  return fails("vkResetCommandPool", &result) ? result : vkResetCommandPool(device, pool, flags);
}

static VKAPI_ATTR VkResult VKAPI_CALL begin_commands(VkCommandBuffer commands, const VkCommandBufferBeginInfo *info) {
  VkResult result;
  return fails("vkBeginCommandBuffer", &result) ? result : vkBeginCommandBuffer(commands, info);
}

static VKAPI_ATTR VkResult VKAPI_CALL end_commands(VkCommandBuffer commands) {
  VkResult result;
  return fails("vkEndCommandBuffer", &result) ? result : vkEndCommandBuffer(commands);
}

static VKAPI_ATTR VkResult VKAPI_CALL reset_fences(VkDevice device, uint32_t count, const VkFence *fences) {
  VkResult result;
  return fails("vkResetFences", &result) ? result : vkResetFences(device, count, fences);
}

static VKAPI_ATTR VkResult VKAPI_CALL submit(VkQueue queue, uint32_t count, const VkSubmitInfo *infos, VkFence fence) {
  VkResult result;
  return fails_or_lost("vkQueueSubmit", &result) ? result : vkQueueSubmit(queue, count, infos, fence);
}

/* The device is not really lost, so it is really waited for. */
static VKAPI_ATTR VkResult VKAPI_CALL wait_fences(VkDevice device, uint32_t count, const VkFence *fences, VkBool32 all,
                                                  uint64_t timeout) {
  VkResult result;
  const VkResult waited = vkWaitForFences(device, count, fences, all, timeout);
  return fails_or_lost("vkWaitForFences", &result) ? result : waited;
}

static VKAPI_ATTR VkResult VKAPI_CALL get_results(VkDevice device, VkQueryPool pool, uint32_t first, uint32_t count,
                                                  size_t size, void *data, VkDeviceSize stride,
                                                  VkQueryResultFlags flags) {
  VkResult result;
  return fails_or_lost("vkGetQueryPoolResults", &result)
             ? result
             : vkGetQueryPoolResults(device, pool, first, count, size, data, stride, flags);
}

static VKAPI_ATTR VkResult VKAPI_CALL get_image_format(VkPhysicalDevice physical, VkFormat format, VkImageType type,
                                                       VkImageTiling tiling, VkImageUsageFlags usage,
                                                       VkImageCreateFlags flags, VkImageFormatProperties *out) {
  VkResult result;
  return fails("vkGetPhysicalDeviceImageFormatProperties", &result)
             ? result
             : vkGetPhysicalDeviceImageFormatProperties(physical, format, type, tiling, usage, flags, out);
}

static VKAPI_ATTR VkResult VKAPI_CALL enumerate_devices(VkInstance instance, uint32_t *count, VkPhysicalDevice *out) {
  VkResult result;
  return fails("vkEnumeratePhysicalDevices", &result) ? result : vkEnumeratePhysicalDevices(instance, count, out);
}

static VKAPI_ATTR VkResult VKAPI_CALL enumerate_extensions(VkPhysicalDevice physical, const char *layer,
                                                           uint32_t *count, VkExtensionProperties *out) {
  VkResult result;
  if (fails("vkEnumerateDeviceExtensionProperties", &result))
    return result;
  const uint32_t room = *count;
  uint32_t known = room && faults.tells_budget ? room - 1 : room;
  result = vkEnumerateDeviceExtensionProperties(physical, layer, &known, out);
  *count = known + faults.tells_budget;
  if (out && faults.tells_budget && result == VK_SUCCESS)
    out[known] = (VkExtensionProperties){.extensionName = VK_EXT_MEMORY_BUDGET_EXTENSION_NAME, .specVersion = 1};
  return result;
}

static VKAPI_ATTR VkResult VKAPI_CALL enumerate_instance_extensions(const char *layer, uint32_t *count,
                                                                    VkExtensionProperties *out) {
  VkResult result;
  return fails("vkEnumerateInstanceExtensionProperties", &result)
             ? result
             : vkEnumerateInstanceExtensionProperties(layer, count, out);
}

/* ---- the table ---- */

static PFN_vkVoidFunction VKAPI_CALL get_device_proc_addr(VkDevice device, const char *name);

#define FUNCTION(function) ((PFN_vkVoidFunction)(function))
#define ENTRIES(type) {"vkCreate" #type, FUNCTION(create_##type)}, {"vkDestroy" #type, FUNCTION(destroy_##type)},

static const struct {
  const char *name;
  PFN_vkVoidFunction function;
} wrapped[] = {
    PLAIN_OBJECTS(ENTRIES){"vkCreateGraphicsPipelines", FUNCTION(create_pipelines)},
    {"vkCreateComputePipelines", FUNCTION(create_compute)},
    {"vkDestroyPipeline", FUNCTION(destroy_pipeline)},
    {"vkCreateInstance", FUNCTION(create_instance)},
    {"vkDestroyInstance", FUNCTION(destroy_instance)},
    {"vkCreateDevice", FUNCTION(create_device)},
    {"vkDestroyDevice", FUNCTION(destroy_device)},
    {"vkAllocateMemory", FUNCTION(allocate_memory)},
    {"vkFreeMemory", FUNCTION(free_memory)},
    {"vkMapMemory", FUNCTION(map_memory)},
    {"vkGetPhysicalDeviceMemoryProperties2", FUNCTION(get_memory_properties2)},
    {"vkBindBufferMemory", FUNCTION(bind_buffer)},
    {"vkBindImageMemory", FUNCTION(bind_image)},
    {"vkAllocateDescriptorSets", FUNCTION(allocate_sets)},
    {"vkAllocateCommandBuffers", FUNCTION(allocate_commands)},
    {"vkResetCommandPool", FUNCTION(reset_pool)},
    {"vkBeginCommandBuffer", FUNCTION(begin_commands)},
    {"vkEndCommandBuffer", FUNCTION(end_commands)},
    {"vkResetFences", FUNCTION(reset_fences)},
    {"vkQueueSubmit", FUNCTION(submit)},
    {"vkWaitForFences", FUNCTION(wait_fences)},
    {"vkGetQueryPoolResults", FUNCTION(get_results)},
    {"vkGetPhysicalDeviceImageFormatProperties", FUNCTION(get_image_format)},
    {"vkEnumeratePhysicalDevices", FUNCTION(enumerate_devices)},
    {"vkEnumerateDeviceExtensionProperties", FUNCTION(enumerate_extensions)},
    {"vkEnumerateInstanceExtensionProperties", FUNCTION(enumerate_instance_extensions)},
    {"vkGetDeviceProcAddr", FUNCTION(get_device_proc_addr)},
};

static PFN_vkVoidFunction find(const char *name) {
  for (size_t i = 0; i < sizeof wrapped / sizeof wrapped[0]; ++i)
    if (!strcmp(wrapped[i].name, name))
      return wrapped[i].function;
  return NULL;
}

static PFN_vkVoidFunction VKAPI_CALL get_device_proc_addr(VkDevice device, const char *name) {
  const PFN_vkVoidFunction function = find(name);
  return function ? function : vkGetDeviceProcAddr(device, name);
}

PFN_vkVoidFunction VKAPI_CALL faults_get_instance_proc_addr(VkInstance instance, const char *name) {
  const PFN_vkVoidFunction function = find(name);
  return function ? function : vkGetInstanceProcAddr(instance, name);
}

/* ---- the rig's faults ---- */

const rig_fault rig_faults[] = {
    {"out of host memory", VK_ERROR_OUT_OF_HOST_MEMORY, CSM_ERROR_OUT_OF_MEMORY},
    {"out of device memory", VK_ERROR_OUT_OF_DEVICE_MEMORY, CSM_ERROR_OUT_OF_DEVICE_MEMORY},
    {"the device is lost", VK_ERROR_DEVICE_LOST, CSM_ERROR_DEVICE_LOST},
    {"an error of the device's", VK_ERROR_INITIALIZATION_FAILED, CSM_ERROR_DEVICE},
    {"the allocator fails", 0, CSM_ERROR_OUT_OF_MEMORY},
};
const uint32_t rig_fault_count = sizeof rig_faults / sizeof rig_faults[0];

void rig_fail(const rig_fault *fault, uint32_t nth) {
  if (nth)
    faults.failed = NULL;
  faults.result = fault ? fault->code : VK_SUCCESS;
  faults.fail_at = nth && faults.result ? faults.calls + nth : 0;
}

const char *rig_failed(void) {
  return faults.failed;
}

/* A recording that cannot be submitted takes the context's state with it. */
bool rig_loses_recording(const char *function) {
  return function && (!strcmp(function, "vkEndCommandBuffer") || !strcmp(function, "vkResetFences") ||
                      !strcmp(function, "vkQueueSubmit"));
}

void rig_find(void) {
  faults.lost = false;
}

bool rig_lose(void) {
  return false;
}
