#include "d3d12_list.h"

#include "../conformance/support.h"

static d3d12_list *of(ID3D12GraphicsCommandList *list) {
  return (d3d12_list *)list;
}

static ID3D12GraphicsCommandList *real(ID3D12GraphicsCommandList *list) {
  return of(list)->real;
}

static D3D12_COMMAND_LIST_TYPE STDMETHODCALLTYPE get_type(ID3D12GraphicsCommandList *list) {
  return ID3D12GraphicsCommandList_GetType(real(list));
}

/* ---- barriers ---- */

static bool is_read_state(D3D12_RESOURCE_STATES state) {
  const D3D12_RESOURCE_STATES written = D3D12_RESOURCE_STATE_COPY_DEST | D3D12_RESOURCE_STATE_RENDER_TARGET |
                                        D3D12_RESOURCE_STATE_DEPTH_WRITE | D3D12_RESOURCE_STATE_UNORDERED_ACCESS;
  return state && !(state & written);
}

/* The first barrier of a texture tells its state, which it was made in. */
static uint32_t find(d3d12_list *list, const D3D12_RESOURCE_TRANSITION_BARRIER *barrier) {
  uint32_t i = 0;
  while (i < list->resource_count && list->resources[i].resource != barrier->pResource)
    ++i;
  if (i < list->resource_count)
    return i;
  assert_in_range(i, 0, D3D12_LIST_RESOURCES - 1);
  const bool buffer = ID3D12Resource_GetDesc(barrier->pResource).Dimension == D3D12_RESOURCE_DIMENSION_BUFFER;
  list->resources[i].resource = barrier->pResource;
  list->resources[i].buffer = buffer;
  list->resources[i].state = buffer ? D3D12_RESOURCE_STATE_COMMON : barrier->StateBefore;
  return list->resource_count++;
}

static void check_barrier(d3d12_list *list, const D3D12_RESOURCE_BARRIER *barrier) {
  const D3D12_RESOURCE_TRANSITION_BARRIER *t = &barrier->Transition;
  assert_int_equal(barrier->Type, D3D12_RESOURCE_BARRIER_TYPE_TRANSITION);
  assert_int_equal(barrier->Flags, D3D12_RESOURCE_BARRIER_FLAG_NONE);
  assert_int_equal(t->Subresource, D3D12_RESOURCE_BARRIER_ALL_SUBRESOURCES);
  assert_int_not_equal(t->StateBefore, t->StateAfter);
  const uint32_t i = find(list, t);
  const D3D12_RESOURCE_STATES state = list->resources[i].state;
  if (list->resources[i].buffer) {
    D3D12_HEAP_PROPERTIES heap;
    assert_true(SUCCEEDED(ID3D12Resource_GetHeapProperties(t->pResource, &heap, NULL)));
    assert_int_equal(heap.Type, D3D12_HEAP_TYPE_DEFAULT); /* others stay as they are */
  }
  /* A draw may have promoted a buffer out of COMMON. */
  const bool promoted =
      list->resources[i].buffer && state == D3D12_RESOURCE_STATE_COMMON && is_read_state(t->StateBefore);
  assert_true(state == t->StateBefore || promoted);
  list->resources[i].state = t->StateAfter;
}

static void STDMETHODCALLTYPE barrier(ID3D12GraphicsCommandList *list, UINT count,
                                      const D3D12_RESOURCE_BARRIER *barriers) {
  for (UINT i = 0; i < count; ++i) {
    check_barrier(of(list), &barriers[i]);
    for (UINT k = 0; k < i; ++k) /* one transition of a resource in a call */
      assert_ptr_not_equal(barriers[i].Transition.pResource, barriers[k].Transition.pResource);
  }
  of(list)->barriers += count;
  ID3D12GraphicsCommandList_ResourceBarrier(real(list), count, barriers);
}

/* ---- copies, clears, queries ---- */

static void STDMETHODCALLTYPE copy_buffer(ID3D12GraphicsCommandList *list, ID3D12Resource *to, UINT64 to_offset,
                                          ID3D12Resource *from, UINT64 from_offset, UINT64 size) {
  ID3D12GraphicsCommandList_CopyBufferRegion(real(list), to, to_offset, from, from_offset, size);
}

static void STDMETHODCALLTYPE clear_depth(ID3D12GraphicsCommandList *list, D3D12_CPU_DESCRIPTOR_HANDLE view,
                                          D3D12_CLEAR_FLAGS flags, FLOAT depth, UINT8 stencil, UINT count,
                                          const D3D12_RECT *rects) {
  ID3D12GraphicsCommandList_ClearDepthStencilView(real(list), view, flags, depth, stencil, count, rects);
}

static void STDMETHODCALLTYPE end_query(ID3D12GraphicsCommandList *list, ID3D12QueryHeap *heap, D3D12_QUERY_TYPE type,
                                        UINT index) {
  assert_int_equal(type, D3D12_QUERY_TYPE_TIMESTAMP);
  ID3D12GraphicsCommandList_EndQuery(real(list), heap, type, index);
}

static void STDMETHODCALLTYPE resolve(ID3D12GraphicsCommandList *list, ID3D12QueryHeap *heap, D3D12_QUERY_TYPE type,
                                      UINT first, UINT count, ID3D12Resource *to, UINT64 offset) {
  ID3D12GraphicsCommandList_ResolveQueryData(real(list), heap, type, first, count, to, offset);
}

/* ---- state ---- */

