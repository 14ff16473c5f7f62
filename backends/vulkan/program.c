/* program.c: samplers and programs. */
#include "internal.h"

/* ---- samplers ---- */

typedef struct sampler_kind {
  const char *name;
  VkFilter filter;
  VkSamplerMipmapMode mipmap;
  float max_lod;
  bool anisotropic, compares, repeats;
  VkCompareOp compare;
} sampler_kind;

static csm_result sampler_create(gpu_device *device, const sampler_kind *kind, VkSampler *out) {
  const VkSamplerAddressMode mode =
      kind->repeats ? VK_SAMPLER_ADDRESS_MODE_REPEAT : VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
  const VkSamplerCreateInfo info = {.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO,
                                    .magFilter = kind->filter,
                                    .minFilter = kind->filter,
                                    .mipmapMode = kind->mipmap,
                                    .addressModeU = mode,
                                    .addressModeV = mode,
                                    .addressModeW = mode,
                                    .anisotropyEnable = kind->anisotropic,
                                    .maxAnisotropy = (float)device->info.can.max_anisotropy,
                                    .maxLod = kind->max_lod,
                                    .compareEnable = kind->compares,
                                    .compareOp = kind->compare};
  const csm_result result =
      vulkan_made(device, device->vk.CreateSampler(device->handle, &info, NULL, out), out, "vkCreateSampler");
  if (result == CSM_SUCCESS)
    vulkan_name(device, VK_OBJECT_TYPE_SAMPLER, (uint64_t)*out, kind->name);
  return result;
}

csm_result vulkan_samplers_create(gpu_device *device) {
  static const sampler_kind kinds[GPU_SAMPLER_COUNT] = {
      [GPU_SAMPLER_POINT_CLAMP] = {"point", VK_FILTER_NEAREST, .max_lod = VK_LOD_CLAMP_NONE},
      [GPU_SAMPLER_LINEAR_CLAMP] = {"linear", VK_FILTER_LINEAR, .max_lod = VK_LOD_CLAMP_NONE},
      [GPU_SAMPLER_TRILINEAR_CLAMP] = {"trilinear", VK_FILTER_LINEAR, VK_SAMPLER_MIPMAP_MODE_LINEAR, VK_LOD_CLAMP_NONE},
      [GPU_SAMPLER_ANISOTROPIC_CLAMP] = {"anisotropic", VK_FILTER_LINEAR, VK_SAMPLER_MIPMAP_MODE_LINEAR,
                                         VK_LOD_CLAMP_NONE, .anisotropic = true},
      [GPU_SAMPLER_COMPARE_LESS_EQUAL] = {"compare", VK_FILTER_LINEAR, .compares = true,
                                          .compare = VK_COMPARE_OP_LESS_OR_EQUAL},
      [GPU_SAMPLER_COMPARE_GREATER_EQUAL] = {"compare reversed", VK_FILTER_LINEAR, .compares = true,
                                             .compare = VK_COMPARE_OP_GREATER_OR_EQUAL},
      [GPU_SAMPLER_POINT_REPEAT] = {"repeated point", VK_FILTER_NEAREST, .max_lod = VK_LOD_CLAMP_NONE, .repeats = true},
      [GPU_SAMPLER_COMPARE_LESS_EQUAL_REPEAT] = {"repeated compare", VK_FILTER_LINEAR, .compares = true,
                                                 .repeats = true, .compare = VK_COMPARE_OP_LESS_OR_EQUAL},
      [GPU_SAMPLER_COMPARE_GREATER_EQUAL_REPEAT] = {"repeated compare reversed", VK_FILTER_LINEAR, .compares = true,
                                                    .repeats = true, .compare = VK_COMPARE_OP_GREATER_OR_EQUAL},
  };
  csm_result result = CSM_SUCCESS;
  for (uint32_t i = 0; result == CSM_SUCCESS && i < GPU_SAMPLER_COUNT; i++)
    if (!kinds[i].anisotropic || device->info.can.max_anisotropy > 1)
      result = sampler_create(device, &kinds[i], &device->samplers[i]);
  return result;
}

/* ---- programs ---- */

/* What of a program the device cannot do; NULL: nothing. */
static const char *unsupported(const gpu_device *device, const gpu_program_info *info) {
  const gpu_capabilities *can = &device->info.can;
  if (info->raster_bias.clamp != 0 && !can->bias_clamp)
    return "the device clamps no bias: depthBiasClamp is not enabled";
  if (info->compute.spirv_size && !can->compute)
    return "the queue computes nothing";
  if (!info->compute.spirv_size && info->store_image_count + info->store_buffer_count && !can->pixel_stores)
    return "pixel shaders store nothing: fragmentStoresAndAtomics is not enabled";
  if (info->buffer_count + info->store_buffer_count > can->max_buffers)
    return "the device lets no program see so many buffers";
  for (uint32_t i = 0; i < info->sampler_count; i++)
    if (!device->samplers[info->samplers[i]])
      return "no anisotropic sampler: samplerAnisotropy is not enabled";
  return NULL;
}

csm_result vulkan_program_create(gpu_device *device, const gpu_program_info *info, gpu_program **out) {
  *out = NULL;
  const char *lacks = unsupported(device, info);
  if (lacks)
    return lent_fail(&device->lent, CSM_ERROR_UNSUPPORTED, "%s: %s", info->name, lacks);
  gpu_program *program = lent_allocate(&device->lent, sizeof *program);
  if (!program)
    return CSM_ERROR_OUT_OF_MEMORY;
  program->stream_count = info->stream_count;
  program->constants_count = info->constants_count;
  program->texture_count = info->texture_count;
  program->buffer_count = info->buffer_count;
  program->texel_buffer_count = info->texel_buffer_count;
  program->store_image_count = info->store_image_count;
  program->store_buffer_count = info->store_buffer_count;
  program->sampler_count = info->sampler_count;
  for (uint32_t i = 0; i < info->constants_count; i++)
    program->constants_sizes[i] = info->constants_sizes[i];

  csm_result result = vulkan_layouts_create(device, program, info);
  if (result == CSM_SUCCESS)
    result = vulkan_pipeline_create(device, program, info);
  if (result == CSM_SUCCESS)
    *out = program;
  else
    vulkan_program_destroy(device, program);
  return result;
}

void vulkan_program_destroy(gpu_device *device, gpu_program *program) {
  if (!program)
    return;
  device->vk.DestroyPipeline(device->handle, program->pipeline, NULL);
  device->vk.DestroyPipelineLayout(device->handle, program->layout, NULL);
  device->vk.DestroyDescriptorSetLayout(device->handle, program->set_layout, NULL);
  lent_release(&device->lent, program);
}
