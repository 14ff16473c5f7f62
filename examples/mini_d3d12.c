/*
 * mini_d3d12.c: an engine with a Direct3D 12 device of its own that draws its shadows with csm. It is mini_vulkan.c
 * step for step, and draws the same picture.
 *
 * Read main and draw_frame first. What the engine does for csm:
 *   - it hands over its device and the function that serialises root signatures (open_shadows);
 *   - it hands over its vertex and index buffers, which csm draws as they are (add_meshes);
 *   - each frame, it has csm record the maps into its own command list (shadows.c), draws the tree, which only its own
 *     shader can bend, when csm calls back (draw_tree), and samples the maps in its forward shader (forward.ps.hlsl);
 *   - it sets its descriptor heap again after csm, which sets one of its own (draw_forward);
 *   - it tells csm which frames the GPU has finished (begin_frame).
 * csm submits nothing and waits for nothing: all that is here.
 */
#include "d3d12_base.h"
#include "csm/csm_d3d12.h"
#include "d3d12_shaders.h"
#include "shadows.h"
#include <string.h>

static const DXGI_FORMAT color_format = DXGI_FORMAT_R8G8B8A8_UNORM_SRGB;
static const DXGI_FORMAT depth_format = DXGI_FORMAT_D32_FLOAT;
static const D3D12_CLEAR_VALUE color_clear = {.Format = DXGI_FORMAT_R8G8B8A8_UNORM_SRGB,
                                              .Color = {0.4f, 0.55f, 0.8f, 1.0f}};
static const D3D12_CLEAR_VALUE depth_clear = {.Format = DXGI_FORMAT_D32_FLOAT, .DepthStencil = {.Depth = 0.0f}};

/* A row of the picture in a buffer; copies want multiples of D3D12_TEXTURE_DATA_PITCH_ALIGNMENT, and this is one. */
enum { PICTURE_PITCH = WORLD_WIDTH * 4 };
_Static_assert(PICTURE_PITCH % D3D12_TEXTURE_DATA_PITCH_ALIGNMENT == 0, "rows of the picture are not aligned");

/* Root parameters of both pipelines, as the shaders declare them. */
enum { ROOT_DRAW, ROOT_SHADOWS, ROOT_FRAME, ROOT_MAPS, ROOT_COUNT };

/* What changes every frame, once for each frame in flight. */
typedef struct frame_slot {
  ID3D12CommandAllocator *allocator;
  ID3D12Resource *shadow_block, *frame_block; /* csm_binding.constants; frame_constants */
  void *shadow_memory, *frame_memory;
  D3D12_CPU_DESCRIPTOR_HANDLE maps_cpu; /* where csm describes its maps */
  D3D12_GPU_DESCRIPTOR_HANDLE maps_gpu;
} frame_slot;

typedef struct engine {
  d3d12_base base;
  world world;
  shadows shadows;
  ID3D12Resource *vertices[WORLD_MESHES], *indices[WORLD_MESHES];
  ID3D12Resource *color, *depth;
  ID3D12DescriptorHeap *color_view, *depth_view;
  ID3D12Resource *picture;           /* the last frame, for the CPU */
  ID3D12DescriptorHeap *descriptors; /* shader-visible: the maps, for each frame in flight */
  ID3D12RootSignature *signature;    /* of both pipelines */
  ID3D12PipelineState *forward, *caster;
  ID3D12GraphicsCommandList *list;
  frame_slot slots[SHADOWS_FRAMES_IN_FLIGHT];
} engine;

/* ---- what the engine owns ---- */

static ID3D12Resource *upload(const engine *e, const void *data, size_t size) {
  ID3D12Resource *buffer = d3d12_buffer_create(&e->base, D3D12_HEAP_TYPE_UPLOAD, size);
  memcpy(d3d12_buffer_map(buffer), data, size);
  ID3D12Resource_Unmap(buffer, 0, NULL);
  return buffer;
}

