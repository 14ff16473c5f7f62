/*
 * d3d12_only.c: what only Direct3D 12 has: references that csm holds, descriptors that it writes, lists that may be of
 * another kind, and a command list that is itself an object and tells what is recorded.
 */
#include "d3d12_list.h"
#include "rig_d3d12_faults.h"
#include "stage.h"

#include "engine_code.h"
#include "shader_code.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 192, HEIGHT = 128 };

static const picture_size size = {WIDTH, HEIGHT};

static picture draw_own(void) {
  stage own;
  stage_open(&own, NULL);
  const picture out = stage_draw_at(&own, 0, size);
  stage_close(&own);
  return out;
}

/* ---- references ---- */

/* csm holds what it is given for as long as a frame in flight reads it. */
static void images_are_held_while_in_flight(void **state) {
  (void)state;
  static const float depth[WIDTH * HEIGHT];
  stage stage;
  rig *rig = rig_open(RIG_TYPICAL);
  stage_open(&stage, rig);
  rig_image *image =
      rig_image_make(rig, &(rig_image_info){.format = RIG_DEPTH_32, .width = WIDTH, .height = HEIGHT, .texels = depth});
  ID3D12Resource *resource = rig_d3d12_resource(image);
  rig_begin(rig);
  shot shot = stage_shot(&stage, 0);
  const csm_mask_info mask = {.struct_size = sizeof mask,
                              .frame = shot_frame(&shot),
                              .width = WIDTH,
                              .height = HEIGHT,
                              .camera_depth = rig_image_native(image)};
  stage_render(&stage, &shot);
  assert_int_equal(csm_resolve_mask(stage.view, stage.cascades, &mask), CSM_SUCCESS);
  rig_end(rig);
  assert_int_equal(rig_d3d12_references(resource), 2);
  rig_run(rig, rig_frame(rig));
  assert_int_equal(rig_d3d12_references(resource), 2);
  stage_retire(&stage);
  assert_int_equal(rig_d3d12_references(resource), 1);
  rig_image_free(rig, image);
  stage_close(&stage);
  rig_close(rig);
}

/* A mesh that is destroyed while a frame in flight draws it stays until that frame is retired. */
static void meshes_are_held_while_in_flight(void **state) {
  (void)state;
  enum { STRIDE = 16 };
  stage stage;
  hill hill;
  rig *rig = rig_open(RIG_TYPICAL);
  stage_open(&stage, rig);
  hill_make(&hill);
  rig_buffer buffers[2] = {rig_buffer_make(rig, RIG_GEOMETRY, HILL_VERTICES * STRIDE),
                           rig_buffer_make(rig, RIG_GEOMETRY, sizeof hill.indices)};
  for (uint32_t i = 0; i < HILL_VERTICES; ++i)
    memcpy((char *)buffers[0].mapped + (size_t)i * STRIDE, hill.positions[i], sizeof hill.positions[i]);
  memcpy(buffers[1].mapped, hill.indices, sizeof hill.indices);
  csm_mesh_info info = hill_info(&hill, 2);
  rig_native native;
  csm_mesh mesh;
  info.positions = info.indices = NULL;
  for (int axis = 0; axis < 3; ++axis) {
    info.bounds_min[axis] = -1;
    info.bounds_max[axis] = 1;
  }
  rig_mesh_give(&(rig_mesh){.vertices = &buffers[0], .indices = &buffers[1], .vertex_stride = STRIDE}, &native, &info);
  assert_int_equal(csm_mesh_create(stage.context, &info, &mesh), CSM_SUCCESS);
  stage.scene.instances[1] = support_instance(mesh, -1, 2, 1, 3, 2, 3);
  rig_begin(rig);
  shot shot = stage_shot(&stage, 0);
  stage_render(&stage, &shot);
  rig_end(rig);
  assert_int_equal(csm_mesh_destroy(stage.context, mesh), CSM_SUCCESS);
  for (int i = 0; i < 2; ++i)
    assert_int_equal(rig_d3d12_references(buffers[i].object), 2);
  rig_run(rig, rig_frame(rig));
  stage_retire(&stage);
  for (int i = 0; i < 2; ++i)
    rig_buffer_free(rig, &buffers[i]);
  stage_close(&stage);
  rig_close(rig);
}

