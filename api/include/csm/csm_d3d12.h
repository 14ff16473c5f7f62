/*
 * csm_d3d12.h: an engine's own Direct3D 12 device, its images and its buffers. Pointers are void * so that this header
 * needs no other.
 *
 * csm records into the engine's open graphics command list, outside a render pass. It submits nothing and waits for
 * nothing. A recording leaves changed: the CBV/SRV/UAV descriptor heap (csm sets its own; the engine sets its heaps
 * again), the graphics and the compute root signature and their arguments, the pipeline state, render targets, viewport
 * and scissor 0, the primitive topology, vertex buffers 0 to 2 and the index buffer; nothing else.
 *
 * The maps and the mask rest in D3D12_RESOURCE_STATE_PIXEL_SHADER_RESOURCE | NON_PIXEL_SHADER_RESOURCE; an engine may
 * sample them there, and leaves them in that state. csm holds a reference to each object that it is given for as long
 * as it uses it.
 */
#ifndef CSM_D3D12_H
#define CSM_D3D12_H

#include "csm_base.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What csm wants memory for: one placed resource. */
typedef struct csm_d3d12_memory_request {
  uint32_t struct_size;
  uint32_t heap_type; /* D3D12_HEAP_TYPE: DEFAULT, UPLOAD or READBACK */
  uint64_t size, alignment;
  uint32_t heap_flags; /* D3D12_HEAP_FLAGS that a heap for this kind of resource alone has: ALLOW_ONLY_BUFFERS,
                          ALLOW_ONLY_RT_DS_TEXTURES or ALLOW_ONLY_NON_RT_DS_TEXTURES */
  uint32_t reserved;   /* 0 */
  const char *name;    /* for debuggers */
} csm_d3d12_memory_request;

/* What the engine gives. */
typedef struct csm_d3d12_memory {
  void *heap;      /* ID3D12Heap*, of the heap type asked for */
  uint64_t offset; /* in bytes, a multiple of the alignment */
  void *handle;    /* the engine's own, given back when the piece is freed */
} csm_d3d12_memory;

/* Called inside csm's own calls that create, on the same thread. Must not call back into csm. An HRESULT: S_OK, or
   E_OUTOFMEMORY where there is none, with nothing given. A NULL heap is OUT_OF_DEVICE_MEMORY. A piece that breaks the
   rules above is freed, and DEVICE. */
typedef int32_t(CSM_CALL *csm_d3d12_allocate_function)(void *user, const csm_d3d12_memory_request *request,
                                                       csm_d3d12_memory *out);
/* Takes back a piece, once no resource lies in it and the GPU is done with it. Must not call back into csm. */
typedef void(CSM_CALL *csm_d3d12_free_function)(void *user, const csm_d3d12_memory *memory);

typedef struct csm_d3d12_device {
  uint32_t struct_size;
  uint32_t reserved;              /* 0 */
  void *device;                   /* ID3D12Device*; csm holds a reference of its own */
  void *serialize_root_signature; /* PFN_D3D12_SERIALIZE_ROOT_SIGNATURE, so that no run time is loaded twice */
  /* Fields from here on may be left 0. The allocator outlives the context. */
  csm_d3d12_allocate_function allocate_memory; /* all resources; NULL: committed resources. Both, or neither */
  csm_d3d12_free_function free_memory;
  void *memory_user;
} csm_d3d12_device;

/* An image to sample: the camera's depth, normals, or motion; in a state that pixel shaders read, and left in it. */
typedef struct csm_d3d12_image {
  uint32_t struct_size;
  /* DXGI_FORMAT to view it with. Depth: R32_FLOAT, R32_FLOAT_X8X24_TYPELESS, R24_UNORM_X8_TYPELESS, R16_UNORM, R16_FLOAT.
     Normals: R8G8B8A8 and R16G16B16A16 as UNORM or SNORM, R16G16B16A16 and R32G32B32A32 as FLOAT, R32G32B32_FLOAT,
     B8G8R8A8_UNORM, R10G10B10A2_UNORM. Motion: R16G16, R32G32, R16G16B16A16 and R32G32B32A32 as FLOAT. */
  uint32_t format;
  void *resource; /* ID3D12Resource*, 2D, one layer */
  uint32_t width, height;
} csm_d3d12_image;

/* A mesh in the engine's own buffers, in the states that vertices and indices are read in. */
typedef struct csm_d3d12_mesh {
  uint32_t struct_size;
  uint32_t vertex_stride; /* bytes, a multiple of 4, at least 12 */
  void *vertices;         /* ID3D12Resource* */
  uint64_t vertex_offset; /* of the first position: three floats */
  void *indices;          /* ID3D12Resource* */
  uint64_t index_offset;  /* below 4 GiB, as are the indices */
  uint64_t uv_offset;     /* of the first pair of floats, in `vertices`; read only for a mesh with an alpha mask */
  uint32_t uv_stride;     /* bytes, a multiple of 4, at least 8 */
  uint32_t reserved;      /* 0 */
} csm_d3d12_mesh;

#ifdef __cplusplus
}
#endif
#endif