static void create_meshes(engine *e) {
  for (int i = 0; i < WORLD_MESHES; i++) {
    const mesh *m = &e->world.meshes[i];
    e->vertices[i] = upload(e, m->vertices, m->vertex_count * sizeof *m->vertices);
    e->indices[i] = upload(e, m->indices, m->index_count * sizeof *m->indices);
  }
}

static void create_targets(engine *e) {
  e->color =
      d3d12_image_create(&e->base, color_format, WORLD_WIDTH, WORLD_HEIGHT, D3D12_RESOURCE_FLAG_ALLOW_RENDER_TARGET,
                         D3D12_RESOURCE_STATE_RENDER_TARGET, &color_clear);
  e->depth =
      d3d12_image_create(&e->base, depth_format, WORLD_WIDTH, WORLD_HEIGHT, D3D12_RESOURCE_FLAG_ALLOW_DEPTH_STENCIL,
                         D3D12_RESOURCE_STATE_DEPTH_WRITE, &depth_clear);
  e->picture = d3d12_buffer_create(&e->base, D3D12_HEAP_TYPE_READBACK, PICTURE_PITCH * WORLD_HEIGHT);
  e->color_view = d3d12_heap_create(&e->base, D3D12_DESCRIPTOR_HEAP_TYPE_RTV, 1, false);
  e->depth_view = d3d12_heap_create(&e->base, D3D12_DESCRIPTOR_HEAP_TYPE_DSV, 1, false);
  ID3D12Device_CreateRenderTargetView(e->base.device, e->color, NULL,
                                      ID3D12DescriptorHeap_GetCPUDescriptorHandleForHeapStart(e->color_view));
  ID3D12Device_CreateDepthStencilView(e->base.device, e->depth, NULL,
                                      ID3D12DescriptorHeap_GetCPUDescriptorHandleForHeapStart(e->depth_view));
}

/* csm's constants, the engine's own, a draw's, and the maps with a point sampler, as forward.ps.hlsl declares them. */
static void create_signature(engine *e) {
  const D3D12_DESCRIPTOR_RANGE maps = {.RangeType = D3D12_DESCRIPTOR_RANGE_TYPE_SRV, .NumDescriptors = 1};
  const D3D12_ROOT_PARAMETER parameters[ROOT_COUNT] = {
      [ROOT_DRAW] = {.ParameterType = D3D12_ROOT_PARAMETER_TYPE_32BIT_CONSTANTS,
                     .Constants = {.ShaderRegister = 2, .Num32BitValues = sizeof(draw_constants) / 4}},
      [ROOT_SHADOWS] = {.ParameterType = D3D12_ROOT_PARAMETER_TYPE_CBV, .Descriptor = {.ShaderRegister = 0}},
      [ROOT_FRAME] = {.ParameterType = D3D12_ROOT_PARAMETER_TYPE_CBV, .Descriptor = {.ShaderRegister = 1}},
      [ROOT_MAPS] = {.ParameterType = D3D12_ROOT_PARAMETER_TYPE_DESCRIPTOR_TABLE,
                     .DescriptorTable = {.NumDescriptorRanges = 1, .pDescriptorRanges = &maps}}};
  const D3D12_STATIC_SAMPLER_DESC point = {.Filter = D3D12_FILTER_MIN_MAG_MIP_POINT,
                                           .AddressU = D3D12_TEXTURE_ADDRESS_MODE_CLAMP,
                                           .AddressV = D3D12_TEXTURE_ADDRESS_MODE_CLAMP,
                                           .AddressW = D3D12_TEXTURE_ADDRESS_MODE_CLAMP,
                                           .MaxLOD = D3D12_FLOAT32_MAX,
                                           .ShaderVisibility = D3D12_SHADER_VISIBILITY_PIXEL};
  const D3D12_ROOT_SIGNATURE_DESC signature = {.NumParameters = ROOT_COUNT,
                                               .pParameters = parameters,
                                               .NumStaticSamplers = 1,
                                               .pStaticSamplers = &point,
                                               .Flags = D3D12_ROOT_SIGNATURE_FLAG_ALLOW_INPUT_ASSEMBLER_INPUT_LAYOUT};
  ID3DBlob *blob;
  d3d12_check(D3D12SerializeRootSignature(&signature, D3D_ROOT_SIGNATURE_VERSION_1_0, &blob, NULL),
              "D3D12SerializeRootSignature");
  d3d12_check(ID3D12Device_CreateRootSignature(e->base.device, 0, ID3D10Blob_GetBufferPointer(blob),
                                               ID3D10Blob_GetBufferSize(blob), &IID_ID3D12RootSignature,
                                               (void **)&e->signature),
              "CreateRootSignature");
  ID3D10Blob_Release(blob);
}

