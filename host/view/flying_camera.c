#include "view/flying_camera.h"
#include "base/linear.h"
#include <math.h>
#include <string.h>

/* v turned about a unit axis: Rodrigues' formula. */
static void rotate(double v[3], const double axis[3], double angle) {
  double across[3];
  vec_cross(across, axis, v);
  const double c = cos(angle), s = sin(angle), along = vec_dot(axis, v) * (1.0 - c);
  for (int i = 0; i < 3; i++)
    v[i] = v[i] * c + across[i] * s + axis[i] * along;
}

static const double world_up[3] = {0.0, 1.0, 0.0};

/* First the tilt about the right that it started with, then the turn about the world's up. */
static void turn(double v[3], const view_camera *c) {
  rotate(v, c->right, c->tilt);
  rotate(v, world_up, c->turn);
}

void view_camera_start(view_camera *out, const camera *from) {
  const double steepest = 1.55;
  *out = (view_camera){.start = *from};
  memcpy(out->position, from->position, sizeof out->position);
  vec_cross(out->right, from->forward, world_up);
  if (!vec_normalize(out->right))
    out->right[0] = 1.0; /* it looks straight up or down */
  const double tilt = asin(fmin(fmax(from->forward[1], -1.0), 1.0));
  out->lowest = fmin(-steepest - tilt, 0.0);
  out->highest = fmax(steepest - tilt, 0.0);
}

void view_camera_turn(view_camera *c, double left, double up) {
  c->turn = remainder(c->turn + left, 2.0 * 3.14159265358979323846);
  c->tilt = fmin(fmax(c->tilt + up, c->lowest), c->highest);
}

void view_camera_move(view_camera *c, double right, double up, double forward) {
  double to_right[3], ahead[3];
  memcpy(to_right, c->right, sizeof to_right);
  memcpy(ahead, c->start.forward, sizeof ahead);
  turn(to_right, c);
  turn(ahead, c);
  for (int i = 0; i < 3; i++)
    c->position[i] += right * to_right[i] + up * world_up[i] + forward * ahead[i];
}

void view_camera_place(const view_camera *c, camera *out) {
  *out = c->start;
  memcpy(out->position, c->position, sizeof out->position);
  turn(out->forward, c);
  /* Each row of the view's rotation is one of the camera's axes in the world, of whatever handedness. */
  for (int row = 0; row < 3; row++) {
    double axis[3] = {c->start.view[row], c->start.view[4 + row], c->start.view[8 + row]};
    turn(axis, c);
    for (int i = 0; i < 3; i++)
      out->view[i * 4 + row] = axis[i];
    out->view[12 + row] = -vec_dot(axis, c->position);
  }
}
