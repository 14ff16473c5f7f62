#include "picture/outside.h"
#include "base/host.h"
#include "base/linear.h"
#include "picture/lines.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of the outside camera, about the inner one's way. */
static const double elevation_deg = 33.0, turn_deg = 38.0, fov_deg = 45.0;
static const double margin = 0.94; /* of half the picture */
static const double pi = 3.14159265358979323846;

/* ---- what is to be seen ---- */

static void find_slice(double out[8][3], const camera_rays *rays, const camera *inner, double near, double far) {
  camera_slice(rays, inner, near, far, out);
  for (int corner = 0; corner < 8; corner++)
    for (int i = 0; i < 3; i++)
      out[corner][i] += inner->position[i];
}

static bool find_box(double out[8][3], const double world_to_shadow[16]) {
  double back[16];
  if (!mat_invert(back, world_to_shadow))
    return false;
  for (int corner = 0; corner < 8; corner++) {
    double point[4];
    mat_transform(point, back, (const double[3]){corner & 1, corner >> 1 & 1, corner >> 2}, 1.0);
    memcpy(out[corner], point, sizeof out[corner]);
  }
  return true;
}

static bool find_cascades(outside_view *out, const csm_binding *binding) {
  camera_rays rays;
  bool found = camera_rays_make(&rays, out->inner, out->view.width, out->view.height);
  out->cascade_count = binding->cascade_count;
  for (uint32_t k = 0; k < binding->cascade_count && found; k++) {
    const csm_cascade_info *info = &binding->cascades[k];
    out->cascades[k].far_depth = info->far_depth;
    memcpy(out->cascades[k].world_to_shadow, info->world_to_shadow, sizeof info->world_to_shadow);
    find_slice(out->cascades[k].slice, &rays, out->inner, info->near_depth, info->far_depth);
    found = find_box(out->cascades[k].box, info->world_to_shadow);
  }
  return found;
}

/* ---- the outside camera ---- */

/* From what it looks at towards a camera behind and above the inner one, on the side that has the sun behind it. */
static void find_way_back(double out[3], const camera *inner, const scene_light *light) {
  double ahead[3] = {inner->forward[0], 0.0, inner->forward[2]};
  if (!vec_normalize(ahead))
    ahead[2] = -1.0;
  const double aside = light->direction[0] * ahead[2] - light->direction[2] * ahead[0] > 0.0 ? -1.0 : 1.0;
  const double turn = aside * turn_deg * pi / 180.0, elevation = elevation_deg * pi / 180.0;
  out[0] = (ahead[2] * sin(turn) - ahead[0] * cos(turn)) * cos(elevation);
  out[1] = sin(elevation);
  out[2] = (-ahead[0] * sin(turn) - ahead[2] * cos(turn)) * cos(elevation);
}

/* Whether all slices are in the picture. */
static bool sees_slices(const outside_view *o, const double to_clip[16]) {
  for (uint32_t k = 0; k < o->cascade_count; k++)
    for (int corner = 0; corner < 8; corner++) {
      double clip[4];
      mat_transform(clip, to_clip, o->cascades[k].slice[corner], 1.0);
      if (!(clip[2] <= clip[3] && fabs(clip[0]) <= margin * clip[3] && fabs(clip[1]) <= margin * clip[3]))
        return false;
    }
  return true;
}

/* As near as it can be to see all slices. */
static void make_camera(outside_view *o) {
  const double(*last)[3] = o->cascades[o->cascade_count - 1].slice;
  double back[3], reach[3];
  find_way_back(back, o->inner, o->view.light);
  camera_pose pose = {.vertical_fov_deg = fov_deg, .far_depth = INFINITY};
  for (int i = 0; i < 3; i++) {
    reach[i] = 0.25 * (last[4][i] + last[5][i] + last[6][i] + last[7][i]) - o->inner->position[i];
    pose.target[i] = o->inner->position[i] + 0.35 * reach[i];
  }
  const double size = fmax(vec_length(reach), 1e-3);
  double away = 0.2 * size;
  do {
    for (int i = 0; i < 3; i++)
      pose.position[i] = pose.target[i] + away * back[i];
    pose.near_depth = 1e-3 * away;
    camera_from_pose(&o->camera, &pose, (double)o->view.width / o->view.height);
    mat_multiply(o->to_clip, o->camera.projection, o->camera.view);
    away *= 1.03;
  } while (!sees_slices(o, o->to_clip) && away < 1e3 * size);
}

