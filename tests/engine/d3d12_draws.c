/* d3d12_draws.c: an engine's own casters in the cascades' maps, its shaders that read them, and what csm's recordings
 * leave to it. */
#include "d3d12_list.h"
#include "d3d12_rig.h"

#include "bindings_code.h"
#include "shader_code.h"

#include <math.h>
#include <stdlib.h>

enum { HILLS = 2, ROWS = 3 * 4, MASK_WIDTH = 192, MASK_HEIGHT = 128, SLOT_BYTES = HILLS * ROWS * sizeof(float) };

/* A context with the scene, whose last instances are hills. */
typedef struct side {
  csm_context *context;
  csm_cascades *cascades;
  csm_config config;
  support_scene scene;
} side;

enum { FIRST_HILL = SUPPORT_INSTANCES - HILLS };

static void side_open(side *side, csm_context *context, const hill *hill) {
  *side = (struct side){.context = context, .config = support_config()};
  support_scene_make(&side->scene, context);
  const csm_mesh mesh = hill_mesh(context, hill, 2);
  side->scene.instances[FIRST_HILL] = support_instance(mesh, -4, 3, -3, 2, 1, 3);
  side->scene.instances[FIRST_HILL + 1] = support_instance(mesh, 5, 9, -12, 4, 2, 2);
  side->scene.frame.instances = side->scene.instances;
  assert_int_equal(csm_cascades_create(context, &side->config, &side->cascades), CSM_SUCCESS);
}

static picture draw_own(const hill *hill) {
  record record = {0};
  side own;
  side_open(&own, support_open(&record), hill);
  own.scene.frame.instances = own.scene.instances;
  const csm_mask_info mask = {
      .struct_size = sizeof mask, .frame = &own.scene.frame, .width = MASK_WIDTH, .height = MASK_HEIGHT};
  assert_int_equal(csm_render_cascades(own.cascades, &own.scene.frame), CSM_SUCCESS);
  assert_int_equal(csm_resolve_mask(own.cascades, &mask), CSM_SUCCESS);
  const picture out = picture_read(own.cascades, &own.config, MASK_WIDTH, MASK_HEIGHT);
  support_close(own.context, &record);
  return out;
}

static void resolve(const side *side, const csm_frame *frame) {
  const csm_mask_info mask = {.struct_size = sizeof mask, .frame = frame, .width = MASK_WIDTH, .height = MASK_HEIGHT};
  assert_int_equal(csm_resolve_mask(side->cascades, &mask), CSM_SUCCESS);
}

/* ---- the engine's pipelines ---- */

typedef struct pipeline {
  ID3D12RootSignature *signature;
  ID3D12PipelineState *state;
} pipeline;

/* One table of `textures` textures, if any. */
static ID3D12RootSignature *make_signature(d3d12_engine *engine, uint32_t textures) {
  const D3D12_DESCRIPTOR_RANGE range = {.RangeType = D3D12_DESCRIPTOR_RANGE_TYPE_SRV, .NumDescriptors = textures};
  const D3D12_ROOT_PARAMETER parameter = {.ParameterType = D3D12_ROOT_PARAMETER_TYPE_DESCRIPTOR_TABLE,
                                          .DescriptorTable = {.NumDescriptorRanges = 1, .pDescriptorRanges = &range}};
  const D3D12_ROOT_SIGNATURE_DESC description = {.NumParameters = textures ? 1 : 0,
                                                 .pParameters = &parameter,
                                                 .Flags = D3D12_ROOT_SIGNATURE_FLAG_ALLOW_INPUT_ASSEMBLER_INPUT_LAYOUT};
  ID3DBlob *blob = NULL;
  ID3D12RootSignature *signature;
  d3d12_engine_must(D3D12SerializeRootSignature(&description, D3D_ROOT_SIGNATURE_VERSION_1_0, &blob, NULL),
                    "serialising a root signature");
  d3d12_engine_must(ID3D12Device_CreateRootSignature(engine->device, 0, ID3D10Blob_GetBufferPointer(blob),
                                                     ID3D10Blob_GetBufferSize(blob), &IID_ID3D12RootSignature,
                                                     (void **)&signature),
                    "a root signature");
  ID3D10Blob_Release(blob);
  return signature;
}

