#include "truth/truth.h"
#include "base/host.h"
#include "base/linear.h"
#include "base/parallel.h"
#include "truth/geometry.h"
#include "truth/sun_disc.h"
#include <embree3/rtcore.h>
#include <math.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#define PACKET 16
/* The origin of the float32 vertices lies on a grid, so that what is seen depends on the camera alone, and most steps
 * along a path need no new geometry. */
#define ORIGIN_GRID 16.0
/*
 * A point lies at least this far, in weights, inside its triangle. So a pixel's centre that falls on an edge, to within
 * float32's rounding, belongs to one triangle alone.
 */
#define INSIDE 1e-7

struct truth {
  const scene *scene;
  bool alpha_test;
  bool built; /* geometry is there */
  truth_geometry geometry;
  RTCDevice device; /* NULL until the first ray */
  RTCScene world;
  atomic_llong memory;
};

/* Rays on their way, for the filter that sees each hit before it counts. */
typedef struct cast {
  struct RTCIntersectContext context; /* first, so that a filter finds the rest */
  const truth_geometry *geometry;
  uint32_t surface;              /* where the rays start, which they cannot hit; TRUTH_NOTHING: nowhere */
  double from[3];                /* relative to the geometry's origin */
  const double (*directions)[3]; /* by the ray's id; NULL: Embree's word on a hit is good enough */
  double reach;                  /* in lengths of the directions */
} cast;

/* ---- scene ---- */

static bool count_memory(void *user, ssize_t bytes, bool post) {
  (void)post;
  truth *t = user;
  atomic_fetch_add(&t->memory, (long long)bytes);
  return true;
}

truth *truth_create(const scene *s, bool alpha_test) {
  truth *t = host_allocate(1, sizeof *t);
  t->scene = s;
  t->alpha_test = alpha_test;
  return t;
}

static void release(truth *t) {
  if (t->world)
    rtcReleaseScene(t->world);
  if (t->device)
    rtcReleaseDevice(t->device);
  t->world = NULL;
  t->device = NULL;
  truth_geometry_free(&t->geometry);
  t->built = false;
}

void truth_destroy(truth *t) {
  if (t)
    release(t);
  free(t);
}

uint64_t truth_memory(const truth *t) {
  const truth_geometry *g = &t->geometry;
  return (uint64_t)atomic_load(&t->memory) + 12u * (uint64_t)g->vertex_count + 16u * (uint64_t)g->triangle_count;
}

static int place_geometry(truth *t, const double position[3]) {
  double origin[3];
  for (int i = 0; i < 3; i++)
    origin[i] = ORIGIN_GRID * round(position[i] / ORIGIN_GRID);
  if (t->built && memcmp(origin, t->geometry.origin, sizeof origin) == 0)
    return 0;
  release(t);
  t->built = true;
  return truth_geometry_make(&t->geometry, t->scene, origin, t->alpha_test);
}

/*
 * Embree finds in float32 where a ray may hit. Whether it does is decided here, in doubles, with the triangle's alpha
 * mask. The triangle that a ray starts on is left out by its id.
 */
static bool counts(const cast *c, uint32_t triangle, uint32_t ray, double u, double v) {
  if (c->geometry->surfaces[triangle] == c->surface)
    return false;
  double weights[3] = {1.0 - u - v, u, v}, corners[3][3], distance;
  if (c->directions) {
    truth_geometry_corners(c->geometry, triangle, corners);
    if (!truth_ray_triangle(corners, c->from, c->directions[ray], weights, &distance) || !(distance > 0.0) ||
        !(distance < c->reach))
      return false;
  }
  return truth_geometry_opaque(c->geometry, triangle, weights);
}

/*
 * Embree hands a filter its rays and hits as arrays of n, one for each member in the order of struct RTCRay and RTCHit.
 * Embree's own functions for that are C++.
 */
static uint32_t ray_id(const struct RTCFilterFunctionNArguments *arguments, uint32_t index) {
  return ((const uint32_t *)arguments->ray)[offsetof(struct RTCRay, id) / sizeof(float) * arguments->N + index];
}

static uint32_t hit_triangle(const struct RTCFilterFunctionNArguments *arguments, uint32_t index) {
  return ((const uint32_t *)arguments->hit)[offsetof(struct RTCHit, primID) / sizeof(float) * arguments->N + index];
}

