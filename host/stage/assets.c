#include "stage/assets.h"
#include "base/host.h"
#include "scene/mesh_watertight.h"
#include <stdlib.h>

csm_mesh_info assets_mesh_info(const assets *a, size_t index) {
  const scene_mesh *mesh = &a->scene->meshes[index];
  csm_mesh_info info = {.struct_size = sizeof info,
                        .flags = a->watertight[index] ? CSM_MESH_WATERTIGHT : 0,
                        .positions = mesh->positions,
                        .vertex_count = mesh->vertex_count,
                        .indices = mesh->indices,
                        .index_count = mesh->index_count,
                        .index_size = mesh->index_size,
                        .name = mesh->name};
  const scene_alpha_mask *cut = scene_cut_out(a->scene, mesh);
  if (cut) {
    info.flags = CSM_MESH_TWO_SIDED; /* leaves are */
    info.alpha_mask = a->alpha_masks[mesh->material];
    info.uvs = mesh->uvs;
    info.alpha_cutoff = (float)cut->cutoff;
  }
  return info;
}

static csm_result upload_alpha_mask(csm_context *context, const scene_alpha_mask *cut, csm_alpha_mask *out) {
  static const uint32_t wraps[] = {[SCENE_WRAP_REPEAT] = CSM_WRAP_REPEAT,
                                   [SCENE_WRAP_MIRROR] = CSM_WRAP_MIRROR,
                                   [SCENE_WRAP_CLAMP] = CSM_WRAP_CLAMP};
  const csm_alpha_mask_info info = {.struct_size = sizeof info,
                                    .width = cut->width,
                                    .height = cut->height,
                                    .wrap_u = wraps[cut->wrap[0]],
                                    .wrap_v = wraps[cut->wrap[1]],
                                    .texels = cut->alpha};
  return csm_alpha_mask_create(context, &info, out);
}

csm_result assets_upload(assets *out, csm_context *context, const scene *from) {
  *out = (assets){.scene = from,
                  .meshes = host_allocate(from->mesh_count, sizeof *out->meshes),
                  .alpha_masks = host_allocate(from->material_count, sizeof *out->alpha_masks),
                  .watertight = host_allocate(from->mesh_count, sizeof *out->watertight)};
  csm_result result = CSM_SUCCESS;
  for (size_t m = 0; m < from->mesh_count && result == CSM_SUCCESS; m++) {
    const scene_mesh *mesh = &from->meshes[m];
    const scene_alpha_mask *cut = scene_cut_out(from, mesh);
    csm_alpha_mask *alpha_mask = &out->alpha_masks[mesh->material];
    if (cut && !*alpha_mask)
      result = upload_alpha_mask(context, cut, alpha_mask);
    out->watertight[m] = mesh_is_closed(mesh);
    const csm_mesh_info info = assets_mesh_info(out, m);
    if (result == CSM_SUCCESS)
      result = csm_mesh_create(context, &info, &out->meshes[m]);
  }
  return result;
}

void assets_free(assets *a) {
  free(a->meshes);
  free(a->alpha_masks);
  free(a->watertight);
  *a = (assets){0};
}

void assets_destroy(assets *a, csm_context *context) {
  for (size_t m = 0; a->scene && m < a->scene->mesh_count; m++)
    if (a->meshes[m])
      csm_mesh_destroy(context, a->meshes[m]);
  for (size_t m = 0; a->scene && m < a->scene->material_count; m++)
    if (a->alpha_masks[m])
      csm_alpha_mask_destroy(context, a->alpha_masks[m]);
  assets_free(a);
}
