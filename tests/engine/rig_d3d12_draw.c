/* rig_d3d12_draw.c: casters that a Direct3D 12 engine draws by itself. */
#include "rig_d3d12.h"

#include "engine_code.h"

#include <stdlib.h>
#include <string.h>

enum { FIRST_FREE_STREAM = 3 /* csm's own recordings change those before it */ };

/* ---- pipelines ---- */

static ID3D12RootSignature *make_signature(rig *rig, uint32_t textures) {
  const D3D12_DESCRIPTOR_RANGE range = {.RangeType = D3D12_DESCRIPTOR_RANGE_TYPE_SRV, .NumDescriptors = textures};
  const D3D12_ROOT_PARAMETER parameter = {.ParameterType = D3D12_ROOT_PARAMETER_TYPE_DESCRIPTOR_TABLE,
                                          .DescriptorTable = {.NumDescriptorRanges = 1, .pDescriptorRanges = &range}};
  const D3D12_ROOT_SIGNATURE_DESC description = {.NumParameters = textures ? 1 : 0,
                                                 .pParameters = &parameter,
                                                 .Flags = D3D12_ROOT_SIGNATURE_FLAG_ALLOW_INPUT_ASSEMBLER_INPUT_LAYOUT};
  ID3DBlob *blob = NULL;
  ID3D12RootSignature *signature;
  rig_d3d12_must(D3D12SerializeRootSignature(&description, D3D_ROOT_SIGNATURE_VERSION_1_0, &blob, NULL),
                 "serialising a root signature");
  rig_d3d12_must(ID3D12Device_CreateRootSignature(rig->device, 0, ID3D10Blob_GetBufferPointer(blob),
                                                  ID3D10Blob_GetBufferSize(blob), &IID_ID3D12RootSignature,
                                                  (void **)&signature),
                 "a root signature");
  ID3D10Blob_Release(blob);
  return signature;
}

rig_d3d12_pipeline rig_d3d12_pipeline_make(rig *rig, uint32_t textures, D3D12_GRAPHICS_PIPELINE_STATE_DESC *info) {
  rig_d3d12_pipeline out = {.signature = make_signature(rig, textures)};
  info->pRootSignature = out.signature;
  info->SampleMask = ~0u;
  info->RasterizerState.FillMode = D3D12_FILL_MODE_SOLID;
  info->RasterizerState.CullMode = D3D12_CULL_MODE_NONE;
  info->PrimitiveTopologyType = D3D12_PRIMITIVE_TOPOLOGY_TYPE_TRIANGLE;
  info->SampleDesc.Count = 1;
  rig_d3d12_must(
      ID3D12Device_CreateGraphicsPipelineState(rig->device, info, &IID_ID3D12PipelineState, (void **)&out.state),
      "a pipeline");
  return out;
}

void rig_d3d12_pipeline_free(rig_d3d12_pipeline *pipeline) {
  ID3D12PipelineState_Release(pipeline->state);
  ID3D12RootSignature_Release(pipeline->signature);
}

/* ---- the caster ---- */

struct rig_caster {
  rig *rig;
  rig_d3d12_pipeline pipeline;
  rig_buffer vertices, indices, rows;
  uint32_t index_count;
  ID3D12DescriptorHeap *heap; /* of the engine's own, to be set in between */
};

enum { ROWS_OF_CASCADE = RIG_CASTER_INSTANCES * RIG_ROWS * sizeof(float) };

static rig_d3d12_pipeline make_pipeline(rig *rig, const csm_draw_target *target) {
  static const D3D12_INPUT_ELEMENT_DESC elements[] = {
      {"ATTRIBUTE", 0, DXGI_FORMAT_R32G32B32_FLOAT, 0, 0, D3D12_INPUT_CLASSIFICATION_PER_VERTEX_DATA, 0},
      {"ATTRIBUTE", 1, DXGI_FORMAT_R32G32B32A32_FLOAT, FIRST_FREE_STREAM, 0,
       D3D12_INPUT_CLASSIFICATION_PER_INSTANCE_DATA, 1},
      {"ATTRIBUTE", 2, DXGI_FORMAT_R32G32B32A32_FLOAT, FIRST_FREE_STREAM, 16,
       D3D12_INPUT_CLASSIFICATION_PER_INSTANCE_DATA, 1},
      {"ATTRIBUTE", 3, DXGI_FORMAT_R32G32B32A32_FLOAT, FIRST_FREE_STREAM, 32,
       D3D12_INPUT_CLASSIFICATION_PER_INSTANCE_DATA, 1},
  };
  D3D12_GRAPHICS_PIPELINE_STATE_DESC info = {
      .VS = {shader_caster_vs.dxbc, shader_caster_vs.dxbc_size},
      .DepthStencilState = {.DepthEnable = TRUE,
                            .DepthWriteMask = D3D12_DEPTH_WRITE_MASK_ALL,
                            .DepthFunc = target->reversed ? D3D12_COMPARISON_FUNC_GREATER : D3D12_COMPARISON_FUNC_LESS},
      .InputLayout = {elements, sizeof elements / sizeof *elements},
      .DSVFormat = target->depth_format,
  };
  return rig_d3d12_pipeline_make(rig, 0, &info);
}

