#include "measure/measure.h"
#include "base/host.h"
#include "base/interrupt.h"
#include "base/output_file.h"
#include "measure/error_picture.h"
#include "measure/path.h"
#include "measure/truth_frame.h"
#include "scene/camera_json.h"
#include "setup/config_json.h"
#include "setup/output.h"
#include "stage/compare.h"
#include "stage/dump.h"
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

typedef struct measurement {
  const host_options *options;
  host_setup setup;
  truth_store store;
  truth_frame truth;
  uint32_t count; /* of backends asked for */
  stage stages[HOST_BACKENDS];
  stage_frame frames[HOST_BACKENDS];
  metrics metrics[HOST_BACKENDS];
  uint8_t *kinds[HOST_BACKENDS];
  agreement agreement; /* with two */
  measure_path path;
  path_result results[HOST_BACKENDS]; /* along the path */
} measurement;

/* ---- drawing ---- */

static metrics_frame frame_of(const measurement *m, uint32_t i) {
  return truth_frame_against(&m->truth, &m->setup, &m->frames[i]);
}

static int draw(measurement *m, uint32_t i) {
  char text[64];
  snprintf(text, sizeof text, "drawing with %s", m->stages[i].backend);
  host_progress(text);
  int code = stage_load(&m->stages[i], &m->setup);
  if (code == 0)
    code = stage_capture(&m->stages[i], &m->frames[i]);
  host_progress("");
  return code;
}

static int measure_all(measurement *m) {
  int code = 0;
  for (uint32_t i = 0; code == 0 && i < m->count; i++) {
    code = draw(m, i);
    if (code)
      break;
    const metrics_frame frame = frame_of(m, i);
    m->kinds[i] = host_allocate((size_t)m->setup.width * m->setup.height, 1);
    code = metrics_measure(&m->metrics[i], &frame, m->kinds[i]);
  }
  if (code == 0 && m->count == 2)
    compare_frames(&m->agreement, &m->stages[0], &m->frames[0], &m->stages[1], &m->frames[1]);
  return code;
}

/* ---- telling ---- */

static void print_truth(FILE *to, const measurement *m) {
  const scene_light *light = &m->setup.light;
  if (light->disc_deg > 0.0)
    fprintf(to, "truth: a sun of %g degrees, %u rays a pixel; ", light->disc_deg, m->truth.convergence.samples);
  else
    fprintf(to, "truth: a hard sun, one ray a pixel; ");
  if (m->store.cast)
    fprintf(to, "cast in %.2f s, %.0f MiB\n", m->store.cast_ms * 1e-3,
            (double)truth_memory(m->store.caster) / (1024.0 * 1024.0));
  else
    fprintf(to, "found in %s\n", m->store.folder);
  if (light->disc_deg > 0.0)
    fprintf(to,
            "  convergence over %" PRIu64 " pixels in half-shadow: rms %.5f from a quarter of the rays, %.5f from "
            "half (largest %.4f)\n",
            m->truth.convergence.pixels, m->truth.convergence.rms_quarter, m->truth.convergence.rms_half,
            m->truth.convergence.largest_half);
}

static void print_time(FILE *to, const measurement *m, const char *name, double (*value)(const stage_stats *)) {
  fprintf(to, "  %-20s  %-34s", name, "");
  for (uint32_t i = 0; i < m->count; i++)
    fprintf(to, " %12.2f ms", value(&m->frames[i].stats));
  fputc('\n', to);
}

static void print_bytes(FILE *to, const measurement *m, const char *name, uint64_t (*value)(const stage_stats *)) {
  fprintf(to, "  %-20s  %-34s", name, "");
  for (uint32_t i = 0; i < m->count; i++)
    fprintf(to, " %12.2f MiB", (double)value(&m->frames[i].stats) / (1024.0 * 1024.0));
  fputc('\n', to);
}

static uint64_t map_bytes(const stage_stats *stats) {
  return stats->maps.map_bytes;
}

static uint64_t moment_bytes(const stage_stats *stats) {
  return stats->maps.moment_bytes + stats->maps.range_bytes;
}

static uint64_t tree_bytes(const stage_stats *stats) {
  return stats->maps.tree_bytes;
}

static uint64_t view_bytes(const stage_stats *stats) {
  return stats->mask.bytes;
}