static const D3D12_INPUT_ELEMENT_DESC vertex_elements[2] = {
    {.SemanticName = "POSITION",
     .Format = DXGI_FORMAT_R32G32B32_FLOAT,
     .AlignedByteOffset = offsetof(vertex, position)},
    {.SemanticName = "NORMAL", .Format = DXGI_FORMAT_R32G32B32_FLOAT, .AlignedByteOffset = offsetof(vertex, normal)}};

static void create_forward(engine *e) {
  const d3d12_pipeline_info info = {.signature = e->signature,
                                    .vertex_code = forward_vs,
                                    .vertex_size = sizeof forward_vs,
                                    .pixel_code = forward_ps,
                                    .pixel_size = sizeof forward_ps,
                                    .elements = vertex_elements,
                                    .element_count = 2,
                                    .color_format = color_format,
                                    .depth_format = depth_format,
                                    .cull = D3D12_CULL_MODE_BACK,
                                    .depth_compare = D3D12_COMPARISON_FUNC_GREATER, /* reversed-Z */
                                    .depth_clip = true};
  e->forward = d3d12_pipeline_create(&e->base, &info);
}

static void create_slots(engine *e) {
  e->descriptors = d3d12_heap_create(&e->base, D3D12_DESCRIPTOR_HEAP_TYPE_CBV_SRV_UAV, SHADOWS_FRAMES_IN_FLIGHT, true);
  const size_t step =
      ID3D12Device_GetDescriptorHandleIncrementSize(e->base.device, D3D12_DESCRIPTOR_HEAP_TYPE_CBV_SRV_UAV);
  for (int i = 0; i < SHADOWS_FRAMES_IN_FLIGHT; i++) {
    frame_slot *slot = &e->slots[i];
    d3d12_check(ID3D12Device_CreateCommandAllocator(e->base.device, D3D12_COMMAND_LIST_TYPE_DIRECT,
                                                    &IID_ID3D12CommandAllocator, (void **)&slot->allocator),
                "CreateCommandAllocator");
    slot->shadow_block = d3d12_buffer_create(&e->base, D3D12_HEAP_TYPE_UPLOAD, SHADOWS_CONSTANTS_BYTES);
    slot->frame_block = d3d12_buffer_create(&e->base, D3D12_HEAP_TYPE_UPLOAD, sizeof(frame_constants));
    slot->shadow_memory = d3d12_buffer_map(slot->shadow_block);
    slot->frame_memory = d3d12_buffer_map(slot->frame_block);
    slot->maps_cpu = ID3D12DescriptorHeap_GetCPUDescriptorHandleForHeapStart(e->descriptors);
    slot->maps_gpu = ID3D12DescriptorHeap_GetGPUDescriptorHandleForHeapStart(e->descriptors);
    slot->maps_cpu.ptr += i * step;
    slot->maps_gpu.ptr += i * step;
  }
  d3d12_check(ID3D12Device_CreateCommandList(e->base.device, 0, D3D12_COMMAND_LIST_TYPE_DIRECT, e->slots[0].allocator,
                                             NULL, &IID_ID3D12GraphicsCommandList, (void **)&e->list),
              "CreateCommandList");
  d3d12_check(ID3D12GraphicsCommandList_Close(e->list), "Close");
}

/* ---- csm ---- */

static void open_shadows(engine *e, const char *library) {
  const csm_d3d12_device device = {
      .struct_size = sizeof device, .device = e->base.device, .serialize_root_signature = D3D12SerializeRootSignature};
  csm_create_info create = {.backend = "d3d12", .d3d12 = &device};
  shadows_open(&e->shadows, library, &create);
}

