#include "stage/stage.h"
#include "base/host.h"
#include "scene/mesh_closed.h"
#include <stdlib.h>
#include <string.h>

#define TIMED_FRAMES 3

static void CSM_CALL log_message(void *user, int32_t level, const char *message) {
  const stage *s = user;
  if (level == CSM_LOG_ERROR || level == CSM_LOG_WARNING)
    fprintf(stderr, "csm-host: %s: %s: %s\n", s->backend, level == CSM_LOG_ERROR ? "error" : "warning", message);
}

/* Whether the input is at fault, or the machine. What is wrong has been told to the log. */
static int exit_code(csm_result result) {
  switch (result) {
  case CSM_SUCCESS:
    return 0;
  case CSM_ERROR_NOT_FINITE:
  case CSM_ERROR_INVALID_VALUE:
  case CSM_ERROR_INVALID_MATRIX:
  case CSM_ERROR_INVALID_CAMERA:
  case CSM_ERROR_INVALID_LIGHT:
  case CSM_ERROR_INVALID_INDEX:
  case CSM_ERROR_LIMIT_EXCEEDED:
  case CSM_ERROR_UNSUPPORTED:
    return HOST_BAD_INPUT;
  default:
    return HOST_NO_DEVICE;
  }
}

/* What the backend opens by itself; another device that was asked for goes by what was asked. */
static void describe_device(stage *s, const char *asked) {
  csm_backend_info infos[8] = {{.struct_size = sizeof infos[0]}};
  uint32_t count = 8;
  if (csm_query_backends(&count, infos) != CSM_SUCCESS)
    return;
  for (uint32_t i = 0; i < count && i < 8; i++)
    if (strcmp(infos[i].name, s->backend) == 0) {
      const bool fits = !asked || strstr(infos[i].device, asked);
      snprintf(s->device, sizeof s->device, "%s", fits ? infos[i].device : asked);
      snprintf(s->driver, sizeof s->driver, "%s", fits ? infos[i].driver : "driver not known");
    }
}

/* `alpha mask`: of its material, or 0. */
static csm_mesh_info describe_mesh(const scene *from, const scene_mesh *mesh, csm_alpha_mask alpha_mask, bool closed) {
  csm_mesh_info info = {.struct_size = sizeof info,
                        .flags = closed ? CSM_MESH_WATERTIGHT : 0,
                        .positions = mesh->positions,
                        .vertex_count = mesh->vertex_count,
                        .indices = mesh->indices,
                        .index_count = mesh->index_count,
                        .index_size = mesh->index_size,
                        .name = mesh->name};
  const scene_alpha_mask *cut = scene_cut_out(from, mesh);
  if (cut) {
    info.flags = CSM_MESH_TWO_SIDED; /* leaves are */
    info.alpha_mask = alpha_mask;
    info.uvs = mesh->uvs;
    info.alpha_cutoff = (float)cut->cutoff;
  }
  return info;
}

/* The scene stays in memory, so csm need not keep a copy of it for csm_switch_backend. */
static csm_result CSM_CALL supply_mesh(void *user, csm_mesh mesh, csm_mesh_info *info) {
  const stage *s = user;
  for (size_t m = 0; m < s->setup->scene.mesh_count; m++)
    if (s->meshes[m] == mesh) {
      const scene_mesh *from = &s->setup->scene.meshes[m];
      *info = describe_mesh(&s->setup->scene, from, s->alpha_masks[from->material], s->closed[m]);
      return CSM_SUCCESS;
    }
  return CSM_ERROR_INVALID_HANDLE;
}

int stage_open(stage *out, const char *backend, const char *device) {
  *out = (stage){.backend = backend};
  const csm_create_info info = {.struct_size = sizeof info,
                                .version = CSM_VERSION,
                                .backend = backend,
                                .device = device,
                                .log = log_message,
                                .user = out,
                                .supply = supply_mesh};
  if (csm_create(&info, &out->context) != CSM_SUCCESS)
    return HOST_NO_DEVICE;
  describe_device(out, device);
  return 0;
}

void stage_close(stage *s) {
  csm_destroy(s->context);
  free(s->meshes);
  free(s->alpha_masks);
  free(s->closed);
  free(s->instances);
  *s = (stage){0};
}

static csm_result upload_alpha_mask(stage *s, const scene_alpha_mask *cut, csm_alpha_mask *out) {
  static const uint32_t wraps[] = {[SCENE_WRAP_REPEAT] = CSM_WRAP_REPEAT,
                                   [SCENE_WRAP_MIRROR] = CSM_WRAP_MIRROR,
                                   [SCENE_WRAP_CLAMP] = CSM_WRAP_CLAMP};
  const csm_alpha_mask_info info = {.struct_size = sizeof info,
                                    .width = cut->width,
                                    .height = cut->height,
                                    .wrap_u = wraps[cut->wrap[0]],
                                    .wrap_v = wraps[cut->wrap[1]],
                                    .texels = cut->alpha};
  return csm_alpha_mask_create(s->context, &info, out);
}

