/*
 * device.c: opening and closing. A device is obtained first: an own one (obtain_device: driver, device, queue, fence, a
 * list and an allocator for each slot) or an engine's (engine.c); what recording needs on any device is made on top of
 * it (use_device).
 */
#include "d3d12.h"
#include <string.h>
#include <time.h>

enum { WAIT_SECONDS = 2 }; /* how long a wait lasts before it asks whether the device is lost */

static csm_result event_open(d3d12_event *event) {
  pthread_condattr_t attributes;
  if (pthread_condattr_init(&attributes))
    return CSM_ERROR_OUT_OF_MEMORY;
  pthread_condattr_setclock(&attributes, CLOCK_MONOTONIC);
  const int failed = pthread_cond_init(&event->signaled_changed, &attributes);
  pthread_condattr_destroy(&attributes);
  if (failed)
    return CSM_ERROR_OUT_OF_MEMORY;
  pthread_mutex_init(&event->mutex, NULL);
  return CSM_SUCCESS;
}

static void event_close(d3d12_event *event) {
  pthread_mutex_destroy(&event->mutex);
  pthread_cond_destroy(&event->signaled_changed);
}

/* True when the event was signaled within WAIT_SECONDS; it is reset then. */
static bool event_wait(d3d12_event *event) {
  struct timespec end;
  clock_gettime(CLOCK_MONOTONIC, &end);
  end.tv_sec += WAIT_SECONDS;
  pthread_mutex_lock(&event->mutex);
  int failed = 0;
  while (!event->signaled && !failed)
    failed = pthread_cond_timedwait(&event->signaled_changed, &event->mutex, &end);
  const bool signaled = event->signaled;
  event->signaled = false;
  pthread_mutex_unlock(&event->mutex);
  return signaled;
}

csm_result d3d12_signal(gpu_device *device) {
  const HRESULT hr = ID3D12CommandQueue_Signal(device->queue, device->fence, device->fence_value + 1);
  if (SUCCEEDED(hr)) {
    ++device->fence_value;
    return CSM_SUCCESS;
  }
  const csm_result result = d3d12_check(device, hr, "submitting");
  /* vkd3d has no name for a lost device: it answers E_FAIL, and a submission can fail for no other reason. */
  return result == CSM_ERROR_DEVICE ? CSM_ERROR_DEVICE_LOST : result;
}

csm_result d3d12_wait(gpu_device *device, uint32_t slot) {
  const uint64_t value = device->slots[slot].fence_value;
  while (ID3D12Fence_GetCompletedValue(device->fence) < value) {
    const HRESULT hr = ID3D12Fence_SetEventOnCompletion(device->fence, value, &device->event);
    if (FAILED(hr))
      return d3d12_check(device, hr, "waiting");
    /* vkd3d never wakes who waits on a lost device. Another signal behind the work tells whether it is. */
    if (!event_wait(&device->event) && d3d12_signal(device) == CSM_ERROR_DEVICE_LOST)
      return CSM_ERROR_DEVICE_LOST;
  }
  return CSM_SUCCESS;
}

static csm_result query_engine(const gpu_open_info *info, gpu_device_info *out) {
  ID3D12Device *device;
  d3d12_serializer serialize;
  const csm_result result = d3d12_engine_open(info, &device, &serialize, out);
  if (result == CSM_SUCCESS)
    ID3D12Device_Release(device);
  return result;
}

csm_result d3d12_query(const gpu_open_info *info, gpu_device_info *out) {
  if (info->native)
    return query_engine(info, out);
  d3d12_driver driver;
  const csm_result result = d3d12_driver_open(&driver, info, out);
  if (result == CSM_SUCCESS)
    d3d12_driver_close(&driver);
  return result;
}

static csm_result create_device(gpu_device *device, const gpu_open_info *info) {
  const struct vkd3d_device_create_info create = {
      .type = VKD3D_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
      .minimum_feature_level = D3D_FEATURE_LEVEL_11_0,
      .instance = device->driver.instance,
      .vk_physical_device = device->driver.physical_device,
  };
  const HRESULT hr = device->driver.create_device(&create, &IID_ID3D12Device, (void **)&device->device);
  if (SUCCEEDED(hr))
    return CSM_SUCCESS;
  device->device = NULL;
  return d3d12_refuse(info, CSM_ERROR_NO_DEVICE, "vkd3d cannot open %s at feature level 11_0 (HRESULT 0x%08x)",
                      device->info.name, (uint32_t)hr);
}

