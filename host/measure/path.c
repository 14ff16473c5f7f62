#include "measure/path.h"
#include "base/host.h"
#include "scene/camera_json.h"
#include "scene/sun_path.h"
#include <stdlib.h>
#include <string.h>

/* ---- files ---- */

static int load_cameras(measure_path *out, const json_list *list, const host_setup *setup) {
  const double aspect = (double)setup->width / setup->height;
  int code = 0;
  out->cameras = host_allocate(list->count, sizeof *out->cameras);
  for (size_t i = 0; code == 0 && i < list->count; i++) {
    const json_t *value = json_array_get(list->root, i);
    code = json_is_string(value) ? camera_from_text(&out->cameras[i], &setup->scene.camera, json_string_value(value),
                                                    aspect, &list->elements[i])
                                 : camera_from_object(&out->cameras[i], value, &list->elements[i]);
  }
  return code;
}

static int load_lights(measure_path *out, const json_list *list) {
  int code = 0;
  out->lights = host_allocate(list->count, sizeof *out->lights);
  for (size_t i = 0; code == 0 && i < list->count; i++) {
    const json_t *value = json_array_get(list->root, i);
    code = json_is_string(value) ? light_from_text(&out->lights[i], json_string_value(value), &list->elements[i])
                                 : light_from_object(&out->lights[i], value, &list->elements[i]);
  }
  return code;
}

static void fill_in(measure_path *out, const host_setup *setup) {
  if (!out->cameras) {
    out->cameras = host_allocate(out->count, sizeof *out->cameras);
    for (uint32_t i = 0; i < out->count; i++)
      out->cameras[i] = setup->camera;
  }
  if (!out->lights) {
    out->lights = host_allocate(out->count, sizeof *out->lights);
    for (uint32_t i = 0; i < out->count; i++)
      out->lights[i] = setup->light;
  }
}

int measure_path_load(measure_path *out, const host_options *options, const host_setup *setup) {
  json_list cameras = {0}, lights = {0};
  int code = 0;
  *out = (measure_path){0};
  if (options->camera_path)
    code = json_list_load(&cameras, "--camera-path", options->camera_path);
  if (code == 0 && options->camera_path)
    code = load_cameras(out, &cameras, setup);
  uint32_t light_count = 0;
  if (code == 0 && options->light_path && sun_path_is(options->light_path)) {
    code = sun_path_load(&out->lights, &light_count, options->light_path, setup->light.disc_deg);
  } else if (code == 0 && options->light_path) {
    code = json_list_load(&lights, "--light-path", options->light_path);
    light_count = (uint32_t)lights.count;
    if (code == 0)
      code = load_lights(out, &lights);
  }
  if (code == 0 && cameras.count && light_count && cameras.count != light_count)
    code = host_fail(HOST_BAD_INPUT, "--light-path: %u lights, but --camera-path has %zu cameras", light_count,
                     cameras.count);
  if (code == 0) {
    out->count = cameras.count ? (uint32_t)cameras.count : light_count;
    fill_in(out, setup);
  }
  json_list_free(&cameras);
  json_list_free(&lights);
  return code;
}

void measure_path_free(measure_path *path) {
  free(path->cameras);
  free(path->lights);
  *path = (measure_path){0};
}

/* ---- frames ---- */

/* What a frame leaves for the next one. */
typedef struct path_frame {
  truth_view view;
  float *visibility;
  float *masks[HOST_BACKENDS];
  float *alone[HOST_BACKENDS]; /* masks without a history: the same, where none is kept */
  uint8_t *kinds[HOST_BACKENDS];
  float *cascades[HOST_BACKENDS]; /* which each point takes */
} path_frame;

typedef struct walk {
  const measure_path *path;
  truth_store *store;
  stage *stages;
  uint32_t count; /* of stages */
  uint32_t sun_samples;
  path_result *results;
  path_frame frames[2]; /* in turn */
  float *view_depth;    /* scratch, one picture each */
  float *later_mask, *later_cascades, *later_visibility;
  uint8_t *seen;
} walk;