/* A context gives the device back, every reference of it. */
static void the_device_is_given_back(void **state) {
  (void)state;
  stage stage;
  rig *rig = rig_open(RIG_TYPICAL);
  const uint32_t before = rig_d3d12_references(rig->device);
  stage_open(&stage, rig);
  picture drawn = stage_draw_at(&stage, 0, size);
  picture_free(&drawn);
  assert_true(rig_d3d12_references(rig->device) > before);
  stage_close(&stage);
  assert_int_equal(rig_d3d12_references(rig->device), before);
  rig_close(rig);
}

/* An engine's allocator is asked for memory of every kind. */
static void every_heap_is_the_engines(void **state) {
  (void)state;
  stage stage;
  rig *rig = rig_open(RIG_MODERN);
  stage_open(&stage, rig);
  picture drawn = stage_draw_at(&stage, 0, size);
  picture_free(&drawn);
  for (uint32_t kind = D3D12_HEAP_TYPE_DEFAULT; kind <= D3D12_HEAP_TYPE_READBACK; ++kind)
    assert_true(rig->lent_kinds >> kind & 1);
  stage_close(&stage);
  rig_close(rig);
}

/* ---- what a device and a list may be ---- */

static csm_result create_on(rig *rig) {
  record record = {0};
  char text[512] = "";
  csm_context *context = NULL;
  csm_create_info info = stage_create_info(rig, &record);
  record.quiet = true;
  info.error = text;
  info.error_size = sizeof text;
  const csm_result result = csm_create(&info, &context);
  csm_destroy(context);
  assert_int_equal(record.blocks, 0);
  assert_true(!result || strstr(text, "11_0"));
  assert_null(rig_leak());
  return result;
}

static void a_feature_level_may_be_too_low(void **state) {
  (void)state;
  rig *rig = rig_open(RIG_FAILING);
  assert_int_equal(create_on(rig), CSM_SUCCESS);
  d3d12_faults_level(D3D_FEATURE_LEVEL_10_1);
  assert_int_equal(create_on(rig), CSM_ERROR_UNSUPPORTED);
  d3d12_faults_level(0);
  rig_close(rig);
}

static void a_compute_list_is_refused(void **state) {
  (void)state;
  stage stage;
  ID3D12CommandAllocator *allocator;
  ID3D12GraphicsCommandList *compute;
  rig *rig = rig_open(RIG_TYPICAL);
  stage_open(&stage, rig);
  stage.record.quiet = true;
  rig_d3d12_must(ID3D12Device_CreateCommandAllocator(rig->device, D3D12_COMMAND_LIST_TYPE_COMPUTE,
                                                     &IID_ID3D12CommandAllocator, (void **)&allocator),
                 "an allocator");
  rig_d3d12_must(ID3D12Device_CreateCommandList(rig->device, 0, D3D12_COMMAND_LIST_TYPE_COMPUTE, allocator, NULL,
                                                &IID_ID3D12GraphicsCommandList, (void **)&compute),
                 "a list");
  rig_begin(rig);
  shot shot = stage_shot(&stage, 0);
  shot.frame.command_buffer = compute;
  assert_int_equal(csm_render_cascades(stage.cascades, shot_frame(&shot)), CSM_ERROR_INVALID_VALUE);
  assert_true(csm_last_error(stage.context)[0]);
  rig_end(rig);
  rig_d3d12_must(ID3D12GraphicsCommandList_Close(compute), "closing a list");
  ID3D12GraphicsCommandList_Release(compute);
  ID3D12CommandAllocator_Release(allocator);
  stage_close(&stage);
  rig_close(rig);
}

/* ---- csm_bind ---- */

typedef struct reader {
  rig *rig;
  rig_d3d12_pipeline pipeline;
  ID3D12DescriptorHeap *heap, *target_heap;
  ID3D12Resource *target;
  rig_buffer copy;
  uint32_t size;
} reader;