static double hit_weight(const struct RTCFilterFunctionNArguments *arguments, uint32_t index, size_t member) {
  return ((const float *)arguments->hit)[member / sizeof(float) * arguments->N + index];
}

static void filter_hits(const struct RTCFilterFunctionNArguments *arguments) {
  const cast *c = (const cast *)arguments->context;
  for (uint32_t i = 0; i < arguments->N; i++)
    if (arguments->valid[i] && !counts(c, hit_triangle(arguments, i), ray_id(arguments, i),
                                       hit_weight(arguments, i, offsetof(struct RTCHit, u)),
                                       hit_weight(arguments, i, offsetof(struct RTCHit, v))))
      arguments->valid[i] = 0;
}

/* Builds Embree's tree over the geometry, when the first ray needs it. */
static int build_tree(truth *t) {
  if (t->world)
    return 0;
  const truth_geometry *g = &t->geometry;
  host_progress("truth: sorting the triangles");
  t->device = rtcNewDevice(NULL);
  if (!t->device)
    return host_fail(HOST_BAD_INPUT, "Embree does not start here");
  rtcSetDeviceMemoryMonitorFunction(t->device, count_memory, t);
  RTCGeometry triangles = rtcNewGeometry(t->device, RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetSharedGeometryBuffer(triangles, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, g->vertices, 0, 3 * sizeof(float),
                             g->vertex_count);
  rtcSetSharedGeometryBuffer(triangles, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, g->indices, 0, 3 * sizeof(uint32_t),
                             g->triangle_count);
  rtcSetGeometryIntersectFilterFunction(triangles, filter_hits);
  rtcSetGeometryOccludedFilterFunction(triangles, filter_hits);
  rtcCommitGeometry(triangles);
  t->world = rtcNewScene(t->device);
  rtcSetSceneFlags(t->world, RTC_SCENE_FLAG_ROBUST);
  rtcAttachGeometry(t->world, triangles);
  rtcReleaseGeometry(triangles);
  rtcCommitScene(t->world);
  host_progress("");
  return rtcGetDeviceError(t->device) == RTC_ERROR_NONE
             ? 0
             : host_fail(HOST_BAD_INPUT, "Embree could not take the scene's triangles");
}

static cast cast_begin(const truth *t, uint32_t surface) {
  cast c = {.geometry = &t->geometry, .surface = surface, .reach = INFINITY};
  rtcInitIntersectContext(&c.context);
  c.context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  return c;
}

/* ---- what a camera sees ---- */

typedef struct picture {
  truth *truth;
  const camera *camera;
  camera_rays rays;
  double offset[3]; /* of the camera from the geometry's origin */
  uint32_t *found;
  const uint32_t *triangles;
  truth_surface *surfaces;
} picture;

/* Cameras are the view's origin: what a matrix says, not what stands beside it. */
static int picture_begin(picture *p, truth *t, const camera *from, uint32_t width, uint32_t height) {
  *p = (picture){.truth = t, .camera = from};
  if (!camera_rays_make(&p->rays, from, width, height))
    return host_fail(HOST_BAD_INPUT, "the camera's matrices are singular");
  return 0;
}

static int picture_place(picture *p) {
  const int code = place_geometry(p->truth, p->rays.unview + 12);
  vec_subtract(p->offset, p->rays.unview + 12, p->truth->geometry.origin);
  return code;
}

/* From what a picture sees, into the tree. */
static int begin_rays(picture *out, truth *t, const truth_view *view) {
  int code = picture_begin(out, t, view->camera, view->width, view->height);
  if (code == 0)
    code = picture_place(out);
  return code ? code : build_tree(t);
}

/* The ray of a pixel, relative to the geometry's origin. */
static void pixel_ray(const picture *p, uint32_t column, uint32_t row, double from[3], double direction[3],
                      double *reach) {
  camera_ray(&p->rays, camera_pixel_x(&p->rays, column), camera_pixel_y(&p->rays, row), from, direction, reach);
  for (int i = 0; i < 3; i++)
    from[i] += p->offset[i];
}

static void find_row(void *context, uint32_t row) {
  const picture *p = context;
  cast c = cast_begin(p->truth, TRUTH_NOTHING);
  for (uint32_t column = 0; column < p->rays.width; column++) {
    double from[3], direction[3], reach;
    pixel_ray(p, column, row, from, direction, &reach);
    struct RTCRayHit found = {.ray = {.org_x = (float)from[0],
                                      .org_y = (float)from[1],
                                      .org_z = (float)from[2],
                                      .dir_x = (float)direction[0],
                                      .dir_y = (float)direction[1],
                                      .dir_z = (float)direction[2],
                                      .tfar = (float)reach,
                                      .mask = UINT32_MAX},
                              .hit = {.geomID = RTC_INVALID_GEOMETRY_ID, .instID = {RTC_INVALID_GEOMETRY_ID}}};
    rtcIntersect1(p->truth->world, &c.context, &found);
    p->found[(size_t)row * p->rays.width + column] =
        found.hit.geomID == RTC_INVALID_GEOMETRY_ID ? TRUTH_NOTHING : found.hit.primID;
  }
}

int truth_find(truth *t, const camera *from, uint32_t width, uint32_t height, uint32_t *triangles) {
  picture p;
  int code = picture_begin(&p, t, from, width, height);
  if (code == 0)
    code = picture_place(&p);
  if (code == 0)
    code = build_tree(t);
  p.found = triangles;
  if (code == 0)
    parallel_rows(height, find_row, &p, "truth: what the camera sees");
  return code;
}

/* The point of a triangle that a pixel's ray meets, moved into the triangle where rounding leads past its edge. */
static void point_on_triangle(double point[3], double corners[3][3], const double from[3], const double direction[3]) {
  double weights[3], distance, sum = 0.0;
  truth_ray_triangle(corners, from, direction, weights, &distance);
  for (int i = 0; i < 3; i++) {
    weights[i] = weights[i] > INSIDE ? weights[i] : INSIDE;
    sum += weights[i];
  }
  for (int axis = 0; axis < 3; axis++)
    point[axis] = (weights[0] * corners[0][axis] + weights[1] * corners[1][axis] + weights[2] * corners[2][axis]) / sum;
}

static void triangle_normal(double normal[3], double corners[3][3]) {
  double along[3], across[3];
  vec_subtract(along, corners[1], corners[0]);
  vec_subtract(across, corners[2], corners[0]);
  vec_cross(normal, along, across);
  vec_normalize(normal);
}

static void fill_row(void *context, uint32_t row) {
  const picture *p = context;
  const truth_geometry *g = &p->truth->geometry;
  for (uint32_t column = 0; column < p->rays.width; column++) {
    const size_t pixel = (size_t)row * p->rays.width + column;
    truth_surface *surface = &p->surfaces[pixel];
    *surface = (truth_surface){.view_depth = -1.0, .triangle = p->triangles[pixel]};
    if (surface->triangle == TRUTH_NOTHING)
      continue;
    double from[3], direction[3], reach, corners[3][3], point[3], normal[3];
    pixel_ray(p, column, row, from, direction, &reach);
    truth_geometry_corners(g, surface->triangle, corners);
    point_on_triangle(point, corners, from, direction);
    triangle_normal(normal, corners);
    const bool away = vec_dot(normal, direction) > 0.0;
    for (int i = 0; i < 3; i++) {
      surface->normal[i] = (float)(away ? -normal[i] : normal[i]);
      point[i] -= p->offset[i];
    }
    surface->behind = away != truth_geometry_mirrored(g, surface->triangle);
    surface->view_depth = vec_dot(point, p->camera->forward);
  }
}

int truth_view_fill(truth *t, const truth_view *view, const uint32_t *triangles) {
  picture p;
  int code = picture_begin(&p, t, view->camera, view->width, view->height);
  if (code == 0)
    code = picture_place(&p);
  p.triangles = triangles;
  p.surfaces = view->surfaces;
  if (code == 0)
    parallel_rows(view->height, fill_row, &p, NULL);
  return code;
}

double truth_facing(const truth_surface *surface, const scene_light *light) {
  return -(surface->normal[0] * light->direction[0] + surface->normal[1] * light->direction[1] +
           surface->normal[2] * light->direction[2]) /
         vec_length(light->direction);
}

/* The point that a pixel sees, relative to the geometry's origin. */
static void pixel_point(const picture *p, uint32_t column, uint32_t row, uint32_t triangle, double point[3]) {
  double from[3], direction[3], reach, corners[3][3];
  pixel_ray(p, column, row, from, direction, &reach);
  truth_geometry_corners(&p->truth->geometry, triangle, corners);
  point_on_triangle(point, corners, from, direction);
}

/* ---- how much of the sun a point sees ---- */

typedef struct row_convergence {
  uint64_t pixels;
  double square_quarter, square_half, largest_half;
} row_convergence;

typedef struct sunlight {
  picture picture;
  const truth_view *view;
  const scene_light *light;
  double max_depth;
  truth_sun sun;
  float *visibility;
  row_convergence *rows;
} sunlight;

/* Which of up to PACKET rays from the same point get away. */
static uint32_t cast_packet(cast *c, RTCScene world, const double (*directions)[3], uint32_t count) {
  _Alignas(64) int valid[PACKET];
  struct RTCRay16 rays;
  for (uint32_t i = 0; i < PACKET; i++) {
    const double *direction = directions[i < count ? i : 0];
    valid[i] = i < count ? -1 : 0;
    rays.org_x[i] = (float)c->from[0];
    rays.org_y[i] = (float)c->from[1];
    rays.org_z[i] = (float)c->from[2];
    rays.dir_x[i] = (float)direction[0];
    rays.dir_y[i] = (float)direction[1];
    rays.dir_z[i] = (float)direction[2];
    rays.tnear[i] = 0.0f;
    rays.tfar[i] = INFINITY;
    rays.time[i] = 0.0f;
    rays.mask[i] = UINT32_MAX;
    rays.id[i] = i;
    rays.flags[i] = 0;
  }
  c->directions = directions;
  rtcOccluded16(valid, world, &c->context, &rays);
  uint32_t lit = 0;
  for (uint32_t i = 0; i < count; i++)
    lit |= (uint32_t)(rays.tfar[i] >= 0.0f) << i;
  return lit;
}

static bool cast_one(cast *c, RTCScene world, const double (*direction)[3], float reach) {
  struct RTCRay ray = {.org_x = (float)c->from[0],
                       .org_y = (float)c->from[1],
                       .org_z = (float)c->from[2],
                       .dir_x = (float)direction[0][0],
                       .dir_y = (float)direction[0][1],
                       .dir_z = (float)direction[0][2],
                       .tfar = reach,
                       .mask = UINT32_MAX};
  c->directions = direction;
  rtcOccluded1(world, &c->context, &ray);
  return ray.tfar >= 0.0f;
}

static void note_convergence(row_convergence *to, double all, double half, double quarter) {
  if ((all <= 0.0 || all >= 1.0) && half == all)
    return;
  to->pixels++;
  to->square_quarter += (quarter - all) * (quarter - all);
  to->square_half += (half - all) * (half - all);
  to->largest_half = fmax(to->largest_half, fabs(half - all));
}

static double sun_share(const sunlight *s, cast *c, uint32_t pixel, row_convergence *convergence) {
  const RTCScene world = s->picture.truth->world;
  const double(*directions)[3] = truth_sun_set(&s->sun, pixel);
  const uint32_t samples = s->sun.samples;
  if (samples == 1)
    return cast_one(c, world, directions, INFINITY) ? 1.0 : 0.0;
  uint32_t lit = 0, quarter = 0, half = 0;
  for (uint32_t i = 0; i < samples; i += PACKET) {
    const uint32_t count = samples - i < PACKET ? samples - i : PACKET;
    uint32_t away = cast_packet(c, world, directions + i, count);
    for (uint32_t k = 0; k < count; k++) {
      lit += away >> k & 1;
      quarter = i + k + 1 == samples / 4 ? lit : quarter;
      half = i + k + 1 == samples / 2 ? lit : half;
    }
  }
  const double all = (double)lit / samples;
  note_convergence(convergence, all, (double)half / (samples / 2), (double)quarter / (samples / 4));
  return all;
}

static void light_row(void *context, uint32_t row) {
  const sunlight *s = context;
  const truth_view *view = s->view;
  for (uint32_t column = 0; column < view->width; column++) {
    const size_t pixel = (size_t)row * view->width + column;
    const truth_surface *surface = &view->surfaces[pixel];
    s->visibility[pixel] = surface->triangle == TRUTH_NOTHING ? 1.0f : 0.0f;
    if (surface->triangle == TRUTH_NOTHING || surface->view_depth > s->max_depth ||
        truth_facing(surface, s->light) <= 0.0)
      continue;
    cast c = cast_begin(s->picture.truth, s->picture.truth->geometry.surfaces[surface->triangle]);
    pixel_point(&s->picture, column, row, surface->triangle, c.from);
    s->visibility[pixel] = (float)sun_share(s, &c, (uint32_t)pixel, &s->rows[row]);
  }
}

static void sum_convergence(truth_convergence *out, const sunlight *s) {
  double quarter = 0.0, half = 0.0;
  *out = (truth_convergence){.samples = s->sun.samples};
  for (uint32_t row = 0; row < s->view->height; row++) {
    out->pixels += s->rows[row].pixels;
    quarter += s->rows[row].square_quarter;
    half += s->rows[row].square_half;
    out->largest_half = fmax(out->largest_half, s->rows[row].largest_half);
  }
  if (out->pixels) {
    out->rms_quarter = sqrt(quarter / (double)out->pixels);
    out->rms_half = sqrt(half / (double)out->pixels);
  }
}

int truth_visibility(truth *t, const truth_view *view, const truth_asked *asked, float *visibility,
                     truth_convergence *convergence) {
  sunlight s = {.view = view, .light = asked->light, .max_depth = asked->max_depth, .visibility = visibility};
  const int code = begin_rays(&s.picture, t, view);
  if (code)
    return code;
  truth_sun_make(&s.sun, asked->light, asked->samples);
  s.rows = host_allocate(view->height, sizeof *s.rows);
  parallel_rows(view->height, light_row, &s, "truth: rays to the sun");
  sum_convergence(convergence, &s);
  free(s.rows);
  truth_sun_free(&s.sun);
  return 0;
}

/* ---- what another camera sees too ---- */

typedef struct second_look {
  picture picture;
  const truth_view *view;
  camera_rays other;
  const camera *other_camera;
  double offset[3];   /* of the other camera from the geometry's origin */
  double to_clip[16]; /* from the other camera's position, in the world's axes */
  uint8_t *seen;
} second_look;

/* The point lies in the other camera's picture, on a side that it sees, with nothing between. */
static bool sees(const second_look *s, cast *c, const truth_surface *surface, const double point[3]) {
  double local[3], clip[4], from[3], direction[3], to_camera[3], reach;
  vec_subtract(local, point, s->offset);
  mat_transform(clip, s->to_clip, local, 1.0);
  if (!(clip[3] > 0.0) || fabs(clip[0]) > clip[3] || fabs(clip[1]) > clip[3] || clip[2] < 0.0 || clip[2] > clip[3])
    return false;
  camera_ray(&s->other, clip[0] / clip[3], clip[1] / clip[3], from, direction, &reach);
  for (int i = 0; i < 3; i++)
    from[i] += s->offset[i];
  vec_subtract(to_camera, from, point);
  const double facing =
      surface->normal[0] * to_camera[0] + surface->normal[1] * to_camera[1] + surface->normal[2] * to_camera[2];
  if (!(facing > 0.0))
    return false;
  memcpy(c->from, point, sizeof c->from);
  c->reach = 1.0;
  return cast_one(c, s->picture.truth->world, (const double(*)[3]) & to_camera, 1.0f);
}

static void look_row(void *context, uint32_t row) {
  const second_look *s = context;
  for (uint32_t column = 0; column < s->view->width; column++) {
    const size_t pixel = (size_t)row * s->view->width + column;
    const truth_surface *surface = &s->view->surfaces[pixel];
    s->seen[pixel] = 0;
    if (surface->triangle == TRUTH_NOTHING)
      continue;
    double point[3];
    pixel_point(&s->picture, column, row, surface->triangle, point);
    cast c = cast_begin(s->picture.truth, s->picture.truth->geometry.surfaces[surface->triangle]);
    s->seen[pixel] = sees(s, &c, surface, point);
  }
}

int truth_seen(truth *t, const truth_view *view, const camera *other, uint8_t *seen) {
  second_look s = {.view = view, .other_camera = other, .seen = seen};
  if (!camera_rays_make(&s.other, other, view->width, view->height))
    return host_fail(HOST_BAD_INPUT, "the camera's matrices are singular");
  const int code = begin_rays(&s.picture, t, view);
  if (code)
    return code;
  double turn[16];
  memcpy(turn, other->view, sizeof turn);
  turn[12] = turn[13] = turn[14] = 0.0;
  mat_multiply(s.to_clip, other->projection, turn);
  vec_subtract(s.offset, s.other.unview + 12, t->geometry.origin);
  parallel_rows(view->height, look_row, &s, "truth: what both cameras see");
  return 0;
}