static size_t picture_pixels(const walk *w) {
  return (size_t)w->stages[0].setup->width * w->stages[0].setup->height;
}

/* Whether masks are accumulated. */
static bool keeps_history(const walk *w) {
  return w->stages[0].setup->config.history == CSM_HISTORY_ON;
}

static void allocate_frames(walk *w) {
  const size_t pixels = picture_pixels(w);
  for (int f = 0; f < 2; f++) {
    path_frame *frame = &w->frames[f];
    frame->view.width = w->stages[0].setup->width;
    frame->view.height = w->stages[0].setup->height;
    frame->view.surfaces = host_allocate(pixels, sizeof *frame->view.surfaces);
    frame->visibility = host_allocate(pixels, sizeof *frame->visibility);
    for (uint32_t b = 0; b < w->count; b++) {
      frame->masks[b] = host_allocate(pixels, sizeof *frame->masks[b]);
      frame->alone[b] = keeps_history(w) ? host_allocate(pixels, sizeof *frame->alone[b]) : frame->masks[b];
      frame->cascades[b] = host_allocate(pixels, sizeof *frame->cascades[b]);
      frame->kinds[b] = host_allocate(pixels, sizeof *frame->kinds[b]);
    }
  }
  w->view_depth = host_allocate(pixels, sizeof *w->view_depth);
  w->later_mask = host_allocate(pixels, sizeof *w->later_mask);
  w->later_cascades = host_allocate(pixels, sizeof *w->later_cascades);
  w->later_visibility = host_allocate(pixels, sizeof *w->later_visibility);
  w->seen = host_allocate(pixels, sizeof *w->seen);
}

static void free_frames(walk *w) {
  for (int f = 0; f < 2; f++) {
    free(w->frames[f].view.surfaces);
    free(w->frames[f].visibility);
    for (uint32_t b = 0; b < w->count; b++) {
      if (keeps_history(w))
        free(w->frames[f].alone[b]);
      free(w->frames[f].masks[b]);
      free(w->frames[f].cascades[b]);
      free(w->frames[f].kinds[b]);
    }
  }
  free(w->view_depth);
  free(w->later_mask);
  free(w->later_cascades);
  free(w->later_visibility);
  free(w->seen);
}

static int cast_light(walk *w, uint32_t index, const truth_view *view, float *visibility) {
  const truth_asked asked = {
      .light = &w->path->lights[index], .max_depth = w->stages[0].setup->shadow_distance, .samples = w->sun_samples};
  truth_convergence convergence;
  return truth_store_visibility(w->store, view, &asked, visibility, &convergence);
}

static int cast_frame(walk *w, uint32_t index, path_frame *frame) {
  frame->view.camera = &w->path->cameras[index];
  const int code = truth_store_view(w->store, &frame->view);
  return code ? code : cast_light(w, index, &frame->view, frame->visibility);
}

/* What the frame before saw, with this frame's light, as far as this frame sees it too. */
static int cast_pair(walk *w, uint32_t index, const path_frame *before) {
  const int code = truth_store_seen(w->store, &before->view, &w->path->cameras[index], w->seen);
  if (code == 0 && memcmp(&w->path->lights[index], &w->path->lights[index - 1], sizeof w->path->lights[0]) == 0) {
    memcpy(w->later_visibility, before->visibility, picture_pixels(w) * sizeof *w->later_visibility);
    return 0;
  }
  return code ? code : cast_light(w, index, &before->view, w->later_visibility);
}

