/* rig_d3d12_forward.c: a Direct3D 12 engine's forward shader. */
#include "rig_d3d12.h"
#include "rig_forward.h"

#include "csm_constants.h"
#include "forward_code.h"
#include "shader_code.h"

#include <stdlib.h>
#include <string.h>

enum { CONSTANTS = CSM_C_COUNT * 16, AT_PLANE = (CONSTANTS + 255) / 256 * 256, PLANE = 256 };

/* The table: t0 and t1, t8 and t9. */
enum { MAPS = 0, MOMENTS = 1, MESHES = 2, INSTANCES = 3, DESCRIPTORS = 4 };

struct rig_forward {
  rig *rig;
  uint32_t width, height;
  ID3D12RootSignature *signature;
  ID3D12PipelineState *state;
  ID3D12DescriptorHeap *heap, *target_heap;
  ID3D12Resource *target;
  rig_buffer constants, copy;
};

/* ---- objects ---- */

static void make_signature(rig_forward *f) {
  const D3D12_DESCRIPTOR_RANGE ranges[] = {{.RangeType = D3D12_DESCRIPTOR_RANGE_TYPE_SRV, .NumDescriptors = 2},
                                           {.RangeType = D3D12_DESCRIPTOR_RANGE_TYPE_SRV,
                                            .NumDescriptors = 2,
                                            .BaseShaderRegister = 8,
                                            .OffsetInDescriptorsFromTableStart = MESHES}};
  const D3D12_ROOT_PARAMETER parameters[] = {
      {.ParameterType = D3D12_ROOT_PARAMETER_TYPE_CBV},
      {.ParameterType = D3D12_ROOT_PARAMETER_TYPE_CBV, .Descriptor = {.ShaderRegister = 1}},
      {.ParameterType = D3D12_ROOT_PARAMETER_TYPE_DESCRIPTOR_TABLE,
       .DescriptorTable = {.NumDescriptorRanges = 2, .pDescriptorRanges = ranges}}};
  const D3D12_STATIC_SAMPLER_DESC point = {.Filter = D3D12_FILTER_MIN_MAG_MIP_POINT,
                                           .AddressU = D3D12_TEXTURE_ADDRESS_MODE_WRAP,
                                           .AddressV = D3D12_TEXTURE_ADDRESS_MODE_WRAP,
                                           .AddressW = D3D12_TEXTURE_ADDRESS_MODE_WRAP,
                                           .ComparisonFunc = D3D12_COMPARISON_FUNC_NEVER};
  D3D12_STATIC_SAMPLER_DESC samplers[] = {point, point};
  samplers[1].ShaderRegister = 1;
  const D3D12_ROOT_SIGNATURE_DESC description = {
      .NumParameters = 3, .pParameters = parameters, .NumStaticSamplers = 2, .pStaticSamplers = samplers};
  ID3DBlob *blob = NULL;
  rig_d3d12_must(D3D12SerializeRootSignature(&description, D3D_ROOT_SIGNATURE_VERSION_1_0, &blob, NULL),
                 "serialising a root signature");
  rig_d3d12_must(ID3D12Device_CreateRootSignature(f->rig->device, 0, ID3D10Blob_GetBufferPointer(blob),
                                                  ID3D10Blob_GetBufferSize(blob), &IID_ID3D12RootSignature,
                                                  (void **)&f->signature),
                 "a root signature");
  ID3D10Blob_Release(blob);
}

static void make_state(rig_forward *f, bool rays) {
  const gpu_code *code = rays ? &shader_forward_exact_ps : &shader_forward_gathers_ps;
  const D3D12_GRAPHICS_PIPELINE_STATE_DESC info = {
      .pRootSignature = f->signature,
      .VS = {shader_screen_vs.dxbc, shader_screen_vs.dxbc_size},
      .PS = {code->dxbc, code->dxbc_size},
      .BlendState = {.RenderTarget = {{.RenderTargetWriteMask = D3D12_COLOR_WRITE_ENABLE_ALL}}},
      .SampleMask = ~0u,
      .RasterizerState = {.FillMode = D3D12_FILL_MODE_SOLID, .CullMode = D3D12_CULL_MODE_NONE},
      .PrimitiveTopologyType = D3D12_PRIMITIVE_TOPOLOGY_TYPE_TRIANGLE,
      .NumRenderTargets = 1,
      .RTVFormats = {DXGI_FORMAT_R8_UNORM},
      .SampleDesc = {.Count = 1}};
  rig_d3d12_must(
      ID3D12Device_CreateGraphicsPipelineState(f->rig->device, &info, &IID_ID3D12PipelineState, (void **)&f->state),
      "a pipeline");
}

