#include "shadows.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

static void check(const shadows *s, csm_result result, const char *what) {
  if (result != CSM_SUCCESS)
    app_fail(APP_FAILED, "%s: %s: %s", what, s->csm.result_name(result), s->csm.last_error(s->context));
}

static void load(shadows *s, const char *path) {
  s->library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
  if (!s->library)
    app_fail(APP_FAILED, "%s", dlerror());
  const char *missing = csm_functions_load(s->library, &s->csm);
  if (missing)
    app_fail(APP_FAILED, "%s has no %s", path, missing);
}

static void CSM_CALL log_message(void *user, int32_t level, const char *message) {
  (void)user;
  if (level <= CSM_LOG_WARNING)
    fprintf(stderr, "csm: %s\n", message);
}

void shadows_open(shadows *s, const char *library, csm_create_info *create) {
  char error[512] = "";
  *s = (shadows){0};
  load(s, library);

  create->struct_size = sizeof *create;
  create->version = CSM_VERSION;
  create->frame_slots = SHADOWS_FRAMES_IN_FLIGHT;
  create->log = log_message;
  create->error = error;
  create->error_size = sizeof error;
  const csm_result result = s->csm.create(create, &s->context);
  if (result != CSM_SUCCESS)
    app_fail(APP_NO_DEVICE, "csm_create: %s: %s", s->csm.result_name(result), error);

  csm_config config = {.struct_size = sizeof config};
  s->csm.config_default(&config);
  config.cascade_count = 3;
  config.resolution = 1024;
  config.filter = CSM_FILTER_PCF_3X3;
  config.shadow_distance = 50.0;
  config.caster_distance = 40.0;
  check(s, s->csm.cascades_create(s->context, &config, &s->cascades), "csm_cascades_create");
  check(s, s->csm.scene_create(s->context, &s->scene), "csm_scene_create");
}

void shadows_close(shadows *s) {
  s->csm.destroy(s->context); /* and all that was made on it */
  dlclose(s->library);
}

void shadows_add_mesh(shadows *s, uint32_t index, const mesh *m, csm_mesh_info *info) {
  info->struct_size = sizeof *info;
  info->vertex_count = m->vertex_count;
  info->index_count = m->index_count;
  info->index_size = sizeof *m->indices;
  info->name = m->name;
  memcpy(info->bounds_min, m->bounds_min, sizeof info->bounds_min);
  memcpy(info->bounds_max, m->bounds_max, sizeof info->bounds_max);
  check(s, s->csm.mesh_create(s->context, info, &s->meshes[index]), "csm_mesh_create");
}

void shadows_retire(shadows *s, int64_t frame) {
  if (frame > 0)
    check(s, s->csm.retire(s->context, (uint64_t)frame), "csm_retire");
}

/* What bends is drawn by the engine, because its own shader bends it. */
void shadows_place(shadows *s, const world *w) {
  csm_instance instances[WORLD_MAX_THINGS];
  csm_instance_id ids[WORLD_MAX_THINGS];
  uint32_t count = 0;
  for (uint32_t i = 0; i < w->thing_count; i++) {
    const thing *t = &w->things[i];
    if (t->bend > 0.0f)
      continue;
    instances[count] = (csm_instance){.struct_size = sizeof instances[0], .mesh = s->meshes[t->mesh]};
    memcpy(instances[count++].transform, t->bones[0], sizeof instances[0].transform);
  }
  const csm_scene_batch batch = {.struct_size = sizeof batch, .count = count, .ids = ids, .instances = instances};
  check(s, s->csm.scene_add(s->scene, &batch), "csm_scene_add");
}

csm_draw_target shadows_target(shadows *s) {
  csm_draw_target target = {.struct_size = sizeof target};
  check(s, s->csm.get_draw_target(s->cascades, &target), "csm_get_draw_target");
  return target;
}

void shadows_record(shadows *s, const world *w, const shadows_frame *frame, csm_binding *binding) {
  csm_camera camera = {.struct_size = sizeof camera};
  csm_light light = {.struct_size = sizeof light};
  memcpy(camera.view, w->view, sizeof camera.view);
  memcpy(camera.projection, w->projection, sizeof camera.projection);
  memcpy(light.direction, w->sun_direction, sizeof light.direction);
  const csm_frame info = {.struct_size = sizeof info,
                          .frame = frame->number,
                          .command_buffer = frame->command_buffer,
                          .camera = &camera,
                          .light = &light,
                          .scene = s->scene,
                          .draw = frame->draw,
                          .draw_user = frame->user};
  const double start = app_now_ms();
  check(s, s->csm.render_cascades(s->cascades, &info), "csm_render_cascades");
  s->cpu_ms[s->frames++] = app_now_ms() - start;
  check(s, s->csm.bind(s->cascades, binding), "csm_bind");
}

/* The second block grows with csm, and this shader was made with what csm_constants.h had then. */
void shadows_write_constants(void *to, const csm_binding *binding) {
  const uint32_t room = SHADOWS_CONSTANTS_BYTES - 16 * CSM_S_BEGIN, size = binding->setting_constants_size;
  memcpy(to, binding->cascade_constants, binding->cascade_constants_size);
  memcpy((char *)to + 16 * CSM_S_BEGIN, binding->setting_constants, size < room ? size : room);
}

bool shadows_reaches(const csm_draw_info *info, const double center[3], double radius) {
  for (int i = 0; i < 5; i++) {
    const double *plane = info->planes[i];
    const double distance = plane[0] * center[0] + plane[1] * center[1] + plane[2] * center[2] + plane[3];
    if (distance < -radius * sqrt(plane[0] * plane[0] + plane[1] * plane[1] + plane[2] * plane[2]))
      return false;
  }
  return true;
}

void shadows_report(shadows *s, const char *program, const char *device, double frame_ms, uint32_t messages) {
  csm_stats stats = {.struct_size = sizeof stats};
  uint32_t drawn = 0, culled = 0;
  check(s, s->csm.get_stats(s->cascades, &stats), "csm_get_stats");
  for (uint32_t i = 0; i < stats.cascade_count; i++) {
    drawn += stats.cascades[i].casters_drawn;
    culled += stats.cascades[i].casters_culled;
  }
  const double first = s->cpu_ms[0];
  printf("%s: %s: %u frames of %dx%d, %.1f ms each; csm_render_cascades %.3f ms of CPU (first %.3f), %u cascades, %u "
         "casters drawn, %u culled, %.1f MiB of maps; validation messages: %u\n",
         program, device, s->frames, WORLD_WIDTH, WORLD_HEIGHT, frame_ms, app_median(s->cpu_ms, s->frames), first,
         stats.cascade_count, drawn, culled, (double)stats.map_bytes / (1024.0 * 1024.0), messages);
}
