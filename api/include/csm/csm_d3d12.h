/*
 * csm_d3d12.h: an engine's own Direct3D 12 device, its images and its buffers. Pointers are void * so that this header
 * needs no other.
 *
 * csm records into the engine's open graphics command list, outside a render pass. It submits nothing and waits for
 * nothing. A recording leaves changed: the CBV/SRV/UAV descriptor heap (csm sets its own; the engine sets its heaps
 * again), the graphics root signature and its arguments, the pipeline state, render targets, viewport and scissor 0,
 * the primitive topology, vertex buffers 0 to 2 and the index buffer; nothing else.
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

typedef struct csm_d3d12_device {
  uint32_t struct_size;
  uint32_t reserved;              /* 0 */
  void *device;                   /* ID3D12Device*; csm holds a reference of its own */
  void *serialize_root_signature; /* PFN_D3D12_SERIALIZE_ROOT_SIGNATURE, so that no run time is loaded twice */
} csm_d3d12_device;

/* An image to sample: the camera's depth, or normals; in a state that pixel shaders read, and left in it. */
typedef struct csm_d3d12_image {
  uint32_t struct_size;
  uint32_t format; /* DXGI_FORMAT to view it with, such as R32_FLOAT for a typeless depth image */
  void *resource;  /* ID3D12Resource*, 2D, one layer */
  uint32_t width, height;
} csm_d3d12_image;

/* A mesh in the engine's own buffers, in the states that vertices and indices are read in. */
typedef struct csm_d3d12_mesh {
  uint32_t struct_size;
  uint32_t vertex_stride; /* bytes, a multiple of 4, at least 12 */
  void *vertices;         /* ID3D12Resource* */
  uint64_t vertex_offset; /* of the first position: three floats */
  void *indices;          /* ID3D12Resource* */
  uint64_t index_offset;
  uint64_t uv_offset; /* of the first pair of floats, in `vertices`; read only for a mesh with an alpha mask */
  uint32_t uv_stride; /* bytes, a multiple of 4, at least 8 */
  uint32_t reserved;  /* 0 */
} csm_d3d12_mesh;

#ifdef __cplusplus
}
#endif
#endif
