#include "d3d12_rig.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- the rig ---- */

csm_create_info rig_create_info(record *record, const csm_d3d12_device *native) {
  csm_create_info info = support_create_info(record);
  info.flags = 0;
  info.d3d12 = native;
  return info;
}

void rig_open(d3d12_rig *rig) {
  char text[512] = "";
  *rig = (d3d12_rig){0};
  d3d12_engine_open(&rig->engine);
  rig->references = d3d12_engine_references(rig->engine.device);
  csm_create_info info = rig_create_info(&rig->record, &rig->engine.native);
  info.error = text;
  info.error_size = sizeof text;
  const csm_result result = csm_create(&info, &rig->context);
  if (result)
    fail_msg("%s: %s", csm_result_name(result), text);
}

void rig_close(d3d12_rig *rig) {
  d3d12_engine_run(&rig->engine, rig->engine.frame);
  support_close(rig->context, &rig->record);
  assert_int_equal(d3d12_engine_references(rig->engine.device), rig->references);
  const uint32_t messages = rig->engine.messages;
  d3d12_engine_close(&rig->engine);
  assert_int_equal(messages, 0);
}

void rig_retire(d3d12_rig *rig) {
  assert_int_equal(csm_retire(rig->context, rig->engine.done), CSM_SUCCESS);
}

csm_frame rig_frame(const d3d12_rig *rig, const support_scene *scene, ID3D12GraphicsCommandList *list) {
  csm_frame frame = scene->frame;
  frame.instances = scene->instances;
  frame.frame = rig->engine.frame;
  frame.command_buffer = list;
  return frame;
}

void rig_render(d3d12_rig *rig, csm_cascades *cascades, const csm_frame *frame) {
  const csm_result result = csm_render_cascades(cascades, frame);
  if (result)
    fail_msg("%s: %s", csm_result_name(result), csm_last_error(rig->context));
}

/* ---- pictures ---- */

picture picture_read(csm_cascades *own, const csm_config *config, uint32_t mask_width, uint32_t mask_height) {
  picture out = {.count = config->cascade_count};
  for (uint32_t i = 0; i < out.count; ++i)
    out.layers[i] = (picture_layer){config->resolution, config->resolution,
                                    support_read(own, CSM_READ_MAP, i, config->resolution, config->resolution)};
  if (mask_width)
    out.layers[out.count++] =
        (picture_layer){mask_width, mask_height, support_read(own, CSM_READ_MASK, 0, mask_width, mask_height)};
  return out;
}

static uint64_t map_bytes(const picture_copy *copy) {
  return (uint64_t)d3d12_engine_pitch(copy->resolution, sizeof(float)) * copy->resolution;
}

picture_copy picture_record(d3d12_rig *rig, ID3D12GraphicsCommandList *list, csm_cascades *cascades,
                            uint32_t mask_width, uint32_t mask_height) {
  csm_binding binding = {.struct_size = sizeof binding};
  assert_int_equal(csm_bind(cascades, &binding), CSM_SUCCESS);
  picture_copy copy = {.cascades = binding.cascade_count,
                       .resolution = binding.resolution,
                       .mask_width = mask_width,
                       .mask_height = mask_height};
  const uint64_t maps = copy.cascades * map_bytes(&copy);
  copy.buffer = d3d12_engine_buffer(&rig->engine, D3D12_HEAP_TYPE_READBACK,
                                    maps + (uint64_t)d3d12_engine_pitch(mask_width, 1) * mask_height, NULL);
  for (uint32_t i = 0; i < copy.cascades; ++i)
    d3d12_engine_copy(list, (ID3D12Resource *)(uintptr_t)binding.native_maps, i, sizeof(float), copy.buffer,
                      i * map_bytes(&copy));
  if (mask_width)
    d3d12_engine_copy(list, (ID3D12Resource *)(uintptr_t)binding.native_mask, 0, 1, copy.buffer, maps);
  return copy;
}

