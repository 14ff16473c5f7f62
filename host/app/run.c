#include "app/run.h"
#include "base/host.h"
#include "base/interrupt.h"
#include "base/output_file.h"
#include "picture/outside.h"
#include "picture/picture.h"
#include "scene/camera_json.h"
#include "setup/config_json.h"
#include "setup/output.h"
#include "stage/compare.h"
#include "stage/dump.h"
#include "stage/stage.h"
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

typedef struct run {
  const host_options *options;
  host_setup setup;
  stage stages[HOST_BACKENDS]; /* in the order of host_backend_names, those asked for */
  stage_frame frames[HOST_BACKENDS];
  uint32_t count;
  agreement agreement; /* with two */
} run;

static int draw_all(run *r) {
  for (uint32_t i = 0; i < r->count; i++) {
    char text[64];
    snprintf(text, sizeof text, "drawing with %s", r->stages[i].backend);
    host_progress(text);
    int code = stage_load(&r->stages[i], &r->setup);
    if (code == 0)
      code = stage_capture(&r->stages[i], &r->frames[i]);
    if (code == 0)
      code = stage_read_views(&r->stages[i], &r->frames[i]);
    host_progress("");
    if (code)
      return code;
  }
  return 0;
}

/* ---- table ---- */

static void print_cascades(FILE *to, const run *r) {
  const csm_binding *binding = &r->frames[0].binding;
  fprintf(to, "\n  cascade     near..far m     texel m   range m   drawn  culled");
  for (uint32_t i = 0; i < r->count; i++)
    fprintf(to, " %10s ms", r->stages[i].backend);
  fputc('\n', to);
  for (uint32_t k = 0; k < binding->cascade_count; k++) {
    const csm_cascade_info *cascade = &binding->cascades[k];
    const csm_cascade_stats *stats = &r->frames[0].stats.maps.cascades[k];
    fprintf(to, "  %7u %9.2f..%-9.2f %8.4f %9.1f %7u %7u", k, cascade->near_depth, cascade->far_depth,
            cascade->texel_size, cascade->depth_range, stats->casters_drawn, stats->casters_culled);
    for (uint32_t i = 0; i < r->count; i++)
      fprintf(to, " %13.2f", r->frames[i].stats.maps.cascades[k].gpu_ms);
    fputc('\n', to);
  }
}

static void print_row(FILE *to, const run *r, const char *name, double (*value)(const stage_stats *)) {
  fprintf(to, "  %-56s", name);
  for (uint32_t i = 0; i < r->count; i++)
    fprintf(to, " %13.2f", value(&r->frames[i].stats));
  fputc('\n', to);
}

static double clear_ms(const stage_stats *stats) {
  return stats->maps.clear_gpu_ms;
}
static double camera_ms(const stage_stats *stats) {
  return stats->mask.camera_depth_gpu_ms;
}
static double total_ms(const stage_stats *stats) {
  return stage_maps_ms(stats) + stage_view_ms(stats);
}
static double plan_ms(const stage_stats *stats) {
  return stats->maps.plan_ms;
}
static double record_ms(const stage_stats *stats) {
  return stats->maps.record_ms;
}

static void print_table(FILE *to, const run *r) {
  const host_setup *setup = &r->setup;
  fprintf(to, "scene %s: %zu instances of %zu meshes, %" PRIu64 " triangles; %ux%u; shadows to %g m\n",
          setup->scene.name, setup->scene.instance_count, setup->scene.mesh_count, scene_triangles(&setup->scene),
          setup->width, setup->height, setup->config.shadow_distance);
  fprintf(to, "%u maps of %u x %u\n", setup->config.cascade_count, setup->config.resolution, setup->config.resolution);
  for (uint32_t i = 0; i < r->count; i++)
    fprintf(to, "  %-8s %s; %s\n", r->stages[i].backend, r->stages[i].device, r->stages[i].driver);
  for (uint32_t i = 0; i < r->count; i++)
    stage_print_budget(to, &r->stages[i], &r->frames[i].stats);
  print_cascades(to, r);
  print_row(to, r, "clear, GPU", clear_ms);
  print_row(to, r, "all maps, GPU", stage_maps_ms);
  print_row(to, r, "camera depth, GPU", camera_ms);
  print_row(to, r, "mask, GPU", stage_mask_ms);
  print_row(to, r, "total, GPU", total_ms);
  print_row(to, r, "plan, CPU", plan_ms);
  print_row(to, r, "record and submit, CPU", record_ms);
  fputc('\n', to);
  if (r->count == 2)
    agreement_print(to, &r->agreement, r->stages[0].backend, r->stages[1].backend);
}

static uint64_t map_bytes(const run *r) {
  uint64_t bytes = 0;
  for (uint32_t i = 0; i < r->count; i++)
    bytes += r->frames[i].stats.maps.map_bytes;
  return bytes;
}

