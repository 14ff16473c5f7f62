/* rig_d3d12_resources.c: a Direct3D 12 engine's buffers and images. */
#include "rig_d3d12.h"

#include <stdlib.h>
#include <string.h>

enum { ROW = 256 /* copied rows begin at multiples of it */ };

/* ---- buffers ---- */

rig_buffer rig_d3d12_buffer(rig *rig, D3D12_HEAP_TYPE heap, uint64_t size) {
  const D3D12_HEAP_PROPERTIES properties = {.Type = heap};
  const D3D12_RESOURCE_DESC description = {
      .Dimension = D3D12_RESOURCE_DIMENSION_BUFFER,
      .Width = size,
      .Height = 1,
      .DepthOrArraySize = 1,
      .MipLevels = 1,
      .SampleDesc = {.Count = 1},
      .Layout = D3D12_TEXTURE_LAYOUT_ROW_MAJOR,
  };
  const D3D12_RESOURCE_STATES state =
      heap == D3D12_HEAP_TYPE_READBACK ? D3D12_RESOURCE_STATE_COPY_DEST : D3D12_RESOURCE_STATE_GENERIC_READ;
  ID3D12Resource *resource;
  rig_buffer buffer = {.size = size};
  rig_d3d12_must(ID3D12Device_CreateCommittedResource(rig->device, &properties, D3D12_HEAP_FLAG_NONE, &description,
                                                      state, NULL, &IID_ID3D12Resource, (void **)&resource),
                 "a buffer");
  rig_d3d12_must(ID3D12Resource_Map(resource, 0, NULL, &buffer.mapped), "mapping a buffer");
  memset(buffer.mapped, 0, size);
  buffer.object = resource;
  return buffer;
}

rig_buffer rig_buffer_make(rig *rig, rig_buffer_use use, uint64_t size) {
  return rig_d3d12_buffer(rig, use == RIG_READBACK ? D3D12_HEAP_TYPE_READBACK : D3D12_HEAP_TYPE_UPLOAD, size);
}

void rig_buffer_free(rig *rig, rig_buffer *buffer) {
  (void)rig;
  const uint32_t references = buffer->object ? ID3D12Resource_Release((ID3D12Resource *)buffer->object) : 0;
  *buffer = (rig_buffer){0};
  assert_int_equal(references, 0);
}

void rig_mesh_give(const rig_mesh *mesh, rig_native *native, csm_mesh_info *info) {
  native->d3d12_mesh = (csm_d3d12_mesh){.struct_size = sizeof native->d3d12_mesh,
                                        .vertex_stride = mesh->vertex_stride,
                                        .vertices = mesh->vertices->object,
                                        .vertex_offset = mesh->vertex_offset,
                                        .indices = mesh->indices->object,
                                        .index_offset = mesh->index_offset};
  info->d3d12 = &native->d3d12_mesh;
}

/* ---- images ---- */

struct rig_image {
  ID3D12Resource *resource;
  csm_d3d12_image native;
};

/* What an image is made with, and viewed with. */
typedef struct image_kind {
  DXGI_FORMAT format, view;
  D3D12_RESOURCE_FLAGS flags;
} image_kind;

static const image_kind depth_kinds[] = {
    {DXGI_FORMAT_R32_FLOAT, DXGI_FORMAT_R32_FLOAT, D3D12_RESOURCE_FLAG_NONE},
    {DXGI_FORMAT_R32_TYPELESS, DXGI_FORMAT_R32_FLOAT, D3D12_RESOURCE_FLAG_ALLOW_DEPTH_STENCIL}};
const uint32_t rig_depth_ways = sizeof depth_kinds / sizeof depth_kinds[0];

static const DXGI_FORMAT formats[] = {
    [RIG_RGBA_FLOAT_32] = DXGI_FORMAT_R32G32B32A32_FLOAT, [RIG_RGBA_FLOAT_16] = DXGI_FORMAT_R16G16B16A16_FLOAT,
    [RIG_RGBA_SNORM_16] = DXGI_FORMAT_R16G16B16A16_SNORM, [RIG_RGBA_UNORM_16] = DXGI_FORMAT_R16G16B16A16_UNORM,
    [RIG_RGBA_UNORM_8] = DXGI_FORMAT_R8G8B8A8_UNORM,      [RIG_RG_FLOAT_32] = DXGI_FORMAT_R32G32_FLOAT,
    [RIG_RG_FLOAT_16] = DXGI_FORMAT_R16G16_FLOAT};

void rig_d3d12_barrier(ID3D12GraphicsCommandList *list, ID3D12Resource *resource, D3D12_RESOURCE_STATES before,
                       D3D12_RESOURCE_STATES after) {
  const D3D12_RESOURCE_BARRIER barrier = {
      .Type = D3D12_RESOURCE_BARRIER_TYPE_TRANSITION,
      .Transition = {.pResource = resource,
                     .Subresource = D3D12_RESOURCE_BARRIER_ALL_SUBRESOURCES,
                     .StateBefore = before,
                     .StateAfter = after},
  };
  ID3D12GraphicsCommandList_ResourceBarrier(list, 1, &barrier);
}

/* How an image's texels lie in a buffer. */
static D3D12_TEXTURE_COPY_LOCATION in_buffer(const rig_buffer *buffer, uint64_t offset, ID3D12Resource *image,
                                             uint32_t texel_bytes) {
  const D3D12_RESOURCE_DESC description = ID3D12Resource_GetDesc(image);
  return (D3D12_TEXTURE_COPY_LOCATION){
      .pResource = buffer->object,
      .Type = D3D12_TEXTURE_COPY_TYPE_PLACED_FOOTPRINT,
      .PlacedFootprint = {.Offset = offset,
                          .Footprint = {.Format = description.Format,
                                        .Width = (UINT)description.Width,
                                        .Height = description.Height,
                                        .Depth = 1,
                                        .RowPitch = rig_pitch((uint32_t)description.Width, texel_bytes)}},
  };
}

