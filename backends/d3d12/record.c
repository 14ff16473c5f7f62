/*
 * record.c: recording. States are kept in the order of recording, across recordings, and barriers are gathered until
 * the next command that needs them. Images rest, between recordings, in the state that shaders read them in, and
 * buffers of the device's own memory in COMMON: Direct3D 12 lets them decay to it when a list has run, so it is the one
 * state that holds whether or not the next recording is in the same list. Draws promote them out of it, without a
 * barrier; vkd3d knows neither decay nor promotion, but the barriers that bring a buffer back order what follows.
 */
#include "internal.h"

#include <string.h>

static void flush_barriers(gpu_device *device) {
  if (device->barrier_count)
    ID3D12GraphicsCommandList_ResourceBarrier(device->list, device->barrier_count, device->barriers);
  device->barrier_count = 0;
}

static void barrier(gpu_device *device, const d3d12_resource *resource, D3D12_RESOURCE_STATES before,
                    D3D12_RESOURCE_STATES after) {
  if (device->barrier_count == D3D12_MAX_BARRIERS)
    flush_barriers(device);
  device->barriers[device->barrier_count++] = (D3D12_RESOURCE_BARRIER){
      .Type = D3D12_RESOURCE_BARRIER_TYPE_TRANSITION,
      .Transition = {.pResource = resource->handle,
                     .Subresource = D3D12_RESOURCE_BARRIER_ALL_SUBRESOURCES,
                     .StateBefore = before,
                     .StateAfter = after},
  };
}

/* Moves a whole resource to another state, with the next flush. */
static void transition(gpu_device *device, d3d12_resource *resource, D3D12_RESOURCE_STATES state) {
  if (resource->state != state)
    barrier(device, resource, resource->state, state);
  resource->state = state;
}

/* Remembers that `end` must bring the resource back to rest. */
static void touch(gpu_device *device, d3d12_resource *resource) {
  if (resource->touched)
    return;
  resource->touched = true;
  resource->next_touched = device->touched;
  device->touched = resource;
}

static void use_image(gpu_device *device, gpu_image *image, D3D12_RESOURCE_STATES state) {
  touch(device, &image->resource);
  transition(device, &image->resource, state);
}

void d3d12_marker_begin(gpu_device *device, const char *name) {
  if (device->traits->markers)
    ID3D12GraphicsCommandList_BeginEvent(device->list, 1, name, (UINT)strlen(name) + 1);
}

void d3d12_marker_end(gpu_device *device) {
  if (device->traits->markers)
    ID3D12GraphicsCommandList_EndEvent(device->list);
}

void d3d12_timestamp(gpu_device *device, uint32_t index) {
  flush_barriers(device);
  ID3D12GraphicsCommandList_EndQuery(device->list, device->queries, D3D12_QUERY_TYPE_TIMESTAMP,
                                     device->slot * GPU_MAX_TIMESTAMPS + index);
  if (device->timestamps_begin == device->timestamps_end)
    device->timestamps_begin = index;
  device->timestamps_end = index + 1;
}

/*
 * Makes a range of a buffer the next copy's destination. Two copies into one place get a way through another state
 * between them, which orders them everywhere. Readback buffers never leave theirs, so there the run time may want a
 * barrier from it to itself.
 */
static void use_copy_destination(gpu_device *device, gpu_buffer *buffer, uint64_t begin, uint64_t size) {
  const uint64_t end = begin + size;
  const bool overlaps = begin < buffer->copied_end && buffer->copied_begin < end;
  d3d12_resource *resource = &buffer->resource;
  if (buffer->kind == GPU_BUFFER_READBACK && overlaps && device->traits->self_barriers)
    barrier(device, resource, resource->state, resource->state);
  if (buffer->kind == GPU_BUFFER_DEVICE && overlaps)
    transition(device, resource, D3D12_STATE_GEOMETRY);
  if (overlaps || resource->state != D3D12_RESOURCE_STATE_COPY_DEST) {
    flush_barriers(device);
    buffer->copied_end = 0;
  }
  if (buffer->kind == GPU_BUFFER_DEVICE) {
    touch(device, resource);
    transition(device, resource, D3D12_RESOURCE_STATE_COPY_DEST);
  }
  if (buffer->copied_end == 0 || begin < buffer->copied_begin)
    buffer->copied_begin = begin;
  if (buffer->copied_end < end)
    buffer->copied_end = end;
}