static void print_memory(FILE *to, const run *r, uint64_t peak) {
  const double mib = 1.0 / (1024.0 * 1024.0);
  fprintf(to, "  memory       peak %.0f MiB, of which maps %.0f MiB (%.0f %%)\n", (double)peak * mib,
          (double)map_bytes(r) * mib, peak ? 100.0 * (double)map_bytes(r) / (double)peak : 0.0);
}

/* ---- JSON ---- */

static json_t *cascade_to_json(const csm_cascade_info *info, const csm_cascade_stats *stats) {
  json_t *object = json_object();
  json_object_set_new(object, "near", json_real(info->near_depth));
  json_object_set_new(object, "far", json_real(info->far_depth));
  json_object_set_new(object, "texel_size", json_real(info->texel_size));
  json_object_set_new(object, "depth_range", json_real(info->depth_range));
  json_object_set_new(object, "casters_drawn", json_integer(stats->casters_drawn));
  json_object_set_new(object, "casters_culled", json_integer(stats->casters_culled));
  json_object_set_new(object, "triangles_drawn", json_integer((json_int_t)stats->triangles_drawn));
  json_object_set_new(object, "gpu_ms", json_real(stats->gpu_ms));
  return object;
}

static json_t *backend_to_json(const stage *s, const stage_frame *frame) {
  const csm_stats *stats = &frame->stats.maps;
  json_t *object = json_object(), *cascades = json_array();
  char hash[32];
  snprintf(hash, sizeof hash, "%016" PRIx64, stats->plan_hash);
  for (uint32_t k = 0; k < frame->binding.cascade_count; k++)
    json_array_append_new(cascades, cascade_to_json(&frame->binding.cascades[k], &stats->cascades[k]));
  json_object_set_new(object, "name", json_string(s->backend));
  json_object_set_new(object, "device", json_string(s->device));
  json_object_set_new(object, "driver", json_string(s->driver));
  json_object_set_new(object, "plan_hash", json_string(hash));
  json_object_set_new(object, "plan_ms", json_real(stats->plan_ms));
  json_object_set_new(object, "record_ms", json_real(stats->record_ms));
  json_object_set_new(object, "clear_gpu_ms", json_real(stats->clear_gpu_ms));
  json_object_set_new(object, "maps_gpu_ms", json_real(stage_maps_ms(&frame->stats)));
  json_object_set_new(object, "camera_depth_gpu_ms", json_real(camera_ms(&frame->stats)));
  json_object_set_new(object, "mask_gpu_ms", json_real(stage_mask_ms(&frame->stats)));
  json_object_set_new(object, "total_gpu_ms", json_real(total_ms(&frame->stats)));
  json_object_set_new(object, "map_bytes", json_integer((json_int_t)stats->map_bytes));
  json_object_set_new(object, "view_bytes", json_integer((json_int_t)frame->stats.mask.bytes));
  json_object_set_new(object, "geometry_bytes", json_integer((json_int_t)stats->geometry_bytes));
  json_object_set_new(object, "frame_bytes", json_integer((json_int_t)stats->frame_bytes));
  json_object_set_new(object, "cascades", cascades);
  return object;
}

static json_t *run_to_json(const run *r, uint64_t peak) {
  const host_setup *setup = &r->setup;
  json_t *object = json_object(), *backends = json_array();
  for (uint32_t i = 0; i < r->count; i++)
    json_array_append_new(backends, backend_to_json(&r->stages[i], &r->frames[i]));
  json_object_set_new(object, "scene", json_string(setup->scene.name));
  json_object_set_new(object, "instances", json_integer((json_int_t)setup->scene.instance_count));
  json_object_set_new(object, "triangles", json_integer((json_int_t)scene_triangles(&setup->scene)));
  json_object_set_new(object, "width", json_integer(setup->width));
  json_object_set_new(object, "height", json_integer(setup->height));
  json_object_set_new(object, "shadow_distance", json_real(setup->shadow_distance));
  json_object_set_new(object, "camera", camera_to_json(&setup->camera));
  json_object_set_new(object, "config", config_to_json(&setup->config));
  json_object_set_new(object, "backends", backends);
  if (r->count == 2)
    json_object_set_new(object, "agreement", agreement_to_json(&r->agreement));
  json_object_set_new(object, "peak_bytes", json_integer((json_int_t)peak));
  json_object_set_new(object, "maps_share", json_real(peak ? (double)map_bytes(r) / (double)peak : 0.0));
  return object;
}

/* ---- pictures ---- */

static int save(image *picture, const char *folder, const char *prefix, const char *name) {
  char path[OUTPUT_PATH_SIZE];
  int code = output_path(path, folder, "%s%s.png", prefix, name);
  if (code == 0)
    code = image_write_png(picture, path);
  image_free(picture);
  return code;
}