static void print_setup(FILE *to, const measurement *m) {
  const host_setup *setup = &m->setup;
  fprintf(to, "scene %s: %" PRIu64 " triangles; %ux%u; shadow distance %g m; %u maps of %u x %u\n", setup->scene.name,
          scene_triangles(&setup->scene), setup->width, setup->height, setup->shadow_distance,
          setup->config.cascade_count, setup->config.resolution, setup->config.resolution);
  for (uint32_t i = 0; i < m->count; i++)
    fprintf(to, "  %-8s %s; %s\n", m->stages[i].backend, m->stages[i].device, m->stages[i].driver);
}

static double ray_share(const measurement *m, uint32_t i) {
  return m->frames[i].stats.mask.ray_pixels / ((double)m->setup.width * m->setup.height);
}

static void print_rays(FILE *to, const measurement *m) {
  fprintf(to, "  %-51s", "pixels that sent rays");
  for (uint32_t i = 0; i < m->count; i++)
    fprintf(to, " %12.4f %%", 100.0 * ray_share(m, i));
  fprintf(to, "\n  %-51s", "of them decided by the map");
  for (uint32_t i = 0; i < m->count; i++)
    fprintf(to, " %12" PRIu32 "  ", m->frames[i].stats.mask.ray_map_pixels);
  fputc('\n', to);
  print_bytes(to, m, "memory of trees", tree_bytes);
}

static void print_table(FILE *to, const measurement *m) {
  const char *names[HOST_BACKENDS];
  for (uint32_t i = 0; i < m->count; i++)
    names[i] = m->stages[i].backend;
  print_setup(to, m);
  print_truth(to, m);
  fputc('\n', to);
  for (uint32_t i = 0; i < m->count; i++)
    stage_print_budget(to, &m->stages[i], &m->frames[i].stats);
  metrics_print(to, m->metrics, names, m->count);
  print_time(to, m, "maps, GPU", stage_maps_ms);
  print_time(to, m, "moments, GPU", stage_moments_ms);
  print_time(to, m, "mask, GPU", stage_mask_ms);
  print_time(to, m, "history, GPU", stage_history_ms);
  print_bytes(to, m, "memory of maps", map_bytes);
  print_bytes(to, m, "memory of moments", moment_bytes);
  print_bytes(to, m, "memory of the view", view_bytes);
  if (m->frames[0].stats.mask.ray_pixels)
    print_rays(to, m);
  fputc('\n', to);
  if (m->count == 2)
    agreement_print(to, &m->agreement, names[0], names[1]);
}

static json_t *truth_to_json(const measurement *m) {
  json_t *object = json_object();
  json_object_set_new(object, "rays", json_integer(m->truth.convergence.samples));
  json_object_set_new(object, "cached", json_boolean(m->store.cast == 0));
  json_object_set_new(object, "cast_s", json_real(m->store.cast_ms * 1e-3));
  json_object_set_new(object, "bytes", json_integer((json_int_t)truth_memory(m->store.caster)));
  if (m->truth.convergence.samples > 1) {
    json_t *convergence = json_object();
    json_object_set_new(convergence, "pixels", json_integer((json_int_t)m->truth.convergence.pixels));
    json_object_set_new(convergence, "rms_quarter", json_real(m->truth.convergence.rms_quarter));
    json_object_set_new(convergence, "rms_half", json_real(m->truth.convergence.rms_half));
    json_object_set_new(convergence, "largest_half", json_real(m->truth.convergence.largest_half));
    json_object_set_new(object, "convergence", convergence);
  }
  return object;
}

