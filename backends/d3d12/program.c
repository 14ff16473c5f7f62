/*
 * program.c: pipelines with their root signatures. Root parameters: a constant buffer each for b0 and on, then one
 * table with all else, as bindings.c lays it out. Samplers are static.
 */
#include "internal.h"

enum { TABLE_RANGES = 4 };

/* ---- indirect arguments ---- */

csm_result d3d12_commands_create(gpu_device *device) {
  static const struct {
    D3D12_INDIRECT_ARGUMENT_TYPE type;
    uint32_t size;
  } commands[D3D12_COMMANDS] = {
      [D3D12_DRAW] = {D3D12_INDIRECT_ARGUMENT_TYPE_DRAW, sizeof(gpu_indirect_draw)},
      [D3D12_DRAW_INDEXED] = {D3D12_INDIRECT_ARGUMENT_TYPE_DRAW_INDEXED, sizeof(gpu_indirect_indexed)},
      [D3D12_DISPATCH] = {D3D12_INDIRECT_ARGUMENT_TYPE_DISPATCH, sizeof(gpu_indirect_dispatch)},
  };
  csm_result result = CSM_SUCCESS;
  for (uint32_t i = 0; result == CSM_SUCCESS && i < D3D12_COMMANDS; i++) {
    const D3D12_INDIRECT_ARGUMENT_DESC argument = {.Type = commands[i].type};
    const D3D12_COMMAND_SIGNATURE_DESC signature = {
        .ByteStride = commands[i].size, .NumArgumentDescs = 1, .pArgumentDescs = &argument};
    result =
        d3d12_check(device,
                    ID3D12Device_CreateCommandSignature(device->handle, &signature, NULL, &IID_ID3D12CommandSignature,
                                                        (void **)&device->commands[i]),
                    "CreateCommandSignature");
  }
  return result;
}

/* ---- root signatures ---- */

static D3D12_STATIC_SAMPLER_DESC static_sampler(const gpu_device *device, gpu_sampler sampler,
                                                uint32_t shader_register) {
  static const D3D12_FILTER filters[GPU_SAMPLER_COUNT] = {
      [GPU_SAMPLER_POINT_CLAMP] = D3D12_FILTER_MIN_MAG_MIP_POINT,
      [GPU_SAMPLER_LINEAR_CLAMP] = D3D12_FILTER_MIN_MAG_LINEAR_MIP_POINT,
      [GPU_SAMPLER_TRILINEAR_CLAMP] = D3D12_FILTER_MIN_MAG_MIP_LINEAR,
      [GPU_SAMPLER_ANISOTROPIC_CLAMP] = D3D12_FILTER_ANISOTROPIC,
      [GPU_SAMPLER_COMPARE_LESS_EQUAL] = D3D12_FILTER_COMPARISON_MIN_MAG_LINEAR_MIP_POINT,
      [GPU_SAMPLER_COMPARE_GREATER_EQUAL] = D3D12_FILTER_COMPARISON_MIN_MAG_LINEAR_MIP_POINT,
  };
  const bool compare = sampler == GPU_SAMPLER_COMPARE_LESS_EQUAL || sampler == GPU_SAMPLER_COMPARE_GREATER_EQUAL;
  return (D3D12_STATIC_SAMPLER_DESC){
      .Filter = filters[sampler],
      .AddressU = D3D12_TEXTURE_ADDRESS_MODE_CLAMP,
      .AddressV = D3D12_TEXTURE_ADDRESS_MODE_CLAMP,
      .AddressW = D3D12_TEXTURE_ADDRESS_MODE_CLAMP,
      .MaxAnisotropy = sampler == GPU_SAMPLER_ANISOTROPIC_CLAMP ? device->info.can.max_anisotropy : 0,
      .ComparisonFunc = sampler == GPU_SAMPLER_COMPARE_GREATER_EQUAL ? D3D12_COMPARISON_FUNC_GREATER_EQUAL
                                                                     : D3D12_COMPARISON_FUNC_LESS_EQUAL,
      .MaxLOD = compare ? 0 : D3D12_FLOAT32_MAX,
      .ShaderRegister = shader_register,
      .ShaderVisibility = D3D12_SHADER_VISIBILITY_ALL,
  };
}

