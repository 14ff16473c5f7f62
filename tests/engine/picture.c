#include "picture.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static csm_binding bind(csm_cascades *cascades, csm_view *view) {
  csm_binding binding = {.struct_size = sizeof binding, .view = view};
  assert_int_equal(csm_bind(cascades, &binding), CSM_SUCCESS);
  return binding;
}

picture picture_read(csm_context *context, csm_cascades *cascades, csm_view *view, picture_size mask) {
  const csm_binding binding = bind(cascades, view);
  picture out = {.count = binding.cascade_count};
  for (uint32_t i = 0; i < out.count; ++i)
    out.layers[i] = (picture_layer){binding.resolutions[i], binding.resolutions[i],
                                    support_map(context, cascades, i, binding.resolutions[i])};
  if (mask.width)
    out.layers[out.count++] =
        (picture_layer){mask.width, mask.height, support_image(context, view, CSM_READ_MASK, mask.width, mask.height)};
  return out;
}

static uint64_t layer_bytes(const picture_copy *copy) {
  return (uint64_t)rig_pitch(copy->resolution, copy->map_bytes) * copy->resolution;
}

picture_copy picture_record(rig *rig, csm_cascades *cascades, csm_view *view, picture_size mask, uint32_t map_bytes) {
  const csm_binding binding = bind(cascades, view);
  picture_copy copy = {
      .cascades = binding.cascade_count, .resolution = binding.resolutions[0], .map_bytes = map_bytes, .mask = mask};
  const uint64_t maps = copy.cascades * layer_bytes(&copy);
  copy.buffer = rig_buffer_make(rig, RIG_READBACK, maps + (uint64_t)rig_pitch(mask.width, 1) * mask.height);
  for (uint32_t i = 0; i < copy.cascades; ++i)
    rig_copy(rig, &(rig_layer){binding.native_maps, i, copy.resolution, copy.resolution, map_bytes}, &copy.buffer,
             i * layer_bytes(&copy));
  if (mask.width)
    rig_copy(rig, &(rig_layer){binding.native_mask, 0, mask.width, mask.height, 1}, &copy.buffer, maps);
  return copy;
}

/* Of a mask, a map of 16 bits, or one of 32. */
static float texel(const unsigned char *bytes, uint32_t size) {
  uint16_t whole;
  float real;
  if (size == 1)
    return (float)*bytes / 255.0f;
  if (size == sizeof whole) {
    memcpy(&whole, bytes, sizeof whole);
    return (float)whole / 65535.0f;
  }
  memcpy(&real, bytes, sizeof real);
  return real;
}

static picture_layer take_layer(const unsigned char *rows, uint32_t width, uint32_t height, uint32_t texel_bytes) {
  const picture_layer layer = {width, height, malloc((size_t)width * height * sizeof(float))};
  const uint32_t pitch = rig_pitch(width, texel_bytes);
  assert_non_null(layer.texels);
  for (uint32_t y = 0; y < height; ++y, rows += pitch)
    for (uint32_t x = 0; x < width; ++x)
      layer.texels[y * width + x] = texel(rows + x * texel_bytes, texel_bytes);
  return layer;
}

picture picture_take(rig *rig, picture_copy *copy) {
  picture out = {.count = copy->cascades};
  const unsigned char *memory = copy->buffer.mapped;
  for (uint32_t i = 0; i < copy->cascades; ++i, memory += layer_bytes(copy))
    out.layers[i] = take_layer(memory, copy->resolution, copy->resolution, copy->map_bytes);
  if (copy->mask.width)
    out.layers[out.count++] = take_layer(memory, copy->mask.width, copy->mask.height, 1);
  rig_buffer_free(rig, &copy->buffer);
  return out;
}

void picture_free(picture *picture) {
  for (uint32_t i = 0; i < picture->count; ++i)
    free(picture->layers[i].texels);
  picture->count = 0;
}

/* How many texels differ in a layer; all of them where the sizes do. */
static uint32_t differences(const picture_layer *a, const picture_layer *b) {
  if (a->width != b->width || a->height != b->height)
    return UINT32_MAX;
  uint32_t different = 0;
  for (uint32_t t = 0; t < a->width * a->height; ++t)
    different += a->texels[t] != b->texels[t];
  return different;
}

bool picture_equal(const picture *a, const picture *b) {
  bool equal = a->count == b->count;
  for (uint32_t i = 0; equal && i < a->count; ++i)
    equal = !differences(&a->layers[i], &b->layers[i]);
  return equal;
}

void picture_expect_equal(const picture *a, picture *b) {
  assert_int_equal(a->count, b->count);
  for (uint32_t i = 0; i < a->count; ++i) {
    const uint32_t different = differences(&a->layers[i], &b->layers[i]);
    if (different)
      fail_msg("layer %u: %u of %u texels differ", i, different, a->layers[i].width * a->layers[i].height);
  }
  picture_free(b);
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

double picture_mask_difference(const picture *a, const picture *b, double steps) {
  const picture_layer *x = &a->layers[a->count - 1], *y = &b->layers[b->count - 1];
  const uint32_t pixels = x->width * x->height;
  uint32_t different = 0;
  for (uint32_t i = 0; i < pixels; ++i)
    different += fabsf(x->texels[i] - y->texels[i]) * 255 > steps + 0.5;
  return (double)different / pixels;
}
