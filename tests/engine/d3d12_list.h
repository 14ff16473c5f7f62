/*
 * d3d12_list.h: an ID3D12GraphicsCommandList that forwards to another. It has the methods that csm_d3d12.h allows a
 * recording, so any other is a crash; it asserts what they may touch, and that barriers are legal Direct3D 12: vkd3d,
 * which knows no debug layer, takes them all.
 */
#ifndef D3D12_LIST_H
#define D3D12_LIST_H

#include "rig_d3d12.h"

enum { D3D12_LIST_RESOURCES = 64 };

typedef struct d3d12_list {
  ID3D12GraphicsCommandList list; /* what csm gets */
  ID3D12GraphicsCommandList *real;
  uint32_t heaps_set, targets_set, draws, barriers;
  uint32_t resource_count;
  struct {
    ID3D12Resource *resource;
    D3D12_RESOURCE_STATES state; /* as barriers left it */
    bool buffer;
  } resources[D3D12_LIST_RESOURCES]; /* that had a barrier; in this list or an earlier one */
} d3d12_list;

/* Goes on with another list: buffers have decayed to COMMON. Zeroed before the first. */
void d3d12_list_begin(d3d12_list *list, ID3D12GraphicsCommandList *real);

#endif
