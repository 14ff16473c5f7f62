/* record.c: what is recorded outside passes: markers, timestamps, copies, clears, dispatches. */
#include "internal.h"

#include <string.h>

/* ---- markers and timestamps ---- */

void d3d12_marker_begin(gpu_device *device, const char *name) {
  if (device->traits->markers)
    ID3D12GraphicsCommandList_BeginEvent(device->list, 1, name, (UINT)strlen(name) + 1);
}

void d3d12_marker_end(gpu_device *device) {
  if (device->traits->markers)
    ID3D12GraphicsCommandList_EndEvent(device->list);
}

void d3d12_timestamp(gpu_device *device, uint32_t index) {
  d3d12_flush_barriers(device);
  ID3D12GraphicsCommandList_EndQuery(device->list, device->queries, D3D12_QUERY_TYPE_TIMESTAMP,
                                     device->slot * GPU_MAX_TIMESTAMPS + index);
  if (device->timestamps_begin == device->timestamps_end)
    device->timestamps_begin = index;
  device->timestamps_end = index + 1;
}

/* ---- copies ---- */

void d3d12_copy_buffer(gpu_device *device, gpu_buffer *to, uint64_t to_offset, gpu_buffer *from, uint64_t from_offset,
                       uint64_t size) {
  d3d12_buffer_use_target(device, to, to_offset, size);
  d3d12_buffer_use_source(device, from);
  d3d12_flush_barriers(device);
  ID3D12GraphicsCommandList_CopyBufferRegion(device->list, to->resource.handle, to_offset, from->resource.handle,
                                             from_offset, size);
}

static uint32_t region_subresource(const gpu_image *image, const gpu_region *region) {
  return region->level + region->layer * image->level_count;
}

static D3D12_TEXTURE_COPY_LOCATION image_location(const gpu_image *image, const gpu_region *region) {
  return (D3D12_TEXTURE_COPY_LOCATION){.pResource = image->resource.handle,
                                       .Type = D3D12_TEXTURE_COPY_TYPE_SUBRESOURCE_INDEX,
                                       .SubresourceIndex = region_subresource(image, region)};
}

/* A region's texels in a buffer. */
static D3D12_TEXTURE_COPY_LOCATION buffer_location(const gpu_buffer *buffer, uint64_t offset, uint32_t row_bytes,
                                                   gpu_format format, const gpu_region *region) {
  return (D3D12_TEXTURE_COPY_LOCATION){.pResource = buffer->resource.handle,
                                       .Type = D3D12_TEXTURE_COPY_TYPE_PLACED_FOOTPRINT,
                                       .PlacedFootprint = {.Offset = offset,
                                                           .Footprint = {.Format = d3d12_resource_format(format),
                                                                         .Width = region->width,
                                                                         .Height = region->height,
                                                                         .Depth = 1,
                                                                         .RowPitch = row_bytes}}};
}

void d3d12_copy_image(gpu_device *device, gpu_buffer *to, uint64_t offset, uint32_t row_bytes, gpu_image *image,
                      const gpu_region *from) {
  const D3D12_TEXTURE_COPY_LOCATION source = image_location(image, from);
  const D3D12_TEXTURE_COPY_LOCATION target = buffer_location(to, offset, row_bytes, image->format, from);
  const D3D12_BOX box = {
      .left = from->x, .top = from->y, .right = from->x + from->width, .bottom = from->y + from->height, .back = 1};
  d3d12_buffer_use_target(device, to, offset, (uint64_t)row_bytes * from->height);
  d3d12_image_use(device, image, &(gpu_range){from->layer, 1, from->level, 1}, D3D12_RESOURCE_STATE_COPY_SOURCE);
  d3d12_flush_barriers(device);
  /* Direct3D 12 copies no part of a layer of depths, so these take no box. */
  ID3D12GraphicsCommandList_CopyTextureRegion(device->list, &target, 0, 0, 0, &source,
                                              gpu_format_is_depth(image->format) ? NULL : &box);
}

void d3d12_copy_to_image(gpu_device *device, gpu_image *image, const gpu_region *to, gpu_buffer *from, uint64_t offset,
                         uint32_t row_bytes) {
  const D3D12_TEXTURE_COPY_LOCATION source = buffer_location(from, offset, row_bytes, image->format, to);
  const D3D12_TEXTURE_COPY_LOCATION target = image_location(image, to);
  d3d12_image_use(device, image, &(gpu_range){to->layer, 1, to->level, 1}, D3D12_RESOURCE_STATE_COPY_DEST);
  d3d12_flush_barriers(device);
  ID3D12GraphicsCommandList_CopyTextureRegion(device->list, &target, to->x, to->y, 0, &source, NULL);
}

/* ---- clears ---- */

/*
 * Copies of the few rows in `fill`, which stay in the cache, clear 4 maps of 2048 x 2048 in 2.1 ms on lavapipe.
 * vkd3d's ClearDepthStencilView is a render pass that loads with a clear, and takes 5 to 8 ms, with one view of all
 * layers or one of each. On a GPU that view is the cheap way, for it keeps depth compressed.
 */
bool d3d12_clears_by_copies(const gpu_device *device, float depth) {
  return device->fill && (depth == 0 || depth == 1);
}