/* csm draws from the engine's own buffers: it is told where positions lie, and copies nothing. */
static void add_meshes(engine *e) {
  for (uint32_t i = 0; i < WORLD_MESHES; i++) {
    const csm_d3d12_mesh buffers = {.struct_size = sizeof buffers,
                                    .vertex_stride = sizeof(vertex),
                                    .vertices = e->vertices[i],
                                    .vertex_offset = offsetof(vertex, position),
                                    .indices = e->indices[i]};
    csm_mesh_info info = {.d3d12 = &buffers};
    shadows_add_mesh(&e->shadows, i, &e->world.meshes[i], &info);
  }
}

static void draw_mesh(const engine *e, ID3D12GraphicsCommandList *list, uint32_t index,
                      const draw_constants *constants) {
  const mesh *m = &e->world.meshes[index];
  const D3D12_VERTEX_BUFFER_VIEW vertices = {.BufferLocation = ID3D12Resource_GetGPUVirtualAddress(e->vertices[index]),
                                             .SizeInBytes = m->vertex_count * (UINT)sizeof(vertex),
                                             .StrideInBytes = sizeof(vertex)};
  const D3D12_INDEX_BUFFER_VIEW indices = {.BufferLocation = ID3D12Resource_GetGPUVirtualAddress(e->indices[index]),
                                           .SizeInBytes = m->index_count * (UINT)sizeof(uint16_t),
                                           .Format = DXGI_FORMAT_R16_UINT};
  ID3D12GraphicsCommandList_SetGraphicsRoot32BitConstants(list, ROOT_DRAW, sizeof *constants / 4, constants, 0);
  ID3D12GraphicsCommandList_IASetPrimitiveTopology(list, D3D_PRIMITIVE_TOPOLOGY_TRIANGLELIST);
  ID3D12GraphicsCommandList_IASetVertexBuffers(list, 0, 1, &vertices);
  ID3D12GraphicsCommandList_IASetIndexBuffer(list, &indices);
  ID3D12GraphicsCommandList_DrawIndexedInstanced(list, m->index_count, 1, 0, 0, 0);
}

/* Fits csm's maps. Depth is clamped, so that a caster before the map's near plane still casts; both sides are drawn, as
   csm draws its own casters. */
static void create_caster(engine *e) {
  const csm_draw_target target = shadows_target(&e->shadows);
  const d3d12_pipeline_info info = {.signature = e->signature,
                                    .vertex_code = caster_vs,
                                    .vertex_size = sizeof caster_vs,
                                    .elements = vertex_elements,
                                    .element_count = 1,
                                    .depth_format = (DXGI_FORMAT)target.depth_format,
                                    .cull = D3D12_CULL_MODE_NONE,
                                    .depth_compare = D3D12_COMPARISON_FUNC_LESS};
  e->caster = d3d12_pipeline_create(&e->base, &info);
}

/* csm's callback, with each cascade's depth view set: draws the tree, bent as the forward pass bends it. */
static void CSM_CALL draw_tree(void *user, const csm_draw_info *info) {
  engine *e = user;
  const thing *tree = &e->world.things[e->world.thing_count - 1];
  ID3D12GraphicsCommandList *list = info->command_buffer;
  double center[3];
  const double radius = world_skinned_bounds(&e->world, center);
  if (!shadows_reaches(info, center, radius))
    return;
  draw_constants constants;
  world_caster_constants(&constants, tree, info->world_to_clip);
  ID3D12GraphicsCommandList_SetGraphicsRootSignature(list, e->signature);
  ID3D12GraphicsCommandList_SetPipelineState(list, e->caster);
  draw_mesh(e, list, tree->mesh, &constants);
}

/* ---- one frame ---- */

