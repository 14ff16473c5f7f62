#include "scene/assets.h"

#include "scene/scene.h"

void assets_begin(assets *assets, host *host, uint64_t key) {
  assets->host = host;
  assets->meshes.handles = (handle_table){.key = key, .kind = 0};
  assets->alpha_masks.handles = (handle_table){.key = key, .kind = 1};
}

csm_result assets_move(assets *assets, device *to) {
  const csm_result result = alpha_masks_move(assets, to);
  return result ? result : meshes_move(assets, to);
}

void assets_moved(assets *assets, device *to) {
  assets->device = to;
  meshes_moved(assets);
}

void assets_stay(assets *assets) {
  meshes_stay(assets);
}

void assets_end(assets *assets) {
  while (assets->scenes)
    scene_destroy(assets->scenes);
  meshes_end(assets);
  alpha_masks_end(assets);
}

instances_meshes assets_meshes(const assets *assets) {
  const mesh_table *meshes = &assets->meshes;
  return (instances_meshes){
      .handles = &meshes->handles, .bounds = meshes->bounds, .parts = meshes->parts, .users = meshes->users};
}