static pipeline make_pipeline(d3d12_engine *engine, uint32_t textures, D3D12_GRAPHICS_PIPELINE_STATE_DESC *info) {
  pipeline out = {.signature = make_signature(engine, textures)};
  info->pRootSignature = out.signature;
  info->SampleMask = ~0u;
  info->RasterizerState.FillMode = D3D12_FILL_MODE_SOLID;
  info->RasterizerState.CullMode = D3D12_CULL_MODE_NONE;
  info->PrimitiveTopologyType = D3D12_PRIMITIVE_TOPOLOGY_TYPE_TRIANGLE;
  info->SampleDesc.Count = 1;
  d3d12_engine_must(
      ID3D12Device_CreateGraphicsPipelineState(engine->device, info, &IID_ID3D12PipelineState, (void **)&out.state),
      "a pipeline");
  return out;
}

static void free_pipeline(pipeline *pipeline) {
  ID3D12PipelineState_Release(pipeline->state);
  ID3D12RootSignature_Release(pipeline->signature);
}

static pipeline make_caster_pipeline(d3d12_engine *engine) {
  static const D3D12_INPUT_ELEMENT_DESC elements[] = {
      {"ATTRIBUTE", 0, DXGI_FORMAT_R32G32B32_FLOAT, 0, 0, D3D12_INPUT_CLASSIFICATION_PER_VERTEX_DATA, 0},
      {"ATTRIBUTE", 1, DXGI_FORMAT_R32G32B32A32_FLOAT, 3, 0, D3D12_INPUT_CLASSIFICATION_PER_INSTANCE_DATA, 1},
      {"ATTRIBUTE", 2, DXGI_FORMAT_R32G32B32A32_FLOAT, 3, 16, D3D12_INPUT_CLASSIFICATION_PER_INSTANCE_DATA, 1},
      {"ATTRIBUTE", 3, DXGI_FORMAT_R32G32B32A32_FLOAT, 3, 32, D3D12_INPUT_CLASSIFICATION_PER_INSTANCE_DATA, 1},
  };
  D3D12_GRAPHICS_PIPELINE_STATE_DESC info = {
      .VS = {shader_cascade_depth_vs.dxbc, shader_cascade_depth_vs.dxbc_size},
      .DepthStencilState = {.DepthEnable = TRUE,
                            .DepthWriteMask = D3D12_DEPTH_WRITE_MASK_ALL,
                            .DepthFunc = D3D12_COMPARISON_FUNC_LESS},
      .InputLayout = {elements, sizeof elements / sizeof *elements},
      .DSVFormat = DXGI_FORMAT_D32_FLOAT,
  };
  return make_pipeline(engine, 0, &info);
}

/* ---- the draw callback ---- */

typedef struct caster {
  d3d12_engine *engine;
  const csm_instance *hills;
  void *expected_list;
  pipeline pipeline;
  ID3D12Resource *vertices, *indices, *rows;
  ID3D12DescriptorHeap *heap; /* of the engine's own, to be set in between */
  uint32_t calls, inside;     /* instances within the visible bounds */
  csm_draw_info last;
} caster;

static void caster_open(caster *caster, d3d12_engine *engine, const hill *hill, const side *side) {
  const D3D12_DESCRIPTOR_HEAP_DESC heap = {.Type = D3D12_DESCRIPTOR_HEAP_TYPE_CBV_SRV_UAV,
                                           .NumDescriptors = 4,
                                           .Flags = D3D12_DESCRIPTOR_HEAP_FLAG_SHADER_VISIBLE};
  *caster = (struct caster){.engine = engine, .hills = &side->scene.instances[FIRST_HILL]};
  caster->pipeline = make_caster_pipeline(engine);
  caster->vertices =
      d3d12_engine_buffer(engine, D3D12_HEAP_TYPE_UPLOAD, sizeof hill->positions, (const void *)hill->positions);
  caster->indices = d3d12_engine_buffer(engine, D3D12_HEAP_TYPE_UPLOAD, sizeof hill->indices, hill->indices);
  caster->rows = d3d12_engine_buffer(engine, D3D12_HEAP_TYPE_UPLOAD, CSM_MAX_CASCADES * SLOT_BYTES, NULL);
  d3d12_engine_must(
      ID3D12Device_CreateDescriptorHeap(engine->device, &heap, &IID_ID3D12DescriptorHeap, (void **)&caster->heap),
      "a heap");
}

