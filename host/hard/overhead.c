/* overhead.c: straight from above. */
#include "hard/overhead.h"
#include <math.h>
#include <string.h>

/* The camera looks along -y; its right is +x and its up is -z. */
void overhead_begin(host_setup *out, const overhead *how) {
  hard_setup_begin(out, how->pixels, how->pixels);
  hard_look(out, (const double[3]){0.0, how->eye, 0.0}, (const double[3]){0.0, how->eye - 1.0, 0.0}, 60.0);
  camera *c = &out->camera;
  const double far = how->eye - how->floor;
  memset(c->projection, 0, sizeof c->projection);
  c->projection[0] = c->projection[5] = 2.0 / how->side;
  c->projection[10] = 1.0 / far;
  c->projection[14] = 1.0;
  c->projection[15] = 1.0;
  c->near_depth = 0.0;
  c->far_depth = far;
  c->reversed = true;
  out->light.direction[0] = out->light.direction[2] = 0.0;
  out->light.direction[1] = -1.0;
  hard_reach(out, far);
  out->config.cascade_count = 1;
  out->config.fit_mode = CSM_FIT_CASCADE;
}

void overhead_tile(mesh_builder *b, const double corners[4], double height) {
  const double x0 = corners[0], z0 = corners[1], x1 = corners[2], z1 = corners[3];
  builder_quad(b, (const double[4][3]){{x0, height, z0}, {x0, height, z1}, {x1, height, z1}, {x1, height, z0}});
}

void overhead_range(host_setup *setup, double top, double bottom) {
  const double side = 2.0 / setup->camera.projection[0], at = 0.5 * side, size = side / 64.0;
  mesh_builder b = {0};
  overhead_tile(&b, (const double[4]){at + size, -size, at + 2.0 * size, size}, top);
  overhead_tile(&b, (const double[4]){-at - 2.0 * size, -size, -at - size, size}, bottom);
  hard_add(setup, &b, "marks", NULL);
  setup->config.depth_mode = CSM_DEPTH_SCENE;
}

void overhead_place(const host_setup *setup, uint32_t column, uint32_t row, double place[2]) {
  const double side = 2.0 / setup->camera.projection[0];
  place[0] = side * ((column + 0.5) / setup->width - 0.5);
  place[1] = side * ((row + 0.5) / setup->height - 0.5);
}
