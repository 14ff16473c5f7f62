#include "stage/stage.h"
#include "base/host.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define TIMED_FRAMES 3

void CSM_CALL stage_log(void *user, int32_t level, const char *message) {
  const stage *s = user;
  if (!s->quiet && (level == CSM_LOG_ERROR || level == CSM_LOG_WARNING))
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

/* What the backend opens by itself. Another device that was asked for goes by what was asked. */
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

/* The scene stays in memory, so csm need not keep a copy of it for csm_switch_backend. */
static csm_result CSM_CALL supply_mesh(void *user, csm_mesh mesh, csm_mesh_info *info) {
  const assets *a = &((const stage *)user)->assets;
  for (size_t m = 0; m < a->scene->mesh_count; m++)
    if (a->meshes[m] == mesh) {
      *info = assets_mesh_info(a, m);
      return CSM_SUCCESS;
    }
  return CSM_ERROR_INVALID_HANDLE;
}

int stage_open_as(stage *out, const char *backend, const char *device, uint32_t flags) {
  *out = (stage){.backend = backend};
  const csm_create_info info = {.struct_size = sizeof info,
                                .version = CSM_VERSION,
                                .flags = flags,
                                .backend = backend,
                                .device = device,
                                .log = stage_log,
                                .user = out,
                                .supply = supply_mesh};
  if (csm_create(&info, &out->context) != CSM_SUCCESS)
    return HOST_NO_DEVICE;
  describe_device(out, device);
  return 0;
}

int stage_open(stage *out, const char *backend, const char *device) {
  return stage_open_as(out, backend, device, CSM_CREATE_RAYS);
}

int stage_open_all(stage stages[HOST_BACKENDS], uint32_t *count, const host_options *options) {
  int code = 0;
  *count = 0;
  for (int i = 0; i < HOST_BACKENDS && code == 0; i++)
    if (options->backends[i])
      code = stage_open(&stages[(*count)++], host_backend_names[i], options->device);
  return code;
}

void stage_close(stage *s) {
  csm_destroy(s->context);
  assets_free(&s->assets);
  free(s->instances);
  *s = (stage){0};
}

/* Adds the instances, or makes those that are there what they are. */
static csm_result place_instances(stage *s, const scene *from, bool add) {
  const uint32_t count = (uint32_t)from->instance_count;
  csm_instance *instances = host_allocate(count, sizeof *instances);
  for (uint32_t i = 0; i < count; i++) {
    instances[i] = (csm_instance){
        .struct_size = sizeof *instances, .mesh = s->assets.meshes[from->instances[i].mesh], .layers = s->layers};
    memcpy(instances[i].transform, from->instances[i].transform, sizeof instances[i].transform);
  }
  const csm_scene_batch batch = {
      .struct_size = sizeof batch, .count = count, .ids = s->instances, .instances = instances};
  csm_result result = CSM_SUCCESS;
  if (count)
    result = add ? csm_scene_add(s->scene, &batch) : csm_scene_change(s->scene, &batch);
  free(instances);
  return result;
}

int stage_stir(stage *s) {
  s->layers ^= 1; /* the light lights all of them */
  return exit_code(place_instances(s, &s->setup->scene, false));
}

csm_camera stage_camera(const camera *from) {
  csm_camera to = {.struct_size = sizeof to, .reversed = from->reversed ? CSM_REVERSED_YES : CSM_REVERSED_NO};
  memcpy(to.view, from->view, sizeof to.view);
  memcpy(to.projection, from->projection, sizeof to.projection);
  return to;
}

csm_light stage_light(const scene_light *from) {
  csm_light to = {.struct_size = sizeof to};
  memcpy(to.direction, from->direction, sizeof to.direction);
  to.angular_diameter = fmin(from->disc_deg * (3.14159265358979323846 / 180.0), 1.0);
  return to;
}

void stage_look(stage *s, const camera *from) {
  s->camera = stage_camera(from);
}

int stage_load(stage *s, const host_setup *setup) {
  s->setup = setup;
  s->camera = stage_camera(&setup->camera);
  s->light = stage_light(&setup->light);
  csm_result result = assets_upload(&s->assets, s->context, &setup->scene);
  s->instances = host_allocate(setup->scene.instance_count, sizeof *s->instances);
  if (result == CSM_SUCCESS)
    result = csm_scene_create(s->context, &s->scene);
  if (result == CSM_SUCCESS)
    result = place_instances(s, &setup->scene, true);
  s->frame = (csm_frame){.struct_size = sizeof s->frame, .camera = &s->camera, .light = &s->light, .scene = s->scene};
  if (result == CSM_SUCCESS)
    result = csm_view_create(s->context, &s->view);
  if (result == CSM_SUCCESS)
    result = csm_cascades_create(s->context, &setup->config, &s->cascades);
  return exit_code(result);
}

void stage_unload(stage *s) {
  csm_cascades_destroy(s->cascades);
  csm_view_destroy(s->view);
  csm_scene_destroy(s->scene);
  assets_destroy(&s->assets, s->context);
  free(s->instances);
  s->cascades = NULL;
  s->view = NULL;
  s->scene = NULL;
  s->instances = NULL;
}

int stage_configure(stage *s, const csm_config *config) {
  return exit_code(csm_cascades_configure(s->cascades, config));
}

/* The old ones go after the new ones are there, so that programs which both draw with are not made anew. */
int stage_restart(stage *s, const csm_config *config) {
  csm_cascades *old = s->cascades;
  s->cascades = NULL;
  const csm_result result = csm_cascades_create(s->context, config, &s->cascades);
  csm_cascades_destroy(old);
  return exit_code(result);
}

int stage_switch(stage *s, const char *backend, const char *device, double *ms) {
  char error[512] = "";
  const csm_create_info info = {.struct_size = sizeof info,
                                .version = CSM_VERSION,
                                .flags = CSM_CREATE_RAYS,
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

static csm_result wait_for_stats(const stage *s, stage_stats *stats) {
  *stats = (stage_stats){.maps.struct_size = sizeof stats->maps, .mask.struct_size = sizeof stats->mask};
  const csm_result result = csm_get_stats(s->cascades, &stats->maps);
  return result ? result : csm_get_view_stats(s->view, &stats->mask);
}

int stage_render(stage *s) {
  stage_stats stats;
  s->frame.flags = 0;
  csm_result result = csm_render_cascades(s->cascades, &s->frame);
  if (result == CSM_SUCCESS)
    result = wait_for_stats(s, &stats);
  return exit_code(result);
}

static csm_mask_info mask_of(const stage *s) {
  return (csm_mask_info){.struct_size = sizeof(csm_mask_info),
                         .flags = s->frame.flags,
                         .frame = &s->frame,
                         .width = s->setup->width,
                         .height = s->setup->height};
}

/* A mask of a single pixel is a frame of a view as any other. */
static csm_result resolve_on(stage *s, csm_view *view, uint32_t show, bool pixel) {
  csm_mask_info info = mask_of(s);
  info.show = show;
  info.width = pixel ? 1 : info.width;
  info.height = pixel ? 1 : info.height;
  return csm_resolve_mask(view, s->cascades, &info);
}

static csm_result resolve(stage *s, uint32_t show) {
  return resolve_on(s, s->view, show, false);
}

int stage_draw(stage *s, stage_stats *stats) {
  s->frame.flags = CSM_FRAME_TIMESTAMPS;
  csm_result result = csm_render_cascades(s->cascades, &s->frame);
  if (result == CSM_SUCCESS)
    result = resolve(s, CSM_SHOW_VISIBILITY);
  if (result == CSM_SUCCESS)
    result = wait_for_stats(s, stats);
  return exit_code(result);
}

/* Frames in which a budget that has settled chooses nothing else, and the most that it may take. */
enum { SETTLED_FRAMES = 20, MOST_SETTLING_FRAMES = 400 };

int stage_settle(stage *s, stage_stats *stats) {
  int code = stage_draw(s, stats);
  uint32_t side = code == 0 ? stats->maps.budget_side : 0;
  for (uint32_t i = 0, same = 0; code == 0 && side && i < MOST_SETTLING_FRAMES && same < SETTLED_FRAMES; i++) {
    code = stage_draw(s, stats);
    same = stats->maps.budget_side == side ? same + 1 : 0;
    side = stats->maps.budget_side;
  }
  return code;
}

void stage_print_budget(FILE *to, const stage *s, const stage_stats *stats) {
  const csm_stats *maps = &stats->maps;
  if (!maps->budget_side)
    return;
  fprintf(to, "  %-8s budget: %s", s->backend, maps->budget_text);
  if (maps->budget_ms_predicted >= 0.0)
    fprintf(to, "; predicted %.2f ms", maps->budget_ms_predicted);
  if (maps->budget_wrong_predicted >= 0.0)
    fprintf(to, "; predicted %.4f %% wrong", 100.0 * maps->budget_wrong_predicted);
  fputc('\n', to);
}

static double middle_of_three(double a, double b, double c) {
  const double low = a < b ? a : b, high = a < b ? b : a;
  return c < low ? low : c > high ? high : c;
}

/* Every time is the median of its own. */
static void median_times(stage_stats *out, const stage_stats timed[TIMED_FRAMES]) {
  const stage_stats *a = &timed[0], *b = &timed[1], *c = &timed[2];
  *out = *c;
  out->maps.plan_ms = middle_of_three(a->maps.plan_ms, b->maps.plan_ms, c->maps.plan_ms);
  out->maps.record_ms = middle_of_three(a->maps.record_ms, b->maps.record_ms, c->maps.record_ms);
  out->maps.clear_gpu_ms = middle_of_three(a->maps.clear_gpu_ms, b->maps.clear_gpu_ms, c->maps.clear_gpu_ms);
  out->mask.camera_depth_gpu_ms =
      middle_of_three(a->mask.camera_depth_gpu_ms, b->mask.camera_depth_gpu_ms, c->mask.camera_depth_gpu_ms);
  out->mask.mask_gpu_ms = middle_of_three(a->mask.mask_gpu_ms, b->mask.mask_gpu_ms, c->mask.mask_gpu_ms);
  out->mask.history_gpu_ms = middle_of_three(a->mask.history_gpu_ms, b->mask.history_gpu_ms, c->mask.history_gpu_ms);
  out->mask.rays_gpu_ms = middle_of_three(a->mask.rays_gpu_ms, b->mask.rays_gpu_ms, c->mask.rays_gpu_ms);
  out->maps.moments_gpu_ms = middle_of_three(a->maps.moments_gpu_ms, b->maps.moments_gpu_ms, c->maps.moments_gpu_ms);
  out->maps.ranges_gpu_ms = middle_of_three(a->maps.ranges_gpu_ms, b->maps.ranges_gpu_ms, c->maps.ranges_gpu_ms);
  for (uint32_t k = 0; k < out->maps.cascade_count; k++)
    out->maps.cascades[k].gpu_ms =
        middle_of_three(a->maps.cascades[k].gpu_ms, b->maps.cascades[k].gpu_ms, c->maps.cascades[k].gpu_ms);
}

static int read_into(stage *s, uint32_t source, uint32_t cascade, size_t count, float *out) {
  const csm_read_info info = {.struct_size = sizeof info,
                              .source = source,
                              .cascades = source == CSM_READ_MAP ? s->cascades : NULL,
                              .view = source == CSM_READ_MAP ? NULL : s->view,
                              .cascade = cascade,
                              .data = out,
                              .size = count * sizeof *out};
  return exit_code(csm_read(s->context, &info));
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
  if (code == 0)
    code = read_back(s, CSM_READ_VIEW_DEPTH, 0, pixels, &out->view_depth);
  return code;
}

bool stage_has_view(const stage *s, uint32_t show) {
  const uint32_t filter = s->setup->config.filter;
  if (show == CSM_SHOW_PAGES)
    return s->setup->config.map_layout == CSM_LAYOUT_PAGES;
  if (show == CSM_SHOW_RAYS)
    return filter == CSM_FILTER_EXACT || filter == CSM_FILTER_EXACT_SOFT;
  if (show == CSM_SHOW_PENUMBRA)
    return filter == CSM_FILTER_PCSS || filter == CSM_FILTER_VSSM || filter == CSM_FILTER_BACKPROJECTION ||
           filter == CSM_FILTER_EXACT_SOFT;
  return show != CSM_SHOW_HISTORY;
}

int stage_read_views(stage *s, stage_frame *out) {
  const size_t pixels = (size_t)s->setup->width * s->setup->height, instances = s->setup->scene.instance_count;
  int code = 0;
  s->frame.flags = 0;
  for (uint32_t i = 0; i < STAGE_VIEWS && code == 0; i++) {
    if (!stage_has_view(s, CSM_SHOW_CASCADE + i))
      continue;
    code = exit_code(resolve(s, CSM_SHOW_CASCADE + i));
    if (code == 0)
      code = read_back(s, CSM_READ_MASK, 0, pixels, &out->views[i]);
  }
  if (code)
    return code;
  out->casters = host_allocate(instances, sizeof *out->casters);
  return exit_code(csm_get_casters(s->cascades, (uint32_t)instances, s->instances, out->casters));
}

int stage_capture(stage *s, stage_frame *out) {
  stage_stats timed[TIMED_FRAMES];
  *out = (stage_frame){0};
  int code = stage_settle(s, &timed[0]);
  const csm_config *config = &s->setup->config;
  for (uint32_t i = TIMED_FRAMES + 1; config->history && code == 0 && i < config->history_frames; i++)
    code = stage_draw(s, &timed[0]);
  /* A history would forget what is stirred; its ranges are not timed then */
  const bool keeps_some = timed[0].maps.moment_bytes || (timed[0].maps.range_bytes && !config->history);
  for (int i = 0; code == 0 && i < TIMED_FRAMES; i++) {
    code = keeps_some ? stage_stir(s) : 0;
    if (code == 0)
      code = stage_draw(s, &timed[i]);
  }
  if (code == 0)
    code = stage_read(s, true, out);
  if (code == 0)
    median_times(&out->stats, timed);
  return code;
}

int stage_draw_from(stage *s, const camera *from, const scene_light *light) {
  s->frame.flags = 0;
  stage_look(s, from);
  s->light = stage_light(light);
  const csm_mask_info info = mask_of(s);
  csm_frame frame = s->frame;
  csm_result result = s->by_depth ? csm_reduce_depth(s->view, &info) : CSM_SUCCESS;
  frame.depth_view = s->by_depth ? s->view : NULL;
  if (result == CSM_SUCCESS)
    result = csm_render_cascades(s->cascades, &frame);
  return exit_code(result);
}

int stage_cascades(stage *s, const camera *from, float *cascades) {
  s->frame.flags = 0;
  stage_look(s, from);
  const int code = exit_code(resolve(s, CSM_SHOW_CASCADE));
  return code ? code : read_into(s, CSM_READ_MASK, 0, (size_t)s->setup->width * s->setup->height, cascades);
}

int stage_mask(stage *s, const camera *from, float *mask, float *view_depth, float *cascades) {
  const size_t pixels = (size_t)s->setup->width * s->setup->height;
  s->frame.flags = 0;
  stage_look(s, from);
  int code = exit_code(resolve(s, CSM_SHOW_VISIBILITY));
  if (code == 0)
    code = read_into(s, CSM_READ_MASK, 0, pixels, mask);
  if (code == 0 && view_depth)
    code = read_into(s, CSM_READ_VIEW_DEPTH, 0, pixels, view_depth);
  return code == 0 && cascades ? stage_cascades(s, from, cascades) : code;
}

int stage_mask_alone(stage *s, const camera *from, uint32_t frame, float *mask) {
  csm_view *view = NULL;
  s->frame.flags = 0;
  stage_look(s, from);
  csm_result result = csm_view_create(s->context, &view);
  for (uint32_t i = 0; i < frame && result == CSM_SUCCESS; i++)
    result = resolve_on(s, view, CSM_SHOW_VISIBILITY, true);
  if (result == CSM_SUCCESS)
    result = resolve_on(s, view, CSM_SHOW_VISIBILITY, false);
  const csm_read_info info = {.struct_size = sizeof info,
                              .source = CSM_READ_MASK,
                              .view = view,
                              .data = mask,
                              .size = (uint64_t)s->setup->width * s->setup->height * sizeof *mask};
  if (result == CSM_SUCCESS)
    result = csm_read(s->context, &info);
  csm_view_destroy(view);
  return exit_code(result);
}

void stage_frame_free(stage_frame *frame) {
  for (uint32_t k = 0; k < CSM_MAX_CASCADES; k++)
    free(frame->maps[k]);
  free(frame->mask);
  free(frame->camera_depth);
  free(frame->view_depth);
  for (uint32_t i = 0; i < STAGE_VIEWS; i++)
    free(frame->views[i]);
  free(frame->casters);
  memset(frame, 0, sizeof *frame);
}

double stage_maps_ms(const stage_stats *stats) {
  double sum = stats->maps.clear_gpu_ms;
  for (uint32_t k = 0; k < stats->maps.cascade_count; k++)
    sum += stats->maps.cascades[k].gpu_ms;
  return sum;
}

double stage_moments_ms(const stage_stats *stats) {
  return fmax(stats->maps.moments_gpu_ms, 0.0) + fmax(stats->maps.ranges_gpu_ms, 0.0);
}

double stage_mask_ms(const stage_stats *stats) {
  return stats->mask.mask_gpu_ms + fmax(stats->mask.rays_gpu_ms, 0.0);
}

double stage_history_ms(const stage_stats *stats) {
  return fmax(stats->mask.history_gpu_ms, 0.0);
}

double stage_shadows_ms(const stage_stats *stats) {
  return stage_maps_ms(stats) + stage_moments_ms(stats) + stage_mask_ms(stats) + stage_history_ms(stats);
}

double stage_view_ms(const stage_stats *stats) {
  return stats->mask.camera_depth_gpu_ms + stage_mask_ms(stats) + stage_history_ms(stats);
}
