#include "picture/trace.h"
#include "base/host.h"
#include "base/linear.h"
#include "base/parallel.h"
#include <embree3/rtcore.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A mesh, and what cuts it out: NULL if nothing does. */
typedef struct cut_mesh {
  const scene_mesh *mesh;
  const scene_alpha_mask *alpha_mask;
} cut_mesh;

typedef struct tracer {
  const scene *scene;
  const camera *camera;
  RTCDevice device;
  RTCScene *meshes; /* one for each mesh */
  cut_mesh *cuts;   /* likewise */
  RTCScene world;   /* instance i is geometry i; relative to the camera's position */
  camera_rays rays;
  trace_surface *out;
} tracer;

/* Lets a ray through where a mesh is cut out; the geometry's user data is a cut_mesh. Rays are cast one by one. */
static void look_through(const struct RTCFilterFunctionNArguments *arguments) {
  const cut_mesh *cut = arguments->geometryUserPtr;
  const struct RTCHit *hit = (const struct RTCHit *)arguments->hit;
  const double weights[3] = {1.0 - hit->u - hit->v, hit->u, hit->v};
  double uv[2] = {0.0, 0.0};
  for (uint32_t corner = 0; corner < 3; corner++) {
    const float *at = cut->mesh->uvs + 2 * (size_t)scene_index(cut->mesh, 3 * hit->primID + corner);
    uv[0] += weights[corner] * at[0];
    uv[1] += weights[corner] * at[1];
  }
  if (scene_alpha_mask_at(cut->alpha_mask, uv) < cut->alpha_mask->cutoff)
    arguments->valid[0] = 0;
}

static RTCScene commit_mesh(RTCDevice device, cut_mesh *cut) {
  const scene_mesh *mesh = cut->mesh;
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  float *positions = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                             mesh->vertex_count);
  uint32_t *indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                              3 * sizeof(uint32_t), mesh->index_count / 3);
  if (positions && indices) {
    memcpy(positions, mesh->positions, 3 * sizeof(float) * (size_t)mesh->vertex_count);
    for (uint32_t i = 0; i < mesh->index_count; i++)
      indices[i] = scene_index(mesh, i);
  }
  if (cut->alpha_mask) {
    rtcSetGeometryUserData(geometry, cut);
    rtcSetGeometryIntersectFilterFunction(geometry, look_through);
  }
  rtcCommitGeometry(geometry);
  RTCScene committed = rtcNewScene(device);
  rtcAttachGeometry(committed, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(committed);
  return committed;
}

static void attach_instance(tracer *t, uint32_t index) {
  const scene_instance *instance = &t->scene->instances[index];
  float transform[16];
  for (int i = 0; i < 16; i++)
    transform[i] = (float)(instance->transform[i] - (i >= 12 && i < 15 ? t->camera->position[i - 12] : 0.0));
  RTCGeometry geometry = rtcNewGeometry(t->device, RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(geometry, t->meshes[instance->mesh]);
  rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, transform);
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(t->world, geometry, index);
  rtcReleaseGeometry(geometry);
}

static bool build(tracer *t) {
  const scene *s = t->scene;
  t->device = rtcNewDevice(NULL);
  if (!t->device)
    return false;
  t->meshes = host_allocate(s->mesh_count, sizeof(RTCScene));
  t->cuts = host_allocate(s->mesh_count, sizeof *t->cuts);
  for (size_t m = 0; m < s->mesh_count; m++) {
    t->cuts[m] = (cut_mesh){.mesh = &s->meshes[m], .alpha_mask = scene_cut_out(s, &s->meshes[m])};
    t->meshes[m] = commit_mesh(t->device, &t->cuts[m]);
  }
  t->world = rtcNewScene(t->device);
  for (uint32_t i = 0; i < s->instance_count; i++)
    attach_instance(t, i);
  rtcCommitScene(t->world);
  return rtcGetDeviceError(t->device) == RTC_ERROR_NONE;
}

static void destroy(tracer *t) {
  if (t->world)
    rtcReleaseScene(t->world);
  for (size_t m = 0; t->meshes && m < t->scene->mesh_count; m++)
    if (t->meshes[m])
      rtcReleaseScene(t->meshes[m]);
  free(t->meshes);
  free(t->cuts);
  if (t->device)
    rtcReleaseDevice(t->device);
}

static void interpolate(float out[3], const float *values, const uint32_t corner[3], float u, float v) {
  for (int i = 0; i < 3; i++)
    out[i] = (1.0f - u - v) * values[3 * (size_t)corner[0] + i] + u * values[3 * (size_t)corner[1] + i] +
             v * values[3 * (size_t)corner[2] + i];
}