static json_t *backend_to_json(const measurement *m, uint32_t i) {
  const stage_stats *stats = &m->frames[i].stats;
  json_t *object = json_object();
  json_object_set_new(object, "name", json_string(m->stages[i].backend));
  json_object_set_new(object, "device", json_string(m->stages[i].device));
  json_object_set_new(object, "driver", json_string(m->stages[i].driver));
  json_object_set_new(object, "metrics", metrics_to_json(&m->metrics[i]));
  json_object_set_new(object, "plan_ms", json_real(stats->maps.plan_ms));
  json_object_set_new(object, "record_ms", json_real(stats->maps.record_ms));
  json_object_set_new(object, "maps_gpu_ms", json_real(stage_maps_ms(stats)));
  json_object_set_new(object, "camera_depth_gpu_ms", json_real(stats->mask.camera_depth_gpu_ms));
  json_object_set_new(object, "moments_gpu_ms", json_real(stage_moments_ms(stats)));
  json_object_set_new(object, "mask_gpu_ms", json_real(stage_mask_ms(stats)));
  json_object_set_new(object, "history_gpu_ms", json_real(stage_history_ms(stats)));
  json_object_set_new(object, "rays_gpu_ms", json_real(fmax(stats->mask.rays_gpu_ms, 0.0)));
  json_object_set_new(object, "ray_pixels", json_integer(stats->mask.ray_pixels));
  json_object_set_new(object, "ray_map_pixels", json_integer(stats->mask.ray_map_pixels));
  json_object_set_new(object, "tree_bytes", json_integer((json_int_t)tree_bytes(stats)));
  json_object_set_new(object, "mesh_trees_ms", json_real(stats->maps.mesh_trees_ms));
  json_object_set_new(object, "instance_tree_ms", json_real(stats->maps.instance_tree_ms));
  json_object_set_new(object, "map_bytes", json_integer((json_int_t)map_bytes(stats)));
  json_object_set_new(object, "moment_bytes", json_integer((json_int_t)moment_bytes(stats)));
  json_object_set_new(object, "view_bytes", json_integer((json_int_t)view_bytes(stats)));
  return object;
}

static json_t *setup_to_json(const measurement *m) {
  const host_setup *setup = &m->setup;
  json_t *object = json_object();
  json_object_set_new(object, "scene", json_string(setup->scene.name));
  json_object_set_new(object, "triangles", json_integer((json_int_t)scene_triangles(&setup->scene)));
  json_object_set_new(object, "width", json_integer(setup->width));
  json_object_set_new(object, "height", json_integer(setup->height));
  json_object_set_new(object, "shadow_distance", json_real(setup->shadow_distance));
  json_object_set_new(object, "config", config_to_json(&setup->config));
  return object;
}

static json_t *to_json(const measurement *m) {
  json_t *object = setup_to_json(m), *backends = json_array();
  for (uint32_t i = 0; i < m->count; i++)
    json_array_append_new(backends, backend_to_json(m, i));
  json_object_set_new(object, "camera", camera_to_json(&m->setup.camera));
  json_object_set_new(object, "light", light_to_json(&m->setup.light));
  json_object_set_new(object, "truth", truth_to_json(m));
  json_object_set_new(object, "backends", backends);
  if (m->count == 2)
    json_object_set_new(object, "agreement", agreement_to_json(&m->agreement));
  json_object_set_new(object, "peak_bytes", json_integer((json_int_t)output_peak_memory()));
  return object;
}

/* ---- pictures ---- */

static int save(image *picture, const char *folder, const char *backend, const char *name) {
  char path[OUTPUT_PATH_SIZE];
  int code = output_path(path, folder, "%s%s%s.png", backend, *backend ? "-" : "", name);
  if (code == 0)
    code = image_write_png(picture, path);
  image_free(picture);
  return code;
}

static int save_pictures(const measurement *m) {
  int code = host_make_folder(m->options->out);
  if (code)
    return code;
  host_progress("writing pictures");
  image picture;
  measure_picture_lit(&picture, &m->truth.view, &m->setup.light, m->truth.visibility);
  code = save(&picture, m->options->out, "", "truth");
  for (uint32_t i = 0; code == 0 && i < m->count; i++) {
    const metrics_frame frame = frame_of(m, i);
    measure_picture_lit(&picture, &m->truth.view, &m->setup.light, m->frames[i].mask);
    code = save(&picture, m->options->out, m->stages[i].backend, "drawn");
    (m->setup.light.disc_deg > 0.0 ? measure_picture_difference : measure_picture_errors)(&picture, &frame,
                                                                                          m->kinds[i]);
    const int last = save(&picture, m->options->out, m->stages[i].backend, "errors");
    code = code ? code : last;
  }
  host_progress("");
  return code;
}

/* All of it or nothing, so that no file of one run lies beside another's. */
static int dump_all(const measurement *m) {
  interrupt_hold hold;
  int code = 0;
  host_progress("writing the dump");
  interrupt_hold_begin(&hold);
  for (uint32_t i = 0; code == 0 && i < m->count; i++) {
    json_t *numbers = metrics_to_json(&m->metrics[i]);
    code = dump_frame(m->options->dump, &m->stages[i], &m->frames[i], numbers);
    json_decref(numbers);
  }
  interrupt_hold_end(&hold);
  host_progress("");
  return code;
}