rig_caster *rig_caster_make(rig *rig, const rig_caster_info *info) {
  const D3D12_DESCRIPTOR_HEAP_DESC heap = {.Type = D3D12_DESCRIPTOR_HEAP_TYPE_CBV_SRV_UAV,
                                           .NumDescriptors = 4,
                                           .Flags = D3D12_DESCRIPTOR_HEAP_FLAG_SHADER_VISIBLE};
  rig_caster *caster = calloc(1, sizeof *caster);
  assert_non_null(caster);
  *caster = (rig_caster){.rig = rig, .index_count = info->index_count, .pipeline = make_pipeline(rig, &info->target)};
  caster->vertices = rig_buffer_make(rig, RIG_GEOMETRY, info->vertex_count * sizeof *info->positions);
  caster->indices = rig_buffer_make(rig, RIG_GEOMETRY, info->index_count * sizeof *info->indices);
  caster->rows = rig_buffer_make(rig, RIG_GEOMETRY, CSM_MAX_CASCADES * ROWS_OF_CASCADE);
  memcpy(caster->vertices.mapped, info->positions, info->vertex_count * sizeof *info->positions);
  memcpy(caster->indices.mapped, info->indices, info->index_count * sizeof *info->indices);
  rig_d3d12_must(
      ID3D12Device_CreateDescriptorHeap(rig->device, &heap, &IID_ID3D12DescriptorHeap, (void **)&caster->heap),
      "a heap");
  return caster;
}

void rig_caster_free(rig_caster *caster) {
  rig_d3d12_pipeline_free(&caster->pipeline);
  ID3D12DescriptorHeap_Release(caster->heap);
  rig_buffer_free(caster->rig, &caster->vertices);
  rig_buffer_free(caster->rig, &caster->indices);
  rig_buffer_free(caster->rig, &caster->rows);
  free(caster);
}

static D3D12_GPU_VIRTUAL_ADDRESS address(const rig_buffer *buffer) {
  return ID3D12Resource_GetGPUVirtualAddress((ID3D12Resource *)buffer->object);
}

void rig_caster_draw(rig_caster *caster, const csm_draw_info *info, const float (*rows)[RIG_ROWS], uint32_t count) {
  ID3D12GraphicsCommandList *list = info->command_buffer;
  const D3D12_CPU_DESCRIPTOR_HANDLE depth = {.ptr = (SIZE_T)info->depth_view};
  const size_t offset = info->cascade * (size_t)ROWS_OF_CASCADE;
  memcpy((char *)caster->rows.mapped + offset, rows, count * sizeof *rows);
  const D3D12_VERTEX_BUFFER_VIEW vertices = {address(&caster->vertices), (UINT)caster->vertices.size, 12};
  const D3D12_VERTEX_BUFFER_VIEW instances = {address(&caster->rows) + offset, ROWS_OF_CASCADE,
                                              RIG_ROWS * sizeof(float)};
  const D3D12_INDEX_BUFFER_VIEW indices = {address(&caster->indices), (UINT)caster->indices.size, DXGI_FORMAT_R16_UINT};
  ID3D12GraphicsCommandList_SetDescriptorHeaps(list, 1, &caster->heap);
  ID3D12GraphicsCommandList_OMSetRenderTargets(list, 0, NULL, FALSE, &depth);
  ID3D12GraphicsCommandList_SetGraphicsRootSignature(list, caster->pipeline.signature);
  ID3D12GraphicsCommandList_SetPipelineState(list, caster->pipeline.state);
  ID3D12GraphicsCommandList_IASetPrimitiveTopology(list, D3D_PRIMITIVE_TOPOLOGY_TRIANGLELIST);
  ID3D12GraphicsCommandList_IASetVertexBuffers(list, 0, 1, &vertices);
  ID3D12GraphicsCommandList_IASetVertexBuffers(list, FIRST_FREE_STREAM, 1, &instances);
  ID3D12GraphicsCommandList_IASetIndexBuffer(list, &indices);
  ID3D12GraphicsCommandList_DrawIndexedInstanced(list, caster->index_count, count, 0, 0, 0);
  /* What it may change, csm sets again. */
  ID3D12GraphicsCommandList_RSSetViewports(list, 1, &(D3D12_VIEWPORT){.Width = 1, .Height = 1, .MaxDepth = 0.5f});
  ID3D12GraphicsCommandList_RSSetScissorRects(list, 1, &(D3D12_RECT){.right = 1, .bottom = 1});
}

void rig_check_target(const rig *rig, const csm_draw_target *target, uint32_t map_format) {
  (void)rig;
  assert_int_equal(target->depth_format, map_format == CSM_MAP_D16 ? DXGI_FORMAT_D16_UNORM : DXGI_FORMAT_D32_FLOAT);
  assert_true(target->render_pass == 0 && target->dynamic_rendering == 0);
}

void rig_check_draw(const rig *rig, const csm_draw_info *info) {
  (void)rig;
  assert_true(info->depth_view != 0);
}