/* Object to world: by the inverse transpose, up to a positive scale. */
static void transform_normal(double out[3], const double m[16], const float normal[3]) {
  double cofactor[3];
  const double sign = mat_determinant3(m) < 0.0 ? -1.0 : 1.0;
  out[0] = out[1] = out[2] = 0.0;
  for (int column = 0; column < 3; column++) {
    vec_cross(cofactor, m + 4 * ((column + 1) % 3), m + 4 * ((column + 2) % 3));
    for (int i = 0; i < 3; i++)
      out[i] += sign * cofactor[i] * normal[column];
  }
}

/* A shade of its own for every instance, so that a forest is not one green. */
static float instance_shade(uint32_t index) {
  const uint32_t hash = (index + 1) * 2654435761u;
  return 0.86f + 0.28f * (float)(hash >> 16) / 65536.0f;
}

static void fill_surface(const tracer *t, const struct RTCRayHit *found, trace_surface *surface) {
  const uint32_t index = found->hit.instID[0];
  const scene_instance *instance = &t->scene->instances[index];
  const scene_mesh *mesh = &t->scene->meshes[instance->mesh];
  surface->instance = index;
  uint32_t corner[3];
  for (uint32_t i = 0; i < 3; i++)
    corner[i] = scene_index(mesh, 3 * found->hit.primID + i);

  const scene_material *material = &t->scene->materials[mesh->material];
  const float geometric[3] = {found->hit.Ng_x, found->hit.Ng_y, found->hit.Ng_z};
  float local[3], tint[3] = {1, 1, 1};
  memcpy(local, geometric, sizeof local);
  if (mesh->normals && !material->alpha_tested) /* leaves are often two faces in one place, with normals that differ */
    interpolate(local, mesh->normals, corner, found->hit.u, found->hit.v);
  if (mesh->colors)
    interpolate(tint, mesh->colors, corner, found->hit.u, found->hit.v);
  double face[3], normal[3];
  transform_normal(face, instance->transform, geometric);
  transform_normal(normal, instance->transform, local);
  if (!vec_normalize(normal))
    normal[1] = 1.0;
  const float shade = t->scene->instance_count > 200 && mesh->index_count < 9000 ? instance_shade(index) : 1.0f;
  double facing = 0.0;
  for (int i = 0; i < 3; i++)
    facing += face[i] * surface->ray[i];
  for (int i = 0; i < 3; i++) {
    surface->normal[i] = (float)(facing > 0.0 ? -normal[i] : normal[i]);
    surface->color[i] = material->color[i] * tint[i] * shade;
  }
}

static void trace_pixel(const tracer *t, struct RTCIntersectContext *context, uint32_t column, uint32_t row) {
  double origin[3], direction[3], reach;
  camera_ray(&t->rays, camera_pixel_x(&t->rays, column), camera_pixel_y(&t->rays, row), origin, direction, &reach);
  struct RTCRayHit found = {.ray = {.org_x = (float)origin[0],
                                    .org_y = (float)origin[1],
                                    .org_z = (float)origin[2],
                                    .dir_x = (float)direction[0],
                                    .dir_y = (float)direction[1],
                                    .dir_z = (float)direction[2],
                                    .tfar = (float)reach,
                                    .mask = 0xffffffffu},
                            .hit = {.geomID = RTC_INVALID_GEOMETRY_ID, .instID = {RTC_INVALID_GEOMETRY_ID}}};
  rtcIntersect1(t->world, context, &found);
  trace_surface *surface = &t->out[(size_t)row * t->rays.width + column];
  *surface = (trace_surface){.view_depth = -1.0};
  for (int i = 0; i < 3; i++)
    surface->ray[i] = (float)direction[i];
  if (found.hit.geomID == RTC_INVALID_GEOMETRY_ID)
    return;
  double position[3];
  for (int i = 0; i < 3; i++) {
    position[i] = origin[i] + found.ray.tfar * direction[i];
    surface->position[i] = (float)position[i];
  }
  surface->distance = vec_length(position);
  surface->view_depth = vec_dot(position, t->camera->forward);
  fill_surface(t, &found, surface);
}

static void trace_row(void *argument, uint32_t row) {
  const tracer *t = argument;
  struct RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  for (uint32_t column = 0; column < t->rays.width; column++)
    trace_pixel(t, &context, column, row);
}

int trace_camera(const scene *s, const camera *from, uint32_t width, uint32_t height, trace_surface *out) {
  tracer t = {.scene = s, .camera = from, .out = out};
  int code = 0;
  if (!camera_rays_make(&t.rays, from, width, height))
    code = host_fail(HOST_BAD_INPUT, "the camera's matrices are singular");
  else if (!build(&t))
    code = host_fail(HOST_BAD_INPUT, "Embree could not take the scene");
  else
    parallel_rows(height, trace_row, &t, NULL);
  destroy(&t);
  return code;
}