/* Waits until the slot's last frame is done, and lets csm free what it kept for it. */
static void begin_frame(engine *e, const frame_slot *slot, uint32_t frame) {
  if (frame > SHADOWS_FRAMES_IN_FLIGHT)
    d3d12_wait(&e->base, frame - SHADOWS_FRAMES_IN_FLIGHT);
  shadows_retire(&e->shadows, (int64_t)frame - SHADOWS_FRAMES_IN_FLIGHT);
  d3d12_check(ID3D12CommandAllocator_Reset(slot->allocator), "ID3D12CommandAllocator_Reset");
  d3d12_check(ID3D12GraphicsCommandList_Reset(e->list, slot->allocator, NULL), "ID3D12GraphicsCommandList_Reset");
}

static void draw_forward(const engine *e, const frame_slot *slot, const double origin[3]) {
  ID3D12GraphicsCommandList *list = e->list;
  const D3D12_CPU_DESCRIPTOR_HANDLE color = ID3D12DescriptorHeap_GetCPUDescriptorHandleForHeapStart(e->color_view);
  const D3D12_CPU_DESCRIPTOR_HANDLE depth = ID3D12DescriptorHeap_GetCPUDescriptorHandleForHeapStart(e->depth_view);
  const D3D12_VIEWPORT viewport = {.Width = WORLD_WIDTH, .Height = WORLD_HEIGHT, .MaxDepth = 1};
  const D3D12_RECT area = {0, 0, WORLD_WIDTH, WORLD_HEIGHT};
  ID3D12GraphicsCommandList_OMSetRenderTargets(list, 1, &color, FALSE, &depth);
  ID3D12GraphicsCommandList_RSSetViewports(list, 1, &viewport);
  ID3D12GraphicsCommandList_RSSetScissorRects(list, 1, &area);
  ID3D12GraphicsCommandList_ClearRenderTargetView(list, color, color_clear.Color, 0, NULL);
  ID3D12GraphicsCommandList_ClearDepthStencilView(list, depth, D3D12_CLEAR_FLAG_DEPTH, depth_clear.DepthStencil.Depth,
                                                  0, 0, NULL);

  ID3D12DescriptorHeap *heap = e->descriptors;
  ID3D12GraphicsCommandList_SetDescriptorHeaps(list, 1, &heap);
  ID3D12GraphicsCommandList_SetGraphicsRootSignature(list, e->signature);
  ID3D12GraphicsCommandList_SetPipelineState(list, e->forward);
  ID3D12GraphicsCommandList_SetGraphicsRootConstantBufferView(list, ROOT_SHADOWS,
                                                              ID3D12Resource_GetGPUVirtualAddress(slot->shadow_block));
  ID3D12GraphicsCommandList_SetGraphicsRootConstantBufferView(list, ROOT_FRAME,
                                                              ID3D12Resource_GetGPUVirtualAddress(slot->frame_block));
  ID3D12GraphicsCommandList_SetGraphicsRootDescriptorTable(list, ROOT_MAPS, slot->maps_gpu);
  for (uint32_t i = 0; i < e->world.thing_count; i++) {
    draw_constants constants;
    world_draw_constants(&constants, &e->world.things[i], origin);
    draw_mesh(e, list, e->world.things[i].mesh, &constants);
  }
}

static void copy_picture(const engine *e) {
  const D3D12_TEXTURE_COPY_LOCATION from = {.pResource = e->color, .Type = D3D12_TEXTURE_COPY_TYPE_SUBRESOURCE_INDEX};
  const D3D12_TEXTURE_COPY_LOCATION to = {.pResource = e->picture,
                                          .Type = D3D12_TEXTURE_COPY_TYPE_PLACED_FOOTPRINT,
                                          .PlacedFootprint = {.Footprint = {.Format = color_format,
                                                                            .Width = WORLD_WIDTH,
                                                                            .Height = WORLD_HEIGHT,
                                                                            .Depth = 1,
                                                                            .RowPitch = PICTURE_PITCH}}};
  d3d12_transition(e->list, e->color, D3D12_RESOURCE_STATE_RENDER_TARGET, D3D12_RESOURCE_STATE_COPY_SOURCE);
  ID3D12GraphicsCommandList_CopyTextureRegion(e->list, &to, 0, 0, 0, &from, NULL);
  d3d12_transition(e->list, e->color, D3D12_RESOURCE_STATE_COPY_SOURCE, D3D12_RESOURCE_STATE_RENDER_TARGET);
}

