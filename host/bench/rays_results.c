#include "bench/rays.h"

static double share(double part, double whole) {
  return whole > 0.0 ? part / whole : 0.0;
}

/* The same of each of so many things. */
static estimate scaled(const estimate *value, double factor, double count) {
  return (estimate){.median = share(value->median * factor, count),
                    .low = share(value->low * factor, count),
                    .high = share(value->high * factor, count)};
}

static void print_times(FILE *to, const char *name, const estimate *ms, const estimate *ns_each, const char *each) {
  fprintf(to, "  %-32s %9.3f   %8.3f .. %-8.3f  %.0f ns %s\n", name, ms->median, ms->low, ms->high, ns_each->median,
          each);
}

static void print_costs(FILE *to, const bench_ray_costs *c) {
  const estimate ns_a_triangle = scaled(&c->mesh_trees_ms, 1e6, (double)c->triangles);
  const estimate ns_an_instance = scaled(&c->instance_tree_ms, 1e6, c->instances);
  const estimate ns_a_ray = scaled(&c->rays_ms, 1e6, c->pixels);
  fprintf(to, "\n  %s\n", c->backend);
  print_times(to, "meshes' trees made, ms", &c->mesh_trees_ms, &ns_a_triangle, "a triangle");
  print_times(to, "instances' tree made, ms", &c->instance_tree_ms, &ns_an_instance, "an instance");
  print_times(to, "rays, GPU ms", &c->rays_ms, &ns_a_ray, "a ray");
  fprintf(to, "  device memory: %.1f bytes a triangle of %llu, %.1f an instance of %u, with room for more\n",
          share((double)c->mesh_bytes, (double)c->triangles), (unsigned long long)c->triangles,
          share((double)c->instance_bytes, c->instances), c->instances);
  fprintf(to, "  %u rays a mask, %u of them decided by the map; %.1f nodes and %.1f triangles a ray\n", c->pixels,
          c->map_pixels, share((double)c->nodes, c->pixels), share((double)c->triangles_met, c->pixels));
  bench_moved_print(to, &c->moved);
}

void bench_rays_print(FILE *to, const bench_rays *rays) {
  fprintf(to, "\nrays: filter exact, %u rounds\n", rays->pairs);
  for (uint32_t i = 0; i < rays->count; i++)
    print_costs(to, &rays->costs[i]);
  bench_rows_print(to, &rays->masks);
  bench_rows_print(to, &rays->frames);
  bench_normals_print(to, &rays->normals);
}

static void set_estimate(json_t *object, const char *name, estimate value) {
  json_object_set_new(object, name, estimate_to_json(&value));
}

static json_t *costs_to_json(const bench_ray_costs *c) {
  json_t *object = json_object();
  json_object_set_new(object, "backend", json_string(c->backend));
  json_object_set_new(object, "triangles", json_integer((json_int_t)c->triangles));
  json_object_set_new(object, "mesh_tree_bytes", json_integer((json_int_t)c->mesh_bytes));
  json_object_set_new(object, "bytes_a_triangle", json_real(share((double)c->mesh_bytes, (double)c->triangles)));
  set_estimate(object, "mesh_trees_ms", c->mesh_trees_ms);
  set_estimate(object, "ns_a_triangle", scaled(&c->mesh_trees_ms, 1e6, (double)c->triangles));
  json_object_set_new(object, "instances", json_integer(c->instances));
  json_object_set_new(object, "instance_tree_bytes", json_integer((json_int_t)c->instance_bytes));
  set_estimate(object, "instance_tree_ms", c->instance_tree_ms);
  json_object_set_new(object, "ray_pixels", json_integer(c->pixels));
  json_object_set_new(object, "ray_map_pixels", json_integer(c->map_pixels));
  json_object_set_new(object, "nodes_a_ray", json_real(share((double)c->nodes, c->pixels)));
  json_object_set_new(object, "triangles_a_ray", json_real(share((double)c->triangles_met, c->pixels)));
  set_estimate(object, "rays_gpu_ms", c->rays_ms);
  set_estimate(object, "ns_a_ray", scaled(&c->rays_ms, 1e6, c->pixels));
  json_object_set_new(object, "moved", bench_moved_to_json(&c->moved));
  return object;
}

json_t *bench_rays_to_json(const bench_rays *rays) {
  json_t *object = json_object(), *costs = json_array();
  for (uint32_t i = 0; i < rays->count; i++)
    json_array_append_new(costs, costs_to_json(&rays->costs[i]));
  json_object_set_new(object, "costs", costs);
  json_object_set_new(object, "masks", bench_rows_to_json(&rays->masks));
  json_object_set_new(object, "frames", bench_rows_to_json(&rays->frames));
  if (rays->normals.pairs)
    json_object_set_new(object, "normals", bench_normals_to_json(&rays->normals));
  return object;
}
