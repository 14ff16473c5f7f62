/* bindings.c: what programs read and write: one descriptor set each. */
#include "internal.h"

/* Where HLSL registers lie in a descriptor set: what the shaders were compiled with. */
enum {
  BINDING_CONSTANTS = 0,
  BINDING_TEXTURES = 16,
  BINDING_BUFFERS = BINDING_TEXTURES + GPU_FIRST_BUFFER,
  BINDING_TEXEL_BUFFERS = BINDING_TEXTURES + GPU_FIRST_TEXEL_BUFFER,
  BINDING_STORE_IMAGES = 32,
  BINDING_STORE_BUFFERS = BINDING_STORE_IMAGES + GPU_FIRST_STORE_BUFFER,
  BINDING_SAMPLERS = 48
};

/* A row for each kind of binding. */
typedef struct binding_kind {
  VkDescriptorType type;
  uint32_t first, count;
  bool vertices; /* vertex shaders see it too */
} binding_kind;

enum {
  KINDS = 7,
  MAX_BINDINGS = GPU_MAX_CONSTANTS + GPU_MAX_TEXTURES + GPU_MAX_BUFFERS + GPU_MAX_TEXEL_BUFFERS + 2 * GPU_MAX_STORES
};

static void kinds_of(const gpu_program *program, binding_kind out[KINDS]) {
  const binding_kind kinds[KINDS] = {
      {VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC, BINDING_CONSTANTS, program->constants_count, true},
      {VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE, BINDING_TEXTURES, program->texture_count, false},
      {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, BINDING_BUFFERS, program->buffer_count, true},
      {VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER, BINDING_TEXEL_BUFFERS, program->texel_buffer_count, true},
      {VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, BINDING_STORE_IMAGES, program->store_image_count, false},
      {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, BINDING_STORE_BUFFERS, program->store_buffer_count, false},
      {VK_DESCRIPTOR_TYPE_SAMPLER, BINDING_SAMPLERS, program->sampler_count, false},
  };
  for (uint32_t i = 0; i < KINDS; i++)
    out[i] = kinds[i];
}

/* ---- layouts ---- */

csm_result vulkan_layouts_create(gpu_device *device, gpu_program *program, const gpu_program_info *info) {
  const bool compute = info->compute.spirv_size;
  VkDescriptorSetLayoutBinding bindings[MAX_BINDINGS + GPU_MAX_SAMPLERS];
  binding_kind kinds[KINDS];
  uint32_t count = 0;
  kinds_of(program, kinds);
  for (const binding_kind *kind = kinds; kind < kinds + KINDS; kind++)
    for (uint32_t i = 0; i < kind->count; i++)
      bindings[count++] = (VkDescriptorSetLayoutBinding){
          .binding = kind->first + i,
          .descriptorType = kind->type,
          .descriptorCount = 1,
          .stageFlags = compute          ? VK_SHADER_STAGE_COMPUTE_BIT
                        : kind->vertices ? VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT
                                         : VK_SHADER_STAGE_FRAGMENT_BIT,
          .pImmutableSamplers = kind->type == VK_DESCRIPTOR_TYPE_SAMPLER ? &device->samplers[info->samplers[i]] : NULL};
  const VkDescriptorSetLayoutCreateInfo set = {
      .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, .bindingCount = count, .pBindings = bindings};
  csm_result result =
      vulkan_made(device, device->vk.CreateDescriptorSetLayout(device->handle, &set, NULL, &program->set_layout),
                  &program->set_layout, "vkCreateDescriptorSetLayout");
  if (result != CSM_SUCCESS)
    return result;
  vulkan_name(device, VK_OBJECT_TYPE_DESCRIPTOR_SET_LAYOUT, (uint64_t)program->set_layout, info->name);

  const VkPipelineLayoutCreateInfo layout = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO, .setLayoutCount = 1, .pSetLayouts = &program->set_layout};
  result = vulkan_made(device, device->vk.CreatePipelineLayout(device->handle, &layout, NULL, &program->layout),
                       &program->layout, "vkCreatePipelineLayout");
  if (result == CSM_SUCCESS)
    vulkan_name(device, VK_OBJECT_TYPE_PIPELINE_LAYOUT, (uint64_t)program->layout, info->name);
  return result;
}

/* ---- sets ---- */

static csm_result set_allocate(gpu_device *device, gpu_bindings *bindings, const gpu_program *program,
                               const char *name) {
  binding_kind kinds[KINDS];
  VkDescriptorPoolSize sizes[KINDS];
  uint32_t count = 0;
  kinds_of(program, kinds);
  for (uint32_t i = 0; i < KINDS; i++)
    if (kinds[i].count)
      sizes[count++] = (VkDescriptorPoolSize){kinds[i].type, kinds[i].count};
  if (count == 0)
    return CSM_SUCCESS;

  const VkDescriptorPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                           .maxSets = 1,
                                           .poolSizeCount = count,
                                           .pPoolSizes = sizes};
  csm_result result = vulkan_made(device, device->vk.CreateDescriptorPool(device->handle, &pool, NULL, &bindings->pool),
                                  &bindings->pool, "vkCreateDescriptorPool");
  if (result != CSM_SUCCESS)
    return result;
  vulkan_name(device, VK_OBJECT_TYPE_DESCRIPTOR_POOL, (uint64_t)bindings->pool, name);
  const VkDescriptorSetAllocateInfo set = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                           .descriptorPool = bindings->pool,
                                           .descriptorSetCount = 1,
                                           .pSetLayouts = &program->set_layout};
  result = vulkan_check(device, device->vk.AllocateDescriptorSets(device->handle, &set, &bindings->set),
                        "vkAllocateDescriptorSets");
  if (result == CSM_SUCCESS)
    vulkan_name(device, VK_OBJECT_TYPE_DESCRIPTOR_SET, (uint64_t)bindings->set, name);
  return result;
}