/* The ranges of the table that hold anything. */
static uint32_t table_ranges(const gpu_program_info *info, D3D12_DESCRIPTOR_RANGE *out) {
  const D3D12_DESCRIPTOR_RANGE ranges[] = {
      {.RangeType = D3D12_DESCRIPTOR_RANGE_TYPE_SRV,
       .NumDescriptors = info->texture_count,
       .OffsetInDescriptorsFromTableStart = D3D12_BLOCK_TEXTURES},
      {.RangeType = D3D12_DESCRIPTOR_RANGE_TYPE_SRV,
       .NumDescriptors = info->buffer_count,
       .BaseShaderRegister = GPU_FIRST_BUFFER,
       .OffsetInDescriptorsFromTableStart = D3D12_BLOCK_BUFFERS},
      {.RangeType = D3D12_DESCRIPTOR_RANGE_TYPE_UAV,
       .NumDescriptors = info->store_image_count,
       .OffsetInDescriptorsFromTableStart = D3D12_BLOCK_STORE_IMAGES},
      {.RangeType = D3D12_DESCRIPTOR_RANGE_TYPE_UAV,
       .NumDescriptors = info->store_buffer_count,
       .BaseShaderRegister = GPU_FIRST_STORE_BUFFER,
       .OffsetInDescriptorsFromTableStart = D3D12_BLOCK_STORE_BUFFERS},
  };
  uint32_t count = 0;
  for (uint32_t i = 0; i < TABLE_RANGES; i++)
    if (ranges[i].NumDescriptors)
      out[count++] = ranges[i];
  return count;
}

static HRESULT serialize(const gpu_device *device, const D3D12_ROOT_SIGNATURE_DESC *signature, ID3DBlob **out) {
  return device->own ? d3d12_runtime_serialize(device->runtime, signature, out)
                     : device->serialize(signature, D3D_ROOT_SIGNATURE_VERSION_1_0, out, NULL);
}

static csm_result signature_create(gpu_device *device, const gpu_program_info *info, gpu_program *program) {
  D3D12_ROOT_PARAMETER parameters[GPU_MAX_CONSTANTS + 1];
  D3D12_STATIC_SAMPLER_DESC samplers[GPU_MAX_SAMPLERS];
  D3D12_DESCRIPTOR_RANGE ranges[TABLE_RANGES];
  const uint32_t range_count = table_ranges(info, ranges);
  program->has_table = range_count > 0;
  uint32_t count = 0;
  for (; count < info->constants_count; count++)
    parameters[count] = (D3D12_ROOT_PARAMETER){.ParameterType = D3D12_ROOT_PARAMETER_TYPE_CBV,
                                               .Descriptor = {.ShaderRegister = count},
                                               .ShaderVisibility = D3D12_SHADER_VISIBILITY_ALL};
  if (range_count)
    parameters[count++] =
        (D3D12_ROOT_PARAMETER){.ParameterType = D3D12_ROOT_PARAMETER_TYPE_DESCRIPTOR_TABLE,
                               .DescriptorTable = {.NumDescriptorRanges = range_count, .pDescriptorRanges = ranges},
                               .ShaderVisibility = D3D12_SHADER_VISIBILITY_ALL};
  for (uint32_t i = 0; i < info->sampler_count; i++)
    samplers[i] = static_sampler(device, info->samplers[i], i);
  const D3D12_ROOT_SIGNATURE_DESC signature = {
      .NumParameters = count,
      .pParameters = parameters,
      .NumStaticSamplers = info->sampler_count,
      .pStaticSamplers = samplers,
      .Flags = info->compute.dxbc_size ? D3D12_ROOT_SIGNATURE_FLAG_NONE
                                       : D3D12_ROOT_SIGNATURE_FLAG_ALLOW_INPUT_ASSEMBLER_INPUT_LAYOUT};
  ID3DBlob *blob = NULL;
  HRESULT hr = serialize(device, &signature, &blob);
  if (FAILED(hr))
    return d3d12_check(device, hr, "D3D12SerializeRootSignature");
  hr = ID3D12Device_CreateRootSignature(device->handle, 0, ID3D10Blob_GetBufferPointer(blob),
                                        ID3D10Blob_GetBufferSize(blob), &IID_ID3D12RootSignature,
                                        (void **)&program->signature);
  ID3D10Blob_Release(blob);
  return d3d12_check(device, hr, "CreateRootSignature");
}

/* ---- pipelines ---- */

