#include "abi/view.h"

#include "abi/cascades.h"

#include <string.h>

/* Renders without a resolve after which a view is none of a cascades' pictures any more. */
enum { most_unresolved = 8 };

bool view_resolves(const csm_view *view, const csm_cascades *cascades) {
  return view->cascades == cascades && cascades->renders - view->renders <= most_unresolved;
}

bool view_known(const csm_context *context, const csm_view *view) {
  const csm_view *known = context->views;
  while (known && known != view)
    known = known->next;
  return known;
}

bool view_looked_with(const view_look *look, const plan_camera *camera) {
  const plan_camera *seen = &look->camera;
  return memcmp(seen->view, camera->view, sizeof seen->view) == 0 &&
         memcmp(seen->projection, camera->projection, sizeof seen->projection) == 0 &&
         seen->reversed == camera->reversed;
}

csm_result CSM_CALL csm_view_create(csm_context *context, csm_view **out) {
  if (out)
    *out = NULL;
  if (!context)
    return CSM_ERROR_NULL_POINTER;
  host *host = &context->host;
  csm_result result = context_usable(context);
  if (!result && !out)
    result = host_fail(host, CSM_ERROR_NULL_POINTER, "view is NULL");
  if (result)
    return result;
  csm_view *view = host_allocate(host, sizeof *view);
  if (!view)
    return CSM_ERROR_OUT_OF_MEMORY;
  result = technique_set_begin_view(&view->techniques, host);
  if (result) {
    host_release(host, view);
    return result;
  }
  view->context = context;
  view->next = context->views;
  view->link = &context->views;
  if (view->next)
    view->next->link = &view->next;
  context->views = view;
  *out = view;
  return CSM_SUCCESS;
}

csm_result CSM_CALL csm_view_destroy(csm_view *view) {
  if (!view)
    return CSM_SUCCESS;
  csm_context *context = view->context;
  technique_set_drop(&view->techniques, context_device(context));
  technique_set_end(&view->techniques);
  *view->link = view->next;
  if (view->next)
    view->next->link = view->link;
  host_release(&context->host, view);
  return CSM_SUCCESS;
}