int outside_view_make(outside_view *out, const picture_view *inner, const csm_binding *binding) {
  *out = (outside_view){.view = *inner, .inner = inner->camera};
  out->view.camera = &out->camera;
  if (!find_cascades(out, binding))
    return host_fail(HOST_BAD_INPUT, "the camera's or a cascade's matrices are singular");
  make_camera(out);
  const size_t pixels = (size_t)inner->width * inner->height;
  out->view.surfaces = out->surfaces = host_allocate(pixels, sizeof *out->surfaces);
  out->nearest = host_allocate(pixels, sizeof *out->nearest);
  const int code = trace_camera(inner->scene, &out->camera, inner->width, inner->height, out->surfaces);
  for (size_t i = 0; i < pixels && code == 0; i++)
    out->nearest[i] = out->surfaces[i].view_depth < 0.0 ? 0.0f : (float)(-1.0 / out->surfaces[i].view_depth);
  return code;
}

void outside_view_free(outside_view *out) {
  free(out->surfaces);
  free(out->nearest);
  *out = (outside_view){0};
}

/* ---- lines ---- */

/* Pixels and depth of a point in clip space. */
static void place(double out[3], const outside_view *o, const double clip[4]) {
  out[0] = 0.5 * (clip[0] / clip[3] + 1.0) * o->view.width - 0.5;
  out[1] = 0.5 * (1.0 - clip[1] / clip[3]) * o->view.height - 0.5;
  out[2] = -1.0 / clip[3];
}

/* What of a line lies before the near plane. */
static void draw_line(image *out, const outside_view *o, const line_style *style, const double from[3],
                      const double to[3]) {
  double ends[2][4], places[2][3];
  const double near = o->camera.near_depth;
  mat_transform(ends[0], o->to_clip, from, 1.0);
  mat_transform(ends[1], o->to_clip, to, 1.0);
  if (ends[0][3] < near && ends[1][3] < near)
    return;
  for (int end = 0; end < 2; end++)
    if (ends[end][3] < near) {
      const double *other = ends[1 - end], share = (near - ends[end][3]) / (other[3] - ends[end][3]);
      for (int i = 0; i < 4; i++)
        ends[end][i] += share * (other[i] - ends[end][i]);
    }
  for (int end = 0; end < 2; end++)
    place(places[end], o, ends[end]);
  picture_line(out, style, places[0], places[1]);
}

/* The twelve edges of something with eight corners. */
static void draw_edges(image *out, const outside_view *o, const line_style *style, const double corners[8][3]) {
  for (int corner = 0; corner < 8; corner++)
    for (int bit = 1; bit < 8; bit <<= 1)
      if (!(corner & bit))
        draw_line(out, o, style, corners[corner], corners[corner | bit]);
}

static uint32_t line_width(const outside_view *o, uint32_t thin) {
  const uint32_t scale = (o->view.height + 359) / 720;
  return thin * (scale > 1 ? scale : 1);
}

static void draw_boxes(image *out, const outside_view *o) {
  for (uint32_t k = o->cascade_count; k-- > 0;) {
    const line_style style = {
        .color = picture_cascade_colors[k], .width = line_width(o, 2), .nearest = o->nearest, .hidden = 0.45f};
    draw_edges(out, o, &style, o->cascades[k].box);
  }
}

static void draw_slices(image *out, const outside_view *o) {
  for (uint32_t k = o->cascade_count; k-- > 0;) {
    const line_style style = {
        .color = picture_cascade_colors[k], .width = line_width(o, 3), .nearest = o->nearest, .hidden = 0.6f};
    draw_edges(out, o, &style, o->cascades[k].slice);
  }
}

/* ---- surfaces ---- */