/* Frames are numbered from 1 on, as csm wants them. */
static void draw_frame(engine *e, uint32_t frame) {
  frame_slot *slot = &e->slots[frame % SHADOWS_FRAMES_IN_FLIGHT];
  const shadows_frame shadows = {.number = frame, .command_buffer = e->list, .draw = draw_tree, .user = e};
  csm_binding binding = {.struct_size = sizeof binding, .maps_descriptor = slot->maps_cpu.ptr};
  begin_frame(e, slot, frame);
  world_animate(&e->world, frame);

  shadows_record(&e->shadows, &e->world, &shadows, &binding);
  shadows_write_constants(slot->shadow_memory, &binding);
  world_frame_constants(slot->frame_memory, &e->world, binding.origin);
  draw_forward(e, slot, binding.origin);
  if (frame == SHADOWS_FRAMES)
    copy_picture(e);

  ID3D12CommandList *const list = (ID3D12CommandList *)e->list;
  d3d12_check(ID3D12GraphicsCommandList_Close(e->list), "ID3D12GraphicsCommandList_Close");
  ID3D12CommandQueue_ExecuteCommandLists(e->base.queue, 1, &list);
  d3d12_check(ID3D12CommandQueue_Signal(e->base.queue, e->base.fence, frame), "ID3D12CommandQueue_Signal");
}

/* ---- the program ---- */

static void engine_open(engine *e, const app_options *options) {
  world_create(&e->world);
  d3d12_open(&e->base, options->validate);
  create_meshes(e);
  create_targets(e);
  create_signature(e);
  create_forward(e);
  create_slots(e);
  open_shadows(e, options->csm);
  add_meshes(e);
  shadows_place(&e->shadows, &e->world);
  create_caster(e);
}

static void engine_close(engine *e) {
  shadows_close(&e->shadows); /* before the device and the buffers that it was lent */
  for (int i = 0; i < SHADOWS_FRAMES_IN_FLIGHT; i++) {
    ID3D12Resource_Release(e->slots[i].shadow_block);
    ID3D12Resource_Release(e->slots[i].frame_block);
    ID3D12CommandAllocator_Release(e->slots[i].allocator);
  }
  for (int i = 0; i < WORLD_MESHES; i++) {
    ID3D12Resource_Release(e->vertices[i]);
    ID3D12Resource_Release(e->indices[i]);
  }
  ID3D12GraphicsCommandList_Release(e->list);
  if (e->caster)
    ID3D12PipelineState_Release(e->caster);
  ID3D12PipelineState_Release(e->forward);
  ID3D12RootSignature_Release(e->signature);
  ID3D12DescriptorHeap_Release(e->descriptors);
  ID3D12DescriptorHeap_Release(e->depth_view);
  ID3D12DescriptorHeap_Release(e->color_view);
  ID3D12Resource_Release(e->picture);
  ID3D12Resource_Release(e->depth);
  ID3D12Resource_Release(e->color);
  d3d12_close(&e->base);
  world_destroy(&e->world);
}

int main(int count, char **arguments) {
  static engine e;
  app_options options;
  app_parse(&options, count, arguments);
  engine_open(&e, &options);

  const double start = app_now_ms();
  for (uint32_t frame = 1; frame <= SHADOWS_FRAMES; frame++)
    draw_frame(&e, frame);
  d3d12_wait(&e.base, SHADOWS_FRAMES);
  shadows_retire(&e.shadows, SHADOWS_FRAMES);
  const double frame_ms = (app_now_ms() - start) / SHADOWS_FRAMES;

  app_write_png(options.out, d3d12_buffer_map(e.picture), WORLD_WIDTH, WORLD_HEIGHT);
  shadows_report(&e.shadows, "mini_d3d12", e.base.name, frame_ms, e.base.messages);
  engine_close(&e);
  return e.base.messages ? APP_FAILED : 0;
}
