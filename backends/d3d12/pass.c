/* pass.c: passes. Direct3D 12 has none: a pass is what is drawn into the targets that are set. */
#include "internal.h"

/* ---- targets ---- */

static D3D12_RECT native_rect(const gpu_rect *rect) {
  return (D3D12_RECT){.left = (LONG)rect->x,
                      .top = (LONG)rect->y,
                      .right = (LONG)(rect->x + rect->width),
                      .bottom = (LONG)(rect->y + rect->height)};
}

/* Clears by copies what is cheaper to clear so. */
static void fill_depth(gpu_device *device, const gpu_pass_info *info, const gpu_rect *area) {
  const d3d12_attachment *depth = &info->target->depth;
  const gpu_region region = {.layer = depth->range.first_layer,
                             .x = area->x,
                             .y = area->y,
                             .width = area->width,
                             .height = area->height,
                             .level = depth->range.first_level};
  d3d12_image_use(device, depth->image, &depth->range, D3D12_RESOURCE_STATE_COPY_DEST);
  d3d12_flush_barriers(device);
  d3d12_fill_depth(device, depth->image, &region, info->clear_depth);
}

/* Takes an attachment into the state for drawing. What was never used, or is not kept anywhere, is discarded: a target
   in the engine's memory must begin so. An image leaves COMMON with its first use for good. */
static void use_attachment(gpu_device *device, const d3d12_attachment *attachment, bool discards,
                           D3D12_RESOURCE_STATES state) {
  const gpu_range *range = &attachment->range;
  if (!attachment->image)
    return;
  const uint32_t subresource = range->first_level + range->first_layer * attachment->image->level_count;
  const bool fresh = attachment->image->states[subresource] == D3D12_RESOURCE_STATE_COMMON;
  d3d12_image_use(device, attachment->image, range, state);
  if (!device->traits->discards || !(fresh || discards))
    return;
  const D3D12_DISCARD_REGION region = {.FirstSubresource = subresource, .NumSubresources = 1};
  d3d12_flush_barriers(device);
  ID3D12GraphicsCommandList_DiscardResource(device->list, attachment->image->resource.handle, &region);
}

/* What clip space covers, and the part of it that is drawn. */
static void cover(gpu_device *device, const gpu_rect *space, const gpu_rect *area) {
  const D3D12_VIEWPORT viewport = {.TopLeftX = (float)space->x,
                                   .TopLeftY = (float)space->y,
                                   .Width = (float)space->width,
                                   .Height = (float)space->height,
                                   .MaxDepth = 1};
  const D3D12_RECT scissor = native_rect(area);
  ID3D12GraphicsCommandList_RSSetViewports(device->list, 1, &viewport);
  ID3D12GraphicsCommandList_RSSetScissorRects(device->list, 1, &scissor);
}

void d3d12_pass_begin(gpu_device *device, const gpu_pass_info *info) {
  const gpu_target *target = info->target;
  const bool whole = !info->area.width || (info->area.width == target->width && info->area.height == target->height);
  const gpu_rect area = whole ? (gpu_rect){.width = target->width, .height = target->height} : info->area;
  const D3D12_RECT rect = native_rect(&area);
  const bool clears_depth = target->depth.image && info->depth_load == GPU_LOAD_CLEAR;
  const bool fills_depth = clears_depth && d3d12_clears_by_copies(device, info->clear_depth);
  D3D12_CPU_DESCRIPTOR_HANDLE depth = {0}, color = {0};
  if (fills_depth)
    fill_depth(device, info, &area);
  use_attachment(device, &target->depth, whole && info->depth_load == GPU_LOAD_DISCARD,
                 D3D12_RESOURCE_STATE_DEPTH_WRITE);
  use_attachment(device, &target->color, whole && info->color_load == GPU_LOAD_DISCARD,
                 D3D12_RESOURCE_STATE_RENDER_TARGET);
  if (target->depth.image)
    depth = d3d12_depth_view(device, target->depth.heap, 0);
  if (target->color.image)
    color = ID3D12DescriptorHeap_GetCPUDescriptorHandleForHeapStart(target->color.heap);
  d3d12_settle_buffers(device);
  if (info->stores)
    d3d12_use_stores(device, info->stores);
  d3d12_flush_barriers(device);
  if (clears_depth && !fills_depth)
    ID3D12GraphicsCommandList_ClearDepthStencilView(device->list, depth, D3D12_CLEAR_FLAG_DEPTH, info->clear_depth, 0,
                                                    1, &rect);
  if (target->color.image && info->color_load == GPU_LOAD_CLEAR)
    ID3D12GraphicsCommandList_ClearRenderTargetView(device->list, color, info->clear_color, 1, &rect);
  device->target = target;
  ID3D12GraphicsCommandList_OMSetRenderTargets(device->list, target->color.image ? 1 : 0,
                                               target->color.image ? &color : NULL, FALSE,
                                               target->depth.image ? &depth : NULL);
  cover(device, info->clip_space.width ? &info->clip_space : &area, &area);
}

void d3d12_pass_area(gpu_device *device, const gpu_rect *area) {
  cover(device, area, area);
}

void d3d12_pass_end(gpu_device *device) {
  (void)device; /* the next barrier or target ends it */
}

/* ---- programs ---- */