void d3d12_copy_buffer(gpu_device *device, gpu_buffer *to, uint64_t to_offset, gpu_buffer *from, uint64_t from_offset,
                       uint64_t size) {
  use_copy_destination(device, to, to_offset, size);
  if (from->kind == GPU_BUFFER_DEVICE) {
    touch(device, &from->resource);
    transition(device, &from->resource, D3D12_RESOURCE_STATE_COPY_SOURCE);
  }
  flush_barriers(device);
  ID3D12GraphicsCommandList_CopyBufferRegion(device->list, to->resource.handle, to_offset, from->resource.handle,
                                             from_offset, size);
}

void d3d12_copy_image(gpu_device *device, gpu_buffer *to, uint64_t offset, uint32_t row_bytes, gpu_image *image,
                      const gpu_region *from) {
  const gpu_format format = image->info.format;
  const D3D12_TEXTURE_COPY_LOCATION source = {
      .pResource = image->resource.handle,
      .Type = D3D12_TEXTURE_COPY_TYPE_SUBRESOURCE_INDEX,
      .SubresourceIndex = from->layer,
  };
  const D3D12_TEXTURE_COPY_LOCATION destination = {
      .pResource = to->resource.handle,
      .Type = D3D12_TEXTURE_COPY_TYPE_PLACED_FOOTPRINT,
      .PlacedFootprint = {.Offset = offset,
                          .Footprint = {.Format = d3d12_resource_format(format),
                                        .Width = from->width,
                                        .Height = from->height,
                                        .Depth = 1,
                                        .RowPitch = row_bytes}},
  };
  const D3D12_BOX box = {
      .left = from->x, .top = from->y, .right = from->x + from->width, .bottom = from->y + from->height, .back = 1};
  use_copy_destination(device, to, offset, (uint64_t)row_bytes * from->height);
  use_image(device, image, D3D12_RESOURCE_STATE_COPY_SOURCE);
  flush_barriers(device);
  /* Depths take no box: a whole layer is all that may be copied of them. */
  ID3D12GraphicsCommandList_CopyTextureRegion(device->list, &destination, 0, 0, 0, &source,
                                              gpu_format_is_depth(format) ? NULL : &box);
}

void d3d12_copy_to_image(gpu_device *device, gpu_image *to, gpu_buffer *from, uint64_t offset, uint32_t row_bytes) {
  const gpu_image_info *info = &to->info;
  const D3D12_TEXTURE_COPY_LOCATION source = {
      .pResource = from->resource.handle,
      .Type = D3D12_TEXTURE_COPY_TYPE_PLACED_FOOTPRINT,
      .PlacedFootprint = {.Offset = offset,
                          .Footprint = {.Format = d3d12_format(info->format),
                                        .Width = info->width,
                                        .Height = info->height,
                                        .Depth = 1,
                                        .RowPitch = row_bytes}},
  };
  const D3D12_TEXTURE_COPY_LOCATION destination = {
      .pResource = to->resource.handle,
      .Type = D3D12_TEXTURE_COPY_TYPE_SUBRESOURCE_INDEX,
  };
  use_image(device, to, D3D12_RESOURCE_STATE_COPY_DEST);
  flush_barriers(device);
  ID3D12GraphicsCommandList_CopyTextureRegion(device->list, &destination, 0, 0, 0, &source, NULL);
}

/*
 * Clears by copies of the few rows in `fill`, which stay in the cache: 4 maps of 2048 x 2048 take 2.1 ms on lavapipe,
 * where vkd3d's ClearDepthStencilView, a render pass that loads with a clear, takes 5 to 8 ms, with one view of all
 * layers or one of each. On a GPU that view is the cheap way, for it keeps depth compressed.
 */
static void fill_layer(gpu_device *device, gpu_image *image, uint32_t layer, uint32_t part) {
  const uint32_t row_bytes = (image->info.width * gpu_format_bytes(image->info.format) + 255) & ~255u;
  const uint32_t strip = D3D12_FILL_SIZE / row_bytes;
  const D3D12_TEXTURE_COPY_LOCATION to = {
      .pResource = image->resource.handle,
      .Type = D3D12_TEXTURE_COPY_TYPE_SUBRESOURCE_INDEX,
      .SubresourceIndex = layer,
  };
  for (uint32_t row = 0; row < image->info.height; row += strip) {
    const uint32_t left = image->info.height - row;
    const D3D12_TEXTURE_COPY_LOCATION from = {
        .pResource = device->fill,
        .Type = D3D12_TEXTURE_COPY_TYPE_PLACED_FOOTPRINT,
        .PlacedFootprint = {.Offset = part * D3D12_FILL_SIZE,
                            .Footprint = {.Format = d3d12_resource_format(image->info.format),
                                          .Width = image->info.width,
                                          .Height = left < strip ? left : strip,
                                          .Depth = 1,
                                          .RowPitch = row_bytes}},
    };
    ID3D12GraphicsCommandList_CopyTextureRegion(device->list, &to, 0, row, 0, &from, NULL);
  }
}