static void reader_open(reader *reader, rig *rig, uint32_t size) {
  const D3D12_DESCRIPTOR_HEAP_DESC heap = {.Type = D3D12_DESCRIPTOR_HEAP_TYPE_CBV_SRV_UAV,
                                           .NumDescriptors = 2,
                                           .Flags = D3D12_DESCRIPTOR_HEAP_FLAG_SHADER_VISIBLE};
  const D3D12_DESCRIPTOR_HEAP_DESC targets = {.Type = D3D12_DESCRIPTOR_HEAP_TYPE_RTV, .NumDescriptors = 1};
  D3D12_GRAPHICS_PIPELINE_STATE_DESC info = {
      .VS = {shader_screen_vs.dxbc, shader_screen_vs.dxbc_size},
      .PS = {shader_bindings_ps.dxbc, shader_bindings_ps.dxbc_size},
      .BlendState = {.RenderTarget = {{.RenderTargetWriteMask = D3D12_COLOR_WRITE_ENABLE_ALL}}},
      .NumRenderTargets = 1,
      .RTVFormats = {DXGI_FORMAT_R32G32B32A32_FLOAT},
  };
  float *nothing = calloc((size_t)size * size, 16);
  *reader = (struct reader){.rig = rig, .pipeline = rig_d3d12_pipeline_make(rig, 2, &info), .size = size};
  const D3D12_RESOURCE_DESC description = {.Width = size,
                                           .Height = size,
                                           .Format = DXGI_FORMAT_R32G32B32A32_FLOAT,
                                           .Flags = D3D12_RESOURCE_FLAG_ALLOW_RENDER_TARGET};
  reader->target = rig_d3d12_image(rig, &description, 16, nothing);
  free(nothing);
  rig_d3d12_must(
      ID3D12Device_CreateDescriptorHeap(rig->device, &heap, &IID_ID3D12DescriptorHeap, (void **)&reader->heap),
      "a heap");
  rig_d3d12_must(ID3D12Device_CreateDescriptorHeap(rig->device, &targets, &IID_ID3D12DescriptorHeap,
                                                   (void **)&reader->target_heap),
                 "a heap");
  ID3D12Device_CreateRenderTargetView(rig->device, reader->target, NULL,
                                      ID3D12DescriptorHeap_GetCPUDescriptorHandleForHeapStart(reader->target_heap));
  reader->copy = rig_buffer_make(rig, RIG_READBACK, (uint64_t)rig_pitch(size, 16) * size);
}

static void reader_close(reader *reader) {
  rig_d3d12_pipeline_free(&reader->pipeline);
  ID3D12DescriptorHeap_Release(reader->heap);
  ID3D12DescriptorHeap_Release(reader->target_heap);
  ID3D12Resource_Release(reader->target);
  rig_buffer_free(reader->rig, &reader->copy);
}

static void reader_draw(const reader *reader) {
  ID3D12GraphicsCommandList *list = rig_commands(reader->rig);
  const D3D12_CPU_DESCRIPTOR_HANDLE target =
      ID3D12DescriptorHeap_GetCPUDescriptorHandleForHeapStart(reader->target_heap);
  const D3D12_VIEWPORT viewport = {.Width = (float)reader->size, .Height = (float)reader->size, .MaxDepth = 1};
  const D3D12_RECT scissor = {.right = (LONG)reader->size, .bottom = (LONG)reader->size};
  rig_d3d12_barrier(list, reader->target, D3D12_RESOURCE_STATE_PIXEL_SHADER_RESOURCE,
                    D3D12_RESOURCE_STATE_RENDER_TARGET);
  ID3D12GraphicsCommandList_OMSetRenderTargets(list, 1, &target, FALSE, NULL);
  ID3D12GraphicsCommandList_RSSetViewports(list, 1, &viewport);
  ID3D12GraphicsCommandList_RSSetScissorRects(list, 1, &scissor);
  ID3D12GraphicsCommandList_SetDescriptorHeaps(list, 1, &reader->heap);
  ID3D12GraphicsCommandList_SetGraphicsRootSignature(list, reader->pipeline.signature);
  ID3D12GraphicsCommandList_SetPipelineState(list, reader->pipeline.state);
  ID3D12GraphicsCommandList_SetGraphicsRootDescriptorTable(
      list, 0, ID3D12DescriptorHeap_GetGPUDescriptorHandleForHeapStart(reader->heap));
  ID3D12GraphicsCommandList_IASetPrimitiveTopology(list, D3D_PRIMITIVE_TOPOLOGY_TRIANGLELIST);
  ID3D12GraphicsCommandList_DrawInstanced(list, 3, 1, 0, 0);
  rig_d3d12_barrier(list, reader->target, D3D12_RESOURCE_STATE_RENDER_TARGET,
                    D3D12_RESOURCE_STATE_PIXEL_SHADER_RESOURCE | D3D12_RESOURCE_STATE_NON_PIXEL_SHADER_RESOURCE);
  rig_copy(reader->rig, &(rig_layer){(uintptr_t)reader->target, 0, reader->size, reader->size, 16}, &reader->copy, 0);
}