static void caster_close(caster *caster) {
  free_pipeline(&caster->pipeline);
  ID3D12Resource_Release(caster->vertices);
  ID3D12Resource_Release(caster->indices);
  ID3D12Resource_Release(caster->rows);
  ID3D12DescriptorHeap_Release(caster->heap);
}

/* Object to clip, in doubles, as csm makes it of an instance. */
static void write_rows(const csm_draw_info *info, const csm_instance *instance, float out[ROWS]) {
  const double *m = info->world_to_clip, *t = instance->transform;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column) {
      const double constant = column == 3 ? m[12 + row] : 0;
      out[row * 4 + column] =
          (float)(m[row] * t[column * 4] + m[4 + row] * t[column * 4 + 1] + m[8 + row] * t[column * 4 + 2] + constant);
    }
}

/* Whether an instance's centre lies within the planes of what may cast. */
static bool is_inside(const csm_draw_info *info, const csm_instance *instance) {
  const double *p = &instance->transform[12];
  for (int i = 0; i < 5; ++i)
    if (info->planes[i][0] * p[0] + info->planes[i][1] * p[1] + info->planes[i][2] * p[2] + info->planes[i][3] < 0)
      return false;
  return true;
}

static void CSM_CALL draw_hills(void *user, const csm_draw_info *info) {
  caster *caster = user;
  ID3D12GraphicsCommandList *list = info->command_buffer;
  const D3D12_CPU_DESCRIPTOR_HANDLE depth = {.ptr = (SIZE_T)info->depth_view};
  float *rows = (float *)d3d12_engine_map(caster->rows) + info->cascade * HILLS * ROWS;
  assert_ptr_equal(list, caster->expected_list);
  assert_int_equal(info->cascade, caster->calls++);
  for (int i = 0; i < HILLS; ++i) {
    write_rows(info, &caster->hills[i], rows + i * ROWS);
    caster->inside += is_inside(info, &caster->hills[i]);
  }
  const D3D12_VERTEX_BUFFER_VIEW vertices = {ID3D12Resource_GetGPUVirtualAddress(caster->vertices), HILL_VERTICES * 12,
                                             12};
  const D3D12_VERTEX_BUFFER_VIEW instances = {
      ID3D12Resource_GetGPUVirtualAddress(caster->rows) + info->cascade * SLOT_BYTES, SLOT_BYTES, ROWS * sizeof(float)};
  const D3D12_INDEX_BUFFER_VIEW indices = {ID3D12Resource_GetGPUVirtualAddress(caster->indices), HILL_INDICES * 2,
                                           DXGI_FORMAT_R16_UINT};
  /* Everything that it may change: csm must set its own again. */
  ID3D12GraphicsCommandList_SetDescriptorHeaps(list, 1, &caster->heap);
  ID3D12GraphicsCommandList_OMSetRenderTargets(list, 0, NULL, FALSE, &depth);
  ID3D12GraphicsCommandList_SetGraphicsRootSignature(list, caster->pipeline.signature);
  ID3D12GraphicsCommandList_SetPipelineState(list, caster->pipeline.state);
  ID3D12GraphicsCommandList_IASetPrimitiveTopology(list, D3D_PRIMITIVE_TOPOLOGY_TRIANGLELIST);
  ID3D12GraphicsCommandList_IASetVertexBuffers(list, 0, 1, &vertices);
  ID3D12GraphicsCommandList_IASetVertexBuffers(list, 3, 1, &instances);
  ID3D12GraphicsCommandList_IASetIndexBuffer(list, &indices);
  ID3D12GraphicsCommandList_DrawIndexedInstanced(list, HILL_INDICES, HILLS, 0, 0, 0);
  caster->last = *info;
}

