/* rig_d3d12.h: what a rig on Direct3D 12 is made of, on vkd3d, for the tests of what that API alone has. */
#ifndef RIG_D3D12_H
#define RIG_D3D12_H

#define COBJMACROS
#define WIDL_C_INLINE_WRAPPERS
#include <vkd3d_utils.h>
/* after it, for it decides whether prototypes are there */
#include <vkd3d.h>

#include "rig.h"

struct rig {
  struct vkd3d_instance *instance;
  VkDebugUtilsMessengerEXT messenger;
  uint32_t messages; /* errors and warnings of validation */
  ID3D12Device *device;
  ID3D12CommandQueue *queue;
  ID3D12Fence *fence;
  HANDLE event;
  csm_d3d12_device native; /* what csm gets */

  /* frames, by number modulo RIG_FRAMES */
  struct {
    ID3D12CommandAllocator *allocators[RIG_LISTS];
    ID3D12GraphicsCommandList *lists[RIG_LISTS];
    uint32_t count;
  } frames[RIG_FRAMES];
  uint64_t frame, done;

  rig_lent lent;
  uint32_t lent_kinds; /* bits: heap types that pieces were asked for */
};

/* Lends the rig's memory to csm. */
void rig_d3d12_lend(rig *rig);
/* Ends the program with a text if `hr` is a failure. */
void rig_d3d12_must(HRESULT hr, const char *what);
/* References that an object has. */
uint32_t rig_d3d12_references(void *object);
ID3D12Resource *rig_d3d12_resource(const rig_image *image);
/* A buffer's resource, from one heap; `mapped` is set. */
rig_buffer rig_d3d12_buffer(rig *rig, D3D12_HEAP_TYPE heap, uint64_t size);
/* A 2D image of the format, filled with texels, resting readable by pixel shaders. */
ID3D12Resource *rig_d3d12_image(rig *rig, const D3D12_RESOURCE_DESC *description, uint32_t texel_bytes,
                                const void *texels);
void rig_d3d12_barrier(ID3D12GraphicsCommandList *list, ID3D12Resource *resource, D3D12_RESOURCE_STATES before,
                       D3D12_RESOURCE_STATES after);

/* A pipeline with a root signature of one table of `textures` textures, if any; the rest of `info` is filled in. */
typedef struct rig_d3d12_pipeline {
  ID3D12RootSignature *signature;
  ID3D12PipelineState *state;
} rig_d3d12_pipeline;

rig_d3d12_pipeline rig_d3d12_pipeline_make(rig *rig, uint32_t textures, D3D12_GRAPHICS_PIPELINE_STATE_DESC *info);
void rig_d3d12_pipeline_free(rig_d3d12_pipeline *pipeline);

#endif
