/* program.c: programs, and what they read and write. */
#include "null.h"

/* ---- programs ---- */

static void check_counts(gpu_device *device, const gpu_program_info *info) {
  null_require(device,
               info->stream_count <= GPU_MAX_STREAMS && info->attribute_count <= GPU_MAX_ATTRIBUTES &&
                   info->constants_count <= GPU_MAX_CONSTANTS && info->texture_count <= GPU_MAX_TEXTURES &&
                   info->buffer_count <= GPU_MAX_BUFFERS && info->texel_buffer_count <= GPU_MAX_TEXEL_BUFFERS &&
                   info->store_image_count <= GPU_MAX_STORES && info->store_buffer_count <= GPU_MAX_STORES &&
                   info->sampler_count <= GPU_MAX_SAMPLERS,
               "program_create: more than there are places for");
  for (uint32_t i = 0; i < info->sampler_count && i < GPU_MAX_SAMPLERS; i++)
    null_require(device, info->samplers[i] < GPU_SAMPLER_COUNT, "program_create: no such sampler");
}

static void check_attributes(gpu_device *device, const gpu_program_info *info) {
  for (uint32_t i = 0; i < info->stream_count && i < GPU_MAX_STREAMS; i++)
    null_require(device, info->streams[i].stride % 4 == 0, "program_create: a stride is not a multiple of 4");
  for (uint32_t i = 0; i < info->attribute_count && i < GPU_MAX_ATTRIBUTES; i++) {
    const gpu_attribute *attribute = &info->attributes[i];
    null_require(device, gpu_format_is_attribute(attribute->format), "program_create: no format of an attribute");
    null_require(device, attribute->stream < info->stream_count, "program_create: an attribute of no stream");
    null_require(device, attribute->offset % 4 == 0, "program_create: an attribute's offset is not a multiple of 4");
  }
}

static void check_compute(gpu_device *device, const gpu_program_info *info) {
  null_require(device, info->compute.spirv_size && info->compute.dxbc_size, "program_create: half a compute shader");
  null_require(device,
               !info->vertex.spirv_size && !info->pixel.spirv_size && !info->stream_count && !info->attribute_count &&
                   !info->depth_format && !info->color_format,
               "program_create: a compute program that draws");
}

static void check_drawing(gpu_device *device, const gpu_program_info *info) {
  const gpu_raster_bias *bias = &info->raster_bias;
  null_require(device, info->vertex.spirv_size && info->vertex.dxbc_size, "program_create: no vertex shader");
  null_require(device, !info->pixel.spirv_size == !info->pixel.dxbc_size, "program_create: half a pixel shader");
  null_require(device, !info->depth_format || gpu_format_is_depth(info->depth_format),
               "program_create: no depth format");
  null_require(device, !gpu_format_is_depth(info->color_format) && info->color_format != GPU_FORMAT_RGB32_FLOAT,
               "program_create: no colour format");
  null_require(device, info->depth_format || !(bias->constant || bias->slope != 0),
               "program_create: a raster bias without depth");
  null_require(device, info->depth_format || info->depth_compare == GPU_COMPARE_NONE,
               "program_create: a comparison without depth");
  null_require(device, info->depth_compare <= GPU_COMPARE_ALWAYS, "program_create: no such comparison");
  null_require(device, !info->store_image_count || !info->color_format,
               "program_create: images stored to beside a colour target");
  check_attributes(device, info);
}

csm_result null_program_create(gpu_device *device, const gpu_program_info *info, gpu_program **out) {
  check_counts(device, info);
  if (info->compute.spirv_size || info->compute.dxbc_size)
    check_compute(device, info);
  else
    check_drawing(device, info);
  gpu_program *program = *out = null_make(device, sizeof *program);
  if (!program)
    return CSM_ERROR_OUT_OF_MEMORY;
  null_set_name(program->name, info->name);
  program->info = *info;
  return CSM_SUCCESS;
}

void null_program_destroy(gpu_device *device, gpu_program *program) {
  if (program)
    null_require_unused(device, program->used, "program_destroy: a recording uses it");
  null_release(device, program);
}

static bool same_constants(const gpu_program_info *a, const gpu_program_info *b) {
  bool same = a->constants_count == b->constants_count;
  for (uint32_t i = 0; same && i < a->constants_count && i < GPU_MAX_CONSTANTS; i++)
    same = a->constants_sizes[i] == b->constants_sizes[i];
  return same;
}

static bool same_samplers(const gpu_program_info *a, const gpu_program_info *b) {
  bool same = a->sampler_count == b->sampler_count;
  for (uint32_t i = 0; same && i < a->sampler_count && i < GPU_MAX_SAMPLERS; i++)
    same = a->samplers[i] == b->samplers[i];
  return same;
}

bool null_same_shape(const gpu_program *a, const gpu_program *b) {
  return !a->info.compute.spirv_size == !b->info.compute.spirv_size && same_constants(&a->info, &b->info) &&
         a->info.texture_count == b->info.texture_count && a->info.buffer_count == b->info.buffer_count &&
         a->info.texel_buffer_count == b->info.texel_buffer_count &&
         a->info.store_image_count == b->info.store_image_count &&
         a->info.store_buffer_count == b->info.store_buffer_count && same_samplers(&a->info, &b->info);
}

