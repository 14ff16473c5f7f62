/*
 * slot.c: frames in flight. On an own device a slot has a command list of its own, which is submitted and waited for;
 * on an engine's it has nothing but its queries, and commands go where the engine says.
 */
#include "internal.h"

csm_result d3d12_slot_create(gpu_device *device, d3d12_slot *slot) {
  if (!device->own)
    return CSM_SUCCESS;
  csm_result result =
      d3d12_check(device,
                  ID3D12Device_CreateCommandAllocator(device->handle, D3D12_COMMAND_LIST_TYPE_DIRECT,
                                                      &IID_ID3D12CommandAllocator, (void **)&slot->allocator),
                  "CreateCommandAllocator");
  if (result == CSM_SUCCESS)
    result =
        d3d12_check(device,
                    ID3D12Device_CreateCommandList(device->handle, 0, D3D12_COMMAND_LIST_TYPE_DIRECT, slot->allocator,
                                                   NULL, &IID_ID3D12GraphicsCommandList, (void **)&slot->list),
                    "CreateCommandList");
  if (result == CSM_SUCCESS)
    result = d3d12_check(device, ID3D12GraphicsCommandList_Close(slot->list), "Close");
  return result;
}

void d3d12_slot_destroy(d3d12_slot *slot) {
  d3d12_unref(slot->list);
  d3d12_unref(slot->allocator);
}

/* ---- waiting ---- */

/* Puts the next fence value behind what was submitted. */
static csm_result fence_signal(gpu_device *device) {
  const HRESULT hr = ID3D12CommandQueue_Signal(device->queue, device->fence, device->fence_value + 1);
  if (SUCCEEDED(hr)) {
    device->fence_value++;
    return CSM_SUCCESS;
  }
  const csm_result result = d3d12_check(device, hr, "Signal");
  return result == CSM_ERROR_DEVICE && device->traits->nameless_loss ? CSM_ERROR_DEVICE_LOST : result;
}

csm_result d3d12_wait(gpu_device *device, uint32_t slot_index) {
  const uint64_t value = device->slots[slot_index].fence_value;
  while (ID3D12Fence_GetCompletedValue(device->fence) < value) {
    const HRESULT hr = d3d12_runtime_wait(device->runtime, device->fence, value);
    if (FAILED(hr))
      return d3d12_check(device, hr, "SetEventOnCompletion");
    /* A lost device may never get there. Another signal behind the work tells whether it is lost. */
    if (ID3D12Fence_GetCompletedValue(device->fence) < value && fence_signal(device) == CSM_ERROR_DEVICE_LOST)
      return CSM_ERROR_DEVICE_LOST;
  }
  return CSM_SUCCESS;
}

/* ---- a recording ---- */

static csm_result list_begin(gpu_device *device, uint32_t slot_index) {
  const d3d12_slot *slot = &device->slots[slot_index];
  csm_result result = d3d12_wait(device, slot_index);
  if (result == CSM_SUCCESS)
    result = d3d12_check(device, ID3D12CommandAllocator_Reset(slot->allocator), "Reset");
  if (result == CSM_SUCCESS)
    result = d3d12_check(device, ID3D12GraphicsCommandList_Reset(slot->list, slot->allocator, NULL), "Reset");
  return result;
}

static csm_result list_take(const gpu_device *device, ID3D12GraphicsCommandList *list) {
  if (ID3D12GraphicsCommandList_GetType(list) != D3D12_COMMAND_LIST_TYPE_DIRECT)
    return lent_fail(&device->lent, CSM_ERROR_INVALID_VALUE, "the command list is not a direct one");
  return d3d12_check(device, ID3D12Device_GetDeviceRemovedReason(device->handle), "GetDeviceRemovedReason");
}

csm_result d3d12_begin(gpu_device *device, const gpu_record_info *info) {
  const csm_result result = device->own ? list_begin(device, info->slot) : list_take(device, info->native);
  if (result != CSM_SUCCESS)
    return result;
  device->slot = info->slot;
  device->list = device->own ? device->slots[info->slot].list : info->native;
  device->timestamps_begin = device->timestamps_end = 0;
  device->heap = NULL;
  return CSM_SUCCESS;
}

