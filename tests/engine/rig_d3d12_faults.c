#include "rig_d3d12_faults.h"

enum { DEVICE_REMOVED = (int32_t)0x887a0005 /* DXGI_ERROR_DEVICE_REMOVED */ };

static struct {
  ID3D12Device device; /* what csm gets */
  ID3D12Device *real;
  uint32_t references;
  uint32_t calls;   /* that can fail, so far */
  uint32_t fail_at; /* the call that fails, from 1; 0: none */
  HRESULT failure;
  const char *failed;
  bool removed;            /* the device said that it was lost, and goes on saying so */
  D3D_FEATURE_LEVEL level; /* the highest; 0 asks the real one */
} faults;

static ID3D12Device *real(ID3D12Device *device) {
  assert_ptr_equal(device, &faults.device);
  return faults.real;
}

/* What the call that is about to be made answers instead, or S_OK. */
static HRESULT fault(const char *name, void **out) {
  *out = NULL;
  if (faults.removed)
    return DEVICE_REMOVED;
  if (++faults.calls != faults.fail_at)
    return S_OK;
  faults.failed = name;
  faults.removed = faults.failure == DEVICE_REMOVED;
  return faults.failure;
}

static ULONG STDMETHODCALLTYPE add_ref(ID3D12Device *device) {
  (void)device;
  return ++faults.references;
}

static ULONG STDMETHODCALLTYPE release(ID3D12Device *device) {
  (void)device;
  return --faults.references;
}

static HRESULT STDMETHODCALLTYPE create_queue(ID3D12Device *device, const D3D12_COMMAND_QUEUE_DESC *description,
                                              REFIID id, void **out) {
  const HRESULT hr = fault("CreateCommandQueue", out);
  return FAILED(hr) ? hr : ID3D12Device_CreateCommandQueue(real(device), description, id, out);
}

static HRESULT STDMETHODCALLTYPE create_pipeline(ID3D12Device *device,
                                                 const D3D12_GRAPHICS_PIPELINE_STATE_DESC *description, REFIID id,
                                                 void **out) {
  const HRESULT hr = fault("CreateGraphicsPipelineState", out);
  return FAILED(hr) ? hr : ID3D12Device_CreateGraphicsPipelineState(real(device), description, id, out);
}

static HRESULT STDMETHODCALLTYPE create_compute(ID3D12Device *device,
                                                const D3D12_COMPUTE_PIPELINE_STATE_DESC *description, REFIID id,
                                                void **out) {
  const HRESULT hr = fault("CreateComputePipelineState", out);
  return FAILED(hr) ? hr : ID3D12Device_CreateComputePipelineState(real(device), description, id, out);
}

static HRESULT STDMETHODCALLTYPE check_feature(ID3D12Device *device, D3D12_FEATURE feature, void *data, UINT size) {
  const D3D_FEATURE_LEVEL level = faults.level;
  if (!level || feature != D3D12_FEATURE_FEATURE_LEVELS)
    return ID3D12Device_CheckFeatureSupport(real(device), feature, data, size);
  D3D12_FEATURE_DATA_FEATURE_LEVELS *levels = data;
  levels->MaxSupportedFeatureLevel = 0;
  for (UINT i = 0; i < levels->NumFeatureLevels; ++i)
    if (levels->pFeatureLevelsRequested[i] <= level)
      levels->MaxSupportedFeatureLevel = levels->pFeatureLevelsRequested[i];
  return S_OK;
}

static HRESULT STDMETHODCALLTYPE create_heap(ID3D12Device *device, const D3D12_DESCRIPTOR_HEAP_DESC *description,
                                             REFIID id, void **out) {
  const HRESULT hr = fault("CreateDescriptorHeap", out);
  return FAILED(hr) ? hr : ID3D12Device_CreateDescriptorHeap(real(device), description, id, out);
}

static UINT STDMETHODCALLTYPE descriptor_size(ID3D12Device *device, D3D12_DESCRIPTOR_HEAP_TYPE type) {
  return ID3D12Device_GetDescriptorHandleIncrementSize(real(device), type);
}

static HRESULT STDMETHODCALLTYPE create_signature(ID3D12Device *device, UINT node, const void *code, SIZE_T size,
                                                  REFIID id, void **out) {
  const HRESULT hr = fault("CreateRootSignature", out);
  return FAILED(hr) ? hr : ID3D12Device_CreateRootSignature(real(device), node, code, size, id, out);
}

static void STDMETHODCALLTYPE create_srv(ID3D12Device *device, ID3D12Resource *resource,
                                         const D3D12_SHADER_RESOURCE_VIEW_DESC *view,
                                         D3D12_CPU_DESCRIPTOR_HANDLE where) {
  ID3D12Device_CreateShaderResourceView(real(device), resource, view, where);
}

static void STDMETHODCALLTYPE create_uav(ID3D12Device *device, ID3D12Resource *resource, ID3D12Resource *counter,
                                         const D3D12_UNORDERED_ACCESS_VIEW_DESC *view,
                                         D3D12_CPU_DESCRIPTOR_HANDLE where) {
  ID3D12Device_CreateUnorderedAccessView(real(device), resource, counter, view, where);
}

static void STDMETHODCALLTYPE create_rtv(ID3D12Device *device, ID3D12Resource *resource,
                                         const D3D12_RENDER_TARGET_VIEW_DESC *view, D3D12_CPU_DESCRIPTOR_HANDLE where) {
  ID3D12Device_CreateRenderTargetView(real(device), resource, view, where);
}

