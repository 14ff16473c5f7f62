#include "abi/cascades.h"
#include "abi/frame_input.h"
#include "abi/view.h"

enum { largest_mask = 16384 };

/* A mask that is being resolved. */
typedef struct resolve {
  csm_mask_info info;
  frame_input input;
  plan_camera camera;
  plan_camera depth_camera; /* that the depth is of */
  plan_scene scene;
  plan_list seen; /* empty if the engine brings its depth */
} resolve;

static csm_result check_info(csm_context *context, const csm_mask_info *info) {
  host *host = &context->host;
  if (info->flags & ~(uint32_t)CSM_FRAME_TIMESTAMPS)
    return host_fail(host, CSM_ERROR_INVALID_VALUE, "csm_mask_info: unknown flags %x", info->flags);
  if (info->show > CSM_SHOW_PAGES)
    return host_fail(host, CSM_ERROR_INVALID_VALUE, "csm_mask_info: there is no show %u", info->show);
  if (info->reserved)
    return host_fail(host, CSM_ERROR_INVALID_VALUE, "csm_mask_info: reserved is %u, not 0", info->reserved);
  if (context_device(context)->own && (info->camera_depth || info->normals || info->motion))
    return host_fail(host, CSM_ERROR_UNSUPPORTED, "csm_mask_info: %s needs an engine's device",
                     info->camera_depth ? "camera_depth"
                     : info->normals    ? "normals"
                                        : "motion");
  if (!info->width || !info->height || info->width > largest_mask || info->height > largest_mask)
    return host_fail(host, CSM_ERROR_INVALID_VALUE, "csm_mask_info: a size of %u x %u", info->width, info->height);
  return CSM_SUCCESS;
}

static csm_result read_info(csm_context *context, const csm_mask_info *in, resolve *out) {
  csm_mask_info *info = &out->info;
  csm_result result = host_check_struct(&context->host, struct_read(info, sizeof *info, in), "csm_mask_info");
  if (!result)
    result = check_info(context, info);
  return result ? result : frame_input_read(context, info->frame, false, &out->input);
}

/* The camera, and which instances it sees, in the context's scratch memory. */
static csm_result look(csm_context *context, resolve *r) {
  const csm_camera *camera = &r->input.camera;
  const char *text = "";
  csm_result result = plan_camera_make(&r->camera, camera->view, camera->projection, camera->reversed, &text);
  if (result)
    return host_fail(&context->host, result, "csm_frame: %s", text);
  r->depth_camera = r->camera;
  if (r->info.camera_depth)
    return CSM_SUCCESS;
  result = frame_input_scene(context, &r->input, &context->list, &r->scene);
  if (!result)
    result = host_grow(&context->host, &context->scratch, &context->scratch_size,
                       plan_memory_size(r->scene.slot_count, r->scene.mesh_count, 0));
  if (result)
    return result;
  plan_view_make(&r->seen, &r->camera, &r->scene, context->scratch);
  plan_depth_camera_make(&r->depth_camera, &r->camera, &r->seen, &r->scene);
  return CSM_SUCCESS;
}

/* What is shown must be there. */
static csm_result check_shown(csm_context *context, const csm_config *config, uint32_t show) {
  host *host = &context->host;
  if (show == CSM_SHOW_HISTORY && config->history == CSM_HISTORY_OFF)
    return host_fail(host, CSM_ERROR_INVALID_VALUE, "csm_mask_info: show history, and the cascades keep none");
  if (show == CSM_SHOW_PENUMBRA && !plan_is_soft(config))
    return host_fail(host, CSM_ERROR_INVALID_VALUE,
                     "csm_mask_info: show penumbra, and the filter finds none: those that look at the light's size do");
  if (show == CSM_SHOW_RAYS && !plan_has_rays(config))
    return host_fail(host, CSM_ERROR_INVALID_VALUE,
                     "csm_mask_info: show rays, and the filter sends none: exact and exact_soft do");
  if (show == CSM_SHOW_PAGES && !plan_has_pages(config))
    return host_fail(host, CSM_ERROR_INVALID_VALUE, "csm_mask_info: show pages, and map_layout has none");
  return CSM_SUCCESS;
}

static csm_result record(csm_view *view, csm_cascades *cascades, const resolve *r) {
  const planned *planned = cascades_planned(cascades);
  technique_picture picture = {.width = r->info.width,
                               .height = r->info.height,
                               .show = r->info.show,
                               .camera = &r->camera,
                               .depth_camera = &r->depth_camera,
                               .scene = &r->scene,
                               .seen = &r->seen,
                               .engines_depth = r->info.camera_depth,
                               .engines_normals = r->info.normals,
                               .engines_motion = r->info.motion};
  technique_run run = {.device = context_device(view->context),
                       .config = &cascades->config,
                       .settings = cascades->settings,
                       .changes = cascades->changes,
                       .plan = &planned->frame,
                       .constants = &planned->constants,
                       .constants_size = sizeof planned->constants,
                       .frame = &r->input.frame,
                       .timestamps = (r->info.flags | r->input.frame.flags) & CSM_FRAME_TIMESTAMPS,
                       .cascades = &cascades->techniques,
                       .view = &view->techniques,
                       .picture = &picture};
  technique_times times;
  return technique_run_record(&run, &times);
}

csm_result CSM_CALL csm_resolve_mask(csm_view *view, csm_cascades *cascades, const csm_mask_info *in) {
  if (!view || !cascades)
    return CSM_ERROR_NULL_POINTER;
  csm_context *context = cascades->context;
  csm_result result = context_usable(context);
  if (!result && !view_known(context, view))
    result = host_fail(&context->host, CSM_ERROR_INVALID_HANDLE, "the view is none of the cascades' context");
  resolve r = {0};
  if (!result)
    result = read_info(context, in, &r);
  if (!result)
    result = check_shown(context, &cascades->config, r.info.show);
  if (!result)
    result = cascades_drawn(cascades);
  if (!result)
    result = look(context, &r);
  if (!result)
    result = record(view, cascades, &r);
  if (result)
    return result;
  view->cascades = cascades;
  view->renders = cascades->renders;
  technique_set_drop_unwanted(&view->techniques, context_device(context), &cascades->config);
  return CSM_SUCCESS;
}
