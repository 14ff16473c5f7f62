/* pixels.c: how the pixels of a camera's picture and the world belong together. */
#include "plan/internal.h"

/* World positions relative to the frame's origin, to a camera's clip space. */
static void relative_to_clip(double out[16], const plan_frame *frame, const plan_camera *camera) {
  double view[16];
  for (int i = 0; i < 16; ++i)
    view[i] = i < 12 ? camera->view[i] : i == 15;
  for (int row = 0; row < 3; ++row)
    for (int k = 0; k < 3; ++k)
      view[12 + row] += camera->view[k * 4 + row] * (frame->origin[k] - camera->position[k]);
  plan_multiply(out, camera->projection, view);
}

/* And back. */
static void clip_to_relative(double out[16], const plan_frame *frame, const plan_camera *camera) {
  double unproject[16], rotation[9];
  (void)plan_invert(unproject, camera->projection); /* plan_camera_make saw to it that it can be */
  plan_view_rotation_inverse(rotation, camera->view);
  for (int column = 0; column < 4; ++column) {
    const double *from = &unproject[column * 4];
    for (int row = 0; row < 3; ++row)
      out[column * 4 + row] = rotation[row] * from[0] + rotation[3 + row] * from[1] + rotation[6 + row] * from[2] +
                              (camera->position[row] - frame->origin[row]) * from[3];
    out[column * 4 + 3] = from[3];
  }
}

void plan_relative_to_pixels(double out[16], const plan_frame *frame, const plan_camera *camera, uint32_t width,
                             uint32_t height) {
  const double x = 0.5 * width, y = 0.5 * height;
  const double pixels[16] = {x, 0, 0, 0, 0, -y, 0, 0, 0, 0, 1, 0, x, y, 0, 1};
  double clip[16];
  relative_to_clip(clip, frame, camera);
  plan_multiply(out, pixels, clip);
}

void plan_pixels_to_relative(double out[16], const plan_frame *frame, const plan_camera *camera, uint32_t width,
                             uint32_t height) {
  const double x = 0.5 * width, y = 0.5 * height;
  const double clip[16] = {1 / x, 0, 0, 0, 0, -1 / y, 0, 0, 0, 0, 1, 0, -1, 1, 0, 1};
  double relative[16];
  clip_to_relative(relative, frame, camera);
  plan_multiply(out, relative, clip);
}
