/* program.c: pipelines with their root signatures, and what they read. Root parameters: a constant buffer each for b0
   and on, then one table with t0 and on; samplers are static. */
#include "internal.h"

static D3D12_STATIC_SAMPLER_DESC static_sampler(gpu_sampler sampler, uint32_t shader_register) {
  static const D3D12_FILTER filters[] = {
      [GPU_SAMPLER_POINT_CLAMP] = D3D12_FILTER_MIN_MAG_MIP_POINT,
      [GPU_SAMPLER_LINEAR_CLAMP] = D3D12_FILTER_MIN_MAG_LINEAR_MIP_POINT,
      [GPU_SAMPLER_COMPARE_LESS_EQUAL] = D3D12_FILTER_COMPARISON_MIN_MAG_LINEAR_MIP_POINT,
      [GPU_SAMPLER_COMPARE_GREATER_EQUAL] = D3D12_FILTER_COMPARISON_MIN_MAG_LINEAR_MIP_POINT,
  };
  return (D3D12_STATIC_SAMPLER_DESC){
      .Filter = filters[sampler],
      .AddressU = D3D12_TEXTURE_ADDRESS_MODE_CLAMP,
      .AddressV = D3D12_TEXTURE_ADDRESS_MODE_CLAMP,
      .AddressW = D3D12_TEXTURE_ADDRESS_MODE_CLAMP,
      .ComparisonFunc = sampler == GPU_SAMPLER_COMPARE_GREATER_EQUAL ? D3D12_COMPARISON_FUNC_GREATER_EQUAL
                                                                     : D3D12_COMPARISON_FUNC_LESS_EQUAL,
      .MaxLOD = D3D12_FLOAT32_MAX,
      .ShaderRegister = shader_register,
      .ShaderVisibility = D3D12_SHADER_VISIBILITY_ALL,
  };
}

static HRESULT serialize(const gpu_device *device, const D3D12_ROOT_SIGNATURE_DESC *signature, ID3DBlob **out) {
  return device->own ? d3d12_runtime_serialize(device->runtime, signature, out)
                     : device->serialize(signature, D3D_ROOT_SIGNATURE_VERSION_1_0, out, NULL);
}

static HRESULT create_signature(gpu_device *device, const gpu_program_info *info, ID3D12RootSignature **out) {
  D3D12_ROOT_PARAMETER parameters[GPU_MAX_CONSTANTS + 1];
  D3D12_STATIC_SAMPLER_DESC samplers[GPU_MAX_SAMPLERS];
  const D3D12_DESCRIPTOR_RANGE textures = {
      .RangeType = D3D12_DESCRIPTOR_RANGE_TYPE_SRV,
      .NumDescriptors = info->texture_count,
  };
  uint32_t count = 0;
  for (; count < info->constants_count; ++count)
    parameters[count] = (D3D12_ROOT_PARAMETER){
        .ParameterType = D3D12_ROOT_PARAMETER_TYPE_CBV,
        .Descriptor = {.ShaderRegister = count},
        .ShaderVisibility = D3D12_SHADER_VISIBILITY_ALL,
    };
  if (info->texture_count)
    parameters[count++] = (D3D12_ROOT_PARAMETER){
        .ParameterType = D3D12_ROOT_PARAMETER_TYPE_DESCRIPTOR_TABLE,
        .DescriptorTable = {.NumDescriptorRanges = 1, .pDescriptorRanges = &textures},
        .ShaderVisibility = D3D12_SHADER_VISIBILITY_ALL,
    };
  for (uint32_t i = 0; i < info->sampler_count; ++i)
    samplers[i] = static_sampler(info->samplers[i], i);
  const D3D12_ROOT_SIGNATURE_DESC signature = {
      .NumParameters = count,
      .pParameters = parameters,
      .NumStaticSamplers = info->sampler_count,
      .pStaticSamplers = samplers,
      .Flags = D3D12_ROOT_SIGNATURE_FLAG_ALLOW_INPUT_ASSEMBLER_INPUT_LAYOUT,
  };
  ID3DBlob *blob = NULL;
  HRESULT hr = serialize(device, &signature, &blob);
  if (FAILED(hr))
    return hr;
  hr = ID3D12Device_CreateRootSignature(device->handle, 0, ID3D10Blob_GetBufferPointer(blob),
                                        ID3D10Blob_GetBufferSize(blob), &IID_ID3D12RootSignature, (void **)out);
  ID3D10Blob_Release(blob);
  return hr;
}

