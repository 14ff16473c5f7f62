/*
 * memory.c: resources and what they lie in. Each committed resource is an allocation of the driver's; the front makes
 * few and large ones. Where an engine has an allocator, each resource is placed where that says.
 */
#include "internal.h"

/* Of a heap that holds this kind of resource and no other, which every device can make. */
static D3D12_HEAP_FLAGS heap_flags(const D3D12_RESOURCE_DESC *description) {
  const D3D12_RESOURCE_FLAGS target = D3D12_RESOURCE_FLAG_ALLOW_RENDER_TARGET | D3D12_RESOURCE_FLAG_ALLOW_DEPTH_STENCIL;
  return description->Dimension == D3D12_RESOURCE_DIMENSION_BUFFER ? D3D12_HEAP_FLAG_ALLOW_ONLY_BUFFERS
         : description->Flags & target                             ? D3D12_HEAP_FLAG_ALLOW_ONLY_RT_DS_TEXTURES
                                                                   : D3D12_HEAP_FLAG_ALLOW_ONLY_NON_RT_DS_TEXTURES;
}

static csm_result create_committed(gpu_device *device, D3D12_HEAP_TYPE heap, const D3D12_RESOURCE_DESC *description,
                                   D3D12_RESOURCE_STATES state, d3d12_resource *out) {
  const D3D12_HEAP_PROPERTIES properties = {.Type = heap};
  return d3d12_check(device,
                     ID3D12Device_CreateCommittedResource(device->handle, &properties, D3D12_HEAP_FLAG_NONE,
                                                          description, state, NULL, &IID_ID3D12Resource,
                                                          (void **)&out->handle),
                     "CreateCommittedResource");
}

static csm_result create_placed(gpu_device *device, const csm_d3d12_memory_request *request,
                                const D3D12_RESOURCE_DESC *description, D3D12_RESOURCE_STATES state,
                                d3d12_resource *out) {
  const csm_result result = d3d12_check(device, device->allocate_memory(device->memory_user, request, &out->memory),
                                        "the engine's allocate_memory");
  if (result != CSM_SUCCESS) {
    out->memory = (csm_d3d12_memory){0};
    return result;
  }
  if (!out->memory.heap)
    return lent_fail(&device->lent, CSM_ERROR_OUT_OF_DEVICE_MEMORY, "the engine's allocate_memory: heap is NULL");
  if (out->memory.offset % request->alignment)
    return lent_fail(&device->lent, CSM_ERROR_DEVICE,
                     "the engine's allocate_memory: offset is no multiple of the alignment");
  return d3d12_check(device,
                     ID3D12Device_CreatePlacedResource(device->handle, out->memory.heap, out->memory.offset,
                                                       description, state, NULL, &IID_ID3D12Resource,
                                                       (void **)&out->handle),
                     "CreatePlacedResource");
}

csm_result d3d12_resource_create(gpu_device *device, D3D12_HEAP_TYPE heap, const D3D12_RESOURCE_DESC *description,
                                 D3D12_RESOURCE_STATES state, const char *name, d3d12_resource *out) {
  const D3D12_RESOURCE_ALLOCATION_INFO needs =
      ID3D12Device_GetResourceAllocationInfo(device->handle, 0, 1, description);
  const csm_d3d12_memory_request request = {.struct_size = sizeof request,
                                            .heap_type = heap,
                                            .size = needs.SizeInBytes,
                                            .alignment = needs.Alignment,
                                            .heap_flags = heap_flags(description),
                                            .name = name};
  *out = (d3d12_resource){.bytes = needs.SizeInBytes};
  const csm_result result = device->allocate_memory ? create_placed(device, &request, description, state, out)
                                                    : create_committed(device, heap, description, state, out);
  if (result == CSM_SUCCESS)
    d3d12_name(out->handle, name);
  else
    d3d12_resource_destroy(device, out);
  return result;
}

void d3d12_resource_destroy(gpu_device *device, d3d12_resource *resource) {
  d3d12_unref(resource->handle);
  if (resource->memory.heap)
    device->free_memory(device->memory_user, &resource->memory);
  *resource = (d3d12_resource){0};
}