/* ---- bindings ---- */

gpu_view null_texture(const gpu_bindings *bindings, uint32_t index) {
  const gpu_view *view = bindings->info.texture_views[index];
  if (view)
    return *view;
  gpu_image *image = bindings->info.textures[index];
  return (gpu_view){.image = image, .range = null_range(image, NULL)};
}

static void check_part(gpu_device *device, const gpu_buffer_part *part, uint32_t usage) {
  if (!null_require(device, part->buffer && (part->buffer->info.usage & usage),
                    usage == GPU_BUFFER_READ ? "bindings_write: a buffer is missing, or not made to be read"
                                             : "bindings_write: a buffer is missing, or not made to be written"))
    return;
  const uint64_t size = part->size ? part->size : part->buffer->info.size - part->offset;
  null_require(device, null_holds(part->buffer, part->offset, size) && size > 0,
               "bindings_write: a part beyond a buffer's end");
  null_require(device, part->offset % NULL_OFFSET_ALIGNMENT == 0 && size % 4 == 0,
               "bindings_write: a part's offset is not a multiple of 256, or its size not one of 4");
  null_require(device,
               part->stride % 4 == 0 && (!part->stride || !(part->offset % part->stride || size % part->stride)),
               "bindings_write: a part's stride is not a multiple of 4, or divides its offset or size not");
  null_require(device, part->stride || usage == GPU_BUFFER_READ, "bindings_write: a raw buffer that is written");
}

static void check_images(gpu_device *device, const gpu_bindings *bindings) {
  const gpu_bindings_info *info = &bindings->info;
  for (uint32_t i = 0; i < info->program->info.texture_count; i++) {
    const bool there = info->texture_views[i] || info->textures[i];
    null_require(device, there && (null_texture(bindings, i).image->info.usage & GPU_IMAGE_SAMPLED),
                 "bindings_write: a texture is missing, or not made to be sampled");
  }
  for (uint32_t i = 0; i < info->program->info.store_image_count; i++) {
    const gpu_view *view = info->store_images[i];
    if (!null_require(device, view && (view->image->info.usage & GPU_IMAGE_STORED),
                      "bindings_write: an image is missing, or not made to be stored to"))
      continue;
    null_require(device, view->range.level_count == 1, "bindings_write: stores go to one level");
    for (uint32_t k = 0; k < info->program->info.texture_count; k++) {
      if (!info->texture_views[k] && !info->textures[k])
        continue;
      const gpu_view texture = null_texture(bindings, k);
      null_require(device, texture.image != view->image || !null_overlap(&texture.range, &view->range),
                   "bindings_write: a texture is also written");
    }
  }
}

void null_bindings_write(gpu_device *device, gpu_bindings *bindings, const gpu_bindings_info *info) {
  const gpu_program_info *program = &info->program->info;
  null_require_unused(device, bindings->used, "bindings_write: a recording uses them");
  bindings->info = *info;
  for (uint32_t i = 0; i < program->constants_count; i++)
    null_require(device, info->constants[i] && info->constants[i]->info.kind == GPU_BUFFER_UPLOAD,
                 "bindings_write: constants are missing, or in no upload buffer");
  check_images(device, bindings);
  for (uint32_t i = 0; i < program->buffer_count; i++)
    check_part(device, &info->buffers[i], GPU_BUFFER_READ);
  for (uint32_t i = 0; i < program->texel_buffer_count; i++)
    null_require(device, info->texel_buffers[i] && (info->texel_buffers[i]->info.usage & GPU_BUFFER_TEXELS),
                 "bindings_write: a texel buffer is missing, or not made to be one");
  for (uint32_t i = 0; i < program->store_buffer_count; i++) {
    check_part(device, &info->store_buffers[i], GPU_BUFFER_WRITE);
    for (uint32_t k = 0; k < program->buffer_count; k++)
      null_require(device, info->buffers[k].buffer != info->store_buffers[i].buffer,
                   "bindings_write: a buffer is also written");
    for (uint32_t k = 0; k < program->texel_buffer_count; k++)
      null_require(device, info->texel_buffers[k] != info->store_buffers[i].buffer,
                   "bindings_write: a buffer is also written");
  }
}

csm_result null_bindings_create(gpu_device *device, const gpu_bindings_info *info, gpu_bindings **out) {
  gpu_bindings *bindings = *out = null_make(device, sizeof *bindings);
  if (!bindings)
    return CSM_ERROR_OUT_OF_MEMORY;
  null_set_name(bindings->name, info->name);
  null_bindings_write(device, bindings, info);
  return CSM_SUCCESS;
}

void null_bindings_destroy(gpu_device *device, gpu_bindings *bindings) {
  if (bindings)
    null_require_unused(device, bindings->used, "bindings_destroy: a recording uses it");
  null_release(device, bindings);
}