static void upload(rig *rig, ID3D12Resource *image, uint32_t texel_bytes, const void *texels) {
  const D3D12_RESOURCE_DESC description = ID3D12Resource_GetDesc(image);
  const size_t row = (size_t)description.Width * texel_bytes;
  const uint32_t pitch = rig_pitch((uint32_t)description.Width, texel_bytes);
  rig_buffer staging = rig_d3d12_buffer(rig, D3D12_HEAP_TYPE_UPLOAD, (uint64_t)pitch * description.Height);
  for (uint32_t y = 0; y < description.Height; ++y)
    memcpy((char *)staging.mapped + (size_t)y * pitch, (const char *)texels + y * row, row);
  rig_run(rig, rig->frame);
  ID3D12GraphicsCommandList *list = rig_begin(rig);
  const D3D12_TEXTURE_COPY_LOCATION to = {.pResource = image, .Type = D3D12_TEXTURE_COPY_TYPE_SUBRESOURCE_INDEX};
  const D3D12_TEXTURE_COPY_LOCATION from = in_buffer(&staging, 0, image, texel_bytes);
  ID3D12GraphicsCommandList_CopyTextureRegion(list, &to, 0, 0, 0, &from, NULL);
  rig_d3d12_barrier(list, image, D3D12_RESOURCE_STATE_COPY_DEST, D3D12_RESOURCE_STATE_PIXEL_SHADER_RESOURCE);
  rig_end(rig);
  rig_run(rig, rig->frame);
  rig_buffer_free(rig, &staging);
}

ID3D12Resource *rig_d3d12_image(rig *rig, const D3D12_RESOURCE_DESC *description, uint32_t texel_bytes,
                                const void *texels) {
  const D3D12_HEAP_PROPERTIES properties = {.Type = D3D12_HEAP_TYPE_DEFAULT};
  D3D12_RESOURCE_DESC complete = *description;
  complete.Dimension = D3D12_RESOURCE_DIMENSION_TEXTURE2D;
  complete.DepthOrArraySize = complete.MipLevels = 1;
  complete.SampleDesc.Count = 1;
  ID3D12Resource *image;
  rig_d3d12_must(ID3D12Device_CreateCommittedResource(rig->device, &properties, D3D12_HEAP_FLAG_NONE, &complete,
                                                      D3D12_RESOURCE_STATE_COPY_DEST, NULL, &IID_ID3D12Resource,
                                                      (void **)&image),
                 "an image");
  upload(rig, image, texel_bytes, texels);
  return image;
}

rig_image *rig_image_make(rig *rig, const rig_image_info *info) {
  const image_kind kind = info->format == RIG_DEPTH_32
                              ? depth_kinds[info->way]
                              : (image_kind){formats[info->format], formats[info->format], D3D12_RESOURCE_FLAG_NONE};
  const D3D12_RESOURCE_DESC description = {
      .Width = info->width, .Height = info->height, .Format = kind.format, .Flags = kind.flags};
  rig_image *image = calloc(1, sizeof *image);
  assert_non_null(image);
  image->resource = rig_d3d12_image(rig, &description, rig_texel_bytes(info->format), info->texels);
  image->native = (csm_d3d12_image){.struct_size = sizeof image->native,
                                    .format = kind.view,
                                    .resource = image->resource,
                                    .width = info->width,
                                    .height = info->height};
  return image;
}

void rig_image_free(rig *rig, rig_image *image) {
  (void)rig;
  const uint32_t references = ID3D12Resource_Release(image->resource);
  free(image);
  assert_int_equal(references, 0);
}

const void *rig_image_native(const rig_image *image) {
  return &image->native;
}

ID3D12Resource *rig_d3d12_resource(const rig_image *image) {
  return image->resource;
}

/* ---- reading what csm drew ---- */

uint32_t rig_pitch(uint32_t width, uint32_t texel_bytes) {
  return (width * texel_bytes + ROW - 1) / ROW * ROW;
}

void rig_copy(rig *rig, const rig_layer *from, const rig_buffer *to, uint64_t offset) {
  ID3D12GraphicsCommandList *list = rig_commands(rig);
  ID3D12Resource *image = (ID3D12Resource *)(uintptr_t)from->image;
  const D3D12_TEXTURE_COPY_LOCATION source = {
      .pResource = image, .Type = D3D12_TEXTURE_COPY_TYPE_SUBRESOURCE_INDEX, .SubresourceIndex = from->layer};
  const D3D12_TEXTURE_COPY_LOCATION destination = in_buffer(to, offset, image, from->texel_bytes);
  const D3D12_RESOURCE_STATES readable =
      D3D12_RESOURCE_STATE_PIXEL_SHADER_RESOURCE | D3D12_RESOURCE_STATE_NON_PIXEL_SHADER_RESOURCE;
  rig_d3d12_barrier(list, image, readable, D3D12_RESOURCE_STATE_COPY_SOURCE);
  ID3D12GraphicsCommandList_CopyTextureRegion(list, &destination, 0, 0, 0, &source, NULL);
  rig_d3d12_barrier(list, image, D3D12_RESOURCE_STATE_COPY_SOURCE, readable);
}
