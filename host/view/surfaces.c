#include "view/surfaces.h"
#include "base/linear.h"
#include <math.h>
#include <string.h>

static const float plain[3] = {0.42f, 0.41f, 0.38f};

/* From a pixel and its depth to a position in the world, relative to the camera's. */
typedef struct unprojection {
  double from_clip[16];
  uint32_t width, height;
} unprojection;

static void unproject(double out[3], const unprojection *u, uint32_t x, uint32_t y, double depth) {
  const double clip[3] = {2.0 * (x + 0.5) / u->width - 1.0, 1.0 - 2.0 * (y + 0.5) / u->height, depth};
  double point[4];
  mat_transform(point, u->from_clip, clip, 1.0);
  for (int i = 0; i < 3; i++)
    out[i] = point[i] / point[3];
}

static bool make_unprojection(unprojection *out, const camera *from, uint32_t width, uint32_t height) {
  double centered[16], to_clip[16];
  memcpy(centered, from->view, sizeof centered);
  centered[12] = centered[13] = centered[14] = 0.0;
  mat_multiply(to_clip, from->projection, centered);
  out->width = width;
  out->height = height;
  return mat_invert(out->from_clip, to_clip);
}

static void find_position(trace_surface *out, const unprojection *u, const camera *from, uint32_t x, uint32_t y,
                          float depth) {
  const double clear = from->reversed ? 0.0 : 1.0;
  double position[3], near[3], middle[3];
  unproject(near, u, x, y, 1.0 - clear);
  unproject(middle, u, x, y, 0.5);
  vec_subtract(middle, middle, near);
  vec_normalize(middle);
  *out = (trace_surface){.view_depth = -1.0, .color = {plain[0], plain[1], plain[2]}};
  for (int i = 0; i < 3; i++)
    out->ray[i] = (float)middle[i];
  if (depth == clear)
    return;
  unproject(position, u, x, y, depth);
  for (int i = 0; i < 3; i++)
    out->position[i] = (float)position[i];
  out->distance = vec_length(position);
  out->view_depth = vec_dot(position, from->forward);
}

/* The difference to the neighbour along an axis that lies nearer in depth, and so more likely on the same surface. */
static void tangent(double out[3], const trace_surface *here, const trace_surface *before, const trace_surface *after) {
  const bool use_before = before && before->view_depth >= 0.0 &&
                          (!after || after->view_depth < 0.0 ||
                           fabs(before->view_depth - here->view_depth) < fabs(after->view_depth - here->view_depth));
  const trace_surface *to = use_before ? here : after, *from = use_before ? before : here;
  for (int i = 0; i < 3; i++)
    out[i] = to && from ? to->position[i] - from->position[i] : 0.0;
}

static void find_normal(trace_surface *surfaces, uint32_t width, uint32_t height, uint32_t x, uint32_t y) {
  trace_surface *here = &surfaces[(size_t)y * width + x];
  double along[3], down[3], normal[3];
  if (here->view_depth < 0.0)
    return;
  tangent(along, here, x > 0 ? here - 1 : NULL, x + 1 < width ? here + 1 : NULL);
  tangent(down, here, y > 0 ? here - width : NULL, y + 1 < height ? here + width : NULL);
  vec_cross(normal, down, along);
  const bool usable = vec_normalize(normal);
  double facing = 0.0;
  for (int i = 0; i < 3; i++)
    facing += normal[i] * here->ray[i];
  for (int i = 0; i < 3; i++)
    here->normal[i] = (float)(usable ? (facing > 0.0 ? -normal[i] : normal[i]) : -here->ray[i]);
}

void view_surfaces_from_depth(trace_surface *out, const camera *from, const float *depth, uint32_t width,
                              uint32_t height) {
  unprojection u;
  if (!make_unprojection(&u, from, width, height))
    return;
  for (uint32_t y = 0; y < height; y++)
    for (uint32_t x = 0; x < width; x++) {
      const size_t at = (size_t)y * width + x;
      find_position(&out[at], &u, from, x, y, depth[at]);
    }
  for (uint32_t y = 0; y < height; y++)
    for (uint32_t x = 0; x < width; x++)
      find_normal(out, width, height, x, y);
}

/* ---- in the background ---- */

static void *run(void *argument) {
  view_trace *t = argument;
  t->code = trace_camera(t->scene, &t->camera, t->width, t->height, t->surfaces);
  atomic_store(&t->finished, true);
  return NULL;
}

bool view_trace_begin(view_trace *t, const camera *from) {
  if (t->running)
    return false;
  t->camera = *from;
  atomic_store(&t->finished, false);
  t->running = pthread_create(&t->thread, NULL, run, t) == 0;
  return t->running;
}

bool view_trace_done(view_trace *t) {
  return t->running && atomic_load(&t->finished) && view_trace_wait(t);
}

bool view_trace_wait(view_trace *t) {
  if (!t->running)
    return false;
  pthread_join(t->thread, NULL);
  t->running = false;
  return true;
}
