/* matrices.c: what instances are drawn with. Everything is computed in doubles and rounded once. */
#include "plan/internal.h"

/* World to clip: three rows of four. */
static void world_to_clip_rows(double rows[3][4], const plan_frame *frame, uint32_t cascade) {
  const double *to_clip = frame->cascades[cascade].to_clip;
  for (int row = 0; row < 3; ++row) {
    for (int k = 0; k < 3; ++k)
      rows[row][k] = to_clip[row * 4] * frame->basis[k] + to_clip[row * 4 + 1] * frame->basis[3 + k] +
                     to_clip[row * 4 + 2] * frame->basis[6 + k];
    rows[row][3] = to_clip[row * 4 + 3];
  }
}

void plan_cascade_volume(const plan_frame *frame, uint32_t cascade, double world_to_clip[16], double planes[5][4]) {
  double rows[3][4];
  world_to_clip_rows(rows, frame, cascade);
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 3; ++row)
      world_to_clip[column * 4 + row] = rows[row][column];
    world_to_clip[column * 4 + 3] = column == 3;
    const double one = column == 3;
    planes[0][column] = rows[0][column] + one;
    planes[1][column] = one - rows[0][column];
    planes[2][column] = rows[1][column] + one;
    planes[3][column] = one - rows[1][column];
    /* The far side is depth 1, or 0 where depth grows towards the light. */
    planes[4][column] = frame->cascades[cascade].to_clip[10] < 0.0 ? rows[2][column] : one - rows[2][column];
  }
}

void plan_stored_transform(double out[12], const plan_instance *instance, const plan_bounds *bounds) {
  const double *t = instance->transform, *offset = bounds->offset;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      out[row * 4 + column] = t[row * 4 + column];
    out[row * 4 + 3] = plan_dot(&t[row * 4], offset) + t[row * 4 + 3];
  }
}

void plan_light_transform(double out[12], const double basis[9], const plan_instance *instance,
                          const plan_bounds *bounds) {
  double t[12];
  plan_stored_transform(t, instance, bounds);
  for (int row = 0; row < 3; ++row) {
    const double *axis = &basis[row * 3];
    for (int column = 0; column < 4; ++column)
      out[row * 4 + column] = axis[0] * t[column] + axis[1] * t[4 + column] + axis[2] * t[8 + column];
  }
}

/* A window scales and moves light space along its own axes. */
void plan_light_to_clip(float out[12], const double to_clip[12], const double to_light[12]) {
  for (int row = 0; row < 3; ++row) {
    const double scale = to_clip[row * 5], constant[4] = {0.0, 0.0, 0.0, to_clip[row * 4 + 3]};
    for (int column = 0; column < 4; ++column)
      out[row * 4 + column] = plan_float(scale * to_light[row * 4 + column] + constant[column]);
  }
}

void plan_write_window_matrices(float *out, const plan_frame *frame, uint32_t window, const plan_scene *scene) {
  const plan_window *of = &frame->windows[window];
  for (uint32_t i = 0; i < of->list.instance_count; ++i) {
    const uint32_t slot = of->list.instances[i];
    const plan_instance *instance = &scene->instances[slot];
    double made[12];
    if (!frame->to_light)
      plan_light_transform(made, frame->basis, instance, &scene->meshes[instance->mesh]);
    plan_light_to_clip(&out[(size_t)i * 12], of->to_clip, frame->to_light ? frame->to_light[slot] : made);
  }
}

void plan_write_view_matrices(float *out, const plan_list *list, const plan_camera *camera, const plan_scene *scene) {
  /* Relative to the camera, so that a large world costs no precision */
  double to_view[16], to_clip[16];
  for (int i = 0; i < 16; ++i)
    to_view[i] = i < 12 ? camera->view[i] : i == 15;
  plan_multiply(to_clip, camera->projection, to_view);
  for (uint32_t i = 0; i < list->instance_count; ++i, out += 16) {
    const plan_instance *instance = &scene->instances[list->instances[i]];
    double t[12], object[16], clip[16];
    plan_stored_transform(t, instance, &scene->meshes[instance->mesh]);
    for (int column = 0; column < 4; ++column) {
      for (int row = 0; row < 3; ++row)
        object[column * 4 + row] = t[row * 4 + column] - (column == 3 ? camera->position[row] : 0.0);
      object[column * 4 + 3] = column == 3;
    }
    plan_multiply(clip, to_clip, object);
    for (int row = 0; row < 4; ++row)
      for (int column = 0; column < 4; ++column)
        out[row * 4 + column] = plan_float(clip[column * 4 + row]);
  }
}