static void make_target(rig_forward *f) {
  const D3D12_RESOURCE_DESC description = {.Width = f->width,
                                           .Height = f->height,
                                           .Format = DXGI_FORMAT_R8_UNORM,
                                           .Flags = D3D12_RESOURCE_FLAG_ALLOW_RENDER_TARGET};
  unsigned char *nothing = calloc(f->width, f->height);
  f->target = rig_d3d12_image(f->rig, &description, 1, nothing);
  free(nothing);
}

static void make_heaps(rig_forward *f) {
  const D3D12_DESCRIPTOR_HEAP_DESC heap = {.Type = D3D12_DESCRIPTOR_HEAP_TYPE_CBV_SRV_UAV,
                                           .NumDescriptors = DESCRIPTORS,
                                           .Flags = D3D12_DESCRIPTOR_HEAP_FLAG_SHADER_VISIBLE};
  const D3D12_DESCRIPTOR_HEAP_DESC targets = {.Type = D3D12_DESCRIPTOR_HEAP_TYPE_RTV, .NumDescriptors = 1};
  rig_d3d12_must(ID3D12Device_CreateDescriptorHeap(f->rig->device, &heap, &IID_ID3D12DescriptorHeap, (void **)&f->heap),
                 "a heap");
  rig_d3d12_must(
      ID3D12Device_CreateDescriptorHeap(f->rig->device, &targets, &IID_ID3D12DescriptorHeap, (void **)&f->target_heap),
      "a heap");
  ID3D12Device_CreateRenderTargetView(f->rig->device, f->target, NULL,
                                      ID3D12DescriptorHeap_GetCPUDescriptorHandleForHeapStart(f->target_heap));
}

rig_forward *rig_forward_make(rig *rig, uint32_t width, uint32_t height, bool rays) {
  rig_forward *f = calloc(1, sizeof *f);
  assert_non_null(f);
  *f = (rig_forward){.rig = rig, .width = width, .height = height};
  make_signature(f);
  make_state(f, rays);
  make_target(f);
  make_heaps(f);
  f->constants = rig_buffer_make(rig, RIG_CONSTANTS, AT_PLANE + PLANE);
  f->copy = rig_buffer_make(rig, RIG_READBACK, (uint64_t)rig_pitch(width, 1) * height);
  return f;
}

void rig_forward_free(rig_forward *f) {
  rig_buffer_free(f->rig, &f->constants);
  rig_buffer_free(f->rig, &f->copy);
  ID3D12PipelineState_Release(f->state);
  ID3D12RootSignature_Release(f->signature);
  ID3D12DescriptorHeap_Release(f->heap);
  ID3D12DescriptorHeap_Release(f->target_heap);
  ID3D12Resource_Release(f->target);
  free(f);
}

/* ---- a picture ---- */

static D3D12_CPU_DESCRIPTOR_HANDLE descriptor(const rig_forward *f, uint32_t index) {
  D3D12_CPU_DESCRIPTOR_HANDLE handle = ID3D12DescriptorHeap_GetCPUDescriptorHandleForHeapStart(f->heap);
  handle.ptr += (SIZE_T)index *
                ID3D12Device_GetDescriptorHandleIncrementSize(f->rig->device, D3D12_DESCRIPTOR_HEAP_TYPE_CBV_SRV_UAV);
  return handle;
}

static void describe_maps(const rig_forward *f, uint32_t index, const csm_binding *binding) {
  const D3D12_SHADER_RESOURCE_VIEW_DESC view = {
      .Format = DXGI_FORMAT_R32_FLOAT,
      .ViewDimension = D3D12_SRV_DIMENSION_TEXTURE2DARRAY,
      .Shader4ComponentMapping = D3D12_DEFAULT_SHADER_4_COMPONENT_MAPPING,
      .Texture2DArray = {.MipLevels = 1, .ArraySize = binding->cascade_count}};
  ID3D12Device_CreateShaderResourceView(f->rig->device, (ID3D12Resource *)(uintptr_t)binding->native_maps, &view,
                                        descriptor(f, index));
}