static void fill_input(const gpu_program_info *info, D3D12_INPUT_ELEMENT_DESC *elements) {
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

static D3D12_CULL_MODE cull_mode(gpu_cull cull) {
  switch (cull) {
  case GPU_CULL_BACK:
    return D3D12_CULL_MODE_BACK;
  case GPU_CULL_FRONT:
    return D3D12_CULL_MODE_FRONT;
  case GPU_CULL_NONE:
    break;
  }
  return D3D12_CULL_MODE_NONE;
}

static D3D12_RASTERIZER_DESC rasterizer_state(const gpu_program_info *info) {
  return (D3D12_RASTERIZER_DESC){.FillMode = D3D12_FILL_MODE_SOLID,
                                 .CullMode = cull_mode(info->cull),
                                 .FrontCounterClockwise = TRUE,
                                 .DepthBias = info->raster_bias.constant,
                                 .DepthBiasClamp = info->raster_bias.clamp,
                                 .SlopeScaledDepthBias = info->raster_bias.slope,
                                 .DepthClipEnable = info->depth_clip};
}

static D3D12_DEPTH_STENCIL_DESC depth_state(gpu_compare compare) {
  static const D3D12_COMPARISON_FUNC functions[] = {
      [GPU_COMPARE_NONE] = D3D12_COMPARISON_FUNC_ALWAYS,
      [GPU_COMPARE_LESS] = D3D12_COMPARISON_FUNC_LESS,
      [GPU_COMPARE_GREATER] = D3D12_COMPARISON_FUNC_GREATER,
      [GPU_COMPARE_ALWAYS] = D3D12_COMPARISON_FUNC_ALWAYS,
  };
  const D3D12_DEPTH_STENCILOP_DESC keep = {.StencilFailOp = D3D12_STENCIL_OP_KEEP,
                                           .StencilDepthFailOp = D3D12_STENCIL_OP_KEEP,
                                           .StencilPassOp = D3D12_STENCIL_OP_KEEP,
                                           .StencilFunc = D3D12_COMPARISON_FUNC_ALWAYS};
  const bool enabled = compare != GPU_COMPARE_NONE;
  return (D3D12_DEPTH_STENCIL_DESC){.DepthEnable = enabled,
                                    .DepthWriteMask =
                                        enabled ? D3D12_DEPTH_WRITE_MASK_ALL : D3D12_DEPTH_WRITE_MASK_ZERO,
                                    .DepthFunc = functions[compare],
                                    .FrontFace = keep,
                                    .BackFace = keep};
}

static csm_result graphics_create(gpu_device *device, const gpu_program_info *info, gpu_program *program) {
  D3D12_INPUT_ELEMENT_DESC elements[GPU_MAX_ATTRIBUTES];
  fill_input(info, elements);
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
      .RasterizerState = rasterizer_state(info),
      .DepthStencilState = depth_state(info->depth_compare),
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

static csm_result compute_create(gpu_device *device, const gpu_program_info *info, gpu_program *program) {
  const D3D12_COMPUTE_PIPELINE_STATE_DESC pipeline = {
      .pRootSignature = program->signature,
      .CS = {.pShaderBytecode = info->compute.dxbc, .BytecodeLength = info->compute.dxbc_size}};
  return d3d12_check(device,
                     ID3D12Device_CreateComputePipelineState(device->handle, &pipeline, &IID_ID3D12PipelineState,
                                                             (void **)&program->pipeline),
                     "CreateComputePipelineState");
}

/* ---- programs ---- */

/* Feature level 11_0 brings all that programs may ask for but anisotropy, which vkd3d takes from the device. */
static const char *program_lacks(const gpu_device *device, const gpu_program_info *info) {
  for (uint32_t i = 0; i < info->sampler_count; i++)
    if (info->samplers[i] == GPU_SAMPLER_ANISOTROPIC_CLAMP && device->info.can.max_anisotropy < 2)
      return "anisotropic samplers";
  return NULL;
}

csm_result d3d12_program_create(gpu_device *device, const gpu_program_info *info, gpu_program **out) {
  *out = NULL;
  const char *lacks = program_lacks(device, info);
  if (lacks)
    return d3d12_fail(device, CSM_ERROR_UNSUPPORTED, "%s: the device has no %s", info->name, lacks);
  gpu_program *program = d3d12_allocate(device, sizeof *program);
  if (!program)
    return CSM_ERROR_OUT_OF_MEMORY;
  program->constants_count = info->constants_count;
  program->texture_count = info->texture_count;
  program->buffer_count = info->buffer_count;
  program->store_image_count = info->store_image_count;
  program->store_buffer_count = info->store_buffer_count;
  program->stream_count = info->stream_count;
  for (uint32_t i = 0; i < info->stream_count; i++)
    program->strides[i] = info->streams[i].stride;
  csm_result result = signature_create(device, info, program);
  if (result == CSM_SUCCESS)
    result = info->compute.dxbc_size ? compute_create(device, info, program) : graphics_create(device, info, program);
  if (result != CSM_SUCCESS) {
    d3d12_program_destroy(device, program);
    return result;
  }
  d3d12_name(program->pipeline, info->name);
  *out = program;
  return CSM_SUCCESS;
}

void d3d12_program_destroy(gpu_device *device, gpu_program *program) {
  if (!program)
    return;
  d3d12_unref(program->pipeline);
  d3d12_unref(program->signature);
  d3d12_release(device, program);
}
