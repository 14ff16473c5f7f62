/* bench/rays.h: what exact shadows cost: trees, rays, masks and frames with them, and instances that move. */
#ifndef HOST_BENCH_RAYS_H
#define HOST_BENCH_RAYS_H

#include "bench/moved.h"
#include "bench/normals.h"
#include "bench/rows.h"

/* On one backend. */
typedef struct bench_ray_costs {
  const char *backend;
  uint64_t triangles, mesh_bytes; /* of the scene's meshes, and of the buffer of their trees */
  uint32_t instances;
  uint64_t instance_bytes;                  /* of their tree */
  estimate mesh_trees_ms, instance_tree_ms; /* making them, on the CPU */
  uint32_t pixels, map_pixels;   /* of a mask: those that sent rays, and of them those that the map decided */
  uint64_t nodes, triangles_met; /* that these rays looked at */
  estimate rays_ms;              /* on the GPU */
  bench_moved moved;
} bench_ray_costs;

typedef struct bench_rays {
  uint32_t pairs; /* 0: not measured */
  bench_ray_costs costs[HOST_BACKENDS];
  uint32_t count;
  bench_rows masks, frames;
  bench_normals normals;
} bench_rays;

/* `many`: the instances of which some move. The stages have been loaded, and are so afterwards. 0, or a code after a message. */
int bench_rays_run(bench_rays *out, stage *stages, uint32_t stage_count, const bench_plan *many,
                   const host_options *options, uint32_t pairs);
void bench_rays_print(FILE *to, const bench_rays *rays);
json_t *bench_rays_to_json(const bench_rays *rays);

#endif
