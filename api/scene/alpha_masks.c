#include "scene/assets.h"

#include "structs.h"
#include <string.h>

enum { largest_side = 16384, first_capacity = 16 };

static csm_result check_info(host *host, csm_alpha_mask_info *info) {
  if (!info->texels)
    return host_fail(host, CSM_ERROR_NULL_POINTER, "csm_alpha_mask_info: texels is NULL");
  if (!info->row_stride)
    info->row_stride = info->width;
  const char *wrong = info->flags                                    ? "flags"
                      : info->reserved                               ? "reserved"
                      : !info->width || info->width > largest_side   ? "width"
                      : !info->height || info->height > largest_side ? "height"
                      : info->wrap_u > CSM_WRAP_MIRROR               ? "wrap_u"
                      : info->wrap_v > CSM_WRAP_MIRROR               ? "wrap_v"
                      : info->row_stride < info->width               ? "row_stride"
                                                                     : NULL;
  return wrong ? host_fail(host, CSM_ERROR_INVALID_VALUE, "csm_alpha_mask_info: %s is not allowed", wrong)
               : CSM_SUCCESS;
}

static csm_result grow(assets *assets) {
  host *host = assets->host;
  alpha_mask_table *masks = &assets->alpha_masks;
  const uint32_t count = masks->handles.count, capacity = handles_grown(&masks->handles, first_capacity);
  const csm_result result = alpha_images_reserve(assets->device, capacity);
  if (result)
    return result;
  handle_place *places = host_allocate(host, capacity * sizeof *places);
  csm_alpha_mask_info *infos = host_grown_copy(host, masks->infos, count, capacity, sizeof *infos);
  uint32_t *users = host_grown_copy(host, masks->users, count, capacity, sizeof *users);
  const bool made = places && infos && users;
  host_release(host, made ? handles_grow(&masks->handles, places, capacity) : places);
  host_release(host, made ? masks->infos : infos);
  host_release(host, made ? masks->users : users);
  if (!made)
    return CSM_ERROR_OUT_OF_MEMORY;
  masks->infos = infos;
  masks->users = users;
  return CSM_SUCCESS;
}

/* Names a free place without taking it, so that what may still fail changes nothing. */
static csm_result find_place(assets *assets, uint32_t *index) {
  *index = handles_next(&assets->alpha_masks.handles);
  return *index < assets->alpha_masks.handles.capacity ? CSM_SUCCESS : grow(assets);
}

static csm_result keep(host *host, const csm_alpha_mask_info *info, csm_alpha_mask_info *kept) {
  unsigned char *texels = host_allocate(host, (size_t)info->width * info->height);
  if (!texels)
    return CSM_ERROR_OUT_OF_MEMORY;
  for (uint32_t y = 0; y < info->height; ++y)
    memcpy(texels + (size_t)y * info->width, info->texels + (size_t)y * info->row_stride, info->width);
  *kept = *info;
  kept->texels = texels;
  kept->row_stride = info->width;
  kept->name = NULL;
  return CSM_SUCCESS;
}

csm_result alpha_mask_create(assets *assets, const csm_alpha_mask_info *info, csm_alpha_mask *alpha_mask) {
  host *host = assets->host;
  csm_alpha_mask_info own, kept;
  uint32_t index;
  csm_result result = host_check_struct(host, struct_read(&own, sizeof own, info), "csm_alpha_mask_info");
  if (!result && !alpha_mask)
    result = host_fail(host, CSM_ERROR_NULL_POINTER, "alpha_mask is NULL");
  if (!result)
    result = check_info(host, &own);
  if (!result)
    result = find_place(assets, &index);
  if (!result)
    result = keep(host, &own, &kept);
  if (result)
    return result;
  result = alpha_images_add(assets->device, index, &kept);
  if (result) {
    host_release(host, (void *)kept.texels);
    return result;
  }
  alpha_mask_table *masks = &assets->alpha_masks;
  masks->infos[index] = kept;
  masks->users[index] = 0;
  *alpha_mask = handles_take(&masks->handles);
  return CSM_SUCCESS;
}

csm_result alpha_mask_destroy(assets *assets, csm_alpha_mask alpha_mask) {
  alpha_mask_table *masks = &assets->alpha_masks;
  const uint32_t index = handles_find(&masks->handles, alpha_mask);
  if (index == UINT32_MAX)
    return host_fail(assets->host, CSM_ERROR_INVALID_HANDLE, "alpha mask %llx does not exist",
                     (unsigned long long)alpha_mask);
  if (masks->users[index])
    return host_fail(assets->host, CSM_ERROR_INVALID_STATE, "%u meshes use alpha mask %llx still", masks->users[index],
                     (unsigned long long)alpha_mask);
  alpha_images_remove(assets->device, index);
  host_release(assets->host, (void *)masks->infos[index].texels);
  masks->infos[index].texels = NULL;
  handles_free(&masks->handles, index);
  return CSM_SUCCESS;
}

csm_result alpha_masks_move(assets *assets, device *to) {
  const alpha_mask_table *masks = &assets->alpha_masks;
  csm_result result = alpha_images_reserve(to, masks->handles.capacity);
  for (uint32_t i = 0; i < masks->handles.count && !result; ++i)
    if (handles_live(&masks->handles, i))
      result = alpha_images_add(to, i, &masks->infos[i]);
  return result;
}

void alpha_masks_end(assets *assets) {
  host *host = assets->host;
  alpha_mask_table *masks = &assets->alpha_masks;
  for (uint32_t i = 0; i < masks->handles.count; ++i)
    host_release(host, (void *)masks->infos[i].texels);
  host_release(host, masks->handles.places);
  host_release(host, masks->infos);
  host_release(host, masks->users);
}