/* The writes of a set, gathered. */
typedef struct set_writes {
  VkDescriptorSet set;
  uint32_t count;
  VkWriteDescriptorSet writes[MAX_BINDINGS];
  VkDescriptorBufferInfo buffers[MAX_BINDINGS];
  VkDescriptorImageInfo images[MAX_BINDINGS];
  VkBufferView texels[MAX_BINDINGS];
} set_writes;

static void add_write(set_writes *out, uint32_t binding, VkDescriptorType type) {
  out->writes[out->count] = (VkWriteDescriptorSet){.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                                   .dstSet = out->set,
                                                   .dstBinding = binding,
                                                   .descriptorCount = 1,
                                                   .descriptorType = type,
                                                   .pBufferInfo = &out->buffers[out->count],
                                                   .pImageInfo = &out->images[out->count],
                                                   .pTexelBufferView = &out->texels[out->count]};
  out->count++;
}

static void add_parts(set_writes *out, uint32_t first, const gpu_buffer_part *parts, uint32_t count) {
  for (uint32_t i = 0; i < count; i++) {
    out->buffers[out->count] = (VkDescriptorBufferInfo){.buffer = parts[i].buffer->handle,
                                                        .offset = parts[i].offset,
                                                        .range = parts[i].size ? parts[i].size : VK_WHOLE_SIZE};
    add_write(out, first + i, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER);
  }
}

static void add_texel_buffers(set_writes *out, gpu_buffer *const *buffers, uint32_t count) {
  for (uint32_t i = 0; i < count; i++) {
    out->texels[out->count] = buffers[i]->texels;
    add_write(out, BINDING_TEXEL_BUFFERS + i, VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER);
  }
}

static void add_textures(set_writes *out, gpu_bindings *bindings, const gpu_bindings_info *info) {
  for (uint32_t i = 0; i < bindings->texture_count; i++) {
    const gpu_view *view = info->texture_views[i];
    gpu_image *image = view ? view->image : info->textures[i];
    bindings->textures[i] = (vulkan_bound){image, view ? view->range : vulkan_range(image, NULL)};
    out->images[out->count] =
        (VkDescriptorImageInfo){.imageView = view ? view->handle : image->view, .imageLayout = image->sampled_layout};
    add_write(out, BINDING_TEXTURES + i, VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE);
  }
}

static void add_store_images(set_writes *out, gpu_bindings *bindings, const gpu_bindings_info *info) {
  for (uint32_t i = 0; i < bindings->store_image_count; i++) {
    const gpu_view *view = info->store_images[i];
    bindings->store_images[i] = (vulkan_bound){view->image, view->range};
    out->images[out->count] =
        (VkDescriptorImageInfo){.imageView = view->handle, .imageLayout = VK_IMAGE_LAYOUT_GENERAL};
    add_write(out, BINDING_STORE_IMAGES + i, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE);
  }
}

void vulkan_bindings_write(gpu_device *device, gpu_bindings *bindings, const gpu_bindings_info *info) {
  const gpu_program *program = info->program;
  set_writes out = {.set = bindings->set};
  for (uint32_t i = 0; i < program->constants_count; i++) {
    out.buffers[out.count] =
        (VkDescriptorBufferInfo){.buffer = info->constants[i]->handle, .range = program->constants_sizes[i]};
    add_write(&out, BINDING_CONSTANTS + i, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC);
  }
  add_textures(&out, bindings, info);
  add_parts(&out, BINDING_BUFFERS, info->buffers, program->buffer_count);
  add_texel_buffers(&out, info->texel_buffers, program->texel_buffer_count);
  add_store_images(&out, bindings, info);
  add_parts(&out, BINDING_STORE_BUFFERS, info->store_buffers, program->store_buffer_count);
  device->vk.UpdateDescriptorSets(device->handle, out.count, out.writes, 0, NULL);
}

csm_result vulkan_bindings_create(gpu_device *device, const gpu_bindings_info *info, gpu_bindings **out) {
  *out = NULL;
  const gpu_program *program = info->program;
  gpu_bindings *bindings = lent_allocate(&device->lent, sizeof *bindings);
  if (!bindings)
    return CSM_ERROR_OUT_OF_MEMORY;
  bindings->layout = program->layout;
  bindings->constants_count = program->constants_count;
  bindings->texture_count = program->texture_count;
  bindings->store_image_count = program->store_image_count;
  bindings->store_buffer_count = program->store_buffer_count;
  bindings->buffers = program->buffer_count || program->texel_buffer_count || program->store_buffer_count;
  const csm_result result = set_allocate(device, bindings, program, info->name);
  if (result != CSM_SUCCESS) {
    vulkan_bindings_destroy(device, bindings);
    return result;
  }
  vulkan_bindings_write(device, bindings, info);
  *out = bindings;
  return CSM_SUCCESS;
}

void vulkan_bindings_destroy(gpu_device *device, gpu_bindings *bindings) {
  if (!bindings)
    return;
  device->vk.DestroyDescriptorPool(device->handle, bindings->pool, NULL);
  lent_release(&device->lent, bindings);
}