static void STDMETHODCALLTYPE create_dsv(ID3D12Device *device, ID3D12Resource *resource,
                                         const D3D12_DEPTH_STENCIL_VIEW_DESC *view, D3D12_CPU_DESCRIPTOR_HANDLE where) {
  ID3D12Device_CreateDepthStencilView(real(device), resource, view, where);
}

static D3D12_RESOURCE_ALLOCATION_INFO *STDMETHODCALLTYPE allocation_info(ID3D12Device *device,
                                                                         D3D12_RESOURCE_ALLOCATION_INFO *out, UINT mask,
                                                                         UINT count,
                                                                         const D3D12_RESOURCE_DESC *descriptions) {
  *out = ID3D12Device_GetResourceAllocationInfo(real(device), mask, count, descriptions);
  return out;
}

static HRESULT STDMETHODCALLTYPE create_resource(ID3D12Device *device, const D3D12_HEAP_PROPERTIES *properties,
                                                 D3D12_HEAP_FLAGS flags, const D3D12_RESOURCE_DESC *description,
                                                 D3D12_RESOURCE_STATES state, const D3D12_CLEAR_VALUE *clear, REFIID id,
                                                 void **out) {
  const HRESULT hr = fault("CreateCommittedResource", out);
  return FAILED(hr) ? hr
                    : ID3D12Device_CreateCommittedResource(real(device), properties, flags, description, state, clear,
                                                           id, out);
}

static HRESULT STDMETHODCALLTYPE create_placed(ID3D12Device *device, ID3D12Heap *heap, UINT64 offset,
                                               const D3D12_RESOURCE_DESC *description, D3D12_RESOURCE_STATES state,
                                               const D3D12_CLEAR_VALUE *clear, REFIID id, void **out) {
  const HRESULT hr = fault("CreatePlacedResource", out);
  return FAILED(hr) ? hr
                    : ID3D12Device_CreatePlacedResource(real(device), heap, offset, description, state, clear, id, out);
}

static HRESULT STDMETHODCALLTYPE removed_reason(ID3D12Device *device) {
  return faults.removed ? DEVICE_REMOVED : ID3D12Device_GetDeviceRemovedReason(real(device));
}

static HRESULT STDMETHODCALLTYPE create_queries(ID3D12Device *device, const D3D12_QUERY_HEAP_DESC *description,
                                                REFIID id, void **out) {
  const HRESULT hr = fault("CreateQueryHeap", out);
  return FAILED(hr) ? hr : ID3D12Device_CreateQueryHeap(real(device), description, id, out);
}

static HRESULT STDMETHODCALLTYPE create_command_signature(ID3D12Device *device,
                                                          const D3D12_COMMAND_SIGNATURE_DESC *description,
                                                          ID3D12RootSignature *signature, REFIID id, void **out) {
  const HRESULT hr = fault("CreateCommandSignature", out);
  return FAILED(hr) ? hr : ID3D12Device_CreateCommandSignature(real(device), description, signature, id, out);
}

ID3D12Device *d3d12_faults_open(ID3D12Device *real_device) {
  static const ID3D12DeviceVtbl methods = {
      .AddRef = add_ref,
      .Release = release,
      .CreateCommandQueue = create_queue,
      .CreateGraphicsPipelineState = create_pipeline,
      .CreateComputePipelineState = create_compute,
      .CheckFeatureSupport = check_feature,
      .CreateDescriptorHeap = create_heap,
      .GetDescriptorHandleIncrementSize = descriptor_size,
      .CreateRootSignature = create_signature,
      .CreateShaderResourceView = create_srv,
      .CreateUnorderedAccessView = create_uav,
      .CreateRenderTargetView = create_rtv,
      .CreateDepthStencilView = create_dsv,
      .GetResourceAllocationInfo = allocation_info,
      .CreateCommittedResource = create_resource,
      .CreatePlacedResource = create_placed,
      .GetDeviceRemovedReason = removed_reason,
      .CreateQueryHeap = create_queries,
      .CreateCommandSignature = create_command_signature,
  };
  faults.device.lpVtbl = (ID3D12DeviceVtbl *)&methods;
  faults.real = real_device;
  faults.references = 1;
  faults.fail_at = 0;
  faults.removed = false;
  return &faults.device;
}

void d3d12_faults_level(D3D_FEATURE_LEVEL level) {
  faults.level = level;
}

/* ---- the rig's faults ---- */

const rig_fault rig_faults[] = {
    {"out of device memory", E_OUTOFMEMORY, CSM_ERROR_OUT_OF_DEVICE_MEMORY},
    {"an error of the device's", E_FAIL, CSM_ERROR_DEVICE},
    {"the device is removed", DEVICE_REMOVED, CSM_ERROR_DEVICE_LOST},
    {"the allocator fails", S_OK, CSM_ERROR_OUT_OF_MEMORY},
};
const uint32_t rig_fault_count = sizeof rig_faults / sizeof rig_faults[0];

void rig_fail(const rig_fault *fault, uint32_t nth) {
  if (nth)
    faults.failed = NULL;
  faults.failure = fault ? fault->code : S_OK;
  faults.fail_at = nth && faults.failure ? faults.calls + nth : 0;
}

const char *rig_failed(void) {
  return faults.failed;
}

/* csm records into the engine's list alone, and no call of that can fail. */
bool rig_loses_recording(const char *function) {
  (void)function;
  return false;
}

void rig_find(void) {
  faults.removed = false;
}

bool rig_lose(void) {
  faults.removed = true;
  return true;
}

const char *rig_leak(void) {
  return faults.references != 1 ? "a reference of the device" : NULL;
}
