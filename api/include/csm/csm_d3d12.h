/* csm_d3d12.h: an engine's own Direct3D 12 device. The next version takes it; this one answers CSM_ERROR_UNSUPPORTED. */
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

#ifdef __cplusplus
}
#endif
#endif
