/* rig_vulkan_lend.c: what a modern Vulkan engine lends: memory from its own allocator, and its pipeline cache. */
#include "rig_vulkan.h"

#include <string.h>

/* ---- the cache ---- */

/* Of all modern engines of the program, since it began. */
static uint32_t cached, uncached;

void rig_vulkan_pipelines(uint32_t *with_cache, uint32_t *without) {
  *with_cache = __atomic_load_n(&cached, __ATOMIC_RELAXED);
  *without = __atomic_load_n(&uncached, __ATOMIC_RELAXED);
}

static VKAPI_ATTR VkResult VKAPI_CALL create_pipelines(VkDevice device, VkPipelineCache cache, uint32_t count,
                                                       const VkGraphicsPipelineCreateInfo *infos,
                                                       const VkAllocationCallbacks *allocator, VkPipeline *out) {
  __atomic_fetch_add(cache ? &cached : &uncached, count, __ATOMIC_RELAXED);
  return vkCreateGraphicsPipelines(device, cache, count, infos, allocator, out);
}

static VKAPI_ATTR VkResult VKAPI_CALL create_compute(VkDevice device, VkPipelineCache cache, uint32_t count,
                                                     const VkComputePipelineCreateInfo *infos,
                                                     const VkAllocationCallbacks *allocator, VkPipeline *out) {
  __atomic_fetch_add(cache ? &cached : &uncached, count, __ATOMIC_RELAXED);
  return vkCreateComputePipelines(device, cache, count, infos, allocator, out);
}

static PFN_vkVoidFunction VKAPI_CALL device_function(VkDevice device, const char *name) {
  return !strcmp(name, "vkCreateGraphicsPipelines")  ? (PFN_vkVoidFunction)create_pipelines
         : !strcmp(name, "vkCreateComputePipelines") ? (PFN_vkVoidFunction)create_compute
                                                     : vkGetDeviceProcAddr(device, name);
}

static PFN_vkVoidFunction VKAPI_CALL instance_function(VkInstance instance, const char *name) {
  return strcmp(name, "vkGetDeviceProcAddr") ? vkGetInstanceProcAddr(instance, name)
                                             : (PFN_vkVoidFunction)device_function;
}

/* ---- memory ---- */

uint32_t rig_vulkan_memory_type(const rig *rig, uint32_t allowed, VkMemoryPropertyFlags flags) {
  uint32_t type = 0;
  while (type < rig->memory.memoryTypeCount &&
         (!(allowed >> type & 1) || (rig->memory.memoryTypes[type].propertyFlags & flags) != flags))
    ++type;
  return type < rig->memory.memoryTypeCount ? type : UINT32_MAX;
}

/* Each piece begins somewhere in its allocation, as it does with an allocator that shares. */
static VkResult CSM_CALL lend_memory(void *user, const csm_vulkan_memory_request *request, csm_vulkan_memory *out) {
  rig *rig = user;
  const bool visible = request->required & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT;
  const bool at = ++rig->lent.requests == rig->lent.refuse_at;
  const bool wrong = at && (rig->lent.lapse != RIG_UNMAPPED || visible);
  rig->lent.lapses += wrong;
  if (wrong && rig->lent.lapse <= RIG_NOTHING)
    return rig->lent.lapse == RIG_REFUSAL ? VK_ERROR_OUT_OF_DEVICE_MEMORY : VK_SUCCESS;
  uint32_t type = rig_vulkan_memory_type(rig, request->memory_type_bits, request->required | request->preferred);
  if (type == UINT32_MAX)
    type = rig_vulkan_memory_type(rig, request->memory_type_bits, request->required);
  if (type == UINT32_MAX || request->struct_size != sizeof *request || !request->image == !request->buffer ||
      !request->size || !request->alignment || !request->name)
    return VK_ERROR_UNKNOWN;
  const VkMemoryAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                     .allocationSize = request->alignment + request->size,
                                     .memoryTypeIndex = type};
  VkResult result = vkAllocateMemory(rig->device, &info, NULL, &out->memory);
  void *mapped = NULL;
  if (result == VK_SUCCESS && visible)
    result = vkMapMemory(rig->device, out->memory, 0, VK_WHOLE_SIZE, 0, &mapped);
  out->offset = wrong && rig->lent.lapse == RIG_ODD_OFFSET ? 1 : request->alignment;
  out->mapped = mapped && !(wrong && rig->lent.lapse == RIG_UNMAPPED) ? (char *)mapped + out->offset : NULL;
  out->handle = rig;
  if (++rig->lent.pieces > rig->lent.most)
    rig->lent.most = rig->lent.pieces;
  return result;
}

static void CSM_CALL take_memory_back(void *user, const csm_vulkan_memory *memory) {
  rig *rig = user;
  rig_vulkan_must(memory->handle == rig ? VK_SUCCESS : VK_ERROR_UNKNOWN, "the engine's own handle");
  vkFreeMemory(rig->device, memory->memory, NULL);
  --rig->lent.pieces;
}

void rig_vulkan_lend(rig *rig) {
  const VkPipelineCacheCreateInfo create = {.sType = VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO};
  rig_vulkan_must(vkCreatePipelineCache(rig->device, &create, NULL, &rig->cache), "vkCreatePipelineCache");
  rig->native.get_instance_proc_addr = instance_function;
  rig->native.pipeline_cache = rig->cache;
  rig->native.dynamic_rendering = 1;
  rig->native.allocate_memory = lend_memory;
  rig->native.free_memory = take_memory_back;
  rig->native.memory_user = rig;
}