/* What the shader read at the descriptors is what csm drew: maps to the bit, the mask's steps of 255 as floats. */
static void expect_read(const reader *reader, const picture *expected) {
  const char *memory = reader->copy.mapped;
  const uint32_t pitch = rig_pitch(reader->size, 16);
  uint32_t different = 0;
  for (uint32_t y = 0; y < reader->size; ++y)
    for (uint32_t x = 0; x < reader->size; ++x) {
      const float *texel = (const float *)(memory + (size_t)y * pitch + (size_t)x * 16);
      for (uint32_t i = 0; i < expected->count; ++i) {
        const picture_layer *layer = &expected->layers[i];
        if (x < layer->width && y < layer->height)
          different += i + 1 < expected->count ? texel[i] != layer->texels[y * layer->width + x]
                                               : fabsf(texel[i] - layer->texels[y * layer->width + x]) > 1e-6f;
      }
    }
  assert_int_equal(different, 0);
}

static void descriptors_are_written(void **state) {
  (void)state;
  stage stage;
  reader reader;
  picture own = draw_own();
  rig *rig = rig_open(RIG_TYPICAL);
  stage_open(&stage, rig);
  reader_open(&reader, rig, stage.config.resolution);
  rig_begin(rig);
  shot shot = stage_shot(&stage, 0);
  stage_render(&stage, &shot);
  stage_resolve(&stage, &shot, size);
  const SIZE_T where = ID3D12DescriptorHeap_GetCPUDescriptorHandleForHeapStart(reader.heap).ptr;
  const UINT step = ID3D12Device_GetDescriptorHandleIncrementSize(rig->device, D3D12_DESCRIPTOR_HEAP_TYPE_CBV_SRV_UAV);
  csm_binding binding = {.struct_size = sizeof binding, .maps_descriptor = where, .mask_descriptor = where + step};
  binding.view = stage.view;
  assert_int_equal(csm_bind(stage.cascades, &binding), CSM_SUCCESS);
  assert_true(binding.native_maps != 0 && binding.native_mask != 0);
  assert_true(!binding.native_maps_view && !binding.native_mask_view && !binding.native_sampler);
  reader_draw(&reader);
  stage_finish(&stage);
  expect_read(&reader, &own);
  reader_close(&reader);
  picture_free(&own);
  stage_close(&stage);
  rig_close(rig);
}

/* ---- what recordings leave ---- */

/* The list lets through nothing but what the header names. Frames share lists or not; meshes come in between. */
static void recordings_change_what_the_header_lists(void **state) {
  (void)state;
  stage stage;
  hill hill;
  d3d12_list list = {0};
  hill_make(&hill);
  picture own = draw_own();
  rig *rig = rig_open(RIG_TYPICAL);
  stage_open(&stage, rig);
  for (uint32_t i = 1; i <= 4; ++i) {
    d3d12_list_begin(&list, rig_begin(rig));
    shot shot = stage_shot(&stage, 0);
    shot.frame.command_buffer = &list.list;
    shot.frame.flags = CSM_FRAME_TIMESTAMPS;
    stage_render(&stage, &shot);
    assert_int_equal(list.heaps_set, 0); /* nothing is sampled */
    assert_true(list.draws > 0 && list.barriers > 0);
    if (i % 2)
      d3d12_list_begin(&list, rig_split(rig));
    hill_mesh(stage.context, &hill, 4); /* is uploaded by the mask's recording, into a page that is drawn from */
    stage_resolve(&stage, &shot, size);
    assert_int_equal(list.heaps_set, 1);
    picture_copy copy = stage_record(&stage, size);
    stage_finish(&stage);
    picture drawn = picture_take(rig, &copy);
    picture_expect_equal(&own, &drawn);
  }
  picture_free(&own);
  stage_close(&stage);
  rig_close(rig);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(images_are_held_while_in_flight), cmocka_unit_test(meshes_are_held_while_in_flight),
      cmocka_unit_test(the_device_is_given_back),        cmocka_unit_test(every_heap_is_the_engines),
      cmocka_unit_test(a_feature_level_may_be_too_low),  cmocka_unit_test(a_compute_list_is_refused),
      cmocka_unit_test(descriptors_are_written),         cmocka_unit_test(recordings_change_what_the_header_lists),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
