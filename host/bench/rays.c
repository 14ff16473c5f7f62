#include "bench/rays.h"
#include "base/host.h"
#include <stdlib.h>

enum { warm_up = 1 };

/* What is measured in each round. */
typedef struct samples {
  double *mesh_trees_ms, *instance_tree_ms, *rays_ms;
} samples;

static uint64_t mesh_triangles(const scene *s) {
  uint64_t count = 0;
  for (size_t m = 0; m < s->mesh_count; m++)
    count += s->meshes[m].index_count / 3;
  return count;
}

/* Uploads the scene anew. */
static int make_trees(bench_ray_costs *out, stage *s, double *ms) {
  const host_setup *setup = s->setup;
  csm_stats stats = {.struct_size = sizeof stats};
  stage_unload(s);
  const int code = stage_load(s, setup);
  if (code)
    return code;
  if (csm_get_stats(s->cascades, &stats))
    return host_fail(HOST_NO_DEVICE, "%s: %s", s->backend, csm_last_error(s->context));
  *ms = stats.mesh_trees_ms;
  out->mesh_bytes = stats.tree_bytes;
  return 0;
}

/* New cascades make a new tree of the instances. */
static int send_rays(bench_ray_costs *out, stage *s, const csm_config *config, double *tree_ms, double *rays_ms) {
  stage_stats stats;
  int code = stage_restart(s, config);
  if (code == 0)
    code = stage_draw(s, &stats);
  if (code)
    return code;
  *tree_ms = stats.maps.instance_tree_ms;
  *rays_ms = stats.mask.rays_gpu_ms;
  out->instance_bytes = stats.maps.tree_bytes - out->mesh_bytes;
  out->pixels = stats.mask.ray_pixels;
  out->map_pixels = stats.mask.ray_map_pixels;
  return 0;
}

static int count_nodes(bench_ray_costs *out, stage *s) {
  csm_view_stats stats = {.struct_size = sizeof stats};
  const csm_mask_info info = {.struct_size = sizeof info,
                              .frame = &s->frame,
                              .width = s->setup->width,
                              .height = s->setup->height,
                              .show = CSM_SHOW_RAYS};
  s->frame.flags = 0;
  if (csm_resolve_mask(s->view, s->cascades, &info) || csm_get_view_stats(s->view, &stats))
    return host_fail(HOST_NO_DEVICE, "%s: %s", s->backend, csm_last_error(s->context));
  out->nodes = stats.ray_nodes;
  out->triangles_met = stats.ray_triangles;
  return 0;
}

static int measure_rounds(bench_ray_costs *out, stage *s, const samples *to, uint32_t pairs) {
  csm_config exact = s->setup->config;
  bench_exact(&exact);
  int code = 0;
  for (uint32_t round = 0; round < warm_up + pairs && code == 0; round++) {
    const uint32_t i = round < warm_up ? 0 : round - warm_up;
    host_progress("trees and rays");
    code = make_trees(out, s, &to->mesh_trees_ms[i]);
    if (code == 0)
      code = send_rays(out, s, &exact, &to->instance_tree_ms[i], &to->rays_ms[i]);
  }
  host_progress("");
  if (code == 0)
    code = count_nodes(out, s);
  return code ? code : stage_restart(s, &s->setup->config);
}

static int measure(bench_ray_costs *out, stage *s, uint32_t pairs) {
  const samples taken = {.mesh_trees_ms = host_allocate(pairs, sizeof(double)),
                         .instance_tree_ms = host_allocate(pairs, sizeof(double)),
                         .rays_ms = host_allocate(pairs, sizeof(double))};
  *out = (bench_ray_costs){.backend = s->backend,
                           .triangles = mesh_triangles(&s->setup->scene),
                           .instances = (uint32_t)s->setup->scene.instance_count};
  const int code = measure_rounds(out, s, &taken, pairs);
  if (code == 0) {
    out->mesh_trees_ms = estimate_median(taken.mesh_trees_ms, pairs);
    out->instance_tree_ms = estimate_median(taken.instance_tree_ms, pairs);
    out->rays_ms = estimate_median(taken.rays_ms, pairs);
  }
  free(taken.mesh_trees_ms);
  free(taken.instance_tree_ms);
  free(taken.rays_ms);
  return code;
}

static int time_tables(bench_rays *out, stage *stages, uint32_t stage_count) {
  const host_setup *setup = stages[0].setup;
  bench_table table;
  bench_table_ray_masks(&table, &setup->config, setup->scene.name);
  const int code = bench_rows_run(&out->masks, &table, stages, stage_count, (bench_floor){0}, out->pairs);
  bench_table_ray_frames(&table, &setup->config, setup->scene.name);
  return code ? code : bench_rows_run(&out->frames, &table, stages, stage_count, (bench_floor){0}, out->pairs);
}

int bench_rays_run(bench_rays *out, stage *stages, uint32_t stage_count, const bench_plan *many,
                   const host_options *options, uint32_t pairs) {
  int code = 0;
  out->pairs = pairs;
  for (uint32_t i = 0; i < stage_count && code == 0; i++) {
    bench_ray_costs *costs = &out->costs[out->count++];
    code = measure(costs, &stages[i], pairs);
    if (code == 0) /* a frame of many instances is long on a CPU */
      code = bench_moved_run(&costs->moved, &stages[i], many, options->device, 1 + pairs / 4);
  }
  if (code == 0)
    code = time_tables(out, stages, stage_count);
  return code ? code : bench_normals_run(&out->normals, stages[0].setup, options, pairs);
}