/* ---- along a path ---- */

static void print_path(FILE *to, const measurement *m) {
  const char *names[HOST_BACKENDS];
  metrics pooled[HOST_BACKENDS];
  flicker flickers[HOST_BACKENDS];
  ghosts histories[HOST_BACKENDS];
  for (uint32_t i = 0; i < m->count; i++) {
    names[i] = m->stages[i].backend;
    pooled[i] = m->results[i].pooled;
    flickers[i] = m->results[i].flicker;
    histories[i] = m->results[i].ghosts;
  }
  print_setup(to, m);
  fprintf(to, "path: %u frames as one; truth cast in %.2f s, %u of %u answers from before\n\n", m->path.count,
          m->store.cast_ms * 1e-3, m->store.loaded, m->store.cast + m->store.loaded);
  metrics_print(to, pooled, names, m->count);
  flicker_print(to, flickers, m->count);
  if (m->setup.config.history)
    ghosts_print(to, histories, m->count);
}

static json_t *path_to_json(const measurement *m) {
  json_t *object = setup_to_json(m), *backends = json_array();
  for (uint32_t i = 0; i < m->count; i++) {
    const path_result *result = &m->results[i];
    json_t *backend = json_object(), *pooled = metrics_to_json(&result->pooled), *frames = json_array();
    for (uint32_t f = 0; f < m->path.count; f++) {
      json_t *frame = metrics_to_json(&result->frames[f]);
      if (result->histories)
        ghosts_to_json(frame, &result->histories[f]);
      json_array_append_new(frames, frame);
    }
    flicker_to_json(pooled, &result->flicker);
    if (result->histories)
      ghosts_to_json(pooled, &result->ghosts);
    json_object_set_new(backend, "name", json_string(m->stages[i].backend));
    json_object_set_new(backend, "device", json_string(m->stages[i].device));
    json_object_set_new(backend, "driver", json_string(m->stages[i].driver));
    json_object_set_new(backend, "metrics", pooled);
    json_object_set_new(backend, "frames", frames);
    json_array_append_new(backends, backend);
  }
  json_object_set_new(object, "frames", json_integer(m->path.count));
  json_object_set_new(object, "backends", backends);
  return object;
}

static int measure_along_path(measurement *m) {
  int code = 0;
  for (uint32_t i = 0; code == 0 && i < m->count; i++)
    code = stage_load(&m->stages[i], &m->setup);
  if (code == 0)
    code = measure_path_run(m->results, &m->path, &m->store, m->stages, m->count, m->options->sun_samples);
  if (code)
    return code;
  print_path(output_table(m->options), m);
  return output_json(m->options, path_to_json(m));
}

static int measure_frame(measurement *m) {
  const host_options *options = m->options;
  int code = truth_frame_cast(&m->truth, &m->store, &m->setup, options->sun_samples);
  if (code == 0)
    code = measure_all(m);
  if (code)
    return code;
  print_table(output_table(options), m);
  code = save_pictures(m);
  if (code == 0)
    fprintf(output_table(options), "  pictures     %s/\n", options->out);
  if (code == 0 && options->dump)
    code = dump_all(m);
  if (code == 0)
    code = output_json(options, to_json(m));
  return code == 0 && m->count == 2 && !m->agreement.agrees ? HOST_DIFFER : code;
}

int measure_command(const host_options *options) {
  measurement *m = host_allocate(1, sizeof *m);
  m->options = options;
  int code = setup_load(&m->setup, options);
  if (code == 0)
    code = measure_path_load(&m->path, options, &m->setup);
  if (code == 0)
    code = truth_store_open(&m->store, &m->setup.scene, true, options->cache);
  if (code == 0)
    code = stage_open_all(m->stages, &m->count, options);
  if (code == 0)
    code = m->path.count ? measure_along_path(m) : measure_frame(m);
  for (uint32_t i = 0; i < m->count; i++) {
    path_result_free(&m->results[i]);
    stage_frame_free(&m->frames[i]);
    stage_close(&m->stages[i]);
    free(m->kinds[i]);
  }
  truth_frame_free(&m->truth);
  measure_path_free(&m->path);
  truth_store_close(&m->store);
  setup_free(&m->setup);
  free(m);
  return code;
}