/* This frame's maps, asked at the very points that the frame before saw. */
static int compare_with(walk *w, uint32_t index, uint32_t b, const path_frame *before) {
  stage *on = &w->stages[b];
  int code = keeps_history(w) ? stage_mask_alone(on, before->view.camera, index - 1, w->later_mask)
                              : stage_mask(on, before->view.camera, w->later_mask, NULL, NULL);
  if (code == 0)
    code = stage_cascades(on, before->view.camera, w->later_cascades);
  if (code)
    return code;
  const flicker_pair pair = {.view = &before->view,
                             .kinds = before->kinds[b],
                             .seen = w->seen,
                             .second = &w->path->cameras[index],
                             .second_light = &w->path->lights[index],
                             .shadow_distance = w->stages[b].setup->shadow_distance,
                             .cascades = {before->cascades[b], w->later_cascades},
                             .visibility = {before->visibility, w->later_visibility},
                             .masks = {before->alone[b], w->later_mask}};
  flicker_add(&w->results[b].flicker, &pair);
  if (w->path->each) {
    flicker alone = {0};
    flicker_add(&alone, &pair);
    w->path->each(w->path->user, index, &alone);
  }
  return 0;
}

/* What the history made of a frame that is drawn and measured. */
static int add_ghosts(walk *w, uint32_t index, uint32_t b, const path_frame *frame, const metrics_frame *drawn) {
  ghosts *sums[] = {&w->results[b].histories[index], &w->results[b].ghosts};
  const int code = stage_mask_alone(&w->stages[b], frame->view.camera, index, frame->alone[b]);
  for (int i = 0; code == 0 && i < 2; i++)
    ghosts_add(sums[i], drawn, frame->kinds[b], frame->alone[b]);
  return code;
}

static int draw_frame(walk *w, uint32_t index, uint32_t b, path_frame *frame, const path_frame *before) {
  const camera *from = &w->path->cameras[index];
  int code = stage_draw_from(&w->stages[b], from, &w->path->lights[index]);
  if (code == 0 && before)
    code = compare_with(w, index, b, before);
  if (code == 0)
    code = stage_mask(&w->stages[b], from, frame->masks[b], w->view_depth, frame->cascades[b]);
  if (code)
    return code;
  const metrics_frame drawn = {.view = &frame->view,
                               .light = &w->path->lights[index],
                               .shadow_distance = w->stages[b].setup->shadow_distance,
                               .visibility = frame->visibility,
                               .mask = frame->masks[b],
                               .view_depth = w->view_depth};
  code = metrics_measure(&w->results[b].frames[index], &drawn, frame->kinds[b]);
  return code || !keeps_history(w) ? code : add_ghosts(w, index, b, frame, &drawn);
}

static int walk_frame(walk *w, uint32_t index) {
  path_frame *frame = &w->frames[index % 2];
  const path_frame *before = index ? &w->frames[(index + 1) % 2] : NULL;
  char text[64];
  snprintf(text, sizeof text, "frame %u of %u", index + 1, w->path->count);
  host_progress(text);
  int code = cast_frame(w, index, frame);
  if (code == 0 && before)
    code = cast_pair(w, index, before);
  for (uint32_t b = 0; code == 0 && b < w->count; b++)
    code = draw_frame(w, index, b, frame, before);
  return code ? host_fail(code, "this was frame %u of the path", index + 1) : 0;
}

int measure_path_run(path_result *results, const measure_path *path, truth_store *store, stage *stages, uint32_t count,
                     uint32_t sun_samples) {
  walk w = {
      .path = path, .store = store, .stages = stages, .count = count, .sun_samples = sun_samples, .results = results};
  int code = 0;
  allocate_frames(&w);
  for (uint32_t b = 0; b < count; b++)
    results[b] =
        (path_result){.frames = host_allocate(path->count, sizeof *results[b].frames),
                      .histories = keeps_history(&w) ? host_allocate(path->count, sizeof *results[b].histories) : NULL};
  for (uint32_t index = 0; code == 0 && index < path->count; index++)
    code = walk_frame(&w, index);
  for (uint32_t b = 0; code == 0 && b < count; b++)
    metrics_pool(&results[b].pooled, results[b].frames, path->count);
  host_progress("");
  free_frames(&w);
  return code;
}

void path_result_free(path_result *result) {
  free(result->frames);
  free(result->histories);
  *result = (path_result){0};
}