/* `csms` instances are drawn by csm, the hills by the engine; the maps are as if csm had drawn both. */
static void draw_with_callback(const hill *hill, uint32_t csms, picture *out) {
  d3d12_rig rig;
  side side;
  caster caster;
  rig_open(&rig);
  side_open(&side, rig.context, hill);
  caster_open(&caster, &rig.engine, hill, &side);
  ID3D12GraphicsCommandList *list = d3d12_engine_begin(&rig.engine);
  csm_frame frame = rig_frame(&rig, &side.scene, list);
  frame.instance_count = csms;
  frame.draw = draw_hills;
  frame.draw_user = &caster;
  caster.expected_list = list;
  rig_render(&rig, side.cascades, &frame);
  frame.instance_count = SUPPORT_INSTANCES;
  resolve(&side, &frame);
  picture_copy copy = picture_record(&rig, list, side.cascades, MASK_WIDTH, MASK_HEIGHT);
  d3d12_engine_end(&rig.engine);
  d3d12_engine_run(&rig.engine, rig.engine.frame);
  *out = picture_take(&copy);
  assert_int_equal(caster.calls, side.config.cascade_count);
  assert_int_equal(caster.last.depth_format, DXGI_FORMAT_D32_FLOAT);
  assert_int_equal(caster.last.resolution, side.config.resolution);
  assert_true(caster.last.depth_view != 0);
  assert_true(caster.last.render_pass == 0);
  assert_in_range(caster.inside, 1, HILLS * side.config.cascade_count);
  caster_close(&caster);
  rig_close(&rig);
}

static void an_engine_draws_casters_of_its_own(void **state) {
  (void)state;
  hill hill;
  hill_make(&hill);
  picture own = draw_own(&hill), both;
  draw_with_callback(&hill, FIRST_HILL, &both);
  picture_expect_equal(&own, &both);
  picture_free(&both);
  picture_free(&own);
}

static void an_engine_draws_all_casters(void **state) {
  (void)state;
  hill hill;
  hill_make(&hill);
  picture drawn;
  draw_with_callback(&hill, 0, &drawn);
  uint32_t texels = 0;
  for (uint32_t i = 0; i < 256 * 256; ++i)
    texels += drawn.layers[2].texels[i] < 1;
  assert_true(texels > 50);
  picture_free(&drawn);
}

/* ---- csm_bind ---- */

typedef struct reader {
  pipeline pipeline;
  ID3D12DescriptorHeap *heap, *target_heap;
  ID3D12Resource *target, *copy;
  uint32_t size;
} reader;

static void reader_open(reader *reader, d3d12_engine *engine, uint32_t size) {
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
  *reader = (struct reader){.pipeline = make_pipeline(engine, 2, &info), .size = size};
  reader->target = d3d12_engine_image(engine, DXGI_FORMAT_R32G32B32A32_FLOAT, D3D12_RESOURCE_FLAG_ALLOW_RENDER_TARGET,
                                      size, size, 16, nothing);
  free(nothing);
  d3d12_engine_must(
      ID3D12Device_CreateDescriptorHeap(engine->device, &heap, &IID_ID3D12DescriptorHeap, (void **)&reader->heap),
      "a heap");
  d3d12_engine_must(ID3D12Device_CreateDescriptorHeap(engine->device, &targets, &IID_ID3D12DescriptorHeap,
                                                      (void **)&reader->target_heap),
                    "a heap");
  ID3D12Device_CreateRenderTargetView(engine->device, reader->target, NULL,
                                      ID3D12DescriptorHeap_GetCPUDescriptorHandleForHeapStart(reader->target_heap));
  reader->copy =
      d3d12_engine_buffer(engine, D3D12_HEAP_TYPE_READBACK, (uint64_t)d3d12_engine_pitch(size, 16) * size, NULL);
}

static void reader_close(reader *reader) {
  free_pipeline(&reader->pipeline);
  ID3D12DescriptorHeap_Release(reader->heap);
  ID3D12DescriptorHeap_Release(reader->target_heap);
  ID3D12Resource_Release(reader->target);
  ID3D12Resource_Release(reader->copy);
}

