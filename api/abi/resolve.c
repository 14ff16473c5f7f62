#include "abi/cascades.h"
#include "abi/frame_input.h"
#include "abi/view.h"
#include "techniques/camera_depth/camera_depth.h"

#include <string.h>

enum { largest_mask = 16384 };

/* A mask that is being resolved. */
typedef struct resolve {
  csm_mask_info info;
  frame_input input;
  plan_camera camera;
  plan_camera depth_camera; /* that the depth is of */
  plan_scene scene;
  plan_list seen;  /* empty if the engine brings its depth, or it is kept */
  bool depth_kept; /* a reduction drew the depth */
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

static csm_result read_camera(csm_context *context, resolve *r) {
  const csm_camera *camera = &r->input.camera;
  const char *text = "";
  const csm_result result = plan_camera_make(&r->camera, camera->view, camera->projection, camera->reversed, &text);
  r->depth_camera = r->camera;
  return result ? host_fail(&context->host, result, "csm_frame: %s", text) : CSM_SUCCESS;
}

/* Which instances the camera sees. `cache`: of cascades that may have been drawn of the same scene, or NULL. */
static csm_result look(csm_context *context, const plan_cache *cache, resolve *r) {
  if (r->info.camera_depth || r->depth_kept)
    return CSM_SUCCESS;
  csm_result result = frame_input_scene(context, &r->input, &context->list, &r->scene);
  plan_memory *memory = &context->view_memory;
  bool seen = false;
  while (!result && !seen) {
    result = host_grow(&context->host, &memory->at, &context->view_memory_size,
                       plan_memory_size(memory->most, r->scene.mesh_count, 0));
    seen = !result && (plan_view_make(&r->seen, &r->camera, &r->scene, cache, memory) || !plan_memory_short(memory));
  }
  if (result)
    return result;
  plan_depth_camera_make(&r->depth_camera, &r->camera, &r->seen, &r->scene);
  return CSM_SUCCESS;
}

/* Takes over what the view's reduction drew, if that is what this mask would draw. */
static void keep_depth(csm_context *context, const csm_view *view, resolve *r) {
  const view_look *look = &view->look;
  const csm_scene *scene = r->input.frame.scene;
  if (r->info.camera_depth || !scene || !camera_depth_kept(&view->techniques))
    return;
  const plan_scene now = scene_of(&context->assets, &scene->store);
  r->depth_kept = look->own && look->scene == now.identity && look->revision == now.revision &&
                  look->width == r->info.width && look->height == r->info.height && view_looked_with(look, &r->camera);
  if (r->depth_kept)
    r->depth_camera = look->depth_camera;
}

/* Maps that were drawn for a depth hold nothing for another picture. */
static csm_result check_depth(csm_context *context, const planned *planned, const resolve *r) {
  const plan_camera *camera = &planned->frame.camera;
  if (planned->frame.cells_by != CSM_CELLS_DEPTH)
    return CSM_SUCCESS;
  if (planned->seen.width != r->info.width || planned->seen.height != r->info.height)
    return host_fail(&context->host, CSM_ERROR_INVALID_VALUE,
                     "csm_mask_info: %u x %u, and the maps were drawn for a depth of %u x %u", r->info.width,
                     r->info.height, planned->seen.width, planned->seen.height);
  if (memcmp(camera->view, r->camera.view, sizeof camera->view) != 0 ||
      memcmp(camera->projection, r->camera.projection, sizeof camera->projection) != 0)
    return host_fail(&context->host, CSM_ERROR_INVALID_VALUE,
                     "csm_mask_info: the maps were drawn for the depth of another camera");
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

static technique_picture picture_of(const resolve *r) {
  return (technique_picture){.width = r->info.width,
                             .height = r->info.height,
                             .show = r->info.show,
                             .camera = &r->camera,
                             .depth_camera = &r->depth_camera,
                             .scene = &r->scene,
                             .seen = &r->seen,
                             .depth_kept = r->depth_kept,
                             .engines_depth = r->info.camera_depth,
                             .engines_normals = r->info.normals,
                             .engines_motion = r->info.motion};
}

static csm_result record(csm_view *view, csm_cascades *cascades, const resolve *r) {
  const planned *planned = cascades_planned(cascades);
  technique_picture picture = picture_of(r);
  technique_run run = {.device = context_device(view->context),
                       .config = &cascades->config,
                       .settings = cascades->settings,
                       .changes = cascades->changes,
                       .plan = &planned->frame,
                       .constants = &planned->constants,
                       .constants_size = sizeof planned->constants,
                       .frame = &r->input.frame,
                       .timestamps = (r->info.flags | r->input.frame.flags) & CSM_FRAME_TIMESTAMPS ||
                                     cascades->config.budget & CSM_BUDGET_TIME,
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
    result = read_camera(context, &r);
  if (!result)
    result = check_depth(context, cascades_planned(cascades), &r);
  if (result)
    return result;
  keep_depth(context, view, &r);
  result = look(context, &cascades->cache, &r);
  if (!result)
    result = record(view, cascades, &r);
  if (result)
    return result;
  view->cascades = cascades;
  view->renders = cascades->renders;
  technique_set_drop_unwanted(&view->techniques, context_device(context), &cascades->config);
  return CSM_SUCCESS;
}

/* ---- depth, before there are maps ---- */

static csm_result record_reduction(csm_view *view, const resolve *r) {
  technique_picture picture = picture_of(r);
  picture.reduces = true;
  technique_run run = {.device = context_device(view->context),
                       .frame = &r->input.frame,
                       .timestamps = (r->info.flags | r->input.frame.flags) & CSM_FRAME_TIMESTAMPS,
                       .view = &view->techniques,
                       .picture = &picture};
  technique_times times;
  return technique_run_record(&run, &times);
}

csm_result CSM_CALL csm_reduce_depth(csm_view *view, const csm_mask_info *in) {
  if (!view)
    return CSM_ERROR_NULL_POINTER;
  csm_context *context = view->context;
  resolve r = {0};
  csm_result result = context_usable(context);
  if (!result)
    result = read_info(context, in, &r);
  if (!result && !r.input.frame.scene)
    result = host_fail(&context->host, CSM_ERROR_INVALID_VALUE,
                       "csm_reduce_depth: no scene is given, and of a list nobody knows whether it is the next one");
  if (!result)
    result = read_camera(context, &r);
  if (!result)
    result = look(context, NULL, &r);
  if (!result)
    result = record_reduction(view, &r);
  if (result)
    return result;
  const plan_scene scene = scene_of(&context->assets, &r.input.frame.scene->store);
  view->look = (view_look){.scene = scene.identity,
                           .revision = scene.revision,
                           .camera = r.camera,
                           .depth_camera = r.depth_camera,
                           .width = r.info.width,
                           .height = r.info.height,
                           .own = !r.info.camera_depth};
  return CSM_SUCCESS;
}
