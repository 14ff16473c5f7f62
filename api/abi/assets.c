#include "abi/context.h"

csm_result CSM_CALL csm_alpha_mask_create(csm_context *context, const csm_alpha_mask_info *info,
                                          csm_alpha_mask *alpha_mask) {
  if (alpha_mask)
    *alpha_mask = 0;
  if (!context)
    return CSM_ERROR_NULL_POINTER;
  const csm_result result = context_usable(context);
  return result ? result : alpha_mask_create(&context->assets, info, alpha_mask);
}

csm_result CSM_CALL csm_alpha_mask_destroy(csm_context *context, csm_alpha_mask alpha_mask) {
  return context ? alpha_mask_destroy(&context->assets, alpha_mask) : CSM_ERROR_NULL_POINTER;
}

csm_result CSM_CALL csm_mesh_create(csm_context *context, const csm_mesh_info *info, csm_mesh *mesh) {
  if (mesh)
    *mesh = 0;
  if (!context)
    return CSM_ERROR_NULL_POINTER;
  const csm_result result = context_usable(context);
  return result ? result : mesh_create(&context->assets, info, mesh);
}

csm_result CSM_CALL csm_mesh_update(csm_context *context, csm_mesh mesh, const csm_mesh_update_info *info) {
  if (!context)
    return CSM_ERROR_NULL_POINTER;
  const csm_result result = context_usable(context);
  return result ? result : mesh_update(&context->assets, mesh, info);
}

csm_result CSM_CALL csm_mesh_destroy(csm_context *context, csm_mesh mesh) {
  return context ? mesh_destroy(&context->assets, mesh) : CSM_ERROR_NULL_POINTER;
}
