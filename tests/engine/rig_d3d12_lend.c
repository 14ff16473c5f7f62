/* rig_d3d12_lend.c: what a modern Direct3D 12 engine lends: memory from its own allocator, which gives each piece a
   heap of its own, and places it at its second possible offset. */
#include "rig_d3d12.h"

static int32_t CSM_CALL lend_memory(void *user, const csm_d3d12_memory_request *request, csm_d3d12_memory *out) {
  rig *rig = user;
  assert_int_equal(request->struct_size, sizeof *request);
  assert_true(request->size && request->alignment && request->name);
  assert_in_range(request->heap_type, D3D12_HEAP_TYPE_DEFAULT, D3D12_HEAP_TYPE_READBACK);
  const bool at = ++rig->lent.requests == rig->lent.refuse_at;
  const bool wrong = at && rig->lent.lapse != RIG_UNMAPPED;
  rig->lent.lapses += wrong;
  if (wrong && rig->lent.lapse <= RIG_NOTHING)
    return rig->lent.lapse == RIG_REFUSAL ? E_OUTOFMEMORY : S_OK;
  const D3D12_HEAP_DESC description = {.SizeInBytes = request->size + request->alignment,
                                       .Properties = {.Type = request->heap_type},
                                       .Alignment = request->alignment,
                                       .Flags = request->heap_flags};
  const HRESULT hr = ID3D12Device_CreateHeap(rig->device, &description, &IID_ID3D12Heap, &out->heap);
  if (FAILED(hr))
    return hr;
  out->offset = wrong && rig->lent.lapse == RIG_ODD_OFFSET ? 1 : request->alignment;
  out->handle = out->heap;
  rig->lent_kinds |= 1u << request->heap_type;
  if (++rig->lent.pieces > rig->lent.most)
    rig->lent.most = rig->lent.pieces;
  return S_OK;
}

static void CSM_CALL take_memory_back(void *user, const csm_d3d12_memory *memory) {
  rig *rig = user;
  assert_ptr_equal(memory->handle, memory->heap);
  assert_true(rig->lent.pieces);
  --rig->lent.pieces;
  ID3D12Heap_Release((ID3D12Heap *)memory->heap);
}

void rig_d3d12_lend(rig *rig) {
  rig->native.allocate_memory = lend_memory;
  rig->native.free_memory = take_memory_back;
  rig->native.memory_user = rig;
}