static void fill_input(const gpu_program_info *info, D3D12_INPUT_ELEMENT_DESC *elements) {
  for (uint32_t i = 0; i < info->attribute_count; ++i) {
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

static HRESULT create_pipeline(gpu_device *device, const gpu_program_info *info, ID3D12RootSignature *signature,
                               ID3D12PipelineState **out) {
  D3D12_INPUT_ELEMENT_DESC elements[GPU_MAX_ATTRIBUTES];
  fill_input(info, elements);
  const bool test = info->depth_compare != GPU_COMPARE_NONE;
  const bool color = info->color_format != GPU_FORMAT_NONE;
  const D3D12_DEPTH_STENCILOP_DESC keep = {
      .StencilFailOp = D3D12_STENCIL_OP_KEEP,
      .StencilDepthFailOp = D3D12_STENCIL_OP_KEEP,
      .StencilPassOp = D3D12_STENCIL_OP_KEEP,
      .StencilFunc = D3D12_COMPARISON_FUNC_ALWAYS,
  };
  const D3D12_GRAPHICS_PIPELINE_STATE_DESC pipeline = {
      .pRootSignature = signature,
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
      .RasterizerState = {.FillMode = D3D12_FILL_MODE_SOLID,
                          .CullMode = cull_mode(info->cull),
                          .FrontCounterClockwise = TRUE,
                          .DepthBias = info->raster_bias.constant,
                          .DepthBiasClamp = info->raster_bias.clamp,
                          .SlopeScaledDepthBias = info->raster_bias.slope,
                          .DepthClipEnable = info->depth_clip},
      .DepthStencilState = {.DepthEnable = test,
                            .DepthWriteMask = test ? D3D12_DEPTH_WRITE_MASK_ALL : D3D12_DEPTH_WRITE_MASK_ZERO,
                            .DepthFunc = info->depth_compare == GPU_COMPARE_GREATER ? D3D12_COMPARISON_FUNC_GREATER
                                                                                    : D3D12_COMPARISON_FUNC_LESS,
                            .FrontFace = keep,
                            .BackFace = keep},
      .InputLayout = {.pInputElementDescs = elements, .NumElements = info->attribute_count},
      .PrimitiveTopologyType = D3D12_PRIMITIVE_TOPOLOGY_TYPE_TRIANGLE,
      .NumRenderTargets = color ? 1 : 0,
      .RTVFormats = {d3d12_format(info->color_format)},
      .DSVFormat = d3d12_format(info->depth_format),
      .SampleDesc = {.Count = 1},
  };
  return ID3D12Device_CreateGraphicsPipelineState(device->handle, &pipeline, &IID_ID3D12PipelineState, (void **)out);
}

csm_result d3d12_program_create(gpu_device *device, const gpu_program_info *info, gpu_program **out) {
  *out = NULL;
  gpu_program *program = d3d12_allocate(device, sizeof *program);
  if (!program)
    return CSM_ERROR_OUT_OF_MEMORY;
  program->constants_count = info->constants_count;
  program->texture_count = info->texture_count;
  program->stream_count = info->stream_count;
  for (uint32_t i = 0; i < info->stream_count; ++i)
    program->strides[i] = info->streams[i].stride;
  HRESULT hr = create_signature(device, info, &program->signature);
  if (SUCCEEDED(hr))
    hr = create_pipeline(device, info, program->signature, &program->pipeline);
  if (FAILED(hr)) {
    d3d12_program_destroy(device, program);
    return d3d12_check(device, hr, "making a program");
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

/* ---- bindings ---- */

csm_result d3d12_descriptors_create(gpu_device *device) {
  const D3D12_DESCRIPTOR_HEAP_DESC heap = {.Type = D3D12_DESCRIPTOR_HEAP_TYPE_CBV_SRV_UAV,
                                           .NumDescriptors = D3D12_BINDING_BLOCKS * GPU_MAX_TEXTURES,
                                           .Flags = D3D12_DESCRIPTOR_HEAP_FLAG_SHADER_VISIBLE};
  device->descriptor_size =
      ID3D12Device_GetDescriptorHandleIncrementSize(device->handle, D3D12_DESCRIPTOR_HEAP_TYPE_CBV_SRV_UAV);
  device->free_block_count = D3D12_BINDING_BLOCKS;
  for (uint32_t i = 0; i < D3D12_BINDING_BLOCKS; i++)
    device->free_blocks[i] = (uint16_t)(D3D12_BINDING_BLOCKS - 1 - i);
  return d3d12_check(device,
                     ID3D12Device_CreateDescriptorHeap(device->handle, &heap, &IID_ID3D12DescriptorHeap,
                                                       (void **)&device->descriptors),
                     "CreateDescriptorHeap");
}

void d3d12_bindings_write(gpu_device *device, gpu_bindings *bindings, const gpu_bindings_info *info) {
  for (uint32_t i = 0; i < bindings->constants_count; ++i)
    bindings->constants[i] = info->constants[i]->address;
  if (!bindings->has_textures)
    return;
  const D3D12_CPU_DESCRIPTOR_HANDLE start =
      ID3D12DescriptorHeap_GetCPUDescriptorHandleForHeapStart(device->descriptors);
  for (uint32_t i = 0; i < info->program->texture_count; ++i)
    d3d12_image_describe(device, info->textures[i],
                         start.ptr + ((size_t)bindings->block * GPU_MAX_TEXTURES + i) * device->descriptor_size);
}

csm_result d3d12_bindings_create(gpu_device *device, const gpu_bindings_info *info, gpu_bindings **out) {
  *out = NULL;
  const uint32_t texture_count = info->program->texture_count;
  if (texture_count && device->free_block_count == 0)
    return CSM_ERROR_OUT_OF_DEVICE_MEMORY;
  gpu_bindings *bindings = d3d12_allocate(device, sizeof *bindings);
  if (!bindings)
    return CSM_ERROR_OUT_OF_MEMORY;
  bindings->constants_count = info->program->constants_count;
  if (texture_count) {
    bindings->has_textures = true;
    bindings->block = device->free_blocks[--device->free_block_count];
    bindings->textures = ID3D12DescriptorHeap_GetGPUDescriptorHandleForHeapStart(device->descriptors);
    bindings->textures.ptr += (UINT64)bindings->block * GPU_MAX_TEXTURES * device->descriptor_size;
  }
  d3d12_bindings_write(device, bindings, info);
  *out = bindings;
  return CSM_SUCCESS;
}

void d3d12_bindings_destroy(gpu_device *device, gpu_bindings *bindings) {
  if (!bindings)
    return;
  if (bindings->has_textures)
    device->free_blocks[device->free_block_count++] = (uint16_t)bindings->block;
  d3d12_release(device, bindings);
}
