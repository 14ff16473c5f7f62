/*
 * d3d12_faults.c: every call of an engine's ID3D12Device that can fail does so once, and every allocation: csm answers
 * with the error's name, and goes on as if nothing had happened, or is lost for good; nothing leaks either way.
 */
#include "d3d12_proxy.h"
#include "d3d12_rig.h"

#include <string.h>

enum { SIDE = 64, STRIDE = 20 };

static const HRESULT removed = (HRESULT)0x887a0005; /* DXGI_ERROR_DEVICE_REMOVED */

typedef struct fault {
  HRESULT hr; /* S_OK: an allocation of host memory fails */
  csm_result expected;
} fault;

/* What lives through all runs. */
typedef struct stage {
  d3d12_engine engine;
  hill hill;
  ID3D12Resource *vertices, *indices, *depth, *normals;
  picture expected;
} stage;

/* One run through everything that a context does. */
typedef struct run {
  stage *stage;
  fault fault;
  d3d12_proxy proxy;
  csm_d3d12_device native;
  record record;
  csm_context *context;
  csm_cascades *cascades;
  csm_config config;
  support_scene scene;
  csm_frame frame;
  csm_mesh copied, engines;
  bool lost;
} run;

/* ---- the stage ---- */

static void stage_open(stage *stage) {
  static float depth[SIDE * SIDE], normals[SIDE * SIDE][4];
  for (int i = 0; i < SIDE * SIDE; ++i) {
    depth[i] = (float)(i / SIDE) / (8 * SIDE);
    normals[i][1] = 1;
  }
  *stage = (struct stage){0};
  d3d12_engine_open(&stage->engine);
  hill_make(&stage->hill);
  stage->vertices = d3d12_engine_buffer(&stage->engine, D3D12_HEAP_TYPE_UPLOAD, HILL_VERTICES * STRIDE, NULL);
  stage->indices =
      d3d12_engine_buffer(&stage->engine, D3D12_HEAP_TYPE_UPLOAD, sizeof stage->hill.indices, stage->hill.indices);
  char *memory = d3d12_engine_map(stage->vertices);
  for (uint32_t i = 0; i < HILL_VERTICES; ++i)
    memcpy(memory + (size_t)i * STRIDE, stage->hill.positions[i], sizeof stage->hill.positions[i]);
  stage->depth = d3d12_engine_image(&stage->engine, DXGI_FORMAT_R32_FLOAT, 0, SIDE, SIDE, sizeof(float), depth);
  stage->normals =
      d3d12_engine_image(&stage->engine, DXGI_FORMAT_R32G32B32A32_FLOAT, 0, SIDE, SIDE, 4 * sizeof(float), normals);
}

static void stage_close(stage *stage) {
  const uint32_t messages = stage->engine.messages;
  picture_free(&stage->expected);
  assert_int_equal(ID3D12Resource_Release(stage->vertices), 0);
  assert_int_equal(ID3D12Resource_Release(stage->indices), 0);
  assert_int_equal(ID3D12Resource_Release(stage->depth), 0);
  assert_int_equal(ID3D12Resource_Release(stage->normals), 0);
  d3d12_engine_close(&stage->engine);
  assert_int_equal(messages, 0);
}

/* ---- steps: each is a call that may fail ---- */

static csm_result create(run *run) {
  csm_create_info info = rig_create_info(&run->record, &run->native);
  run->record.quiet = true;
  info.flags = CSM_CREATE_KEEP_GEOMETRY;
  return csm_create(&info, &run->context);
}

static csm_result create_cascades(run *run) {
  run->config = support_config();
  return csm_cascades_create(run->context, &run->config, &run->cascades);
}

static csm_result create_copied(run *run) {
  const csm_mesh_info info = {.struct_size = sizeof info,
                              .positions = run->stage->hill.positions,
                              .vertex_count = HILL_VERTICES,
                              .indices = run->stage->hill.wide_indices,
                              .index_count = HILL_INDICES,
                              .index_size = 4};
  return csm_mesh_create(run->context, &info, &run->copied);
}

static csm_result create_engines(run *run) {
  const csm_d3d12_mesh native = {.struct_size = sizeof native,
                                 .vertex_stride = STRIDE,
                                 .vertices = run->stage->vertices,
                                 .indices = run->stage->indices};
  const csm_mesh_info info = {.struct_size = sizeof info,
                              .vertex_count = HILL_VERTICES,
                              .index_count = HILL_INDICES,
                              .index_size = 2,
                              .d3d12 = &native,
                              .bounds_min = {-1, -1, -1},
                              .bounds_max = {1, 1, 1}};
  return csm_mesh_create(run->context, &info, &run->engines);
}

