/* view.h: what belongs to one picture: the states of a view's techniques. */
#ifndef ABI_VIEW_H
#define ABI_VIEW_H

#include "abi/context.h"
#include "techniques/technique.h"

struct csm_view {
  csm_context *context;
  csm_view *next, **link;
  technique_set techniques;
  const csm_cascades *cascades; /* that it was resolved with last; NULL: none that are there */
  uint64_t renders;             /* of theirs, then */
};

/* Whether it is a context's. The pointer is compared, not followed. */
bool view_known(const csm_context *context, const csm_view *view);

#endif
