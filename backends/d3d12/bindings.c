/*
 * bindings.c: what programs read and write. Root parameters are a constant buffer each for b0 and on, then one table
 * with all else, which points to a block of descriptors. Samplers are static.
 */
#include "internal.h"

enum { TABLE_RANGES = 5 };

/* ---- root signatures ---- */

/* The ranges of the table that hold anything, without gaps between them. */
static uint32_t table_ranges(const gpu_program_info *info, D3D12_DESCRIPTOR_RANGE *out) {
  const D3D12_DESCRIPTOR_RANGE ranges[] = {
      {.RangeType = D3D12_DESCRIPTOR_RANGE_TYPE_SRV, .NumDescriptors = info->texture_count},
      {.RangeType = D3D12_DESCRIPTOR_RANGE_TYPE_SRV,
       .NumDescriptors = info->buffer_count,
       .BaseShaderRegister = GPU_FIRST_BUFFER},
      {.RangeType = D3D12_DESCRIPTOR_RANGE_TYPE_SRV,
       .NumDescriptors = info->texel_buffer_count,
       .BaseShaderRegister = GPU_FIRST_TEXEL_BUFFER},
      {.RangeType = D3D12_DESCRIPTOR_RANGE_TYPE_UAV, .NumDescriptors = info->store_image_count},
      {.RangeType = D3D12_DESCRIPTOR_RANGE_TYPE_UAV,
       .NumDescriptors = info->store_buffer_count,
       .BaseShaderRegister = GPU_FIRST_STORE_BUFFER},
  };
  uint32_t count = 0, place = 0;
  for (uint32_t i = 0; i < TABLE_RANGES; i++) {
    if (!ranges[i].NumDescriptors)
      continue;
    out[count] = ranges[i];
    out[count++].OffsetInDescriptorsFromTableStart = place;
    place += ranges[i].NumDescriptors;
  }
  return count;
}

static HRESULT serialize(const gpu_device *device, const D3D12_ROOT_SIGNATURE_DESC *signature, ID3DBlob **out) {
  return device->own ? d3d12_runtime_serialize(device->runtime, signature, out)
                     : device->serialize(signature, D3D_ROOT_SIGNATURE_VERSION_1_0, out, NULL);
}

csm_result d3d12_signature_create(gpu_device *device, gpu_program *program, const gpu_program_info *info) {
  D3D12_ROOT_PARAMETER parameters[GPU_MAX_CONSTANTS + 1];
  D3D12_STATIC_SAMPLER_DESC samplers[GPU_MAX_SAMPLERS];
  D3D12_DESCRIPTOR_RANGE ranges[TABLE_RANGES];
  const uint32_t range_count = table_ranges(info, ranges);
  uint32_t count = 0;
  for (; count < info->constants_count; count++)
    parameters[count] = (D3D12_ROOT_PARAMETER){.ParameterType = D3D12_ROOT_PARAMETER_TYPE_CBV,
                                               .Descriptor = {.ShaderRegister = count},
                                               .ShaderVisibility = D3D12_SHADER_VISIBILITY_ALL};
  if (range_count)
    parameters[count++] =
        (D3D12_ROOT_PARAMETER){.ParameterType = D3D12_ROOT_PARAMETER_TYPE_DESCRIPTOR_TABLE,
                               .DescriptorTable = {.NumDescriptorRanges = range_count, .pDescriptorRanges = ranges},
                               .ShaderVisibility = D3D12_SHADER_VISIBILITY_ALL};
  for (uint32_t i = 0; i < info->sampler_count; i++)
    samplers[i] = d3d12_sampler(device, info->samplers[i], i);
  const D3D12_ROOT_SIGNATURE_DESC signature = {
      .NumParameters = count,
      .pParameters = parameters,
      .NumStaticSamplers = info->sampler_count,
      .pStaticSamplers = samplers,
      .Flags = info->compute.dxbc_size ? D3D12_ROOT_SIGNATURE_FLAG_NONE
                                       : D3D12_ROOT_SIGNATURE_FLAG_ALLOW_INPUT_ASSEMBLER_INPUT_LAYOUT};
  ID3DBlob *blob = NULL;
  HRESULT hr = serialize(device, &signature, &blob);
  if (FAILED(hr))
    return d3d12_check(device, hr, "D3D12SerializeRootSignature");
  hr = ID3D12Device_CreateRootSignature(device->handle, 0, ID3D10Blob_GetBufferPointer(blob),
                                        ID3D10Blob_GetBufferSize(blob), &IID_ID3D12RootSignature,
                                        (void **)&program->signature);
  ID3D10Blob_Release(blob);
  return d3d12_check(device, hr, "CreateRootSignature");
}