static void describe_rows(const rig_forward *f, uint32_t index, uint64_t buffer, uint64_t size) {
  const D3D12_SHADER_RESOURCE_VIEW_DESC view = {
      .Format = DXGI_FORMAT_UNKNOWN,
      .ViewDimension = D3D12_SRV_DIMENSION_BUFFER,
      .Shader4ComponentMapping = D3D12_DEFAULT_SHADER_4_COMPONENT_MAPPING,
      .Buffer = {.NumElements = (UINT)(size / 16), .StructureByteStride = 16}};
  ID3D12Device_CreateShaderResourceView(f->rig->device, (ID3D12Resource *)(uintptr_t)buffer, &view,
                                        descriptor(f, index));
}

static void write_inputs(const rig_forward *f, const csm_binding *binding, const float plane[FORWARD_PLANE]) {
  char *constants = f->constants.mapped;
  memcpy(constants, binding->cascade_constants, binding->cascade_constants_size);
  memcpy(constants + 16 * CSM_S_BEGIN, binding->setting_constants, binding->setting_constants_size);
  memcpy(constants + AT_PLANE, plane, FORWARD_PLANE * sizeof *plane);
  describe_maps(f, MAPS, binding);
  describe_maps(f, MOMENTS, binding); /* not read */
  describe_rows(f, MESHES, binding->native_ray_meshes, binding->ray_meshes_size);
  describe_rows(f, INSTANCES, binding->native_ray_instances, binding->ray_instances_size);
}

void rig_forward_draw(rig_forward *f, const csm_binding *binding, const float plane[FORWARD_PLANE]) {
  ID3D12GraphicsCommandList *list = rig_commands(f->rig);
  const D3D12_CPU_DESCRIPTOR_HANDLE target = ID3D12DescriptorHeap_GetCPUDescriptorHandleForHeapStart(f->target_heap);
  const D3D12_GPU_VIRTUAL_ADDRESS constants =
      ID3D12Resource_GetGPUVirtualAddress((ID3D12Resource *)f->constants.object);
  const D3D12_VIEWPORT viewport = {.Width = (float)f->width, .Height = (float)f->height, .MaxDepth = 1};
  const D3D12_RECT scissor = {.right = (LONG)f->width, .bottom = (LONG)f->height};
  const D3D12_RESOURCE_STATES readable =
      D3D12_RESOURCE_STATE_PIXEL_SHADER_RESOURCE | D3D12_RESOURCE_STATE_NON_PIXEL_SHADER_RESOURCE;
  write_inputs(f, binding, plane);
  rig_d3d12_barrier(list, f->target, D3D12_RESOURCE_STATE_PIXEL_SHADER_RESOURCE, D3D12_RESOURCE_STATE_RENDER_TARGET);
  ID3D12GraphicsCommandList_OMSetRenderTargets(list, 1, &target, FALSE, NULL);
  ID3D12GraphicsCommandList_RSSetViewports(list, 1, &viewport);
  ID3D12GraphicsCommandList_RSSetScissorRects(list, 1, &scissor);
  ID3D12GraphicsCommandList_SetDescriptorHeaps(list, 1, &f->heap);
  ID3D12GraphicsCommandList_SetGraphicsRootSignature(list, f->signature);
  ID3D12GraphicsCommandList_SetPipelineState(list, f->state);
  ID3D12GraphicsCommandList_SetGraphicsRootConstantBufferView(list, 0, constants);
  ID3D12GraphicsCommandList_SetGraphicsRootConstantBufferView(list, 1, constants + AT_PLANE);
  ID3D12GraphicsCommandList_SetGraphicsRootDescriptorTable(
      list, 2, ID3D12DescriptorHeap_GetGPUDescriptorHandleForHeapStart(f->heap));
  ID3D12GraphicsCommandList_IASetPrimitiveTopology(list, D3D_PRIMITIVE_TOPOLOGY_TRIANGLELIST);
  ID3D12GraphicsCommandList_DrawInstanced(list, 3, 1, 0, 0);
  rig_d3d12_barrier(list, f->target, D3D12_RESOURCE_STATE_RENDER_TARGET, readable);
  rig_copy(f->rig, &(rig_layer){(uintptr_t)f->target, 0, f->width, f->height, 1}, &f->copy, 0);
  rig_d3d12_barrier(list, f->target, readable, D3D12_RESOURCE_STATE_PIXEL_SHADER_RESOURCE);
}

const unsigned char *rig_forward_picture(const rig_forward *f) {
  return f->copy.mapped;
}
