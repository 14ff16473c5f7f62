/*
 * runtime.h: where Direct3D 12 comes from. A run time is one file that implements what is below: it opens libraries,
 * chooses a device and describes it, waits for fences, passes on what validation says, and tells what it allows beyond
 * Direct3D 12. There is one, runtime_vkd3d.c. Nothing is linked with it, and the rest of the backend knows none.
 */
#ifndef D3D12_RUNTIME_H
#define D3D12_RUNTIME_H

#define COBJMACROS
#define WIDL_C_INLINE_WRAPPERS
#include <vkd3d_windows.h>
/* after the types that it needs */
#include <vkd3d_d3d12.h>

#include "../gpu.h"

/* Libraries, and the adapter chosen in them. */
typedef struct d3d12_runtime d3d12_runtime;

/* What is true of the run time, whoever opened the device. */
typedef struct d3d12_traits {
  gpu_needs required, optional;
  bool self_barriers; /* a barrier from a state to itself orders two writes in that state; else copies need none */
  bool partial_depth_copies; /* a part of a layer of depths may be copied */
  bool markers;              /* events in a command list are seen by someone */
} d3d12_traits;

const d3d12_traits *d3d12_runtime_traits(void);

/* Opens the libraries, chooses an adapter, and describes it in device->info. The run time is device->runtime then, and
   d3d12_runtime_close is due, also after an error. Errors: NO_DEVICE, DEVICE, OUT_OF_MEMORY. */
csm_result d3d12_runtime_open(gpu_device *device, const gpu_open_info *info);
void d3d12_runtime_close(gpu_device *device);

/* Makes device->handle on the adapter. Errors: NO_DEVICE. */
csm_result d3d12_runtime_create_device(gpu_device *device);

/* D3D12SerializeRootSignature, of version 1.0. */
HRESULT d3d12_runtime_serialize(const d3d12_runtime *runtime, const D3D12_ROOT_SIGNATURE_DESC *signature,
                                ID3DBlob **out);

/* Waits until the fence has the value, or a second or two have passed: a lost device may never wake who waits. */
HRESULT d3d12_runtime_wait(d3d12_runtime *runtime, ID3D12Fence *fence, uint64_t value);

/* Bytes of device memory that this process may still take, or UINT64_MAX. */
uint64_t d3d12_runtime_memory_available(const d3d12_runtime *runtime);

#endif