static int upload_meshes(stage *s, const scene *from) {
  int code = 0;
  s->meshes = host_allocate(from->mesh_count, sizeof *s->meshes);
  s->alpha_masks = host_allocate(from->material_count, sizeof *s->alpha_masks);
  s->closed = host_allocate(from->mesh_count, sizeof *s->closed);
  for (size_t m = 0; m < from->mesh_count && code == 0; m++) {
    const scene_mesh *mesh = &from->meshes[m];
    const scene_alpha_mask *cut = scene_cut_out(from, mesh);
    csm_alpha_mask *alpha_mask = &s->alpha_masks[mesh->material];
    if (cut && !*alpha_mask)
      code = exit_code(upload_alpha_mask(s, cut, alpha_mask));
    s->closed[m] = mesh_is_closed(mesh);
    const csm_mesh_info info = describe_mesh(from, mesh, *alpha_mask, s->closed[m]);
    if (code == 0)
      code = exit_code(csm_mesh_create(s->context, &info, &s->meshes[m]));
  }
  return code;
}

static void place_instances(stage *s, const scene *from) {
  s->instances = host_allocate(from->instance_count, sizeof *s->instances);
  for (size_t i = 0; i < from->instance_count; i++) {
    s->instances[i].struct_size = sizeof *s->instances;
    s->instances[i].mesh = s->meshes[from->instances[i].mesh];
    memcpy(s->instances[i].transform, from->instances[i].transform, sizeof s->instances[i].transform);
  }
}

int stage_load(stage *s, const host_setup *setup) {
  s->setup = setup;
  int code = upload_meshes(s, &setup->scene);
  if (code)
    return code;
  place_instances(s, &setup->scene);
  s->frame = (csm_frame){.struct_size = sizeof s->frame,
                         .instances = s->instances,
                         .instance_count = (uint32_t)setup->scene.instance_count};
  memcpy(s->frame.view, setup->camera.view, sizeof s->frame.view);
  memcpy(s->frame.projection, setup->camera.projection, sizeof s->frame.projection);
  memcpy(s->frame.light_direction, setup->light.direction, sizeof s->frame.light_direction);
  return exit_code(csm_cascades_create(s->context, &setup->config, &s->cascades));
}

int stage_configure(stage *s, const csm_config *config) {
  return exit_code(csm_cascades_configure(s->cascades, config));
}

int stage_switch(stage *s, const char *backend, const char *device, double *ms) {
  char error[512] = "";
  const csm_create_info info = {.struct_size = sizeof info,
                                .version = CSM_VERSION,
                                .backend = backend,
                                .device = device,
                                .error = error,
                                .error_size = sizeof error};
  const double start_ms = host_now_ms();
  if (csm_switch_backend(s->context, &info))
    return host_fail(HOST_NO_DEVICE, "switching to %s: %s", backend, error);
  *ms = host_now_ms() - start_ms;
  s->backend = backend;
  return 0;
}

static int wait_for_stats(stage *s, csm_stats *stats) {
  *stats = (csm_stats){.struct_size = sizeof *stats};
  return exit_code(csm_get_stats(s->cascades, stats));
}

int stage_render(stage *s) {
  csm_stats stats;
  s->frame.flags = 0;
  const int code = exit_code(csm_render_cascades(s->cascades, &s->frame));
  return code ? code : wait_for_stats(s, &stats);
}

int stage_draw(stage *s, csm_stats *stats) {
  s->frame.flags = CSM_FRAME_TIMESTAMPS;
  int code = exit_code(csm_render_cascades(s->cascades, &s->frame));
  const csm_mask_info mask = {.struct_size = sizeof mask,
                              .flags = CSM_FRAME_TIMESTAMPS,
                              .frame = &s->frame,
                              .width = s->setup->width,
                              .height = s->setup->height};
  if (code == 0)
    code = exit_code(csm_resolve_mask(s->cascades, &mask));
  return code ? code : wait_for_stats(s, stats);
}

static double middle_of_three(double a, double b, double c) {
  const double low = a < b ? a : b, high = a < b ? b : a;
  return c < low ? low : c > high ? high : c;
}

/* Every time is the median of its own. */
static void median_times(csm_stats *out, const csm_stats timed[TIMED_FRAMES]) {
  const csm_stats *a = &timed[0], *b = &timed[1], *c = &timed[2];
  *out = *c;
  out->plan_ms = middle_of_three(a->plan_ms, b->plan_ms, c->plan_ms);
  out->record_ms = middle_of_three(a->record_ms, b->record_ms, c->record_ms);
  out->clear_gpu_ms = middle_of_three(a->clear_gpu_ms, b->clear_gpu_ms, c->clear_gpu_ms);
  out->camera_depth_gpu_ms = middle_of_three(a->camera_depth_gpu_ms, b->camera_depth_gpu_ms, c->camera_depth_gpu_ms);
  out->mask_gpu_ms = middle_of_three(a->mask_gpu_ms, b->mask_gpu_ms, c->mask_gpu_ms);
  for (uint32_t k = 0; k < out->cascade_count; k++)
    out->cascades[k].gpu_ms = middle_of_three(a->cascades[k].gpu_ms, b->cascades[k].gpu_ms, c->cascades[k].gpu_ms);
}

