/* view.h: what belongs to one picture: the states of a view's techniques. */
#ifndef ABI_VIEW_H
#define ABI_VIEW_H

#include "abi/context.h"
#include "techniques/technique.h"

/* What a view's last csm_reduce_depth looked at. */
typedef struct view_look {
  uint64_t scene, revision; /* the scene's identity, and how often it had changed */
  plan_camera camera;
  plan_camera depth_camera; /* that the depth is of */
  uint32_t width, height;
  bool own; /* csm drew the depth */
} view_look;

struct csm_view {
  csm_context *context;
  csm_view *next, **link;
  technique_set techniques;
  const csm_cascades *cascades; /* that it was resolved with last; NULL: none that are there */
  uint64_t renders;             /* of theirs, then */
  view_look look;
};

/* Whether it is a context's. The pointer is compared, not followed. */
bool view_known(const csm_context *context, const csm_view *view);
/* Whether a view was looked at with this camera. */
bool view_looked_with(const view_look *look, const plan_camera *camera);

/* Whether it is a picture of these cascades': it was resolved with them in one of their last renders. */
bool view_resolves(const csm_view *view, const csm_cascades *cascades);

#endif
