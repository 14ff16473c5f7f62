/* draw.c: the same picture on every backend. */
#include "base/host.h"
#include "base/linear.h"
#include "hard/engine.h"
#include "stage/compare.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

int hard_load(hard_run *run, const host_setup *setup) {
  int code = 0;
  hard_unload(run);
  if (run->stage_count == 0)
    code = stage_open_all(run->stages, &run->stage_count, run->options);
  run->setup = setup;
  for (uint32_t i = 0; code == 0 && i < run->stage_count; i++)
    code = stage_load(&run->stages[i], setup);
  return code;
}

void hard_unload(hard_run *run) {
  for (uint32_t i = 0; i < run->stage_count; i++)
    stage_unload(&run->stages[i]);
  for (int i = 0; i < 2; i++) {
    hard_engine_close(run->engines[i]);
    run->engines[i] = NULL;
  }
  truth_destroy(run->truth);
  run->truth = NULL;
  run->setup = NULL;
}

/* For every stage that there is, an engine's, too. */
static int set_all(hard_run *run, const csm_config *config, int (*set)(stage *s, const csm_config *config)) {
  int code = 0;
  for (uint32_t i = 0; code == 0 && i < run->stage_count; i++)
    code = set(&run->stages[i], config);
  for (int i = 0; code == 0 && i < 2; i++)
    code = run->engines[i] ? set(hard_engine_stage(run->engines[i]), config) : 0;
  return code;
}

int hard_configure(hard_run *run, const csm_config *config) {
  return set_all(run, config, stage_configure);
}

int hard_restart(hard_run *run, const csm_config *config) {
  return set_all(run, config, stage_restart);
}

void hard_by_depth(hard_run *run, bool by_depth) {
  for (uint32_t i = 0; i < run->stage_count; i++)
    run->stages[i].by_depth = by_depth;
}

/* ---- pictures ---- */

void hard_picture_free(hard_picture *picture) {
  free(picture->mask);
  free(picture->view_depth);
  free(picture->cascades);
  *picture = (hard_picture){0};
}

static void picture_make(hard_picture *out, const host_setup *setup, uint32_t wanted) {
  const size_t pixels = (size_t)setup->width * setup->height;
  hard_picture_free(out);
  *out =
      (hard_picture){.width = setup->width, .height = setup->height, .mask = host_allocate(pixels, sizeof *out->mask)};
  if (wanted & HARD_DEPTH)
    out->view_depth = host_allocate(pixels, sizeof *out->view_depth);
  if (wanted & HARD_CASCADES)
    out->cascades = host_allocate(pixels, sizeof *out->cascades);
}

/* Backends draw the same, but for the few pixels that other rasterisers may take another side in. */
static void compare_backends(hard_run *run, const hard_picture *first, const hard_picture *other) {
  const size_t pixels = (size_t)first->width * first->height;
  uint64_t beyond = 0;
  for (size_t i = 0; i < pixels; i++)
    beyond += !(fabsf(first->mask[i] - other->mask[i]) <= compare_mask_tolerance);
  hard_figure_add(run, (double)beyond / (double)pixels, compare_mask_share, "1", "mask pixels that backends differ in");
}

int hard_resolve(hard_run *run, const camera *from, uint32_t wanted, hard_picture *out) {
  hard_picture other = {0};
  int code = 0;
  for (uint32_t i = 0; code == 0 && i < run->stage_count; i++) {
    hard_picture *picture = i == 0 ? out : &other;
    picture_make(picture, run->setup, wanted);
    code = stage_mask(&run->stages[i], from, picture->mask, picture->view_depth, picture->cascades);
    if (code == 0 && i > 0)
      compare_backends(run, out, picture);
  }
  hard_picture_free(&other);
  return code;
}

int hard_draw(hard_run *run, const camera *from, const scene_light *light, uint32_t wanted, hard_picture *out) {
  int code = 0;
  for (uint32_t i = 0; code == 0 && i < run->stage_count; i++)
    code = stage_draw_from(&run->stages[i], from, light);
  return code ? code : hard_resolve(run, from, wanted, out);
}

bool hard_has_engine(const hard_run *run) {
  return hard_engine_there(run->options);
}

int hard_draw_engine(hard_run *run, const hard_inputs *inputs, const camera *from, const scene_light *light,
                     hard_picture *out) {
  hard_engine **engine = &run->engines[inputs->engine_buffers];
  int code = 0;
  if (!*engine)
    code = hard_engine_open(engine, run->setup, run->options, inputs->engine_buffers);
  picture_make(out, run->setup, 0);
  return code ? code : hard_engine_draw(*engine, inputs, from, light, out->mask);
}

int hard_map_engine(hard_run *run, const hard_inputs *inputs, uint32_t index, csm_cascade_info *cascade, float **out) {
  return hard_engine_map(run->engines[inputs->engine_buffers], index, cascade, out);
}

int hard_called(csm_result result, const char *what) {
  return result ? host_fail(HOST_NO_DEVICE, "%s: %s", what, csm_result_name(result)) : 0;
}

int hard_flag(hard_run *run, size_t begin, size_t end, uint32_t flags) {
  const scene *from = &run->setup->scene;
  csm_instance *instances = host_allocate(end - begin, sizeof *instances);
  csm_result result = CSM_SUCCESS;
  for (uint32_t i = 0; !result && i < run->stage_count; i++) {
    const stage *s = &run->stages[i];
    for (size_t k = begin; k < end; k++) {
      csm_instance *to = &instances[k - begin];
      *to =
          (csm_instance){.struct_size = sizeof *to, .flags = flags, .mesh = s->assets.meshes[from->instances[k].mesh]};
      memcpy(to->transform, from->instances[k].transform, sizeof to->transform);
    }
    const csm_scene_batch batch = {.struct_size = sizeof batch,
                                   .count = (uint32_t)(end - begin),
                                   .ids = s->instances + begin,
                                   .instances = instances};
    result = csm_scene_change(s->scene, &batch);
  }
  free(instances);
  return result ? host_fail(HOST_NO_DEVICE, "flags: %s", csm_result_name(result)) : 0;
}

int hard_bind(hard_run *run, csm_binding *binding) {
  *binding = (csm_binding){.struct_size = sizeof *binding};
  return csm_bind(run->stages[0].cascades, binding) == CSM_SUCCESS ? 0 : HOST_NO_DEVICE;
}

double hard_along(const csm_cascade_info *cascade, const scene_light *light, double depth) {
  const double *m = cascade->world_to_shadow;
  const double scale = m[2] * light->direction[0] + m[6] * light->direction[1] + m[10] * light->direction[2];
  return (depth - m[14]) / (scale / vec_length(light->direction));
}

int hard_map(hard_run *run, uint32_t cascade, float **out, uint32_t *side) {
  csm_binding binding;
  const int code = hard_bind(run, &binding);
  if (code)
    return code;
  *side = binding.resolutions[cascade];
  const size_t texels = (size_t)*side * *side;
  *out = host_allocate(texels, sizeof **out);
  const csm_read_info info = {.struct_size = sizeof info,
                              .source = CSM_READ_MAP,
                              .cascades = run->stages[0].cascades,
                              .cascade = cascade,
                              .data = *out,
                              .size = texels * sizeof **out};
  return csm_read(run->stages[0].context, &info) == CSM_SUCCESS ? 0 : HOST_NO_DEVICE;
}
