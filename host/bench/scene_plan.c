#include "bench/scene_plan.h"
#include "base/host.h"
#include "csm_constants.h"
#include "scene/mesh_builder.h"
#include <stdlib.h>
#include <string.h>

static void fill_bounds(plan_bounds *out, const scene_mesh *mesh) {
  double minimum[3], maximum[3];
  float low[3], high[3];
  scene_mesh_bounds(mesh, minimum, maximum);
  for (int i = 0; i < 3; i++) {
    low[i] = (float)minimum[i];
    high[i] = (float)maximum[i];
  }
  plan_bounds_make(out, low, high);
}

static void fill_instance(plan_instance *out, const scene_instance *from) {
  out->mesh = from->mesh;
  for (int row = 0; row < 3; row++)
    for (int column = 0; column < 4; column++)
      out->transform[row * 4 + column] = from->transform[column * 4 + row];
}

/* A copy is moved to where another instance is, so that it lies in the scene's bounds. */
static void strew(plan_instance *instances, uint32_t own, uint32_t count) {
  for (uint32_t i = own; i < count; i++) {
    const uint32_t from = (uint32_t)(noise_hash(i, 1, 7) * own), to = (uint32_t)(noise_hash(i, 2, 7) * own);
    instances[i] = instances[from];
    for (int row = 0; row < 3; row++)
      instances[i].transform[row * 4 + 3] =
          instances[to].transform[row * 4 + 3] + (row == 1 ? 0.0 : 20.0 * noise_hash(i, 3 + (uint32_t)row, 7));
  }
}

static int plan_once(bench_plan *plan, const host_setup *setup) {
  const char *error = NULL;
  const plan_frame_info info = {.config = &setup->config,
                                .view = setup->camera.view,
                                .projection = setup->camera.projection,
                                .reversed = setup->camera.reversed ? CSM_REVERSED_YES : CSM_REVERSED_NO,
                                .light = setup->light.direction,
                                .scene = &plan->scene,
                                .all_receivers = true};
  const csm_result result = plan_frame_make(&plan->frame, &info, &plan->memory, &error);
  if (result != CSM_SUCCESS)
    return host_fail(HOST_BAD_INPUT, "cannot plan the frame: %s", error ? error : csm_result_name(result));
  return 0;
}

int bench_plan_make(bench_plan *out, const host_setup *setup, uint32_t instance_count) {
  const scene *s = &setup->scene;
  const uint32_t own = (uint32_t)s->instance_count < instance_count ? (uint32_t)s->instance_count : instance_count;
  *out = (bench_plan){.instances = host_allocate(instance_count, sizeof *out->instances),
                      .boxes = host_allocate(instance_count, sizeof *out->boxes),
                      .bounds = host_allocate(s->mesh_count, sizeof *out->bounds),
                      .matrices = host_allocate((size_t)instance_count * 12, sizeof *out->matrices)};
  for (size_t m = 0; m < s->mesh_count; m++)
    fill_bounds(&out->bounds[m], &s->meshes[m]);
  for (uint32_t i = 0; i < own; i++)
    fill_instance(&out->instances[i], &s->instances[i]);
  strew(out->instances, own, instance_count);
  for (uint32_t i = 0; i < instance_count; i++) {
    if (plan_instance_check(&out->instances[i]))
      return host_fail(HOST_BAD_INPUT, "instance %u cannot be placed", i);
    plan_instance_box(&out->boxes[i], &out->instances[i], &out->bounds[out->instances[i].mesh]);
  }
  out->scene = (plan_scene){.instances = out->instances,
                            .boxes = out->boxes,
                            .slot_count = instance_count,
                            .caster_count = instance_count,
                            .receiver_count = instance_count,
                            .meshes = out->bounds,
                            .mesh_count = (uint32_t)s->mesh_count};
  const size_t size = plan_memory_size(instance_count, out->scene.mesh_count, plan_windows_most(&setup->config));
  out->memory = (plan_memory){.at = host_allocate(size, 1), .most = instance_count};
  const char *error = NULL;
  if (plan_config_check(&setup->config, &error) != CSM_SUCCESS)
    return host_fail(HOST_BAD_INPUT, "--config: %s", error);
  return plan_once(out, setup);
}

void bench_plan_free(bench_plan *plan) {
  free(plan->instances);
  free(plan->boxes);
  free(plan->bounds);
  free(plan->memory.at);
  free(plan->matrices);
  memset(plan, 0, sizeof *plan);
}

estimate bench_plan_time(bench_plan *plan, const host_setup *setup, uint32_t count) {
  double *samples = host_allocate(count, sizeof *samples);
  float constants[CSM_C_COUNT * 4];
  for (uint32_t i = 0; i < count; i++) {
    const double start = host_now_ms();
    plan_once(plan, setup);
    for (uint32_t k = 0; k < plan->frame.window_count; k++)
      plan_write_window_matrices(plan->matrices, &plan->frame, k, &plan->scene);
    plan_write_constants(constants, &plan->frame, &setup->config);
    samples[i] = host_now_ms() - start;
  }
  const estimate result = estimate_median(samples, count);
  free(samples);
  return result;
}