static void reader_draw(const reader *reader, ID3D12GraphicsCommandList *list) {
  const D3D12_CPU_DESCRIPTOR_HANDLE target =
      ID3D12DescriptorHeap_GetCPUDescriptorHandleForHeapStart(reader->target_heap);
  const D3D12_VIEWPORT viewport = {.Width = (float)reader->size, .Height = (float)reader->size, .MaxDepth = 1};
  const D3D12_RECT scissor = {.right = (LONG)reader->size, .bottom = (LONG)reader->size};
  d3d12_engine_barrier(list, reader->target, D3D12_RESOURCE_STATE_PIXEL_SHADER_RESOURCE,
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
  d3d12_engine_barrier(list, reader->target, D3D12_RESOURCE_STATE_RENDER_TARGET,
                       D3D12_RESOURCE_STATE_PIXEL_SHADER_RESOURCE | D3D12_RESOURCE_STATE_NON_PIXEL_SHADER_RESOURCE);
  d3d12_engine_copy(list, reader->target, 0, 16, reader->copy, 0);
}

/* What the shader read at the descriptors is what csm drew: maps to the bit, the mask's steps of 255 as floats. */
static void expect_read(const reader *reader, const picture *expected) {
  const char *memory = d3d12_engine_map(reader->copy);
  const uint32_t pitch = d3d12_engine_pitch(reader->size, 16);
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
  d3d12_rig rig;
  side side;
  reader reader;
  hill hill;
  hill_make(&hill);
  picture own = draw_own(&hill);
  rig_open(&rig);
  side_open(&side, rig.context, &hill);
  reader_open(&reader, &rig.engine, side.config.resolution);
  ID3D12GraphicsCommandList *list = d3d12_engine_begin(&rig.engine);
  csm_frame frame = rig_frame(&rig, &side.scene, list);
  rig_render(&rig, side.cascades, &frame);
  resolve(&side, &frame);
  const SIZE_T where = ID3D12DescriptorHeap_GetCPUDescriptorHandleForHeapStart(reader.heap).ptr;
  const UINT step =
      ID3D12Device_GetDescriptorHandleIncrementSize(rig.engine.device, D3D12_DESCRIPTOR_HEAP_TYPE_CBV_SRV_UAV);
  csm_binding binding = {.struct_size = sizeof binding, .maps_descriptor = where, .mask_descriptor = where + step};
  assert_int_equal(csm_bind(side.cascades, &binding), CSM_SUCCESS);
  assert_true(binding.native_maps != 0 && binding.native_mask != 0);
  assert_true(!binding.native_maps_view && !binding.native_mask_view && !binding.native_sampler);
  reader_draw(&reader, list);
  d3d12_engine_end(&rig.engine);
  d3d12_engine_run(&rig.engine, rig.engine.frame);
  expect_read(&reader, &own);
  reader_close(&reader);
  picture_free(&own);
  rig_close(&rig);
}

/* ---- what recordings leave ---- */

/* The list lets through nothing but what the header names. Frames share lists or not; meshes come in between. */
static void recordings_change_what_the_header_lists(void **state) {
  (void)state;
  d3d12_rig rig;
  side side;
  hill hill;
  d3d12_list list = {0};
  hill_make(&hill);
  picture own = draw_own(&hill);
  rig_open(&rig);
  side_open(&side, rig.context, &hill);
  for (uint32_t i = 1; i <= 4; ++i) {
    d3d12_list_begin(&list, d3d12_engine_begin(&rig.engine));
    csm_frame frame = rig_frame(&rig, &side.scene, &list.list);
    frame.flags = CSM_FRAME_TIMESTAMPS;
    rig_render(&rig, side.cascades, &frame);
    assert_int_equal(list.heaps_set, 0); /* nothing is sampled */
    assert_true(list.draws > 0 && list.barriers > 0);
    if (i % 2) {
      ID3D12GraphicsCommandList *next = d3d12_engine_split(&rig.engine);
      d3d12_list_begin(&list, next);
    }
    hill_mesh(rig.context, &hill, 4); /* is uploaded by the mask's recording, into a page that is drawn from */
    resolve(&side, &frame);
    assert_int_equal(list.heaps_set, 1);
    picture_copy copy = picture_record(&rig, list.real, side.cascades, MASK_WIDTH, MASK_HEIGHT);
    d3d12_engine_end(&rig.engine);
    d3d12_engine_run(&rig.engine, rig.engine.frame);
    rig_retire(&rig);
    picture drawn = picture_take(&copy);
    picture_expect_equal(&own, &drawn);
    picture_free(&drawn);
  }
  picture_free(&own);
  rig_close(&rig);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(an_engine_draws_casters_of_its_own),
      cmocka_unit_test(an_engine_draws_all_casters),
      cmocka_unit_test(descriptors_are_written),
      cmocka_unit_test(recordings_change_what_the_header_lists),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
