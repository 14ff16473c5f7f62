/*
 * runtime.h: where Direct3D 12 comes from. A run time is one file that implements what is declared here. It opens
 * libraries, chooses an adapter and describes it, makes the device, waits for fences, and passes on what validation
 * says. It also tells what it allows beyond Direct3D 12. The rest of the backend knows Direct3D 12 alone.
 */
#ifndef D3D12_RUNTIME_H
#define D3D12_RUNTIME_H

#include "../gpu.h"
#include "headers.h"

/* Libraries, and the adapter chosen in them. */
typedef struct d3d12_runtime d3d12_runtime;

/* What is true of the run time, whoever opened the device. */
typedef struct d3d12_traits {
  gpu_needs required, optional;
  bool self_barriers; /* two writes in one state are ordered by a barrier from it to itself; else by themselves */
  bool partial_depth_copies; /* a part of a layer of depths may be copied */
  bool markers;              /* events in a command list are seen by someone */
  bool discards;             /* DiscardResource does what it says; else nothing needs it */
  bool nameless_loss;        /* a lost device has no HRESULT of its own: a signal that fails in any way tells of it */
} d3d12_traits;

const d3d12_traits *d3d12_runtime_traits(void);

/* Opens the libraries, chooses an adapter, and describes it in device->info. The run time is device->runtime then.
   d3d12_runtime_close is due, after an error too. Errors: NO_DEVICE, DEVICE, OUT_OF_MEMORY. */
csm_result d3d12_runtime_open(gpu_device *device, const gpu_open_info *info);
void d3d12_runtime_close(gpu_device *device);

/* Makes device->handle on the adapter. Errors: NO_DEVICE. */
csm_result d3d12_runtime_create_device(gpu_device *device);

/* D3D12SerializeRootSignature, of version 1.0. */
HRESULT d3d12_runtime_serialize(const d3d12_runtime *runtime, const D3D12_ROOT_SIGNATURE_DESC *signature,
                                ID3DBlob **out);

/* Waits until the fence has the value. Returns after a second or two all the same: a lost device may never wake who
   waits. */
HRESULT d3d12_runtime_wait(d3d12_runtime *runtime, ID3D12Fence *fence, uint64_t value);

/* Bytes of device memory that this process may still take, or UINT64_MAX. */
uint64_t d3d12_runtime_memory_available(const d3d12_runtime *runtime);

#endif
