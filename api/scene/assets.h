/* assets.h: what casts, whatever the device is: meshes and alpha masks by handle, with what is kept of them. */
#ifndef SCENE_ASSETS_H
#define SCENE_ASSETS_H

#include "device/geometry.h"
#include "plan/plan.h"
#include "scene/handles.h"
#include "scene/instances.h"
#include "scene/mesh_tree.h"

/* What a mesh has on the device to move to. */
typedef struct moved_mesh {
  plan_bounds bounds;
  plan_parts parts;
  mesh_tree *tree; /* of a mesh that was supplied again; NULL: it keeps its own */
} moved_mesh;

/* Arrays are by index of the handle. */
typedef struct mesh_table {
  handle_table handles;
  csm_mesh_info *infos; /* shapes; positions, uvs and indices point into the copy, or are NULL */
  void **copies;
  mesh_tree **trees;   /* of those that rays may meet; else NULL */
  plan_bounds *bounds; /* as the plan wants them */
  plan_parts *parts;   /* until its vertices move: then a mesh is whole, and stays so */
  uint32_t *users;     /* instances of scenes */
  uint64_t revision;   /* counts the meshes that changed or went */
  uint64_t *revisions; /* after the last time that this one did */
  moved_mesh *moved;   /* NULL between moves */
} mesh_table;

typedef struct alpha_mask_table {
  handle_table handles;
  csm_alpha_mask_info *infos; /* texels are the table's copy */
  uint32_t *users;            /* meshes */
} alpha_mask_table;

typedef struct assets {
  host *host;
  device *device; /* that they lie on now */
  mesh_table meshes;
  alpha_mask_table alpha_masks;
  struct csm_scene *scenes; /* all of them */
  bool keep_geometry;
  bool trees;                 /* meshes get trees */
  csm_supply_function supply; /* may be NULL */
} assets;

/* Handles of these assets mean nothing to others'. `key` is a handles_key. */
void assets_begin(assets *assets, host *host, uint64_t key);
/* Places everything on another device, from copies or what `supply` gives; assets->device stays. */
csm_result assets_move(assets *assets, device *to);
/* After that: takes the device over, or stays on the old one. */
void assets_moved(assets *assets, device *to);
void assets_stay(assets *assets);
/* Frees what lies in host memory, scenes included. */
void assets_end(assets *assets);

/* What instances look into. */
instances_meshes assets_meshes(const assets *assets);

/* ---- meshes.c; the device is not lost ---- */
csm_result mesh_create(assets *assets, const csm_mesh_info *info, csm_mesh *mesh);
csm_result mesh_update(assets *assets, csm_mesh mesh, const csm_mesh_update_info *info);
csm_result mesh_destroy(assets *assets, csm_mesh mesh);
/* What making the trees of all meshes took. */
double meshes_trees_ms(const assets *assets);
csm_result meshes_move(assets *assets, device *to);
void meshes_moved(assets *assets);
void meshes_stay(assets *assets);
void meshes_end(assets *assets);

/* ---- alpha_masks.c; likewise ---- */
csm_result alpha_mask_create(assets *assets, const csm_alpha_mask_info *info, csm_alpha_mask *alpha_mask);
csm_result alpha_mask_destroy(assets *assets, csm_alpha_mask alpha_mask);
csm_result alpha_masks_move(assets *assets, device *to);
void alpha_masks_end(assets *assets);

#endif