void d3d12_clear_depth(gpu_device *device, gpu_image *image, float depth) {
  const bool copy = device->fill && (depth == 0 || depth == 1);
  use_image(device, image, copy ? D3D12_RESOURCE_STATE_COPY_DEST : D3D12_RESOURCE_STATE_DEPTH_WRITE);
  flush_barriers(device);
  if (!copy) {
    ID3D12GraphicsCommandList_ClearDepthStencilView(
        device->list, ID3D12DescriptorHeap_GetCPUDescriptorHandleForHeapStart(image->clear_heap),
        D3D12_CLEAR_FLAG_DEPTH, depth, 0, 0, NULL);
    return;
  }
  const uint32_t one = image->info.format == GPU_FORMAT_D16_UNORM ? D3D12_FILL_ONE_D16 : D3D12_FILL_ONE_D32;
  for (uint32_t layer = 0; layer < image->info.layers; ++layer)
    fill_layer(device, image, layer, depth == 1 ? one : D3D12_FILL_ZERO);
}

/* What was copied becomes readable: a pass may draw from it. Images never rest in COMMON. */
static void settle_buffers(gpu_device *device) {
  const D3D12_RESOURCE_STATES copied = D3D12_RESOURCE_STATE_COPY_DEST | D3D12_RESOURCE_STATE_COPY_SOURCE;
  for (d3d12_resource *resource = device->touched; resource; resource = resource->next_touched)
    if (resource->rest == D3D12_RESOURCE_STATE_COMMON && resource->state & copied)
      transition(device, resource, D3D12_STATE_GEOMETRY);
}

void d3d12_pass_begin(gpu_device *device, gpu_target *target) {
  D3D12_CPU_DESCRIPTOR_HANDLE depth = {0}, color = {0};
  if (target->depth) {
    use_image(device, target->depth, D3D12_RESOURCE_STATE_DEPTH_WRITE);
    depth = ID3D12DescriptorHeap_GetCPUDescriptorHandleForHeapStart(target->depth_heap);
  }
  if (target->color) {
    use_image(device, target->color, D3D12_RESOURCE_STATE_RENDER_TARGET);
    color = ID3D12DescriptorHeap_GetCPUDescriptorHandleForHeapStart(target->color_heap);
  }
  settle_buffers(device);
  flush_barriers(device);
  device->target = target;
  ID3D12GraphicsCommandList_OMSetRenderTargets(device->list, target->color ? 1 : 0, target->color ? &color : NULL,
                                               FALSE, target->depth ? &depth : NULL);
  d3d12_pass_area(device, &(gpu_rect){.width = target->width, .height = target->height});
}

void d3d12_pass_area(gpu_device *device, const gpu_rect *area) {
  const D3D12_VIEWPORT viewport = {.TopLeftX = (float)area->x,
                                   .TopLeftY = (float)area->y,
                                   .Width = (float)area->width,
                                   .Height = (float)area->height,
                                   .MaxDepth = 1};
  const D3D12_RECT scissor = {.left = (LONG)area->x,
                              .top = (LONG)area->y,
                              .right = (LONG)(area->x + area->width),
                              .bottom = (LONG)(area->y + area->height)};
  ID3D12GraphicsCommandList_RSSetViewports(device->list, 1, &viewport);
  ID3D12GraphicsCommandList_RSSetScissorRects(device->list, 1, &scissor);
}

void d3d12_pass_end(gpu_device *device) {
  (void)device; /* D3D12 has no passes: the next barrier or target ends this one */
}

void d3d12_pass_program(gpu_device *device, gpu_program *program) {
  ID3D12GraphicsCommandList_SetGraphicsRootSignature(device->list, program->signature);
  ID3D12GraphicsCommandList_SetPipelineState(device->list, program->pipeline);
  ID3D12GraphicsCommandList_IASetPrimitiveTopology(device->list, D3D_PRIMITIVE_TOPOLOGY_TRIANGLELIST);
  device->bound = (d3d12_bound){.program = program};
}