/* ---- descriptors ---- */

/* Of the first page. Each other one has twice as many as the one before it, up to a power of two that every device can
   make: 1,000,000 is the least of the limits. */
enum { FIRST_PAGE = 1 << 14, LARGEST_PAGE = 1 << 19 };

static csm_result page_create(gpu_device *device, uint32_t size) {
  const D3D12_DESCRIPTOR_HEAP_DESC heap = {.Type = D3D12_DESCRIPTOR_HEAP_TYPE_CBV_SRV_UAV,
                                           .NumDescriptors = size,
                                           .Flags = D3D12_DESCRIPTOR_HEAP_FLAG_SHADER_VISIBLE};
  d3d12_page *page = lent_allocate(&device->lent, sizeof *page);
  if (!page)
    return CSM_ERROR_OUT_OF_MEMORY;
  const csm_result result = d3d12_check(
      device, ID3D12Device_CreateDescriptorHeap(device->handle, &heap, &IID_ID3D12DescriptorHeap, (void **)&page->heap),
      "CreateDescriptorHeap");
  if (result != CSM_SUCCESS) {
    lent_release(&device->lent, page);
    return result;
  }
  page->size = size;
  page->next = device->pages;
  device->pages = page;
  return CSM_SUCCESS;
}

csm_result d3d12_descriptors_create(gpu_device *device) {
  device->descriptor_size =
      ID3D12Device_GetDescriptorHandleIncrementSize(device->handle, D3D12_DESCRIPTOR_HEAP_TYPE_CBV_SRV_UAV);
  return page_create(device, FIRST_PAGE);
}

void d3d12_descriptors_destroy(gpu_device *device) {
  for (uint32_t size = 0; size <= D3D12_MAX_BLOCK; size++)
    for (d3d12_block *block = device->free_blocks[size], *next; block; block = next) {
      next = block->next;
      lent_release(&device->lent, block);
    }
  for (d3d12_page *page = device->pages, *next; page; page = next) {
    next = page->next;
    d3d12_unref(page->heap);
    lent_release(&device->lent, page);
  }
}

/* Programs have few shapes, so blocks that come back are used again whole. */
static csm_result block_take(gpu_device *device, uint32_t size, d3d12_block **out) {
  d3d12_block *block = device->free_blocks[size];
  if (block) {
    device->free_blocks[size] = block->next;
    *out = block;
    return CSM_SUCCESS;
  }
  const uint32_t last = device->pages->size;
  if (last - device->pages->taken < size) {
    const csm_result result = page_create(device, last < LARGEST_PAGE ? 2 * last : last);
    if (result != CSM_SUCCESS)
      return result;
  }
  block = lent_allocate(&device->lent, sizeof *block);
  if (!block)
    return CSM_ERROR_OUT_OF_MEMORY;
  *block = (d3d12_block){.page = device->pages, .first = device->pages->taken, .size = size};
  device->pages->taken += size;
  *out = block;
  return CSM_SUCCESS;
}

static void block_give_back(gpu_device *device, d3d12_block *block) {
  block->next = device->free_blocks[block->size];
  device->free_blocks[block->size] = block;
}

/* ---- bindings ---- */

static uint64_t part_size(const gpu_buffer_part *part) {
  return part->size ? part->size : part->buffer->size - part->offset;
}

static void write_buffer(gpu_device *device, const gpu_buffer_part *part, D3D12_CPU_DESCRIPTOR_HANDLE descriptor) {
  const uint32_t element = part->stride ? part->stride : 4;
  const D3D12_SHADER_RESOURCE_VIEW_DESC view = {
      .Format = part->stride ? DXGI_FORMAT_UNKNOWN : DXGI_FORMAT_R32_TYPELESS,
      .ViewDimension = D3D12_SRV_DIMENSION_BUFFER,
      .Shader4ComponentMapping = D3D12_DEFAULT_SHADER_4_COMPONENT_MAPPING,
      .Buffer = {.FirstElement = part->offset / element,
                 .NumElements = (UINT)(part_size(part) / element),
                 .StructureByteStride = part->stride,
                 .Flags = part->stride ? D3D12_BUFFER_SRV_FLAG_NONE : D3D12_BUFFER_SRV_FLAG_RAW}};
  ID3D12Device_CreateShaderResourceView(device->handle, part->buffer->resource.handle, &view, descriptor);
}