/* What stands outside and looks at the camera and the cascades. */
static int save_outside(const run *r, const picture_view *view, const stage_frame *frame, const char *prefix) {
  outside_view outside;
  image picture;
  int code = outside_view_make(&outside, view, &frame->binding);
  if (code == 0) {
    picture_frusta(&picture, &outside);
    code = save(&picture, r->options->out, prefix, "frusta");
  }
  if (code == 0) {
    picture_culled(&picture, &outside, frame->casters);
    code = save(&picture, r->options->out, prefix, "culled");
  }
  outside_view_free(&outside);
  return code;
}

/* The pictures of one backend; `prefix` keeps two apart. */
static int save_frame(const run *r, const picture_view *view, const stage_frame *frame, const char *prefix) {
  static const char *const views[STAGE_VIEWS] = {"cascades", "density", "penumbra", NULL, "rays", "pages"};
  image picture;
  picture_lit(&picture, view, frame->mask);
  int code = save(&picture, r->options->out, prefix, "lit");
  if (code == 0) {
    picture_mask(&picture, view, frame->mask);
    code = save(&picture, r->options->out, prefix, "mask");
  }
  if (code == 0) {
    picture_maps(&picture, (const float *const *)frame->maps, frame->binding.cascade_count, frame->binding.resolutions,
                 r->setup.config.map_reversed);
    code = save(&picture, r->options->out, prefix, "maps");
  }
  for (uint32_t i = 0; i < STAGE_VIEWS && code == 0; i++)
    if (frame->views[i]) {
      picture_shown(&picture, view, frame->mask, i + 1, frame->views[i]);
      code = save(&picture, r->options->out, prefix, views[i]);
    }
  return code ? code : save_outside(r, view, frame, prefix);
}

/*
 * Backends that agree share one set of pictures. Where they differ, the second one has a set of its own, named after
 * it. difference.png shows where.
 */
static int save_pictures(const run *r) {
  const host_setup *setup = &r->setup;
  int code = host_make_folder(r->options->out);
  if (code)
    return code;
  host_progress("writing pictures");
  trace_surface *surfaces = host_allocate((size_t)setup->width * setup->height, sizeof *surfaces);
  code = trace_camera(&setup->scene, &setup->camera, setup->width, setup->height, surfaces);
  const picture_view view = {.scene = &setup->scene,
                             .light = &setup->light,
                             .camera = &setup->camera,
                             .width = setup->width,
                             .height = setup->height,
                             .surfaces = surfaces};
  if (code == 0)
    code = save_frame(r, &view, &r->frames[0], "");
  if (code == 0 && r->count == 2) {
    char prefix[64];
    snprintf(prefix, sizeof prefix, "%s-", r->stages[1].backend);
    if (!r->agreement.agrees)
      code = save_frame(r, &view, &r->frames[1], prefix);
    image picture;
    picture_difference(&picture, &view, r->frames[0].mask, r->frames[1].mask, compare_mask_tolerance);
    const int last = save(&picture, r->options->out, "", "difference");
    code = code ? code : last;
  }
  host_progress("");
  free(surfaces);
  return code;
}

/* All of it or nothing, so that no file of one run lies beside another's. */
static int dump_all(const run *r) {
  interrupt_hold hold;
  int code = 0;
  host_progress("writing the dump");
  interrupt_hold_begin(&hold);
  for (uint32_t i = 0; code == 0 && i < r->count; i++)
    code = dump_frame(r->options->dump, &r->stages[i], &r->frames[i], NULL);
  interrupt_hold_end(&hold);
  host_progress("");
  return code;
}

int run_command(const host_options *options) {
  run *r = host_allocate(1, sizeof *r);
  r->options = options;
  int code = setup_load(&r->setup, options);
  if (code == 0) /* before anything is drawn, so that a missing one is told at once */
    code = stage_open_all(r->stages, &r->count, options);
  if (code == 0)
    code = draw_all(r);
  if (code == 0 && r->count == 2)
    compare_frames(&r->agreement, &r->stages[0], &r->frames[0], &r->stages[1], &r->frames[1]);
  if (code == 0)
    print_table(output_table(options), r);
  if (code == 0)
    code = save_pictures(r);
  if (code == 0 && options->dump)
    code = dump_all(r);
  if (code == 0) {
    const uint64_t peak = output_peak_memory();
    print_memory(output_table(options), r, peak);
    fprintf(output_table(options), "  pictures     %s/\n", options->out);
    code = output_json(options, run_to_json(r, peak));
  }
  if (code == 0 && r->count == 2 && !r->agreement.agrees)
    code = HOST_DIFFER;
  for (uint32_t i = 0; i < r->count; i++) {
    stage_frame_free(&r->frames[i]);
    stage_close(&r->stages[i]);
  }
  setup_free(&r->setup);
  free(r);
  return code;
}
