/* rig_vulkan_resources.c: a Vulkan engine's buffers and images. */
#include "rig_vulkan.h"

#include <stdlib.h>
#include <string.h>

VkDeviceMemory rig_vulkan_allocate(const rig *rig, const VkMemoryRequirements *needs, VkMemoryPropertyFlags flags) {
  const VkMemoryAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                     .allocationSize = needs->size,
                                     .memoryTypeIndex = rig_vulkan_memory_type(rig, needs->memoryTypeBits, flags)};
  VkDeviceMemory memory;
  rig_vulkan_must(vkAllocateMemory(rig->device, &info, NULL, &memory), "vkAllocateMemory");
  return memory;
}

/* ---- buffers ---- */

rig_buffer rig_buffer_make(rig *rig, rig_buffer_use use, uint64_t size) {
  static const VkBufferUsageFlags usages[] = {[RIG_GEOMETRY] = VK_BUFFER_USAGE_VERTEX_BUFFER_BIT |
                                                               VK_BUFFER_USAGE_INDEX_BUFFER_BIT |
                                                               VK_BUFFER_USAGE_TRANSFER_SRC_BIT,
                                              [RIG_READBACK] = VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                                              [RIG_CONSTANTS] = VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT};
  const VkBufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = size, .usage = usages[use]};
  VkBuffer handle;
  rig_vulkan_must(vkCreateBuffer(rig->device, &info, NULL, &handle), "vkCreateBuffer");
  VkMemoryRequirements needs;
  vkGetBufferMemoryRequirements(rig->device, handle, &needs);
  const VkDeviceMemory memory =
      rig_vulkan_allocate(rig, &needs, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
  rig_vulkan_must(vkBindBufferMemory(rig->device, handle, memory, 0), "vkBindBufferMemory");
  rig_buffer buffer = {.size = size, .object = handle, .memory = memory};
  rig_vulkan_must(vkMapMemory(rig->device, memory, 0, VK_WHOLE_SIZE, 0, &buffer.mapped), "vkMapMemory");
  memset(buffer.mapped, 0, size);
  return buffer;
}

void rig_buffer_free(rig *rig, rig_buffer *buffer) {
  vkDestroyBuffer(rig->device, buffer->object, NULL);
  vkFreeMemory(rig->device, buffer->memory, NULL);
  *buffer = (rig_buffer){0};
}

void rig_mesh_give(const rig_mesh *mesh, rig_native *native, csm_mesh_info *info) {
  native->vulkan_mesh = (csm_vulkan_mesh){.struct_size = sizeof native->vulkan_mesh,
                                          .vertex_stride = mesh->vertex_stride,
                                          .vertices = mesh->vertices->object,
                                          .vertex_offset = mesh->vertex_offset,
                                          .indices = mesh->indices->object,
                                          .index_offset = mesh->index_offset};
  info->vulkan = &native->vulkan_mesh;
}

/* ---- images ---- */

struct rig_image {
  VkImage handle;
  VkDeviceMemory memory;
  csm_vulkan_image native;
};

static const VkFormat formats[] = {[RIG_DEPTH_32] = VK_FORMAT_D32_SFLOAT,
                                   [RIG_RGBA_FLOAT_32] = VK_FORMAT_R32G32B32A32_SFLOAT,
                                   [RIG_RGBA_FLOAT_16] = VK_FORMAT_R16G16B16A16_SFLOAT,
                                   [RIG_RGBA_SNORM_16] = VK_FORMAT_R16G16B16A16_SNORM,
                                   [RIG_RGBA_UNORM_16] = VK_FORMAT_R16G16B16A16_UNORM,
                                   [RIG_RGBA_UNORM_8] = VK_FORMAT_R8G8B8A8_UNORM,
                                   [RIG_RG_FLOAT_32] = VK_FORMAT_R32G32_SFLOAT,
                                   [RIG_RG_FLOAT_16] = VK_FORMAT_R16G16_SFLOAT};

static const VkImageLayout layouts[] = {VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
                                        VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL, VK_IMAGE_LAYOUT_GENERAL};
const uint32_t rig_depth_ways = sizeof layouts / sizeof layouts[0];

static void barrier(VkCommandBuffer commands, const VkImageMemoryBarrier *change, VkPipelineStageFlags from,
                    VkPipelineStageFlags to) {
  VkImageMemoryBarrier complete = *change;
  complete.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER;
  complete.srcQueueFamilyIndex = complete.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  vkCmdPipelineBarrier(commands, from, to, 0, 0, NULL, 0, NULL, 1, &complete);
}

