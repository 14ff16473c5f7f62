#include "sides.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void side_open(side *side, const char *backend) {
  memset(side, 0, sizeof *side);
  support_create_info(&side->record);
  side->record.backend = backend;
  side->context = support_open_with(&side->record, CSM_CREATE_RAYS);
  side->view = support_view(side->context);
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
    assert_true(stats[i].cascades[0].casters_drawn > 0);
  }
  assert_true(stats[0].plan_hash == stats[1].plan_hash);
  support_same_binding(&bindings[0], &bindings[1]);
}

static float *read_image(const side *side, const sides_image *image) {
  return image->source == CSM_READ_MAP
             ? support_map(side->context, side->cascades, image->cascade, image->width)
             : support_image(side->context, side->view, image->source, image->width, image->height);
}

sides_difference sides_compare(const side *a, const side *b, const sides_image *image, float tolerance) {
  float *left = read_image(a, image), *right = read_image(b, image);
  const uint32_t count = image->width * image->height;
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

static void expect_same(const side *a, const side *b, const sides_image *image) {
  const sides_difference found = sides_compare(a, b, image, 0);
  if (found.texels)
    fail_msg("source %u, cascade %u: %u of %u texels differ, by up to %g", image->source, image->cascade, found.texels,
             image->width * image->height, (double)found.largest);
}

sides_difference sides_same_images(const side *a, const side *b, const csm_config *config, uint32_t width,
                                   uint32_t height) {
  csm_binding binding = {.struct_size =
                             sizeof binding}; /* a budget may have made maps smaller than they were asked for */
  assert_int_equal(csm_bind(a->cascades, &binding), CSM_SUCCESS);
  for (uint32_t cascade = 0; cascade < config->cascade_count; ++cascade) {
    const uint32_t resolution = binding.resolutions[cascade];
    expect_same(a, b, &(sides_image){CSM_READ_MAP, cascade, resolution, resolution});
  }
  expect_same(a, b, &(sides_image){CSM_READ_CAMERA_DEPTH, 0, width, height});
  const sides_difference mask =
      sides_compare(a, b, &(sides_image){CSM_READ_MASK, 0, width, height}, 1.0f / 255 + 1e-6f);
  if (mask.texels > width * height / 10000)
    fail_msg("mask: %u of %u pixels differ by more than 1/255, %u may", mask.texels, width * height,
             width * height / 10000);
  return mask;
}
