/*
 * d3d12_base.h: what every Direct3D 12 engine has below its renderer: a device with its queue, buffers, images and
 * pipelines. The device is vkd3d's; only d3d12_open and the waiting know that. Every failure ends the program.
 */
#ifndef EXAMPLE_D3D12_BASE_H
#define EXAMPLE_D3D12_BASE_H

#define COBJMACROS
#define WIDL_C_INLINE_WRAPPERS
#include <vkd3d.h>
#include <vkd3d_utils.h>

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct d3d12_base {
  struct vkd3d_instance *instance;
  VkDebugUtilsMessengerEXT messenger; /* while validating */
  uint32_t messages;                  /* warnings and errors of the validation layer */
  ID3D12Device *device;
  ID3D12CommandQueue *queue;
  ID3D12Fence *fence; /* its value is the number of the last frame that the GPU has finished */
  HANDLE event;
  char name[256]; /* of the device */
} d3d12_base;

typedef struct d3d12_pipeline_info {
  ID3D12RootSignature *signature;
  const void *vertex_code, *pixel_code; /* pixel_code may be NULL: depth alone */
  size_t vertex_size, pixel_size;       /* bytes */
  const D3D12_INPUT_ELEMENT_DESC *elements;
  uint32_t element_count;
  DXGI_FORMAT color_format, depth_format; /* color_format UNKNOWN: none */
  D3D12_CULL_MODE cull;
  D3D12_COMPARISON_FUNC depth_compare;
  bool depth_clip;
} d3d12_pipeline_info;

/* Ends the program, naming what failed. */
void d3d12_check(HRESULT result, const char *what);

/* Opens a device with one queue; `validate` turns the Khronos layer on below vkd3d, core and synchronization. */
void d3d12_open(d3d12_base *out, bool validate);
void d3d12_close(d3d12_base *base);

/* Waits until the GPU has finished a frame. */
void d3d12_wait(const d3d12_base *base, uint64_t frame);

/* In an upload heap, which a larger engine would copy from for what stays, or in a readback heap. */
ID3D12Resource *d3d12_buffer_create(const d3d12_base *base, D3D12_HEAP_TYPE heap, uint64_t size);
/* Maps it for good, which both heaps allow. */
void *d3d12_buffer_map(ID3D12Resource *buffer);

ID3D12Resource *d3d12_image_create(const d3d12_base *base, DXGI_FORMAT format, uint32_t width, uint32_t height,
                                   D3D12_RESOURCE_FLAGS flags, D3D12_RESOURCE_STATES state,
                                   const D3D12_CLEAR_VALUE *clear);

ID3D12DescriptorHeap *d3d12_heap_create(const d3d12_base *base, D3D12_DESCRIPTOR_HEAP_TYPE type, uint32_t count,
                                        bool shader_visible);

/* Triangles face the viewer counter-clockwise. */
ID3D12PipelineState *d3d12_pipeline_create(const d3d12_base *base, const d3d12_pipeline_info *info);

void d3d12_transition(ID3D12GraphicsCommandList *list, ID3D12Resource *resource, D3D12_RESOURCE_STATES before,
                      D3D12_RESOURCE_STATES after);

#endif