static void upload(rig *rig, const rig_image *image, VkImageAspectFlags aspect, const rig_image_info *info) {
  const uint64_t size = (uint64_t)info->width * info->height * rig_texel_bytes(info->format);
  rig_buffer staging = rig_buffer_make(rig, RIG_GEOMETRY, size);
  memcpy(staging.mapped, info->texels, size);
  rig_run(rig, rig->frame);
  const VkCommandBuffer commands = rig_begin(rig);
  const VkImageSubresourceRange range = {.aspectMask = aspect, .levelCount = 1, .layerCount = 1};
  barrier(commands,
          &(VkImageMemoryBarrier){.dstAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT,
                                  .newLayout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                                  .image = image->handle,
                                  .subresourceRange = range},
          VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT);
  const VkBufferImageCopy region = {.imageSubresource = {.aspectMask = aspect, .layerCount = 1},
                                    .imageExtent = {info->width, info->height, 1}};
  vkCmdCopyBufferToImage(commands, staging.object, image->handle, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region);
  barrier(commands,
          &(VkImageMemoryBarrier){.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT,
                                  .dstAccessMask = VK_ACCESS_SHADER_READ_BIT,
                                  .oldLayout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                                  .newLayout = (VkImageLayout)image->native.layout,
                                  .image = image->handle,
                                  .subresourceRange = range},
          VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT);
  rig_end(rig);
  rig_run(rig, rig->frame);
  rig_buffer_free(rig, &staging);
}

static void make_view(const rig *rig, rig_image *image, VkImageAspectFlags aspect) {
  const VkImageViewCreateInfo view = {.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                      .image = image->handle,
                                      .viewType = VK_IMAGE_VIEW_TYPE_2D,
                                      .format = image->native.format,
                                      .subresourceRange = {.aspectMask = aspect, .levelCount = 1, .layerCount = 1}};
  rig_vulkan_must(vkCreateImageView(rig->device, &view, NULL, &image->native.view), "vkCreateImageView");
}

rig_image *rig_image_make(rig *rig, const rig_image_info *info) {
  rig_image *image = calloc(1, sizeof *image);
  assert_non_null(image);
  image->native = (csm_vulkan_image){.struct_size = sizeof image->native,
                                     .layout = layouts[info->way],
                                     .format = formats[info->format],
                                     .width = info->width,
                                     .height = info->height};
  const bool depth = info->format == RIG_DEPTH_32;
  const VkImageAspectFlags aspect = depth ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
  const VkImageCreateInfo create = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                                    .imageType = VK_IMAGE_TYPE_2D,
                                    .format = formats[info->format],
                                    .extent = {info->width, info->height, 1},
                                    .mipLevels = 1,
                                    .arrayLayers = 1,
                                    .samples = VK_SAMPLE_COUNT_1_BIT,
                                    .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT |
                                             (depth ? VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT : 0)};
  rig_vulkan_must(vkCreateImage(rig->device, &create, NULL, &image->handle), "vkCreateImage");
  VkMemoryRequirements needs;
  vkGetImageMemoryRequirements(rig->device, image->handle, &needs);
  image->memory = rig_vulkan_allocate(rig, &needs, 0);
  rig_vulkan_must(vkBindImageMemory(rig->device, image->handle, image->memory, 0), "vkBindImageMemory");
  make_view(rig, image, aspect);
  upload(rig, image, aspect, info);
  return image;
}

void rig_image_free(rig *rig, rig_image *image) {
  vkDestroyImageView(rig->device, image->native.view, NULL);
  vkDestroyImage(rig->device, image->handle, NULL);
  vkFreeMemory(rig->device, image->memory, NULL);
  free(image);
}

const void *rig_image_native(const rig_image *image) {
  return &image->native;
}

/* ---- reading what csm drew ---- */

uint32_t rig_pitch(uint32_t width, uint32_t texel_bytes) {
  return width * texel_bytes;
}

void rig_copy(rig *rig, const rig_layer *from, const rig_buffer *to, uint64_t offset) {
  const VkCommandBuffer commands = rig_commands(rig);
  const VkImage image = (VkImage)from->image;
  const VkImageAspectFlags aspect =
      from->texel_bytes == 4 || from->texel_bytes == 2 ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
  VkImageMemoryBarrier change = {
      .srcAccessMask = VK_ACCESS_SHADER_READ_BIT,
      .dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT,
      .oldLayout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
      .newLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
      .image = image,
      .subresourceRange = {.aspectMask = aspect, .levelCount = 1, .baseArrayLayer = from->layer, .layerCount = 1}};
  barrier(commands, &change, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT);
  const VkBufferImageCopy region = {
      .bufferOffset = offset,
      .imageSubresource = {.aspectMask = aspect, .baseArrayLayer = from->layer, .layerCount = 1},
      .imageExtent = {from->width, from->height, 1}};
  vkCmdCopyImageToBuffer(commands, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, to->object, 1, &region);
  change.srcAccessMask = 0;
  change.dstAccessMask = VK_ACCESS_SHADER_READ_BIT;
  change.oldLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
  change.newLayout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
  barrier(commands, &change, VK_PIPELINE_STAGE_TRANSFER_BIT,
          VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT | VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT);
}