/* How light a surface is, 0 to 1: from the sun's side brighter, so that shapes are seen. */
static float lightness(const picture_view *view, const trace_surface *surface) {
  double sun[3];
  memcpy(sun, view->light->direction, sizeof sun);
  vec_normalize(sun);
  double cosine = 0.0;
  for (int i = 0; i < 3; i++)
    cosine -= sun[i] * surface->normal[i];
  return 0.4f + 0.2f * surface->normal[1] + 0.4f * (float)fmax(cosine, 0.0);
}

/* A pixel's surface, `share` in a colour and else grey. */
static void set_surface(image *out, const outside_view *o, size_t at, const float color[3], float share) {
  static const float nothing[3] = {0.012f, 0.014f, 0.018f};
  const trace_surface *surface = &o->surfaces[at];
  const float light = lightness(&o->view, surface);
  float shown[3];
  for (int i = 0; i < 3; i++)
    shown[i] = light * (0.2f + share * (0.05f + 0.75f * color[i] - 0.2f));
  image_set(out, (uint32_t)(at % o->view.width), (uint32_t)(at / o->view.width),
            surface->view_depth < 0.0 ? nothing : shown);
}

static void world_position(double out[3], const outside_view *o, const trace_surface *surface) {
  for (int i = 0; i < 3; i++)
    out[i] = o->camera.position[i] + surface->position[i];
}

/* The slice of the inner camera's view that a surface of the outside one lies in; the cascade count if none. */
static uint32_t slice_of(const outside_view *o, const double to_clip[16], const trace_surface *surface) {
  double world[3], from[3], clip[4];
  world_position(world, o, surface);
  vec_subtract(from, world, o->inner->position);
  const double depth = vec_dot(from, o->inner->forward);
  mat_transform(clip, to_clip, world, 1.0);
  if (depth < o->inner->near_depth || !(fabs(clip[0]) <= clip[3] && fabs(clip[1]) <= clip[3]))
    return o->cascade_count;
  uint32_t k = 0;
  while (k < o->cascade_count && depth > o->cascades[k].far_depth)
    k++;
  return k;
}

void picture_frusta(image *out, const outside_view *o) {
  double to_clip[16];
  mat_multiply(to_clip, o->inner->projection, o->inner->view);
  image_create(out, o->view.width, o->view.height);
  for (size_t at = 0; at < (size_t)o->view.width * o->view.height; at++) {
    const uint32_t k = slice_of(o, to_clip, &o->surfaces[at]);
    set_surface(out, o, at, picture_cascade_colors[k % CSM_MAX_CASCADES], k < o->cascade_count ? 1.0f : 0.0f);
  }
  draw_boxes(out, o);
  draw_slices(out, o);
}

/* Whether a surface lies in what a cascade's map is wide and high. */
static bool lies_in(const outside_view *o, uint32_t k, const trace_surface *surface) {
  double world[3], at[4];
  world_position(world, o, surface);
  mat_transform(at, o->cascades[k].world_to_shadow, world, 1.0);
  return fmin(at[0], at[1]) >= 0.0 && fmax(at[0], at[1]) <= 1.0;
}

void picture_culled(image *out, const outside_view *o, const uint8_t *drawn) {
  static const float dark[3] = {0.0f, 0.0f, 0.0f};
  const uint32_t stripe_px = o->view.height / 180 + 1, all = (1u << o->cascade_count) - 1;
  image_create(out, o->view.width, o->view.height);
  for (size_t at = 0; at < (size_t)o->view.width * o->view.height; at++) {
    const trace_surface *surface = &o->surfaces[at];
    const uint32_t set = surface->view_depth < 0.0 ? 0 : drawn[surface->instance];
    const bool stripe = (at % o->view.width + at / o->view.width) / stripe_px % 3 == 0;
    uint32_t first = 0;
    while (set && !(set >> first & 1))
      first++;
    const bool later_culls = set >> first != all >> first;
    set_surface(out, o, at, stripe && later_culls ? dark : picture_cascade_colors[first],
                set == 0                     ? 0.0f
                : lies_in(o, first, surface) ? 1.0f
                                             : 0.3f);
  }
  draw_boxes(out, o);
}
