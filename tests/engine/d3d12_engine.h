/*
 * d3d12_engine.h: as much of an engine as tests need: an ID3D12Device of its own on vkd3d, with validation, frames in
 * flight, images and buffers. What must not fail ends the program with a text.
 */
#ifndef D3D12_ENGINE_H
#define D3D12_ENGINE_H

#define COBJMACROS
#define WIDL_C_INLINE_WRAPPERS
#include <vkd3d_utils.h>
/* after it, for it decides whether prototypes are there */
#include <vkd3d.h>

#include "csm/csm_d3d12.h"
#include <stdbool.h>

enum { D3D12_ENGINE_FRAMES = 3, D3D12_ENGINE_LISTS = 2, D3D12_ENGINE_ROW = 256 /* copied rows begin at multiples */ };

typedef struct d3d12_engine {
  struct vkd3d_instance *instance;
  VkDebugUtilsMessengerEXT messenger;
  uint32_t messages; /* errors and warnings of validation, which are printed */
  ID3D12Device *device;
  ID3D12CommandQueue *queue;
  ID3D12Fence *fence;
  HANDLE event;
  csm_d3d12_device native; /* what csm gets */

  /* frames, by number modulo D3D12_ENGINE_FRAMES */
  struct {
    ID3D12CommandAllocator *allocators[D3D12_ENGINE_LISTS];
    ID3D12GraphicsCommandList *lists[D3D12_ENGINE_LISTS];
    uint32_t list_count;
  } frames[D3D12_ENGINE_FRAMES];
  uint64_t frame; /* the last that was begun, from 1 */
  uint64_t done;  /* the last that the GPU is done with */
} d3d12_engine;

void d3d12_engine_open(d3d12_engine *engine);
/* Fails if anything but the engine still holds its device. */
void d3d12_engine_close(d3d12_engine *engine);

/* Begins the next frame's list; goes on in a second list, submitted on its own; ends the frame. Nothing is submitted
   yet, so csm cannot count on its being done. */
ID3D12GraphicsCommandList *d3d12_engine_begin(d3d12_engine *engine);
ID3D12GraphicsCommandList *d3d12_engine_split(d3d12_engine *engine);
void d3d12_engine_end(d3d12_engine *engine);
/* Submits the frames up to and with `frame`, in their order, and waits for them. */
void d3d12_engine_run(d3d12_engine *engine, uint64_t frame);

/* A mapped buffer, for vertices, indices and constants, or to copy into; data may be NULL. */
ID3D12Resource *d3d12_engine_buffer(d3d12_engine *engine, D3D12_HEAP_TYPE heap, uint64_t size, const void *data);
void *d3d12_engine_map(ID3D12Resource *buffer);

/* A 2D image to sample, of tightly packed texels, resting readable by pixel shaders. Runs all frames. */
ID3D12Resource *d3d12_engine_image(d3d12_engine *engine, DXGI_FORMAT format, D3D12_RESOURCE_FLAGS flags, uint32_t width,
                                   uint32_t height, uint32_t texel_bytes, const void *texels);

/* Copies a layer of an image that is readable by all shaders, as csm's are, into a readback buffer at `offset`; rows
   lie D3D12_ENGINE_ROW apart or a multiple. */
void d3d12_engine_copy(ID3D12GraphicsCommandList *list, ID3D12Resource *from, uint32_t layer, uint32_t texel_bytes,
                       ID3D12Resource *to, uint64_t offset);
/* Bytes from one copied row to the next. */
uint32_t d3d12_engine_pitch(uint32_t width, uint32_t texel_bytes);

void d3d12_engine_barrier(ID3D12GraphicsCommandList *list, ID3D12Resource *resource, D3D12_RESOURCE_STATES before,
                          D3D12_RESOURCE_STATES after);
/* References that an object has. */
uint32_t d3d12_engine_references(void *object);

/* Ends the program with a text if `hr` is a failure. */
void d3d12_engine_must(HRESULT hr, const char *what);

#endif
