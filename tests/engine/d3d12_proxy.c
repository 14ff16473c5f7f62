#include "d3d12_proxy.h"

static d3d12_proxy *of(ID3D12Device *device) {
  return (d3d12_proxy *)device;
}

static ID3D12Device *real(ID3D12Device *device) {
  return of(device)->real;
}

/* What the call that is about to be made answers instead, or S_OK. */
static HRESULT fault(ID3D12Device *device, void **out) {
  d3d12_proxy *proxy = of(device);
  if (out)
    *out = NULL;
  if (proxy->removed)
    return proxy->failure;
  if (++proxy->calls != proxy->fail_at)
    return S_OK;
  proxy->removed = proxy->failure == (HRESULT)0x887a0005; /* DXGI_ERROR_DEVICE_REMOVED */
  return proxy->failure;
}

static ULONG STDMETHODCALLTYPE add_ref(ID3D12Device *device) {
  return ++of(device)->references;
}

static ULONG STDMETHODCALLTYPE release(ID3D12Device *device) {
  return --of(device)->references;
}

static HRESULT STDMETHODCALLTYPE create_queue(ID3D12Device *device, const D3D12_COMMAND_QUEUE_DESC *description,
                                              REFIID id, void **out) {
  const HRESULT hr = fault(device, out);
  return FAILED(hr) ? hr : ID3D12Device_CreateCommandQueue(real(device), description, id, out);
}

static HRESULT STDMETHODCALLTYPE create_pipeline(ID3D12Device *device,
                                                 const D3D12_GRAPHICS_PIPELINE_STATE_DESC *description, REFIID id,
                                                 void **out) {
  const HRESULT hr = fault(device, out);
  return FAILED(hr) ? hr : ID3D12Device_CreateGraphicsPipelineState(real(device), description, id, out);
}

static HRESULT STDMETHODCALLTYPE create_compute(ID3D12Device *device,
                                                const D3D12_COMPUTE_PIPELINE_STATE_DESC *description, REFIID id,
                                                void **out) {
  const HRESULT hr = fault(device, out);
  return FAILED(hr) ? hr : ID3D12Device_CreateComputePipelineState(real(device), description, id, out);
}

static HRESULT STDMETHODCALLTYPE check_feature(ID3D12Device *device, D3D12_FEATURE feature, void *data, UINT size) {
  const D3D_FEATURE_LEVEL level = of(device)->level;
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
  const HRESULT hr = fault(device, out);
  return FAILED(hr) ? hr : ID3D12Device_CreateDescriptorHeap(real(device), description, id, out);
}

static UINT STDMETHODCALLTYPE descriptor_size(ID3D12Device *device, D3D12_DESCRIPTOR_HEAP_TYPE type) {
  return ID3D12Device_GetDescriptorHandleIncrementSize(real(device), type);
}

static HRESULT STDMETHODCALLTYPE create_signature(ID3D12Device *device, UINT node, const void *code, SIZE_T size,
                                                  REFIID id, void **out) {
  const HRESULT hr = fault(device, out);
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
  const HRESULT hr = fault(device, out);
  return FAILED(hr) ? hr
                    : ID3D12Device_CreateCommittedResource(real(device), properties, flags, description, state, clear,
                                                           id, out);
}

static HRESULT STDMETHODCALLTYPE create_placed(ID3D12Device *device, ID3D12Heap *heap, UINT64 offset,
                                               const D3D12_RESOURCE_DESC *description, D3D12_RESOURCE_STATES state,
                                               const D3D12_CLEAR_VALUE *clear, REFIID id, void **out) {
  const HRESULT hr = fault(device, out);
  return FAILED(hr) ? hr
                    : ID3D12Device_CreatePlacedResource(real(device), heap, offset, description, state, clear, id, out);
}

static HRESULT STDMETHODCALLTYPE removed_reason(ID3D12Device *device) {
  return of(device)->removed ? of(device)->failure : ID3D12Device_GetDeviceRemovedReason(real(device));
}

static HRESULT STDMETHODCALLTYPE create_queries(ID3D12Device *device, const D3D12_QUERY_HEAP_DESC *description,
                                                REFIID id, void **out) {
  const HRESULT hr = fault(device, out);
  return FAILED(hr) ? hr : ID3D12Device_CreateQueryHeap(real(device), description, id, out);
}

static HRESULT STDMETHODCALLTYPE create_command_signature(ID3D12Device *device,
                                                          const D3D12_COMMAND_SIGNATURE_DESC *description,
                                                          ID3D12RootSignature *signature, REFIID id, void **out) {
  const HRESULT hr = fault(device, out);
  return FAILED(hr) ? hr : ID3D12Device_CreateCommandSignature(real(device), description, signature, id, out);
}

void d3d12_proxy_open(d3d12_proxy *proxy, ID3D12Device *device) {
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
  *proxy = (d3d12_proxy){.device = {.lpVtbl = (ID3D12DeviceVtbl *)&methods}, .real = device, .references = 1};
}
