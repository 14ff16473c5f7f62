#include "sides.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void side_open(side *side, const char *backend) {
  memset(side, 0, sizeof *side);
  support_create_info(&side->record);
  side->record.backend = backend;
  side->context = support_open(&side->record);
  side->meshes[0] = support_square(side->context);
  side->meshes[1] = support_box(side->context, 2);
}

void side_close(side *side) {
  support_close(side->context, &side->record);
}

void sides_same_plan(const side *a, const side *b) {
  csm_stats stats[2] = {{.struct_size = sizeof stats[0]}, {.struct_size = sizeof stats[0]}};
  csm_binding bindings[2] = {{.struct_size = sizeof bindings[0]}, {.struct_size = sizeof bindings[0]}};
  const side *sides[2] = {a, b};
  for (int i = 0; i < 2; ++i) {
    assert_int_equal(csm_get_stats(sides[i]->cascades, &stats[i]), CSM_SUCCESS);
    assert_int_equal(csm_bind(sides[i]->cascades, &bindings[i]), CSM_SUCCESS);
    memset(&bindings[i].native_maps, 0, offsetof(csm_binding, maps_descriptor) - offsetof(csm_binding, native_maps));
    assert_true(stats[i].cascades[0].casters_drawn > 0);
  }
  assert_true(stats[0].plan_hash == stats[1].plan_hash);
  assert_memory_equal(&bindings[0], &bindings[1], sizeof bindings[0]);
}

sides_difference sides_compare(const side *a, const side *b, uint32_t source, uint32_t cascade, uint32_t width,
                               uint32_t height, float tolerance) {
  float *left = support_read(a->cascades, source, cascade, width, height);
  float *right = support_read(b->cascades, source, cascade, width, height);
  const uint32_t count = width * height;
  sides_difference out = {0};
  uint32_t lit = 0, shaded = 0;
  for (uint32_t i = 0; i < count; ++i) {
    const float apart = fabsf(left[i] - right[i]);
    out.texels += !(apart <= tolerance);
    out.largest = fmaxf(out.largest, apart);
    lit += left[i] == 1;
    shaded += left[i] == 0;
  }
  out.lit = (double)lit / count;
  out.shaded = (double)shaded / count;
  free(left);
  free(right);
  return out;
}

static void expect_same(const side *a, const side *b, uint32_t source, uint32_t cascade, uint32_t width,
                        uint32_t height) {
  const sides_difference found = sides_compare(a, b, source, cascade, width, height, 0);
  if (found.texels)
    fail_msg("source %u, cascade %u: %u of %u texels differ, by up to %g", source, cascade, found.texels,
             width * height, (double)found.largest);
}

sides_difference sides_same_images(const side *a, const side *b, const csm_config *config, uint32_t width,
                                   uint32_t height) {
  for (uint32_t cascade = 0; cascade < config->cascade_count; ++cascade) {
    const uint32_t own = config->resolutions[cascade], resolution = own ? own : config->resolution;
    expect_same(a, b, CSM_READ_MAP, cascade, resolution, resolution);
  }
  expect_same(a, b, CSM_READ_CAMERA_DEPTH, 0, width, height);
  const sides_difference mask = sides_compare(a, b, CSM_READ_MASK, 0, width, height, 1.0f / 255 + 1e-6f);
  if (mask.texels > width * height / 10000)
    fail_msg("mask: %u of %u pixels differ by more than 1/255, %u may", mask.texels, width * height,
             width * height / 10000);
  return mask;
}
