#include "vulkan_case.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void case_open(vulkan_case *c, vulkan_engine *engine) {
  *c = (vulkan_case){.engine = engine};
  char text[512] = "";
  csm_create_info info = support_create_info(&c->record);
  info.vulkan = engine ? &engine->native : NULL;
  info.frame_slots = VULKAN_ENGINE_FRAMES;
  info.error = text;
  info.error_size = sizeof text;
  const csm_result result = csm_create(&info, &c->context);
  if (result)
    fail_msg("%s: %s", csm_result_name(result), text);
  c->config = support_config();
  c->config.selection = CSM_SELECT_INTERVAL; /* the larger texels: normals of the depth decide fewer pixels */
  assert_int_equal(csm_cascades_create(c->context, &c->config, &c->cascades), CSM_SUCCESS);
  support_scene_make(&c->scene, c->context);
  if (engine)
    c->readback = vulkan_engine_buffer(engine, VULKAN_ENGINE_FRAMES * sizeof(case_image));
}

void case_close(vulkan_case *c) {
  if (c->engine) {
    vulkan_engine_run(c->engine, c->engine->frame);
    vulkan_engine_buffer_destroy(c->engine, &c->readback);
  }
  support_close(c->context, &c->record);
  if (c->engine)
    assert_int_equal(c->engine->messages, 0);
}

csm_frame case_frame(const vulkan_case *c, double time) {
  csm_frame frame = c->scene.frame;
  const double eye[3] = {-4 + 0.7 * time, 6, 12 - time}, target[3] = {0.3 * time, 0, -4};
  support_look_at(frame.view, eye, target);
  frame.light_direction[0] = 0.4 - 0.05 * time;
  if (c->engine) {
    frame.frame = c->engine->frame;
    frame.command_buffer = c->engine->frames[c->engine->frame % VULKAN_ENGINE_FRAMES].commands;
  }
  return frame;
}

void case_configure(vulkan_case *c, const case_step *step) {
  if (c->config.cascade_count == step->cascades && c->config.resolution == step->resolution)
    return;
  c->config.cascade_count = step->cascades;
  c->config.resolution = step->resolution;
  assert_int_equal(csm_cascades_configure(c->cascades, &c->config), CSM_SUCCESS);
}

static uint64_t place(uint64_t frame) {
  return frame % VULKAN_ENGINE_FRAMES * sizeof(case_image);
}

void case_copy(const vulkan_case *c, const case_step *step) {
  const uint64_t frame = c->engine->frame, offset = place(frame);
  const VkCommandBuffer commands = c->engine->frames[frame % VULKAN_ENGINE_FRAMES].commands;
  csm_binding binding = {.struct_size = sizeof binding};
  assert_int_equal(csm_bind(c->cascades, &binding), CSM_SUCCESS);
  for (uint32_t i = 0; i < step->cascades; ++i)
    vulkan_engine_copy(commands, (VkImage)binding.native_maps, VK_IMAGE_ASPECT_DEPTH_BIT, i, step->resolution,
                       step->resolution, &c->readback, offset + i * sizeof((case_image *)0)->maps[0]);
  if (step->width)
    vulkan_engine_copy(commands, (VkImage)binding.native_mask, VK_IMAGE_ASPECT_COLOR_BIT, 0, step->width, step->height,
                       &c->readback, offset + offsetof(case_image, mask));
}

void case_read(const vulkan_case *c, uint64_t frame, const case_step *step, case_image *out) {
  memset(out, 0, sizeof *out);
  const size_t map_bytes = (size_t)step->resolution * step->resolution * sizeof(float);
  const size_t pixels = (size_t)step->width * step->height;
  if (c->engine) {
    const case_image *copied = (const case_image *)((const char *)c->readback.mapped + place(frame));
    for (uint32_t i = 0; i < step->cascades; ++i)
      memcpy(out->maps[i], copied->maps[i], map_bytes);
    memcpy(out->mask, copied->mask, pixels);
    return;
  }
  for (uint32_t i = 0; i < step->cascades; ++i) {
    float *map = support_read(c->cascades, CSM_READ_MAP, i, step->resolution, step->resolution);
    memcpy(out->maps[i], map, map_bytes);
    free(map);
  }
  if (!pixels)
    return;
  float *mask = support_read(c->cascades, CSM_READ_MASK, 0, step->width, step->height);
  for (size_t i = 0; i < pixels; ++i)
    out->mask[i] = (uint8_t)lrintf(mask[i] * 255);
  free(mask);
}

void case_reference(const case_step *steps, uint32_t count, case_image *out) {
  vulkan_case c;
  case_open(&c, NULL);
  for (uint32_t i = 0; i < count; ++i) {
    const case_step *step = &steps[i];
    case_configure(&c, step);
    const csm_frame frame = case_frame(&c, step->time);
    assert_int_equal(csm_render_cascades(c.cascades, &frame), CSM_SUCCESS);
    const csm_mask_info mask = {
        .struct_size = sizeof mask, .frame = &frame, .width = step->width, .height = step->height};
    if (step->width)
      assert_int_equal(csm_resolve_mask(c.cascades, &mask), CSM_SUCCESS);
    case_read(&c, 0, step, &out[i]);
  }
  case_close(&c);
}

void case_compare(const case_image *drawn, const case_image *expected, const case_step *step) {
  for (uint32_t i = 0; i < step->cascades; ++i)
    assert_memory_equal(drawn->maps[i], expected->maps[i], (size_t)step->resolution * step->resolution * sizeof(float));
  assert_memory_equal(drawn->mask, expected->mask, (size_t)step->width * step->height);
}
