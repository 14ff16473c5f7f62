/* d3d12_memory.c: all that csm makes on an engine's Direct3D 12 device lies where the engine's allocator says. */
#include "d3d12_rig.h"

enum { MASK_WIDTH = 192, MASK_HEIGHT = 128 };

/* An allocator that gives each piece a heap of its own, and places it at its second possible offset. */
typedef struct allocator {
  ID3D12Device *device;
  uint32_t requests, live;
  uint32_t fail_at;  /* the request that is refused, from 1; 0: none */
  uint32_t kinds[4]; /* pieces by D3D12_HEAP_TYPE */
} allocator;

static int32_t CSM_CALL allocate(void *user, const csm_d3d12_memory_request *request, csm_d3d12_memory *out) {
  allocator *pieces = user;
  assert_int_equal(request->struct_size, sizeof *request);
  assert_true(request->size && request->alignment && request->name);
  assert_in_range(request->heap_type, D3D12_HEAP_TYPE_DEFAULT, D3D12_HEAP_TYPE_READBACK);
  if (++pieces->requests == pieces->fail_at)
    return E_OUTOFMEMORY;
  const D3D12_HEAP_DESC description = {.SizeInBytes = request->size + request->alignment,
                                       .Properties = {.Type = request->heap_type},
                                       .Alignment = request->alignment,
                                       .Flags = request->heap_flags};
  const HRESULT hr = ID3D12Device_CreateHeap(pieces->device, &description, &IID_ID3D12Heap, &out->heap);
  if (FAILED(hr))
    return hr;
  out->offset = request->alignment;
  out->handle = out->heap;
  pieces->kinds[request->heap_type]++;
  pieces->live++;
  return S_OK;
}

static void CSM_CALL give_back(void *user, const csm_d3d12_memory *memory) {
  allocator *pieces = user;
  assert_ptr_equal(memory->handle, memory->heap);
  assert_true(pieces->live);
  pieces->live--;
  ID3D12Heap_Release((ID3D12Heap *)memory->heap);
}

static csm_result open_with(d3d12_rig *rig, allocator *pieces) {
  *rig = (d3d12_rig){0};
  d3d12_engine_open(&rig->engine);
  rig->references = d3d12_engine_references(rig->engine.device);
  pieces->device = rig->engine.device;
  rig->engine.native.allocate_memory = allocate;
  rig->engine.native.free_memory = give_back;
  rig->engine.native.memory_user = pieces;
  const csm_create_info info = rig_create_info(&rig->record, &rig->engine.native);
  return csm_create(&info, &rig->context);
}

static void render(csm_context *context, support_scene *scene, csm_cascades **out, const csm_config *config) {
  support_scene_make(scene, context);
  assert_int_equal(csm_cascades_create(context, config, out), CSM_SUCCESS);
}

static void resolve(csm_cascades *cascades, const csm_frame *frame) {
  const csm_mask_info mask = {.struct_size = sizeof mask, .frame = frame, .width = MASK_WIDTH, .height = MASK_HEIGHT};
  assert_int_equal(csm_resolve_mask(cascades, &mask), CSM_SUCCESS);
}

static picture draw_own(const csm_config *config) {
  record record = {0};
  support_scene scene;
  csm_cascades *cascades;
  csm_context *context = support_open(&record);
  render(context, &scene, &cascades, config);
  assert_int_equal(csm_render_cascades(cascades, &scene.frame), CSM_SUCCESS);
  resolve(cascades, &scene.frame);
  const picture out = picture_read(cascades, config, MASK_WIDTH, MASK_HEIGHT);
  support_close(context, &record);
  return out;
}

static picture draw_placed(d3d12_rig *rig, const csm_config *config) {
  support_scene scene;
  csm_cascades *cascades;
  render(rig->context, &scene, &cascades, config);
  ID3D12GraphicsCommandList *list = d3d12_engine_begin(&rig->engine);
  csm_frame frame = rig_frame(rig, &scene, list);
  rig_render(rig, cascades, &frame);
  resolve(cascades, &frame);
  picture_copy copy = picture_record(rig, list, cascades, MASK_WIDTH, MASK_HEIGHT);
  d3d12_engine_end(&rig->engine);
  d3d12_engine_run(&rig->engine, rig->engine.frame);
  rig_retire(rig);
  return picture_take(&copy);
}

/* What lies in the engine's heaps is drawn as what lies in csm's own, and every piece goes back. */
static void the_engines_heaps_hold_everything(void **state) {
  (void)state;
  const csm_config config = support_config();
  d3d12_rig rig;
  allocator pieces = {0};
  picture expected = draw_own(&config);
  assert_int_equal(open_with(&rig, &pieces), CSM_SUCCESS);
  picture placed = draw_placed(&rig, &config);
  picture_expect_equal(&expected, &placed);
  picture_expect_casters(&placed, config.cascade_count);
  for (uint32_t kind = D3D12_HEAP_TYPE_DEFAULT; kind <= D3D12_HEAP_TYPE_READBACK; kind++)
    assert_true(pieces.kinds[kind]);
  rig_close(&rig);
  assert_int_equal(pieces.live, 0);
  picture_free(&expected);
  picture_free(&placed);
}

/* Each refusal while a context is made is told by name, and nothing is kept. */
static void a_refusal_is_out_of_device_memory(void **state) {
  (void)state;
  uint32_t at = 1;
  for (;; at++) {
    d3d12_rig rig;
    allocator pieces = {.fail_at = at};
    const csm_result result = open_with(&rig, &pieces);
    if (result == CSM_SUCCESS) {
      rig_close(&rig);
      break;
    }
    assert_int_equal(result, CSM_ERROR_OUT_OF_DEVICE_MEMORY);
    assert_int_equal(pieces.live, 0);
    assert_int_equal(rig.record.blocks, 0);
    assert_int_equal(d3d12_engine_references(rig.engine.device), rig.references);
    d3d12_engine_close(&rig.engine);
  }
  assert_true(at > 1);
}

static void half_an_allocator_is_refused(void **state) {
  (void)state;
  for (uint32_t half = 0; half < 2; half++) {
    d3d12_engine engine;
    record record = {.quiet = true};
    csm_context *context = NULL;
    d3d12_engine_open(&engine);
    if (half)
      engine.native.allocate_memory = allocate;
    else
      engine.native.free_memory = give_back;
    const csm_create_info info = rig_create_info(&record, &engine.native);
    assert_int_equal(csm_create(&info, &context), CSM_ERROR_NULL_POINTER);
    assert_int_equal(record.blocks, 0);
    d3d12_engine_close(&engine);
  }
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_engines_heaps_hold_everything),
      cmocka_unit_test(a_refusal_is_out_of_device_memory),
      cmocka_unit_test(half_an_allocator_is_refused),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