void d3d12_fill_depth(gpu_device *device, gpu_image *image, const gpu_region *region, float depth) {
  const uint32_t one = image->format == GPU_FORMAT_D16_UNORM ? D3D12_FILL_ONE_D16 : D3D12_FILL_ONE_D32;
  const uint64_t offset = (uint64_t)(depth == 1 ? one : D3D12_FILL_ZERO) * D3D12_FILL_SIZE;
  const uint32_t row_bytes = (region->width * gpu_format_bytes(image->format) + 255) & ~255u;
  const uint32_t strip = D3D12_FILL_SIZE / row_bytes;
  const D3D12_TEXTURE_COPY_LOCATION to = image_location(image, region);
  gpu_region rows = *region;
  for (uint32_t row = 0; row < region->height; row += strip) {
    const uint32_t left = region->height - row;
    rows.height = left < strip ? left : strip;
    const D3D12_TEXTURE_COPY_LOCATION from = buffer_location(device->fill, offset, row_bytes, image->format, &rows);
    ID3D12GraphicsCommandList_CopyTextureRegion(device->list, &to, region->x, region->y + row, 0, &from, NULL);
  }
}

static void fill_image(gpu_device *device, gpu_image *image, float depth) {
  d3d12_image_use(device, image, NULL, D3D12_RESOURCE_STATE_COPY_DEST);
  d3d12_flush_barriers(device);
  for (uint32_t layer = 0; layer < image->layer_count; layer++)
    for (uint32_t level = 0; level < image->level_count; level++) {
      const gpu_region region = {.layer = layer,
                                 .width = gpu_level_size(image->width, level),
                                 .height = gpu_level_size(image->height, level),
                                 .level = level};
      d3d12_fill_depth(device, image, &region, depth);
    }
}

void d3d12_clear_depth(gpu_device *device, gpu_image *image, float depth) {
  if (d3d12_clears_by_copies(device, depth))
    fill_image(device, image, depth);
  /* One barrier for all layers; else each layer's pass would begin with one, and wait for the pass before it. */
  d3d12_image_use(device, image, NULL, D3D12_RESOURCE_STATE_DEPTH_WRITE);
  if (d3d12_clears_by_copies(device, depth))
    return;
  d3d12_flush_barriers(device);
  for (uint32_t level = 0; level < image->level_count; level++)
    ID3D12GraphicsCommandList_ClearDepthStencilView(device->list, d3d12_depth_view(device, image->clear_heap, level),
                                                    D3D12_CLEAR_FLAG_DEPTH, depth, 0, 0, NULL);
}

/* ---- what shaders read, and dispatches ---- */

void d3d12_make_readable(gpu_device *device, gpu_image *image, const gpu_range *range) {
  d3d12_image_use(device, image, range, D3D12_STATE_READABLE);
}

static void use_bindings(gpu_device *device, const gpu_bindings *bindings) {
  const gpu_bindings_info *info = &bindings->info;
  for (uint32_t i = 0; i < bindings->texture_count; i++) {
    const gpu_view *view = info->texture_views[i];
    gpu_image *image = view ? view->image : info->textures[i];
    d3d12_image_use(device, image, view ? &view->range : NULL, D3D12_STATE_READABLE);
  }
  for (uint32_t i = 0; i < bindings->buffer_count; i++)
    d3d12_buffer_use_read(device, info->buffers[i].buffer, D3D12_STATE_READABLE);
  for (uint32_t i = 0; i < bindings->texel_buffer_count; i++)
    d3d12_buffer_use_read(device, info->texel_buffers[i], D3D12_STATE_READABLE);
  d3d12_use_stores(device, bindings);
}

static void bind_compute(gpu_device *device, const gpu_bindings *bindings, const uint32_t *offsets) {
  for (uint32_t i = 0; i < bindings->constants_count; i++)
    ID3D12GraphicsCommandList_SetComputeRootConstantBufferView(device->list, i,
                                                               bindings->info.constants[i]->address + offsets[i]);
  if (!bindings->block)
    return;
  d3d12_set_heap(device, bindings);
  ID3D12GraphicsCommandList_SetComputeRootDescriptorTable(device->list, bindings->constants_count, bindings->table);
}

void d3d12_dispatch(gpu_device *device, const gpu_dispatch_info *info) {
  if (info->bindings)
    use_bindings(device, info->bindings);
  if (info->arguments)
    d3d12_buffer_use_read(device, info->arguments, D3D12_RESOURCE_STATE_INDIRECT_ARGUMENT);
  d3d12_flush_barriers(device);
  ID3D12GraphicsCommandList_SetComputeRootSignature(device->list, info->program->signature);
  ID3D12GraphicsCommandList_SetPipelineState(device->list, info->program->pipeline);
  if (info->bindings)
    bind_compute(device, info->bindings, info->offsets);
  if (info->arguments)
    ID3D12GraphicsCommandList_ExecuteIndirect(device->list, device->command_signatures[D3D12_DISPATCH], 1,
                                              info->arguments->resource.handle, info->arguments_offset, NULL, 0);
  else
    ID3D12GraphicsCommandList_Dispatch(device->list, info->groups[0], info->groups[1], info->groups[2]);
}
