/* program.c: programs, and what is made once for all of them. */
#include "internal.h"

/* ---- samplers ---- */

D3D12_STATIC_SAMPLER_DESC d3d12_sampler(const gpu_device *device, gpu_sampler sampler, uint32_t shader_register) {
  static const D3D12_FILTER filters[GPU_SAMPLER_COUNT] = {
      [GPU_SAMPLER_POINT_CLAMP] = D3D12_FILTER_MIN_MAG_MIP_POINT,
      [GPU_SAMPLER_LINEAR_CLAMP] = D3D12_FILTER_MIN_MAG_LINEAR_MIP_POINT,
      [GPU_SAMPLER_TRILINEAR_CLAMP] = D3D12_FILTER_MIN_MAG_MIP_LINEAR,
      [GPU_SAMPLER_ANISOTROPIC_CLAMP] = D3D12_FILTER_ANISOTROPIC,
      [GPU_SAMPLER_COMPARE_LESS_EQUAL] = D3D12_FILTER_COMPARISON_MIN_MAG_LINEAR_MIP_POINT,
      [GPU_SAMPLER_COMPARE_GREATER_EQUAL] = D3D12_FILTER_COMPARISON_MIN_MAG_LINEAR_MIP_POINT,
      [GPU_SAMPLER_POINT_REPEAT] = D3D12_FILTER_MIN_MAG_MIP_POINT,
      [GPU_SAMPLER_COMPARE_LESS_EQUAL_REPEAT] = D3D12_FILTER_COMPARISON_MIN_MAG_LINEAR_MIP_POINT,
      [GPU_SAMPLER_COMPARE_GREATER_EQUAL_REPEAT] = D3D12_FILTER_COMPARISON_MIN_MAG_LINEAR_MIP_POINT,
  };
  const bool repeats = sampler == GPU_SAMPLER_POINT_REPEAT || sampler == GPU_SAMPLER_COMPARE_LESS_EQUAL_REPEAT ||
                       sampler == GPU_SAMPLER_COMPARE_GREATER_EQUAL_REPEAT;
  const bool compare = filters[sampler] == D3D12_FILTER_COMPARISON_MIN_MAG_LINEAR_MIP_POINT;
  const bool greater =
      sampler == GPU_SAMPLER_COMPARE_GREATER_EQUAL || sampler == GPU_SAMPLER_COMPARE_GREATER_EQUAL_REPEAT;
  const D3D12_TEXTURE_ADDRESS_MODE mode = repeats ? D3D12_TEXTURE_ADDRESS_MODE_WRAP : D3D12_TEXTURE_ADDRESS_MODE_CLAMP;
  return (D3D12_STATIC_SAMPLER_DESC){
      .Filter = filters[sampler],
      .AddressU = mode,
      .AddressV = mode,
      .AddressW = mode,
      .MaxAnisotropy = sampler == GPU_SAMPLER_ANISOTROPIC_CLAMP ? device->info.can.max_anisotropy : 0,
      .ComparisonFunc = greater ? D3D12_COMPARISON_FUNC_GREATER_EQUAL : D3D12_COMPARISON_FUNC_LESS_EQUAL,
      .MaxLOD = compare ? 0 : D3D12_FLOAT32_MAX,
      .ShaderRegister = shader_register,
      .ShaderVisibility = D3D12_SHADER_VISIBILITY_ALL,
  };
}

/* ---- indirect arguments ---- */

csm_result d3d12_command_signatures_create(gpu_device *device) {
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
                                                        (void **)&device->command_signatures[i]),
                    "CreateCommandSignature");
  }
  return result;
}

/* ---- programs ---- */

/* Feature level 11_0 brings all that programs may ask for but anisotropy, which vkd3d takes from the device. */
static const char *unsupported(const gpu_device *device, const gpu_program_info *info) {
  for (uint32_t i = 0; i < info->sampler_count; i++)
    if (info->samplers[i] == GPU_SAMPLER_ANISOTROPIC_CLAMP && device->info.can.max_anisotropy < 2)
      return "anisotropic samplers";
  return NULL;
}

csm_result d3d12_program_create(gpu_device *device, const gpu_program_info *info, gpu_program **out) {
  *out = NULL;
  const char *lacks = unsupported(device, info);
  if (lacks)
    return lent_fail(&device->lent, CSM_ERROR_UNSUPPORTED, "%s: the device has no %s", info->name, lacks);
  gpu_program *program = lent_allocate(&device->lent, sizeof *program);
  if (!program)
    return CSM_ERROR_OUT_OF_MEMORY;
  program->constants_count = info->constants_count;
  program->texture_count = info->texture_count;
  program->buffer_count = info->buffer_count;
  program->texel_buffer_count = info->texel_buffer_count;
  program->store_image_count = info->store_image_count;
  program->store_buffer_count = info->store_buffer_count;
  program->stream_count = info->stream_count;
  for (uint32_t i = 0; i < info->stream_count; i++)
    program->strides[i] = info->streams[i].stride;
  csm_result result = d3d12_signature_create(device, program, info);
  if (result == CSM_SUCCESS)
    result = d3d12_pipeline_create(device, program, info);
  if (result == CSM_SUCCESS)
    *out = program;
  else
    d3d12_program_destroy(device, program);
  return result;
}

void d3d12_program_destroy(gpu_device *device, gpu_program *program) {
  if (!program)
    return;
  d3d12_unref(program->pipeline);
  d3d12_unref(program->signature);
  lent_release(&device->lent, program);
}
