/* own.c: an own device: what the run time opens, and the queue that its commands go to. */
#include "internal.h"

csm_result d3d12_own_select(gpu_device *device, const gpu_open_info *info) {
  return d3d12_runtime_open(device, info);
}

csm_result d3d12_own_open(gpu_device *device) {
  const D3D12_COMMAND_QUEUE_DESC queue = {.Type = D3D12_COMMAND_LIST_TYPE_DIRECT};
  csm_result result = d3d12_runtime_create_device(device);
  if (result == CSM_SUCCESS)
    result = d3d12_check(
        device,
        ID3D12Device_CreateCommandQueue(device->handle, &queue, &IID_ID3D12CommandQueue, (void **)&device->queue),
        "CreateCommandQueue");
  if (result == CSM_SUCCESS)
    result = d3d12_check(
        device,
        ID3D12Device_CreateFence(device->handle, 0, D3D12_FENCE_FLAG_NONE, &IID_ID3D12Fence, (void **)&device->fence),
        "CreateFence");
  return result;
}

void d3d12_own_close(gpu_device *device) {
  d3d12_unref(device->fence);
  d3d12_unref(device->queue);
  const ULONG references = device->handle ? ID3D12Device_Release(device->handle) : 0;
  if (references)
    lent_fail(&device->lent, CSM_ERROR_DEVICE, "the device still has %u references when it is closed", references);
  d3d12_runtime_close(device);
}