void d3d12_pass_program(gpu_device *device, gpu_program *program) {
  ID3D12GraphicsCommandList_SetGraphicsRootSignature(device->list, program->signature);
  ID3D12GraphicsCommandList_SetPipelineState(device->list, program->pipeline);
  ID3D12GraphicsCommandList_IASetPrimitiveTopology(device->list, D3D_PRIMITIVE_TOPOLOGY_TRIANGLELIST);
  device->bound = (d3d12_bound){.program = program};
}

void d3d12_set_heap(gpu_device *device, const gpu_bindings *bindings) {
  ID3D12DescriptorHeap *heap = bindings->block->page->heap;
  if (device->heap != heap)
    ID3D12GraphicsCommandList_SetDescriptorHeaps(device->list, 1, &heap);
  device->heap = heap;
}

void d3d12_pass_bind(gpu_device *device, gpu_bindings *bindings, const uint32_t *offsets) {
  for (uint32_t i = 0; i < bindings->constants_count; i++)
    ID3D12GraphicsCommandList_SetGraphicsRootConstantBufferView(device->list, i,
                                                                bindings->info.constants[i]->address + offsets[i]);
  for (uint32_t i = 0; i < bindings->buffer_count; i++)
    d3d12_buffer_use_read(device, bindings->info.buffers[i].buffer, D3D12_STATE_READABLE);
  for (uint32_t i = 0; i < bindings->texel_buffer_count; i++)
    d3d12_buffer_use_read(device, bindings->info.texel_buffers[i], D3D12_STATE_READABLE);
  if (!bindings->block)
    return;
  d3d12_set_heap(device, bindings);
  ID3D12GraphicsCommandList_SetGraphicsRootDescriptorTable(device->list, bindings->constants_count, bindings->table);
}

void d3d12_pass_native(gpu_device *device, gpu_native_pass *out) {
  const gpu_target *target = device->target;
  *out = (gpu_native_pass){.command_buffer = device->list};
  if (target->depth.image)
    out->depth_view = d3d12_depth_view(device, target->depth.heap, 0).ptr;
  d3d12_target_native(device, target->depth.image ? target->depth.image->format : GPU_FORMAT_NONE,
                      target->color.image ? target->color.image->format : GPU_FORMAT_NONE, &out->target);
  device->heap = NULL; /* the engine sets its own */
}

/* ---- draws ---- */

/* Views hold 32-bit sizes. What lies beyond 4 GiB of a buffer cannot be drawn. */
static UINT view_size(const gpu_buffer *buffer, uint64_t offset) {
  const uint64_t size = buffer->size - offset;
  return size < UINT32_MAX ? (UINT)size : UINT32_MAX;
}

static void bind_stream(gpu_device *device, uint32_t index, gpu_buffer *buffer, uint64_t offset) {
  d3d12_bound *bound = &device->bound;
  if (bound->streams[index] == buffer && bound->stream_offsets[index] == offset)
    return;
  d3d12_buffer_use_read(device, buffer, D3D12_RESOURCE_STATE_VERTEX_AND_CONSTANT_BUFFER);
  const D3D12_VERTEX_BUFFER_VIEW view = {.BufferLocation = buffer->address + offset,
                                         .SizeInBytes = view_size(buffer, offset),
                                         .StrideInBytes = bound->program->strides[index]};
  ID3D12GraphicsCommandList_IASetVertexBuffers(device->list, index, 1, &view);
  bound->streams[index] = buffer;
  bound->stream_offsets[index] = offset;
}

/* Binds a buffer from its beginning, so that meshes in one page share the view; draws say where they start. */
static void bind_indices(gpu_device *device, gpu_buffer *buffer, uint32_t index_size) {
  d3d12_bound *bound = &device->bound;
  if (bound->indices == buffer && bound->index_size == index_size)
    return;
  d3d12_buffer_use_read(device, buffer, D3D12_RESOURCE_STATE_INDEX_BUFFER);
  const D3D12_INDEX_BUFFER_VIEW view = {.BufferLocation = buffer->address,
                                        .SizeInBytes = view_size(buffer, 0),
                                        .Format = index_size == 2 ? DXGI_FORMAT_R16_UINT : DXGI_FORMAT_R32_UINT};
  ID3D12GraphicsCommandList_IASetIndexBuffer(device->list, &view);
  bound->indices = buffer;
  bound->index_size = index_size;
}

static void draw_indirect(gpu_device *device, const gpu_draw *draw) {
  if (draw->indices)
    bind_indices(device, draw->indices, draw->index_size);
  d3d12_buffer_use_read(device, draw->arguments, D3D12_RESOURCE_STATE_INDIRECT_ARGUMENT);
  ID3D12GraphicsCommandList_ExecuteIndirect(device->list,
                                            device->command_signatures[draw->indices ? D3D12_DRAW_INDEXED : D3D12_DRAW],
                                            1, draw->arguments->resource.handle, draw->arguments_offset, NULL, 0);
}

void d3d12_pass_draw(gpu_device *device, const gpu_draw *draw) {
  for (uint32_t i = 0; i < device->bound.program->stream_count; i++)
    bind_stream(device, i, draw->streams[i], draw->stream_offsets[i]);
  if (draw->arguments) {
    draw_indirect(device, draw);
    return;
  }
  if (!draw->indices) {
    ID3D12GraphicsCommandList_DrawInstanced(device->list, draw->count, draw->instance_count, 0, 0);
    return;
  }
  bind_indices(device, draw->indices, draw->index_size);
  ID3D12GraphicsCommandList_DrawIndexedInstanced(device->list, draw->count, draw->instance_count,
                                                 (UINT)(draw->index_offset / draw->index_size), 0, 0);
}