static int read_into(stage *s, uint32_t source, uint32_t cascade, size_t count, float *out) {
  const csm_read_info info = {
      .struct_size = sizeof info, .source = source, .cascade = cascade, .data = out, .size = count * sizeof *out};
  return exit_code(csm_read(s->cascades, &info));
}

static int read_back(stage *s, uint32_t source, uint32_t cascade, size_t count, float **out) {
  *out = host_allocate(count, sizeof **out);
  return read_into(s, source, cascade, count, *out);
}

size_t stage_map_texels(const stage_frame *frame, uint32_t cascade) {
  return (size_t)frame->binding.resolutions[cascade] * frame->binding.resolutions[cascade];
}

int stage_read(stage *s, bool maps, stage_frame *out) {
  *out = (stage_frame){.binding.struct_size = sizeof out->binding};
  int code = exit_code(csm_bind(s->cascades, &out->binding));
  const size_t pixels = (size_t)s->setup->width * s->setup->height;
  for (uint32_t k = 0; maps && code == 0 && k < out->binding.cascade_count; k++)
    code = read_back(s, CSM_READ_MAP, k, stage_map_texels(out, k), &out->maps[k]);
  if (code == 0)
    code = read_back(s, CSM_READ_MASK, 0, pixels, &out->mask);
  if (code == 0)
    code = read_back(s, CSM_READ_CAMERA_DEPTH, 0, pixels, &out->camera_depth);
  return code;
}

int stage_read_views(stage *s, stage_frame *out) {
  const size_t pixels = (size_t)s->setup->width * s->setup->height, instances = s->setup->scene.instance_count;
  int code = 0;
  s->frame.flags = 0;
  for (uint32_t i = 0; i < STAGE_VIEWS && code == 0; i++) {
    const csm_mask_info info = {.struct_size = sizeof info,
                                .frame = &s->frame,
                                .width = s->setup->width,
                                .height = s->setup->height,
                                .view = CSM_VIEW_CASCADE + i};
    code = exit_code(csm_resolve_mask(s->cascades, &info));
    if (code == 0)
      code = read_back(s, CSM_READ_MASK, 0, pixels, &out->views[i]);
  }
  if (code)
    return code;
  out->casters = host_allocate(instances, sizeof *out->casters);
  return exit_code(csm_get_casters(s->cascades, (uint32_t)instances, out->casters));
}

int stage_capture(stage *s, stage_frame *out) {
  csm_stats timed[TIMED_FRAMES];
  *out = (stage_frame){0};
  int code = stage_draw(s, &timed[0]);
  for (int i = 0; code == 0 && i < TIMED_FRAMES; i++)
    code = stage_draw(s, &timed[i]);
  if (code == 0)
    code = stage_read(s, true, out);
  if (code == 0)
    median_times(&out->stats, timed);
  return code;
}

static void look_from(stage *s, const camera *from) {
  s->frame.flags = 0;
  memcpy(s->frame.view, from->view, sizeof s->frame.view);
  memcpy(s->frame.projection, from->projection, sizeof s->frame.projection);
}

int stage_draw_from(stage *s, const camera *from, const scene_light *light, csm_binding *binding) {
  look_from(s, from);
  memcpy(s->frame.light_direction, light->direction, sizeof s->frame.light_direction);
  const int code = exit_code(csm_render_cascades(s->cascades, &s->frame));
  *binding = (csm_binding){.struct_size = sizeof *binding};
  return code ? code : exit_code(csm_bind(s->cascades, binding));
}

int stage_mask(stage *s, const camera *from, float *mask, float *camera_depth, float *cascades) {
  look_from(s, from);
  csm_mask_info info = {
      .struct_size = sizeof info, .frame = &s->frame, .width = s->setup->width, .height = s->setup->height};
  const size_t pixels = (size_t)s->setup->width * s->setup->height;
  int code = exit_code(csm_resolve_mask(s->cascades, &info));
  if (code == 0)
    code = read_into(s, CSM_READ_MASK, 0, pixels, mask);
  if (code == 0 && camera_depth)
    code = read_into(s, CSM_READ_CAMERA_DEPTH, 0, pixels, camera_depth);
  info.view = CSM_VIEW_CASCADE;
  if (code == 0 && cascades)
    code = exit_code(csm_resolve_mask(s->cascades, &info));
  if (code == 0 && cascades)
    code = read_into(s, CSM_READ_MASK, 0, pixels, cascades);
  return code;
}

void stage_frame_free(stage_frame *frame) {
  for (uint32_t k = 0; k < CSM_MAX_CASCADES; k++)
    free(frame->maps[k]);
  free(frame->mask);
  free(frame->camera_depth);
  for (uint32_t i = 0; i < STAGE_VIEWS; i++)
    free(frame->views[i]);
  free(frame->casters);
  memset(frame, 0, sizeof *frame);
}

double stage_depth_ms(const csm_stats *stats) {
  double sum = stats->clear_gpu_ms;
  for (uint32_t k = 0; k < stats->cascade_count; k++)
    sum += stats->cascades[k].gpu_ms;
  return sum;
}