static HRESULT create_queue(gpu_device *device) {
  const D3D12_COMMAND_QUEUE_DESC queue = {.Type = D3D12_COMMAND_LIST_TYPE_DIRECT};
  HRESULT hr =
      ID3D12Device_CreateCommandQueue(device->device, &queue, &IID_ID3D12CommandQueue, (void **)&device->queue);
  if (SUCCEEDED(hr))
    hr = ID3D12Device_CreateFence(device->device, 0, D3D12_FENCE_FLAG_NONE, &IID_ID3D12Fence, (void **)&device->fence);
  for (uint32_t i = 0; i < device->slot_count && SUCCEEDED(hr); ++i)
    hr = ID3D12Device_CreateCommandAllocator(device->device, D3D12_COMMAND_LIST_TYPE_DIRECT,
                                             &IID_ID3D12CommandAllocator, (void **)&device->slots[i].allocator);
  if (SUCCEEDED(hr))
    hr = ID3D12Device_CreateCommandList(device->device, 0, D3D12_COMMAND_LIST_TYPE_DIRECT, device->slots[0].allocator,
                                        NULL, &IID_ID3D12GraphicsCommandList, (void **)&device->own_list);
  return SUCCEEDED(hr) ? ID3D12GraphicsCommandList_Close(device->own_list) : hr;
}

static csm_result obtain_device(gpu_device *device, const gpu_open_info *info) {
  csm_result result = d3d12_driver_open(&device->driver, info, &device->info);
  if (result == CSM_SUCCESS)
    result = create_device(device, info);
  if (result != CSM_SUCCESS)
    return result;
  const HRESULT hr = create_queue(device);
  if (FAILED(hr))
    return d3d12_refuse(info, d3d12_result(hr), "a command queue cannot be made (HRESULT 0x%08x)", (uint32_t)hr);
  return CSM_SUCCESS;
}

static HRESULT create_descriptors(gpu_device *device) {
  const D3D12_DESCRIPTOR_HEAP_DESC heap = {
      .Type = D3D12_DESCRIPTOR_HEAP_TYPE_CBV_SRV_UAV,
      .NumDescriptors = D3D12_BINDING_BLOCKS * GPU_MAX_TEXTURES,
      .Flags = D3D12_DESCRIPTOR_HEAP_FLAG_SHADER_VISIBLE,
  };
  device->descriptor_size =
      ID3D12Device_GetDescriptorHandleIncrementSize(device->device, D3D12_DESCRIPTOR_HEAP_TYPE_CBV_SRV_UAV);
  device->free_block_count = D3D12_BINDING_BLOCKS;
  for (uint32_t i = 0; i < D3D12_BINDING_BLOCKS; ++i)
    device->free_blocks[i] = (uint16_t)(D3D12_BINDING_BLOCKS - 1 - i);
  return ID3D12Device_CreateDescriptorHeap(device->device, &heap, &IID_ID3D12DescriptorHeap,
                                           (void **)&device->descriptors);
}

static HRESULT create_queries(gpu_device *device) {
  const D3D12_QUERY_HEAP_DESC heap = {
      .Type = D3D12_QUERY_HEAP_TYPE_TIMESTAMP,
      .Count = device->slot_count * GPU_MAX_TIMESTAMPS,
  };
  void *memory = NULL;
  HRESULT hr = ID3D12Device_CreateQueryHeap(device->device, &heap, &IID_ID3D12QueryHeap, (void **)&device->queries);
  if (SUCCEEDED(hr))
    hr = d3d12_commit_buffer(device->device, D3D12_HEAP_TYPE_READBACK, heap.Count * sizeof(uint64_t),
                             &device->query_results);
  if (SUCCEEDED(hr))
    hr = ID3D12Resource_Map(device->query_results, 0, NULL, &memory);
  device->query_ticks = memory;
  if (FAILED(hr))
    return hr;
  return device->queue ? ID3D12CommandQueue_GetTimestampFrequency(device->queue, &device->ticks_per_second)
                       : d3d12_engine_tick_rate(device->device, &device->ticks_per_second);
}