static csm_result list_submit(gpu_device *device) {
  csm_result result = d3d12_check(device, ID3D12GraphicsCommandList_Close(device->list), "Close");
  if (result != CSM_SUCCESS)
    return result;
  ID3D12CommandList *const list = (ID3D12CommandList *)device->list;
  ID3D12CommandQueue_ExecuteCommandLists(device->queue, 1, &list);
  result = fence_signal(device);
  if (result == CSM_SUCCESS)
    device->slots[device->slot].fence_value = device->fence_value;
  return result;
}

/* Timestamps of one recording are neighbours, so those before and after it, which a slot's other recordings take, are
   left alone. */
static void resolve_timestamps(gpu_device *device) {
  const uint32_t first = device->slot * GPU_MAX_TIMESTAMPS + device->timestamps_begin;
  const uint32_t count = device->timestamps_end - device->timestamps_begin;
  if (count)
    ID3D12GraphicsCommandList_ResolveQueryData(device->list, device->queries, D3D12_QUERY_TYPE_TIMESTAMP, first, count,
                                               device->query_results->resource.handle, first * sizeof(uint64_t));
}

csm_result d3d12_end(gpu_device *device) {
  d3d12_rest(device);
  resolve_timestamps(device);
  const csm_result result = device->own ? list_submit(device) : CSM_SUCCESS;
  d3d12_release_used(device, result == CSM_SUCCESS);
  return result;
}

/* ---- timestamps ---- */

/* Only a queue tells how fast the ticks of the device go. An engine's device gets one to be asked; nothing is submitted
   to it. */
static HRESULT get_tick_rate(gpu_device *device) {
  if (device->queue)
    return ID3D12CommandQueue_GetTimestampFrequency(device->queue, &device->ticks_per_second);
  const D3D12_COMMAND_QUEUE_DESC description = {.Type = D3D12_COMMAND_LIST_TYPE_DIRECT};
  ID3D12CommandQueue *queue;
  HRESULT hr = ID3D12Device_CreateCommandQueue(device->handle, &description, &IID_ID3D12CommandQueue, (void **)&queue);
  if (FAILED(hr))
    return hr;
  hr = ID3D12CommandQueue_GetTimestampFrequency(queue, &device->ticks_per_second);
  ID3D12CommandQueue_Release(queue);
  return hr;
}

csm_result d3d12_queries_create(gpu_device *device) {
  const D3D12_QUERY_HEAP_DESC heap = {.Type = D3D12_QUERY_HEAP_TYPE_TIMESTAMP,
                                      .Count = device->slot_count * GPU_MAX_TIMESTAMPS};
  const gpu_buffer_info results = {
      .name = "csm timestamps", .kind = GPU_BUFFER_READBACK, .size = heap.Count * sizeof(uint64_t)};
  csm_result result = d3d12_check(
      device, ID3D12Device_CreateQueryHeap(device->handle, &heap, &IID_ID3D12QueryHeap, (void **)&device->queries),
      "CreateQueryHeap");
  if (result == CSM_SUCCESS)
    result = d3d12_buffer_create(device, &results, &device->query_results);
  if (result == CSM_SUCCESS)
    result = d3d12_check(device, get_tick_rate(device), "GetTimestampFrequency");
  return result;
}

csm_result d3d12_timestamps(gpu_device *device, uint32_t slot_index, uint32_t first, uint32_t count,
                            uint64_t *nanoseconds) {
  const csm_result result = device->own ? d3d12_wait(device, slot_index) : CSM_SUCCESS;
  if (result != CSM_SUCCESS)
    return result;
  const uint64_t *ticks = (const uint64_t *)device->query_results->mapped + slot_index * GPU_MAX_TIMESTAMPS + first;
  const uint64_t rate = device->ticks_per_second;
  for (uint32_t i = 0; i < count; i++)
    nanoseconds[i] = ticks[i] / rate * 1000000000u + ticks[i] % rate * 1000000000u / rate;
  return CSM_SUCCESS;
}