static void write_texel_buffer(gpu_device *device, const gpu_buffer *buffer, D3D12_CPU_DESCRIPTOR_HANDLE descriptor) {
  const D3D12_SHADER_RESOURCE_VIEW_DESC view = {.Format = DXGI_FORMAT_R32G32B32A32_UINT,
                                                .ViewDimension = D3D12_SRV_DIMENSION_BUFFER,
                                                .Shader4ComponentMapping = D3D12_DEFAULT_SHADER_4_COMPONENT_MAPPING,
                                                .Buffer = {.NumElements = (UINT)(buffer->size / GPU_TEXEL_SIZE)}};
  ID3D12Device_CreateShaderResourceView(device->handle, buffer->resource.handle, &view, descriptor);
}

static void write_store_buffer(gpu_device *device, const gpu_buffer_part *part,
                               D3D12_CPU_DESCRIPTOR_HANDLE descriptor) {
  const D3D12_UNORDERED_ACCESS_VIEW_DESC view = {.ViewDimension = D3D12_UAV_DIMENSION_BUFFER,
                                                 .Buffer = {.FirstElement = part->offset / part->stride,
                                                            .NumElements = (UINT)(part_size(part) / part->stride),
                                                            .StructureByteStride = part->stride}};
  ID3D12Device_CreateUnorderedAccessView(device->handle, part->buffer->resource.handle, NULL, &view, descriptor);
}

void d3d12_bindings_write(gpu_device *device, gpu_bindings *bindings, const gpu_bindings_info *info) {
  bindings->info = *info;
  bindings->info.name = NULL;
  bindings->info.program = NULL;
  if (!bindings->block)
    return;
  D3D12_CPU_DESCRIPTOR_HANDLE place =
      ID3D12DescriptorHeap_GetCPUDescriptorHandleForHeapStart(bindings->block->page->heap);
  const SIZE_T step = device->descriptor_size;
  place.ptr += bindings->block->first * step;
  for (uint32_t i = 0; i < bindings->texture_count; i++, place.ptr += step)
    if (info->texture_views[i])
      d3d12_view_read(device, info->texture_views[i], place);
    else
      d3d12_image_describe(device, info->textures[i], place.ptr);
  for (uint32_t i = 0; i < bindings->buffer_count; i++, place.ptr += step)
    write_buffer(device, &info->buffers[i], place);
  for (uint32_t i = 0; i < bindings->texel_buffer_count; i++, place.ptr += step)
    write_texel_buffer(device, info->texel_buffers[i], place);
  for (uint32_t i = 0; i < bindings->store_image_count; i++, place.ptr += step)
    d3d12_view_store(device, info->store_images[i], place);
  for (uint32_t i = 0; i < bindings->store_buffer_count; i++, place.ptr += step)
    write_store_buffer(device, &info->store_buffers[i], place);
}

csm_result d3d12_bindings_create(gpu_device *device, const gpu_bindings_info *info, gpu_bindings **out) {
  *out = NULL;
  const gpu_program *program = info->program;
  const uint32_t size = program->texture_count + program->buffer_count + program->texel_buffer_count +
                        program->store_image_count + program->store_buffer_count;
  gpu_bindings *bindings = lent_allocate(&device->lent, sizeof *bindings);
  if (!bindings)
    return CSM_ERROR_OUT_OF_MEMORY;
  bindings->constants_count = program->constants_count;
  bindings->texture_count = program->texture_count;
  bindings->buffer_count = program->buffer_count;
  bindings->texel_buffer_count = program->texel_buffer_count;
  bindings->store_image_count = program->store_image_count;
  bindings->store_buffer_count = program->store_buffer_count;
  if (size) {
    const csm_result result = block_take(device, size, &bindings->block);
    if (result != CSM_SUCCESS) {
      lent_release(&device->lent, bindings);
      return result;
    }
    bindings->table = ID3D12DescriptorHeap_GetGPUDescriptorHandleForHeapStart(bindings->block->page->heap);
    bindings->table.ptr += (UINT64)bindings->block->first * device->descriptor_size;
  }
  d3d12_bindings_write(device, bindings, info);
  *out = bindings;
  return CSM_SUCCESS;
}

void d3d12_bindings_destroy(gpu_device *device, gpu_bindings *bindings) {
  if (!bindings)
    return;
  if (bindings->block)
    block_give_back(device, bindings->block);
  lent_release(&device->lent, bindings);
}