static void STDMETHODCALLTYPE set_heaps(ID3D12GraphicsCommandList *list, UINT count,
                                        ID3D12DescriptorHeap *const *heaps) {
  ++of(list)->heaps_set;
  ID3D12GraphicsCommandList_SetDescriptorHeaps(real(list), count, heaps);
}

static void STDMETHODCALLTYPE set_signature(ID3D12GraphicsCommandList *list, ID3D12RootSignature *signature) {
  ID3D12GraphicsCommandList_SetGraphicsRootSignature(real(list), signature);
}

static void STDMETHODCALLTYPE set_table(ID3D12GraphicsCommandList *list, UINT parameter,
                                        D3D12_GPU_DESCRIPTOR_HANDLE table) {
  assert_true(of(list)->heaps_set > 0);
  ID3D12GraphicsCommandList_SetGraphicsRootDescriptorTable(real(list), parameter, table);
}

static void STDMETHODCALLTYPE set_constants(ID3D12GraphicsCommandList *list, UINT parameter,
                                            D3D12_GPU_VIRTUAL_ADDRESS address) {
  assert_int_equal(address % D3D12_CONSTANT_BUFFER_DATA_PLACEMENT_ALIGNMENT, 0);
  ID3D12GraphicsCommandList_SetGraphicsRootConstantBufferView(real(list), parameter, address);
}

static void STDMETHODCALLTYPE set_pipeline(ID3D12GraphicsCommandList *list, ID3D12PipelineState *pipeline) {
  ID3D12GraphicsCommandList_SetPipelineState(real(list), pipeline);
}

static void STDMETHODCALLTYPE set_topology(ID3D12GraphicsCommandList *list, D3D12_PRIMITIVE_TOPOLOGY topology) {
  ID3D12GraphicsCommandList_IASetPrimitiveTopology(real(list), topology);
}

static void STDMETHODCALLTYPE set_vertices(ID3D12GraphicsCommandList *list, UINT slot, UINT count,
                                           const D3D12_VERTEX_BUFFER_VIEW *views) {
  assert_in_range(slot + count, 1, 2);
  ID3D12GraphicsCommandList_IASetVertexBuffers(real(list), slot, count, views);
}

static void STDMETHODCALLTYPE set_indices(ID3D12GraphicsCommandList *list, const D3D12_INDEX_BUFFER_VIEW *view) {
  assert_int_equal(view->BufferLocation % (view->Format == DXGI_FORMAT_R16_UINT ? 2 : 4), 0);
  ID3D12GraphicsCommandList_IASetIndexBuffer(real(list), view);
}

static void STDMETHODCALLTYPE set_targets(ID3D12GraphicsCommandList *list, UINT count,
                                          const D3D12_CPU_DESCRIPTOR_HANDLE *targets, BOOL one,
                                          const D3D12_CPU_DESCRIPTOR_HANDLE *depth) {
  ++of(list)->targets_set;
  ID3D12GraphicsCommandList_OMSetRenderTargets(real(list), count, targets, one, depth);
}

static void STDMETHODCALLTYPE set_viewports(ID3D12GraphicsCommandList *list, UINT count,
                                            const D3D12_VIEWPORT *viewports) {
  assert_int_equal(count, 1);
  ID3D12GraphicsCommandList_RSSetViewports(real(list), count, viewports);
}

static void STDMETHODCALLTYPE set_scissors(ID3D12GraphicsCommandList *list, UINT count, const D3D12_RECT *rects) {
  assert_int_equal(count, 1);
  ID3D12GraphicsCommandList_RSSetScissorRects(real(list), count, rects);
}

static void STDMETHODCALLTYPE draw(ID3D12GraphicsCommandList *list, UINT vertices, UINT instances, UINT vertex,
                                   UINT instance) {
  ++of(list)->draws;
  ID3D12GraphicsCommandList_DrawInstanced(real(list), vertices, instances, vertex, instance);
}

static void STDMETHODCALLTYPE draw_indexed(ID3D12GraphicsCommandList *list, UINT indices, UINT instances, UINT index,
                                           INT vertex, UINT instance) {
  ++of(list)->draws;
  ID3D12GraphicsCommandList_DrawIndexedInstanced(real(list), indices, instances, index, vertex, instance);
}

void d3d12_list_begin(d3d12_list *list, ID3D12GraphicsCommandList *real_list) {
  static const ID3D12GraphicsCommandListVtbl methods = {
      .GetType = get_type,
      .ResourceBarrier = barrier,
      .CopyBufferRegion = copy_buffer,
      .ClearDepthStencilView = clear_depth,
      .EndQuery = end_query,
      .ResolveQueryData = resolve,
      .SetDescriptorHeaps = set_heaps,
      .SetGraphicsRootSignature = set_signature,
      .SetGraphicsRootDescriptorTable = set_table,
      .SetGraphicsRootConstantBufferView = set_constants,
      .SetPipelineState = set_pipeline,
      .IASetPrimitiveTopology = set_topology,
      .IASetVertexBuffers = set_vertices,
      .IASetIndexBuffer = set_indices,
      .OMSetRenderTargets = set_targets,
      .RSSetViewports = set_viewports,
      .RSSetScissorRects = set_scissors,
      .DrawInstanced = draw,
      .DrawIndexedInstanced = draw_indexed,
  };
  list->list.lpVtbl = (ID3D12GraphicsCommandListVtbl *)&methods;
  list->real = real_list;
  list->heaps_set = list->targets_set = list->draws = list->barriers = 0;
  for (uint32_t i = 0; i < list->resource_count; ++i)
    if (list->resources[i].buffer)
      list->resources[i].state = D3D12_RESOURCE_STATE_COMMON;
}