static HRESULT create_fill(gpu_device *device) {
  void *memory = NULL;
  HRESULT hr =
      d3d12_commit_buffer(device->device, D3D12_HEAP_TYPE_UPLOAD, D3D12_FILL_PARTS * D3D12_FILL_SIZE, &device->fill);
  if (SUCCEEDED(hr))
    hr = ID3D12Resource_Map(device->fill, 0, NULL, &memory);
  if (FAILED(hr))
    return hr;
  unsigned char *bytes = memory;
  float *ones = (float *)(bytes + D3D12_FILL_ONE_D32 * D3D12_FILL_SIZE);
  memset(bytes + D3D12_FILL_ZERO * D3D12_FILL_SIZE, 0, D3D12_FILL_SIZE);
  for (uint32_t i = 0; i < D3D12_FILL_SIZE / sizeof *ones; ++i)
    ones[i] = 1;
  memset(bytes + D3D12_FILL_ONE_D16 * D3D12_FILL_SIZE, 0xff, D3D12_FILL_SIZE);
  ID3D12Resource_Unmap(device->fill, 0, NULL);
  return S_OK;
}

static csm_result use_device(gpu_device *device, const gpu_open_info *info) {
  HRESULT hr = create_descriptors(device);
  if (SUCCEEDED(hr))
    hr = create_queries(device);
  if (SUCCEEDED(hr) && device->info.type == CSM_DEVICE_CPU)
    hr = create_fill(device);
  if (FAILED(hr))
    return d3d12_refuse(info, d3d12_result(hr), "descriptors or queries cannot be made (HRESULT 0x%08x)", (uint32_t)hr);
  return CSM_SUCCESS;
}

static void leave_device(gpu_device *device) {
  if (device->fill)
    ID3D12Resource_Release(device->fill);
  if (device->query_results)
    ID3D12Resource_Release(device->query_results);
  if (device->queries)
    ID3D12QueryHeap_Release(device->queries);
  if (device->descriptors)
    ID3D12DescriptorHeap_Release(device->descriptors);
}

static void release_device(gpu_device *device) {
  if (device->own_list)
    ID3D12GraphicsCommandList_Release(device->own_list);
  for (uint32_t i = 0; i < device->slot_count; ++i)
    if (device->slots[i].allocator)
      ID3D12CommandAllocator_Release(device->slots[i].allocator);
  if (device->fence)
    ID3D12Fence_Release(device->fence);
  if (device->queue)
    ID3D12CommandQueue_Release(device->queue);
  const bool own = device->driver.instance;
  const ULONG references = device->device ? ID3D12Device_Release(device->device) : 0;
  if (references && own)
    d3d12_log(&device->host, CSM_LOG_ERROR, "d3d12: the device still has %u references when it is closed", references);
  d3d12_driver_close(&device->driver);
}

csm_result d3d12_open(const gpu_open_info *info, gpu_device **out) {
  *out = NULL;
  gpu_device *device = d3d12_new(info->host, sizeof *device);
  if (!device)
    return d3d12_refuse(info, CSM_ERROR_OUT_OF_MEMORY, "out of memory");
  device->host = *info->host;
  device->slot_count = info->slots;
  csm_result result = event_open(&device->event);
  if (result != CSM_SUCCESS) {
    device->host.release(device->host.user, device);
    return d3d12_refuse(info, result, "out of memory");
  }
  result = info->native ? d3d12_engine_open(info, &device->device, &device->serialize, &device->info)
                        : obtain_device(device, info);
  if (result == CSM_SUCCESS)
    result = use_device(device, info);
  if (result != CSM_SUCCESS) {
    d3d12_close(device);
    return result;
  }
  *out = device;
  return CSM_SUCCESS;
}

void d3d12_close(gpu_device *device) {
  for (uint32_t i = 0; i < device->slot_count && device->fence; ++i)
    if (d3d12_wait(device, i) != CSM_SUCCESS)
      break; /* a lost device runs nothing any more */
  leave_device(device);
  release_device(device);
  event_close(&device->event);
  device->host.release(device->host.user, device);
}

void d3d12_describe(const gpu_device *device, gpu_device_info *out) {
  *out = device->info;
}

uint64_t d3d12_memory_available(gpu_device *device) {
  return d3d12_driver_memory_available(&device->driver);
}