static csm_result render(run *run) {
  support_scene_make(&run->scene, NULL);
  for (uint32_t i = 0; i < SUPPORT_INSTANCES; ++i)
    run->scene.instances[i].mesh = i % 2 ? run->copied : run->engines;
  run->frame = run->scene.frame;
  run->frame.instances = run->scene.instances;
  run->frame.frame = run->stage->engine.frame;
  run->frame.command_buffer = run->stage->engine.frames[run->stage->engine.frame % D3D12_ENGINE_FRAMES].lists[0];
  run->frame.flags = CSM_FRAME_TIMESTAMPS;
  return csm_render_cascades(run->cascades, &run->frame);
}

static csm_result resolve_instances(run *run) {
  const csm_mask_info mask = {.struct_size = sizeof mask, .frame = &run->frame, .width = 2 * SIDE, .height = SIDE};
  return csm_resolve_mask(run->cascades, &mask);
}

static csm_result resolve_images(run *run) {
  const csm_d3d12_image depth = {.struct_size = sizeof depth,
                                 .format = DXGI_FORMAT_R32_FLOAT,
                                 .resource = run->stage->depth,
                                 .width = SIDE,
                                 .height = SIDE};
  csm_d3d12_image normals = depth;
  normals.resource = run->stage->normals;
  normals.format = DXGI_FORMAT_R32G32B32A32_FLOAT;
  const csm_mask_info mask = {.struct_size = sizeof mask,
                              .frame = &run->frame,
                              .width = SIDE,
                              .height = SIDE,
                              .camera_depth = &depth,
                              .normals = &normals};
  return csm_resolve_mask(run->cascades, &mask);
}

static csm_result configure(run *run) {
  run->config.resolution = 128;
  run->config.cascade_count = 4;
  return csm_cascades_configure(run->cascades, &run->config);
}

typedef csm_result (*step)(run *run);
static const step steps[] = {create,         create_cascades,   create_copied, create_engines, render,
                             resolve_images, resolve_instances, configure,     render,         resolve_images};
enum { STEPS = sizeof steps / sizeof *steps };

/* ---- a run ---- */

static void expect_failure(run *run, csm_result result, uint32_t index) {
  if (result != run->fault.expected)
    fail_msg("step %u, call %u: %s (%s), not %s", index, run->proxy.fail_at, csm_result_name(result),
             csm_last_error(run->context), csm_result_name(run->fault.expected));
  run->lost = result == CSM_ERROR_DEVICE_LOST;
  if (!run->context) {
    assert_int_equal(run->record.blocks, 0);
    assert_int_equal(run->proxy.references, 1);
    return;
  }
  assert_true(csm_last_error(run->context)[0]);
  csm_cascades *none;
  if (run->lost)
    assert_int_equal(csm_cascades_create(run->context, &run->config, &none), CSM_ERROR_DEVICE_LOST);
}

/* Each step until it succeeds, which is at once or the second time. */
static void go(run *run) {
  for (uint32_t i = 0; i < STEPS && !run->lost; ++i) {
    csm_result result = steps[i](run);
    if (!result)
      continue;
    expect_failure(run, result, i);
    run->record.allocations_left = -1;
    if (run->lost)
      return;
    result = steps[i](run);
    if (result)
      fail_msg("step %u, call %u: %s (%s) when tried again", i, run->proxy.fail_at, csm_result_name(result),
               csm_last_error(run->context));
  }
}

/* What was drawn is what is drawn without a fault. */
static void finish(run *run) {
  stage *stage = run->stage;
  d3d12_rig rig = {.engine = stage->engine};
  picture_copy copy = {0};
  if (!run->lost)
    copy = picture_record(&rig, run->frame.command_buffer, run->cascades, SIDE, SIDE);
  d3d12_engine_end(&stage->engine);
  if (run->lost) { /* what was recorded is never run */
    stage->engine.frames[stage->engine.frame % D3D12_ENGINE_FRAMES].list_count = 0;
    d3d12_engine_run(&stage->engine, stage->engine.frame);
    return;
  }
  d3d12_engine_run(&stage->engine, stage->engine.frame);
  assert_int_equal(csm_retire(run->context, stage->engine.frame), CSM_SUCCESS);
  picture drawn = picture_take(&copy);
  if (!stage->expected.count) {
    picture_expect_casters(&drawn, 3);
    stage->expected = drawn;
  } else {
    picture_expect_equal(&stage->expected, &drawn);
    picture_free(&drawn);
  }
}

