/* pipeline.c: the pipelines of programs that draw and of programs that compute. */
#include "internal.h"

static void describe_vertices(const gpu_program_info *info, D3D12_INPUT_ELEMENT_DESC *elements) {
  for (uint32_t i = 0; i < info->attribute_count; i++) {
    const gpu_attribute *attribute = &info->attributes[i];
    const bool per_instance = info->streams[attribute->stream].per_instance;
    elements[i] = (D3D12_INPUT_ELEMENT_DESC){
        .SemanticName = "ATTRIBUTE",
        .SemanticIndex = i,
        .Format = d3d12_format(attribute->format),
        .InputSlot = attribute->stream,
        .AlignedByteOffset = attribute->offset,
        .InputSlotClass =
            per_instance ? D3D12_INPUT_CLASSIFICATION_PER_INSTANCE_DATA : D3D12_INPUT_CLASSIFICATION_PER_VERTEX_DATA,
        .InstanceDataStepRate = per_instance ? 1 : 0,
    };
  }
}

static D3D12_RASTERIZER_DESC raster_of(const gpu_program_info *info) {
  static const D3D12_CULL_MODE culls[] = {[GPU_CULL_NONE] = D3D12_CULL_MODE_NONE,
                                          [GPU_CULL_BACK] = D3D12_CULL_MODE_BACK,
                                          [GPU_CULL_FRONT] = D3D12_CULL_MODE_FRONT};
  return (D3D12_RASTERIZER_DESC){.FillMode = D3D12_FILL_MODE_SOLID,
                                 .CullMode = culls[info->cull],
                                 .FrontCounterClockwise = TRUE,
                                 .DepthBias = info->raster_bias.constant,
                                 .DepthBiasClamp = info->raster_bias.clamp,
                                 .SlopeScaledDepthBias = info->raster_bias.slope,
                                 .DepthClipEnable = info->depth_clip};
}

static D3D12_DEPTH_STENCIL_DESC depth_of(const gpu_program_info *info) {
  static const D3D12_COMPARISON_FUNC compares[] = {
      [GPU_COMPARE_NONE] = D3D12_COMPARISON_FUNC_ALWAYS,
      [GPU_COMPARE_LESS] = D3D12_COMPARISON_FUNC_LESS,
      [GPU_COMPARE_GREATER] = D3D12_COMPARISON_FUNC_GREATER,
      [GPU_COMPARE_ALWAYS] = D3D12_COMPARISON_FUNC_ALWAYS,
  };
  const D3D12_DEPTH_STENCILOP_DESC keep = {.StencilFailOp = D3D12_STENCIL_OP_KEEP,
                                           .StencilDepthFailOp = D3D12_STENCIL_OP_KEEP,
                                           .StencilPassOp = D3D12_STENCIL_OP_KEEP,
                                           .StencilFunc = D3D12_COMPARISON_FUNC_ALWAYS};
  const bool enabled = info->depth_compare != GPU_COMPARE_NONE;
  return (D3D12_DEPTH_STENCIL_DESC){.DepthEnable = enabled,
                                    .DepthWriteMask =
                                        enabled ? D3D12_DEPTH_WRITE_MASK_ALL : D3D12_DEPTH_WRITE_MASK_ZERO,
                                    .DepthFunc = compares[info->depth_compare],
                                    .FrontFace = keep,
                                    .BackFace = keep};
}

static csm_result drawing_create(gpu_device *device, gpu_program *program, const gpu_program_info *info) {
  D3D12_INPUT_ELEMENT_DESC elements[GPU_MAX_ATTRIBUTES];
  describe_vertices(info, elements);
  const D3D12_GRAPHICS_PIPELINE_STATE_DESC pipeline = {
      .pRootSignature = program->signature,
      .VS = {.pShaderBytecode = info->vertex.dxbc, .BytecodeLength = info->vertex.dxbc_size},
      .PS = {.pShaderBytecode = info->pixel.dxbc_size ? info->pixel.dxbc : NULL,
             .BytecodeLength = info->pixel.dxbc_size},
      .BlendState = {.RenderTarget = {{.SrcBlend = D3D12_BLEND_ONE,
                                       .DestBlend = D3D12_BLEND_ZERO,
                                       .BlendOp = D3D12_BLEND_OP_ADD,
                                       .SrcBlendAlpha = D3D12_BLEND_ONE,
                                       .DestBlendAlpha = D3D12_BLEND_ZERO,
                                       .BlendOpAlpha = D3D12_BLEND_OP_ADD,
                                       .LogicOp = D3D12_LOGIC_OP_NOOP,
                                       .RenderTargetWriteMask = D3D12_COLOR_WRITE_ENABLE_ALL}}},
      .SampleMask = ~0u,
      .RasterizerState = raster_of(info),
      .DepthStencilState = depth_of(info),
      .InputLayout = {.pInputElementDescs = elements, .NumElements = info->attribute_count},
      .PrimitiveTopologyType = D3D12_PRIMITIVE_TOPOLOGY_TYPE_TRIANGLE,
      .NumRenderTargets = info->color_format != GPU_FORMAT_NONE,
      .RTVFormats = {d3d12_format(info->color_format)},
      .DSVFormat = d3d12_format(info->depth_format),
      .SampleDesc = {.Count = 1},
  };
  return d3d12_check(device,
                     ID3D12Device_CreateGraphicsPipelineState(device->handle, &pipeline, &IID_ID3D12PipelineState,
                                                              (void **)&program->pipeline),
                     "CreateGraphicsPipelineState");
}

static csm_result computing_create(gpu_device *device, gpu_program *program, const gpu_program_info *info) {
  const D3D12_COMPUTE_PIPELINE_STATE_DESC pipeline = {
      .pRootSignature = program->signature,
      .CS = {.pShaderBytecode = info->compute.dxbc, .BytecodeLength = info->compute.dxbc_size}};
  return d3d12_check(device,
                     ID3D12Device_CreateComputePipelineState(device->handle, &pipeline, &IID_ID3D12PipelineState,
                                                             (void **)&program->pipeline),
                     "CreateComputePipelineState");
}

csm_result d3d12_pipeline_create(gpu_device *device, gpu_program *program, const gpu_program_info *info) {
  const csm_result result =
      info->compute.dxbc_size ? computing_create(device, program, info) : drawing_create(device, program, info);
  if (result == CSM_SUCCESS)
    d3d12_name(program->pipeline, info->name);
  return result;
}
