/*
 * slot.c: frames in flight. On an own device a slot has a command buffer of its own, which is submitted and waited for;
 * on an engine's it has nothing but its queries, and commands go where the engine says.
 */
#include "internal.h"

static csm_result commands_create(gpu_device *device, vulkan_slot *slot) {
  const vulkan_functions *vk = &device->vk;
  const VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                        .flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT,
                                        .queueFamilyIndex = device->queue_family};
  csm_result result = vulkan_made(device, vk->CreateCommandPool(device->handle, &pool, NULL, &slot->pool), &slot->pool,
                                  "vkCreateCommandPool");
  if (result != CSM_SUCCESS)
    return result;
  const VkCommandBufferAllocateInfo commands = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                                .commandPool = slot->pool,
                                                .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                                .commandBufferCount = 1};
  result = vulkan_check(device, vk->AllocateCommandBuffers(device->handle, &commands, &slot->commands),
                        "vkAllocateCommandBuffers");
  if (result != CSM_SUCCESS)
    return result;
  const VkFenceCreateInfo fence = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
  result =
      vulkan_made(device, vk->CreateFence(device->handle, &fence, NULL, &slot->fence), &slot->fence, "vkCreateFence");
  if (result != CSM_SUCCESS)
    return result;
  vulkan_name(device, VK_OBJECT_TYPE_COMMAND_POOL, (uint64_t)slot->pool, "csm slot");
  vulkan_name(device, VK_OBJECT_TYPE_COMMAND_BUFFER, (uint64_t)(uintptr_t)slot->commands, "csm slot");
  vulkan_name(device, VK_OBJECT_TYPE_FENCE, (uint64_t)slot->fence, "csm slot");
  return CSM_SUCCESS;
}

csm_result vulkan_slot_create(gpu_device *device, vulkan_slot *slot) {
  csm_result result = device->own ? commands_create(device, slot) : CSM_SUCCESS;
  if (result != CSM_SUCCESS || device->timestamp_mask == 0)
    return result;
  const VkQueryPoolCreateInfo queries = {.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
                                         .queryType = VK_QUERY_TYPE_TIMESTAMP,
                                         .queryCount = GPU_MAX_TIMESTAMPS};
  result = vulkan_made(device, device->vk.CreateQueryPool(device->handle, &queries, NULL, &slot->queries),
                       &slot->queries, "vkCreateQueryPool");
  if (result == CSM_SUCCESS)
    vulkan_name(device, VK_OBJECT_TYPE_QUERY_POOL, (uint64_t)slot->queries, "csm slot");
  return result;
}

void vulkan_slot_destroy(gpu_device *device, vulkan_slot *slot) {
  device->vk.DestroyQueryPool(device->handle, slot->queries, NULL);
  if (!device->own)
    return;
  device->vk.DestroyFence(device->handle, slot->fence, NULL);
  device->vk.DestroyCommandPool(device->handle, slot->pool, NULL);
}

csm_result vulkan_wait(gpu_device *device, uint32_t slot_index) {
  vulkan_slot *slot = &device->slots[slot_index];
  if (!slot->submitted)
    return CSM_SUCCESS;
  const csm_result result = vulkan_check(
      device, device->vk.WaitForFences(device->handle, 1, &slot->fence, VK_TRUE, UINT64_MAX), "vkWaitForFences");
  if (result == CSM_SUCCESS)
    slot->submitted = false;
  return result;
}

/* ---- a recording ---- */

static csm_result commands_begin(gpu_device *device, uint32_t slot_index) {
  const vulkan_functions *vk = &device->vk;
  vulkan_slot *slot = &device->slots[slot_index];
  csm_result result = vulkan_wait(device, slot_index);
  if (result == CSM_SUCCESS)
    result = vulkan_check(device, vk->ResetCommandPool(device->handle, slot->pool, 0), "vkResetCommandPool");
  const VkCommandBufferBeginInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                         .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
  if (result == CSM_SUCCESS)
    result = vulkan_check(device, vk->BeginCommandBuffer(slot->commands, &info), "vkBeginCommandBuffer");
  return result;
}