void d3d12_pass_bind(gpu_device *device, gpu_bindings *bindings, const uint32_t *offsets) {
  for (uint32_t i = 0; i < bindings->constants_count; ++i)
    ID3D12GraphicsCommandList_SetGraphicsRootConstantBufferView(device->list, i, bindings->constants[i] + offsets[i]);
  if (!bindings->has_textures)
    return;
  if (!device->descriptors_set)
    ID3D12GraphicsCommandList_SetDescriptorHeaps(device->list, 1, &device->descriptors);
  device->descriptors_set = true;
  ID3D12GraphicsCommandList_SetGraphicsRootDescriptorTable(device->list, bindings->constants_count, bindings->textures);
}

void d3d12_pass_native(gpu_device *device, gpu_native_pass *out) {
  const gpu_target *target = device->target;
  *out = (gpu_native_pass){.command_buffer = device->list};
  if (target->depth) {
    out->depth_view = ID3D12DescriptorHeap_GetCPUDescriptorHandleForHeapStart(target->depth_heap).ptr;
    out->depth_format = d3d12_format(target->depth->info.format);
  }
  device->descriptors_set = false; /* the engine sets its own */
}

/* A draw promotes a buffer of the device's own memory to a state that it reads it in. */
static void read_geometry(gpu_device *device, gpu_buffer *buffer, D3D12_RESOURCE_STATES state) {
  if (buffer->kind != GPU_BUFFER_DEVICE || buffer->imported)
    return;
  touch(device, &buffer->resource);
  buffer->resource.state |= state;
}

/* Views hold 32-bit sizes; what lies beyond is out of reach of 32-bit indices of the caller's. */
static UINT view_size(const gpu_buffer *buffer, uint64_t offset) {
  const uint64_t size = buffer->size - offset;
  return size < UINT32_MAX ? (UINT)size : UINT32_MAX;
}

static void bind_stream(gpu_device *device, uint32_t index, gpu_buffer *buffer, uint64_t offset) {
  d3d12_bound *bound = &device->bound;
  if (bound->streams[index] == buffer && bound->stream_offsets[index] == offset)
    return;
  read_geometry(device, buffer, D3D12_RESOURCE_STATE_VERTEX_AND_CONSTANT_BUFFER);
  const D3D12_VERTEX_BUFFER_VIEW view = {
      .BufferLocation = buffer->address + offset,
      .SizeInBytes = view_size(buffer, offset),
      .StrideInBytes = bound->program->strides[index],
  };
  ID3D12GraphicsCommandList_IASetVertexBuffers(device->list, index, 1, &view);
  bound->streams[index] = buffer;
  bound->stream_offsets[index] = offset;
}

/* Binds a buffer from its beginning, so that meshes in one page share the view; draws say where they start. */
static void bind_indices(gpu_device *device, gpu_buffer *buffer, uint32_t index_size) {
  d3d12_bound *bound = &device->bound;
  if (bound->indices == buffer && bound->index_size == index_size)
    return;
  read_geometry(device, buffer, D3D12_RESOURCE_STATE_INDEX_BUFFER);
  const D3D12_INDEX_BUFFER_VIEW view = {
      .BufferLocation = buffer->address,
      .SizeInBytes = view_size(buffer, 0),
      .Format = index_size == 2 ? DXGI_FORMAT_R16_UINT : DXGI_FORMAT_R32_UINT,
  };
  ID3D12GraphicsCommandList_IASetIndexBuffer(device->list, &view);
  bound->indices = buffer;
  bound->index_size = index_size;
}

void d3d12_pass_draw(gpu_device *device, const gpu_draw *draw) {
  for (uint32_t i = 0; i < device->bound.program->stream_count; ++i)
    bind_stream(device, i, draw->streams[i], draw->stream_offsets[i]);
  if (!draw->indices) {
    ID3D12GraphicsCommandList_DrawInstanced(device->list, draw->count, draw->instance_count, 0, 0);
    return;
  }
  bind_indices(device, draw->indices, draw->index_size);
  ID3D12GraphicsCommandList_DrawIndexedInstanced(device->list, draw->count, draw->instance_count,
                                                 (UINT)(draw->index_offset / draw->index_size), 0, 0);
}

void d3d12_make_readable(gpu_device *device, gpu_image *image) {
  use_image(device, image, D3D12_STATE_READABLE);
}

/* Brings everything back to rest, and makes what was copied readable on the way. */
void d3d12_rest(gpu_device *device) {
  settle_buffers(device);
  flush_barriers(device);
  for (d3d12_resource *resource = device->touched, *next; resource; resource = next) {
    next = resource->next_touched;
    transition(device, resource, resource->rest);
    resource->touched = false;
  }
  device->touched = NULL;
  flush_barriers(device);
}
