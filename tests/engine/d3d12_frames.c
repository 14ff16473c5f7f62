/* d3d12_frames.c: frames in flight on an engine's Direct3D 12 device, against what an own device draws. */
#include "d3d12_rig.h"

#include <math.h>
#include <string.h>

/* One of two contexts that go through the same frames. */
typedef struct side {
  csm_context *context;
  csm_cascades *cascades;
  csm_config config;
  support_scene scene;
  csm_instance instances[SUPPORT_INSTANCES + 1];
  csm_mesh hill; /* 0: not there */
  uint32_t mask_width, mask_height;
} side;

static void side_open(side *side, csm_context *context) {
  *side = (struct side){.context = context, .config = support_config(), .mask_width = 192, .mask_height = 128};
  support_scene_make(&side->scene, context);
  memcpy(side->instances, side->scene.instances, sizeof side->scene.instances);
  assert_int_equal(csm_cascades_create(context, &side->config, &side->cascades), CSM_SUCCESS);
}

static void reconfigure(side *side) {
  assert_int_equal(csm_cascades_configure(side->cascades, &side->config), CSM_SUCCESS);
}

/* What happens before each frame, while others are in flight. */
static void side_step(side *side, const hill *hill, uint32_t frame) {
  const double x = -4 + 0.37 * frame;
  support_look_at(side->scene.frame.view, (const double[]){x, 6, 12}, (const double[]){0.2 * frame, 0, -4});
  if (frame == 3) {
    side->hill = hill_mesh(side->context, hill, 4);
    side->instances[SUPPORT_INSTANCES] = support_instance(side->hill, -2, 1, -2, 3, 1, 3);
  } else if (frame == 5) {
    side->config.resolution = 128;
    reconfigure(side);
  } else if (frame == 7) {
    side->mask_width = 320;
    side->mask_height = 200;
  } else if (frame == 8) {
    assert_int_equal(csm_mesh_destroy(side->context, side->hill), CSM_SUCCESS);
    side->hill = 0;
  } else if (frame == 9) {
    side->config.cascade_count = 4;
    side->config.filter = CSM_FILTER_PCF_2X2;
    reconfigure(side);
  } else if (frame == 11) {
    assert_int_equal(csm_cascades_destroy(side->cascades), CSM_SUCCESS);
    assert_int_equal(csm_cascades_create(side->context, &side->config, &side->cascades), CSM_SUCCESS);
  }
}

static csm_frame side_frame(const side *side) {
  csm_frame frame = side->scene.frame;
  frame.instances = side->instances;
  frame.instance_count = SUPPORT_INSTANCES + (side->hill != 0);
  return frame;
}

static void resolve(side *side, const csm_frame *frame) {
  const csm_mask_info mask = {
      .struct_size = sizeof mask, .frame = frame, .width = side->mask_width, .height = side->mask_height};
  assert_int_equal(csm_resolve_mask(side->cascades, &mask), CSM_SUCCESS);
}

static picture draw_own(side *side) {
  const csm_frame frame = side_frame(side);
  assert_int_equal(csm_render_cascades(side->cascades, &frame), CSM_SUCCESS);
  resolve(side, &frame);
  return picture_read(side->cascades, &side->config, side->mask_width, side->mask_height);
}

/* Odd frames resolve the mask in a list of its own. */
static picture_copy record_engines(d3d12_rig *rig, side *side) {
  ID3D12GraphicsCommandList *list = d3d12_engine_begin(&rig->engine);
  csm_frame frame = side_frame(side);
  frame.frame = rig->engine.frame;
  frame.command_buffer = list;
  rig_render(rig, side->cascades, &frame);
  if (rig->engine.frame % 2)
    frame.command_buffer = list = d3d12_engine_split(&rig->engine);
  resolve(side, &frame);
  const picture_copy copy = picture_record(rig, list, side->cascades, side->mask_width, side->mask_height);
  d3d12_engine_end(&rig->engine);
  return copy;
}

/* Frames are recorded three ahead of the GPU, and nothing is submitted before it must be. */
static void frames_in_flight(void **state) {
  enum { FRAMES = 14 };
  (void)state;
  record own_record = {0};
  d3d12_rig rig;
  side own, engines;
  hill hill;
  picture expected[D3D12_ENGINE_FRAMES];
  picture_copy copies[D3D12_ENGINE_FRAMES];
  hill_make(&hill);
  rig_open(&rig);
  side_open(&own, support_open(&own_record));
  side_open(&engines, rig.context);
  for (uint32_t i = 1; i <= FRAMES + D3D12_ENGINE_FRAMES; ++i) {
    const uint32_t slot = i % D3D12_ENGINE_FRAMES;
    if (i > D3D12_ENGINE_FRAMES) {
      d3d12_engine_run(&rig.engine, i - D3D12_ENGINE_FRAMES);
      rig_retire(&rig);
      picture drawn = picture_take(&copies[slot]);
      picture_expect_equal(&expected[slot], &drawn);
      picture_expect_casters(&drawn, drawn.count - 1);
      picture_free(&drawn);
      picture_free(&expected[slot]);
    }
    if (i > FRAMES)
      continue;
    side_step(&own, &hill, i);
    side_step(&engines, &hill, i);
    expected[slot] = draw_own(&own);
    copies[slot] = record_engines(&rig, &engines);
  }
  support_close(own.context, &own_record);
  rig_close(&rig);
}