static picture_layer take_layer(const unsigned char *rows, uint32_t width, uint32_t height, uint32_t texel_bytes) {
  const picture_layer layer = {width, height, malloc((size_t)width * height * sizeof(float))};
  const uint32_t pitch = d3d12_engine_pitch(width, texel_bytes);
  assert_non_null(layer.texels);
  for (uint32_t y = 0; y < height; ++y, rows += pitch)
    for (uint32_t x = 0; x < width; ++x)
      if (texel_bytes == 1)
        layer.texels[y * width + x] = (float)rows[x] / 255.0f;
      else
        memcpy(&layer.texels[y * width + x], rows + x * sizeof(float), sizeof(float));
  return layer;
}

picture picture_take(picture_copy *copy) {
  picture out = {.count = copy->cascades};
  const unsigned char *memory = d3d12_engine_map(copy->buffer);
  for (uint32_t i = 0; i < copy->cascades; ++i, memory += map_bytes(copy))
    out.layers[i] = take_layer(memory, copy->resolution, copy->resolution, sizeof(float));
  if (copy->mask_width)
    out.layers[out.count++] = take_layer(memory, copy->mask_width, copy->mask_height, 1);
  ID3D12Resource_Release(copy->buffer);
  copy->buffer = NULL;
  return out;
}

void picture_free(picture *picture) {
  for (uint32_t i = 0; i < picture->count; ++i)
    free(picture->layers[i].texels);
  picture->count = 0;
}

void picture_expect_equal(const picture *a, const picture *b) {
  assert_int_equal(a->count, b->count);
  for (uint32_t i = 0; i < a->count; ++i) {
    const picture_layer *x = &a->layers[i], *y = &b->layers[i];
    assert_int_equal(x->width, y->width);
    assert_int_equal(x->height, y->height);
    uint32_t different = 0;
    for (uint32_t t = 0; t < x->width * x->height; ++t)
      different += x->texels[t] != y->texels[t];
    if (different)
      fail_msg("layer %u: %u of %u texels differ", i, different, x->width * x->height);
  }
}

void picture_expect_casters(const picture *picture, uint32_t cascades) {
  for (uint32_t i = 0; i < cascades; ++i) {
    const picture_layer *map = &picture->layers[i];
    uint32_t drawn = 0;
    for (uint32_t t = 1; t < map->width * map->height; ++t)
      drawn += map->texels[t] < 1 && map->texels[t] != map->texels[t - 1];
    assert_true(drawn > 100);
  }
}

/* ---- the hill ---- */

void hill_make(hill *hill) {
  for (uint32_t i = 0; i < HILL_VERTICES; ++i) {
    const float x = (float)(i % HILL_SIDE) / (HILL_SIDE - 1) * 2 - 1,
                z = (float)(i / HILL_SIDE) / (HILL_SIDE - 1) * 2 - 1;
    const float p[3] = {x, cosf(x * 2.1f + 0.3f) * cosf(z * 1.7f), z};
    memcpy(hill->positions[i], p, sizeof p);
  }
  uint16_t *out = hill->indices;
  for (uint16_t row = 0; row + 1 < HILL_SIDE; ++row)
    for (uint16_t column = 0; column + 1 < HILL_SIDE; ++column) {
      const uint16_t a = (uint16_t)(row * HILL_SIDE + column), b = (uint16_t)(a + HILL_SIDE);
      const uint16_t corners[6] = {a, b, (uint16_t)(a + 1), (uint16_t)(a + 1), b, (uint16_t)(b + 1)};
      memcpy(out, corners, sizeof corners);
      out += 6;
    }
  for (uint32_t i = 0; i < HILL_INDICES; ++i)
    hill->wide_indices[i] = hill->indices[i];
}

csm_mesh hill_mesh(csm_context *context, const hill *hill, uint32_t index_size) {
  const csm_mesh_info info = {
      .struct_size = sizeof info,
      .positions = hill->positions,
      .vertex_count = HILL_VERTICES,
      .indices = index_size == 2 ? (const void *)hill->indices : hill->wide_indices,
      .index_count = HILL_INDICES,
      .index_size = index_size,
      .name = "hill",
  };
  csm_mesh mesh;
  assert_int_equal(csm_mesh_create(context, &info, &mesh), CSM_SUCCESS);
  return mesh;
}