/* Fails the n-th call; true if there was one. */
static bool fail_nth(stage *stage, fault fault, uint32_t n) {
  const uint32_t references = d3d12_engine_references(stage->engine.device);
  run run = {.stage = stage, .fault = fault, .native = stage->engine.native};
  d3d12_proxy_open(&run.proxy, stage->engine.device);
  run.native.device = &run.proxy.device;
  support_create_info(&run.record);
  if (fault.hr == S_OK)
    run.record.allocations_left = n;
  else
    run.proxy.fail_at = n;
  run.proxy.failure = fault.hr;
  d3d12_engine_begin(&stage->engine);
  go(&run);
  finish(&run);
  const bool failed = fault.hr == S_OK ? run.record.allocations_left < 0 : run.proxy.calls >= n;
  csm_destroy(run.context);
  assert_int_equal(run.record.blocks, 0);
  assert_int_equal(run.proxy.references, 1);
  assert_int_equal(d3d12_engine_references(stage->engine.device), references);
  assert_int_equal(d3d12_engine_references(stage->vertices), 1);
  assert_int_equal(d3d12_engine_references(stage->depth), 1);
  return failed;
}

static void fail_every(fault fault, uint32_t least) {
  stage stage;
  stage_open(&stage);
  assert_false(fail_nth(&stage, (struct fault){E_FAIL, CSM_ERROR_DEVICE}, UINT32_MAX)); /* none: what is right */
  uint32_t n = 1;
  while (fail_nth(&stage, fault, n))
    ++n;
  assert_in_range(n, least, 10000);
  stage_close(&stage);
}

static void out_of_device_memory(void **state) {
  (void)state;
  fail_every((fault){E_OUTOFMEMORY, CSM_ERROR_OUT_OF_DEVICE_MEMORY}, 40);
}

static void refused(void **state) {
  (void)state;
  fail_every((fault){E_FAIL, CSM_ERROR_DEVICE}, 40);
}

static void device_removed(void **state) {
  (void)state;
  fail_every((fault){removed, CSM_ERROR_DEVICE_LOST}, 40);
}

static void out_of_host_memory(void **state) {
  (void)state;
  fail_every((fault){S_OK, CSM_ERROR_OUT_OF_MEMORY}, 40);
}

/* A device that is lost between frames is told by the next, and left by a switch. */
static void a_lost_device_can_be_left(void **state) {
  (void)state;
  stage stage;
  stage_open(&stage);
  fail_nth(&stage, (fault){E_FAIL, CSM_ERROR_DEVICE}, UINT32_MAX);
  run run = {.stage = &stage, .native = stage.engine.native};
  d3d12_proxy_open(&run.proxy, stage.engine.device);
  run.native.device = &run.proxy.device;
  run.proxy.failure = removed;
  d3d12_engine_begin(&stage.engine);
  assert_int_equal(create(&run), CSM_SUCCESS);
  assert_int_equal(create_cascades(&run), CSM_SUCCESS);
  assert_int_equal(create_copied(&run), CSM_SUCCESS);
  run.engines = run.copied; /* a mesh in the lost device's buffers could not be brought along */
  assert_int_equal(render(&run), CSM_SUCCESS);
  run.proxy.removed = true;
  assert_int_equal(render(&run), CSM_ERROR_DEVICE_LOST);
  assert_int_equal(resolve_images(&run), CSM_ERROR_DEVICE_LOST);
  run.lost = true;
  finish(&run);
  run.lost = false;

  d3d12_engine_begin(&stage.engine);
  const csm_create_info info = rig_create_info(&run.record, &stage.engine.native);
  assert_int_equal(csm_switch_backend(run.context, &info), CSM_SUCCESS);
  assert_int_equal(run.proxy.references, 1);
  assert_int_equal(configure(&run), CSM_SUCCESS);
  assert_int_equal(render(&run), CSM_SUCCESS);
  assert_int_equal(resolve_images(&run), CSM_SUCCESS);
  finish(&run);
  csm_destroy(run.context);
  assert_int_equal(run.record.blocks, 0);
  stage_close(&stage);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(out_of_device_memory),
      cmocka_unit_test(refused),
      cmocka_unit_test(device_removed),
      cmocka_unit_test(out_of_host_memory),
      cmocka_unit_test(a_lost_device_can_be_left),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