/* Meshes that are uploaded by a frame without casters are drawn by the next. */
static void uploads_wait_for_nobody(void **state) {
  (void)state;
  record own_record = {0};
  d3d12_rig rig;
  side own, engines;
  rig_open(&rig);
  side_open(&own, support_open(&own_record));
  side_open(&engines, rig.context);
  csm_frame empty = side_frame(&engines), full = empty;
  ID3D12GraphicsCommandList *list = d3d12_engine_begin(&rig.engine);
  empty.instance_count = 0;
  empty.frame = full.frame = rig.engine.frame;
  empty.command_buffer = full.command_buffer = list;
  rig_render(&rig, engines.cascades, &empty);
  rig_render(&rig, engines.cascades, &full);
  resolve(&engines, &full);
  picture_copy copy = picture_record(&rig, list, engines.cascades, engines.mask_width, engines.mask_height);
  d3d12_engine_end(&rig.engine);
  d3d12_engine_run(&rig.engine, rig.engine.frame);
  picture drawn = picture_take(&copy), expected = draw_own(&own);
  picture_expect_equal(&expected, &drawn);
  picture_free(&drawn);
  picture_free(&expected);
  support_close(own.context, &own_record);
  rig_close(&rig);
}

static void timestamps_are_those_of_retired_frames(void **state) {
  (void)state;
  d3d12_rig rig;
  side side;
  csm_stats stats = {.struct_size = sizeof stats};
  rig_open(&rig);
  side_open(&side, rig.context);
  for (uint32_t i = 1; i <= 4; ++i) {
    csm_frame frame = side_frame(&side);
    frame.flags = i < 4 ? CSM_FRAME_TIMESTAMPS : 0;
    frame.command_buffer = d3d12_engine_begin(&rig.engine);
    frame.frame = rig.engine.frame;
    rig_render(&rig, side.cascades, &frame);
    resolve(&side, &frame);
    d3d12_engine_end(&rig.engine);
    assert_int_equal(csm_get_stats(side.cascades, &stats), CSM_SUCCESS);
    assert_true(i > 1 || stats.cascades[0].gpu_ms < 0); /* not done, so not known */
    d3d12_engine_run(&rig.engine, rig.engine.frame);
    rig_retire(&rig);
  }
  assert_int_equal(csm_get_stats(side.cascades, &stats), CSM_SUCCESS);
  double sum = stats.clear_gpu_ms + stats.mask_gpu_ms + stats.camera_depth_gpu_ms;
  for (uint32_t i = 0; i < stats.cascade_count; ++i) {
    assert_true(stats.cascades[i].gpu_ms >= 0);
    sum += stats.cascades[i].gpu_ms;
  }
  assert_true(stats.mask_gpu_ms > 0);
  assert_true(sum > 0.01 && sum < 10e3);
  rig_close(&rig);
}

static void two_contexts_share_a_device(void **state) {
  (void)state;
  d3d12_rig rig;
  record second_record = {0};
  csm_context *second;
  side a, b;
  rig_open(&rig);
  const csm_create_info info = rig_create_info(&second_record, &rig.engine.native);
  assert_int_equal(csm_create(&info, &second), CSM_SUCCESS);
  side_open(&a, rig.context);
  side_open(&b, second);
  picture_copy copies[2];
  ID3D12GraphicsCommandList *list = d3d12_engine_begin(&rig.engine);
  side *const sides[2] = {&a, &b};
  for (int i = 0; i < 2; ++i) {
    csm_frame frame = side_frame(sides[i]);
    frame.frame = rig.engine.frame;
    frame.command_buffer = list;
    rig_render(&rig, sides[i]->cascades, &frame);
    resolve(sides[i], &frame);
    copies[i] = picture_record(&rig, list, sides[i]->cascades, sides[i]->mask_width, sides[i]->mask_height);
  }
  d3d12_engine_end(&rig.engine);
  d3d12_engine_run(&rig.engine, rig.engine.frame);
  picture x = picture_take(&copies[0]), y = picture_take(&copies[1]);
  picture_expect_equal(&x, &y);
  picture_expect_casters(&x, a.config.cascade_count);
  picture_free(&x);
  picture_free(&y);
  support_close(second, &second_record);
  rig_close(&rig);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(frames_in_flight),
      cmocka_unit_test(uploads_wait_for_nobody),
      cmocka_unit_test(timestamps_are_those_of_retired_frames),
      cmocka_unit_test(two_contexts_share_a_device),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
