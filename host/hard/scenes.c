/* scenes.c: little scenes. */
#include "base/linear.h"
#include "hard/hard.h"
#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

void hard_setup_begin(host_setup *out, uint32_t width, uint32_t height) {
  *out = (host_setup){.width = width, .height = height, .config.struct_size = sizeof out->config};
  csm_config_default(&out->config);
  snprintf(out->scene.name, sizeof out->scene.name, "hard");
  out->light = out->scene.light = hard_sun(45.0, 30.0);
  out->scene.haze_distance = INFINITY;
  hard_reach(out, 100.0);
}

void hard_add(host_setup *setup, mesh_builder *b, const char *name, const double position[3]) {
  static const double origin[3] = {0.0, 0.0, 0.0}, scale[3] = {1.0, 1.0, 1.0};
  double transform[16];
  mat_place(transform, position ? position : origin, 0.0, scale);
  if (setup->scene.material_count == 0)
    scene_add_material(&setup->scene, &(scene_material){.name = "plain", .color = {0.6f, 0.6f, 0.6f}});
  scene_add_instance(&setup->scene, builder_finish(b, &setup->scene, name, 4, false), transform);
}

void hard_ground(mesh_builder *b, const double center[3], double half, uint32_t cells) {
  for (uint32_t j = 0; j <= cells; j++)
    for (uint32_t i = 0; i <= cells; i++)
      builder_vertex(b, center[0] - half + 2.0 * half * i / cells, center[1],
                     center[2] - half + 2.0 * half * j / cells);
  builder_cells(b, cells);
}

void hard_look(host_setup *setup, const double from[3], const double at[3], double vertical_fov_deg) {
  camera_pose *pose = &setup->scene.camera;
  *pose = (camera_pose){.vertical_fov_deg = vertical_fov_deg, .near_depth = 0.1, .far_depth = INFINITY};
  memcpy(pose->position, from, sizeof pose->position);
  memcpy(pose->target, at, sizeof pose->target);
  camera_from_pose(&setup->camera, pose, (double)setup->width / setup->height);
}

void hard_yard(host_setup *setup, bool with_balls) {
  static const double boxes[][6] = {
      {-3, 0, -6, -1, 2.5, -4},       {2, 0, -9, 5, 4, -7},        {-9, 0, -14, -6, 6, -11},
      {1, 0, -17, 4, 1.5, -14},       {9, 0, -22, 14, 9, -17},     {-16, 0, -27, -11, 5, -24},
      {-5, 0, -33, 5, 3, -32.5},      {16, 0, -40, 19, 12, -37},   {-24, 0, -42, -18, 7, -38},
      {0.5, 0, -3.5, 0.75, 2, -3.25}, {7, 0, -12, 7.25, 5, -11.75}};
  static const double balls[][4] = {{4, 1, -5, 1}, {-6, 1.5, -9, 1.5}, {12, 2, -30, 2}, {-1, 4, -20, 1}};
  mesh_builder b = {0};
  hard_ground(&b, (const double[3]){0.0, 0.0, -24.0}, 30.0, 4);
  hard_add(setup, &b, "ground", NULL);
  for (size_t i = 0; i < sizeof boxes / sizeof boxes[0]; i++) {
    const double *box = boxes[i];
    builder_box(&b, (const double[3]){0.0, 0.0, 0.0},
                (const double[3]){box[3] - box[0], box[4] - box[1], box[5] - box[2]});
    hard_add(setup, &b, "box", box);
  }
  for (size_t i = 0; with_balls && i < sizeof balls / sizeof balls[0]; i++) {
    const double radius = balls[i][3];
    builder_ball(&b, (const double[3]){0.0, 0.0, 0.0}, (const double[3]){radius, radius, radius}, 3, 0.0, 1);
    hard_add(setup, &b, "ball", balls[i]);
  }
  hard_look(setup, (const double[3]){0.0, 2.5, 2.0}, (const double[3]){1.0, 1.5, -10.0}, 60.0);
  hard_reach(setup, 60.0);
}

void hard_reach(host_setup *setup, double meters) {
  setup->shadow_distance = setup->scene.shadow_distance = setup->config.shadow_distance = meters;
}

scene_light hard_sun(double height_deg, double azimuth_deg) {
  const double height = height_deg * (pi / 180.0), azimuth = azimuth_deg * (pi / 180.0);
  return (scene_light){.direction = {-cos(height) * cos(azimuth), -sin(height), -cos(height) * sin(azimuth)}};
}

/* The inverse of a rotation and a translation. */
static void invert_rigid(double out[16], const double m[16]) {
  memset(out, 0, 16 * sizeof *out);
  for (int row = 0; row < 3; row++)
    for (int column = 0; column < 3; column++)
      out[column * 4 + row] = m[row * 4 + column];
  for (int row = 0; row < 3; row++)
    out[12 + row] = -vec_dot(m + row * 4, m + 12);
  out[15] = 1.0;
}

void hard_place(host_setup *setup, const double rigid[16]) {
  double moved[16], inverse[16], turned[4];
  for (size_t i = 0; i < setup->scene.instance_count; i++) {
    mat_multiply(moved, rigid, setup->scene.instances[i].transform);
    memcpy(setup->scene.instances[i].transform, moved, sizeof moved);
  }
  camera *from = &setup->camera;
  invert_rigid(inverse, rigid);
  mat_multiply(moved, from->view, inverse);
  memcpy(from->view, moved, sizeof moved);
  mat_transform(turned, rigid, from->position, 1.0);
  memcpy(from->position, turned, sizeof from->position);
  mat_transform(turned, rigid, from->forward, 0.0);
  memcpy(from->forward, turned, sizeof from->forward);
  mat_transform(turned, rigid, setup->light.direction, 0.0);
  memcpy(setup->light.direction, turned, sizeof setup->light.direction);
}