csm_result vulkan_begin(gpu_device *device, const gpu_record_info *info) {
  vulkan_slot *slot = &device->slots[info->slot];
  const csm_result result = device->own ? commands_begin(device, info->slot) : CSM_SUCCESS;
  if (result != CSM_SUCCESS)
    return result;
  device->slot = slot;
  device->commands = device->own ? slot->commands : info->native;
  device->readback_written = false;
  if (info->first && slot->queries)
    device->vk.CmdResetQueryPool(device->commands, slot->queries, 0, GPU_MAX_TIMESTAMPS);
  if (device->recording_lost)
    vulkan_memory_barrier(device, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_ACCESS_MEMORY_WRITE_BIT,
                          VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT);
  device->recording_lost = false;
  return CSM_SUCCESS;
}

static csm_result commands_submit(gpu_device *device) {
  const vulkan_functions *vk = &device->vk;
  vulkan_slot *slot = device->slot;
  const VkSubmitInfo submit = {
      .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &slot->commands};
  csm_result result = vulkan_check(device, vk->EndCommandBuffer(slot->commands), "vkEndCommandBuffer");
  if (result == CSM_SUCCESS)
    result = vulkan_check(device, vk->ResetFences(device->handle, 1, &slot->fence), "vkResetFences");
  if (result == CSM_SUCCESS)
    result = vulkan_check(device, vk->QueueSubmit(device->queue, 1, &submit, slot->fence), "vkQueueSubmit");
  slot->submitted = result == CSM_SUCCESS;
  device->recording_lost = !slot->submitted;
  return result;
}

csm_result vulkan_end(gpu_device *device) {
  vulkan_rest(device);
  if (device->readback_written)
    vulkan_memory_barrier(device, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
                          VK_PIPELINE_STAGE_HOST_BIT, VK_ACCESS_HOST_READ_BIT);
  const csm_result result = device->own ? commands_submit(device) : CSM_SUCCESS;
  vulkan_release_used(device, result == CSM_SUCCESS);
  return result;
}

/* ---- timestamps ---- */

/* Ticks of a counter with the mask's bits, which may have begun anew since the first. */
static void convert_ticks(const gpu_device *device, uint32_t count, uint64_t *ticks) {
  const uint64_t first = ticks[0] & device->timestamp_mask;
  const uint64_t begin = (uint64_t)((double)first * device->timestamp_period_ns);
  for (uint32_t i = 0; i < count; i++) {
    const uint64_t since = (ticks[i] - first) & device->timestamp_mask;
    ticks[i] = begin + (uint64_t)((double)since * device->timestamp_period_ns);
  }
}

csm_result vulkan_timestamps(gpu_device *device, uint32_t slot_index, uint32_t first, uint32_t count,
                             uint64_t *nanoseconds) {
  const vulkan_slot *slot = &device->slots[slot_index];
  if (!slot->queries)
    return lent_fail(&device->lent, CSM_ERROR_UNSUPPORTED, "the device's queue has no timestamps");
  csm_result result = vulkan_wait(device, slot_index);
  if (result != CSM_SUCCESS || count == 0)
    return result;
  const VkResult got =
      device->vk.GetQueryPoolResults(device->handle, slot->queries, first, count, count * sizeof *nanoseconds,
                                     nanoseconds, sizeof *nanoseconds, VK_QUERY_RESULT_64_BIT);
  if (got == VK_NOT_READY)
    return CSM_ERROR_UNSUPPORTED; /* an engine did not submit the recording */
  result = vulkan_check(device, got, "vkGetQueryPoolResults");
  if (result == CSM_SUCCESS)
    convert_ticks(device, count, nanoseconds);
  return result;
}
