/* input_camera.c: a camera file, as --camera reads it. */
#include "base/host.h"
#include "input.h"
#include "scene/camera_json.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char perspective[] =
    "{\"camera\": {\"position\": [1, 2, 3], \"view\": [1,0,0,0, 0,1,0,0, 0,0,1,0, -1,-2,-3,1],\n"
    " \"projection\": [1.2,0,0,0, 0,1.7,0,0, 0,0,0.001,-1, 0,0,0.5,0], \"near\": 0.5, \"far\": null,\n"
    " \"reversed\": true}, \"width\": 64, \"height\": 36}";
static const char orthographic[] =
    "{\"view\": [1,0,0,0, 0,0,1,0, 0,-1,0,0, 0,0,-10,1],\n"
    " \"projection\": [0.1,0,0,0, 0,0.1,0,0, 0,0,-0.01,0, 0,0,0.5,1], \"near\": -50, \"far\": 50, \"reversed\": false}";

uint32_t input_seeds(input_seed out[INPUT_SEEDS]) {
  out[0] = (input_seed){perspective, sizeof perspective - 1};
  out[1] = (input_seed){orthographic, sizeof orthographic - 1};
  return 2;
}

static void expect_finite(const double *values, int count) {
  for (int i = 0; i < count; i++)
    if (!isfinite(values[i]))
      abort();
}

/* A camera that was taken can be looked through. */
static void look(const camera *from, uint32_t width, uint32_t height) {
  camera_rays rays;
  double origin[3], direction[3], reach;
  expect_finite(from->position, 3);
  expect_finite(from->forward, 3);
  expect_finite(from->view, 16);
  expect_finite(from->projection, 16);
  if (!(from->far_depth > from->near_depth))
    abort();
  if (!camera_rays_make(&rays, from, width ? width : 8, height ? height : 8))
    return;
  camera_ray(&rays, camera_pixel_x(&rays, 0), camera_pixel_y(&rays, 0), origin, direction, &reach);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  camera out;
  uint32_t width = 0, height = 0;
  input_quiet();
  if (camera_from_json(&out, &width, &height, input_file(data, size, ".json")) == 0) {
    look(&out, width, height);
    json_decref(camera_to_json(&out));
  }
  return 0;
}
