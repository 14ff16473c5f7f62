/* truth/store.h: truths that were cast before, kept in files by what they depend on. */
#ifndef HOST_TRUTH_STORE_H
#define HOST_TRUTH_STORE_H

#include "truth/truth.h"

typedef struct truth_store {
  truth *caster;
  char folder[4096]; /* "": nothing is kept */
  uint64_t scene_hash, triangles;
  double cast_ms;        /* spent on casting rays, since the store was opened */
  uint32_t cast, loaded; /* answers that were cast, and that were found */
} truth_store;

/*
 * Truths are kept in `folder`; NULL: in $XDG_CACHE_HOME/csm or ~/.cache/csm, where one of them can be made. `s` must
 * outlive the store. 0, or HOST_BAD_INPUT after a message; truth_store_close is allowed in both cases.
 */
int truth_store_open(truth_store *out, const scene *s, bool alpha_test, const char *folder);
void truth_store_close(truth_store *store);

/* As truth_find and truth_view_fill, for a view whose camera and size are set. */
int truth_store_view(truth_store *store, const truth_view *view);
/* As truth_visibility. */
int truth_store_visibility(truth_store *store, const truth_view *view, const truth_asked *asked, float *visibility,
                           truth_convergence *convergence);
/* As truth_seen. */
int truth_store_seen(truth_store *store, const truth_view *view, const camera *other, uint8_t *seen);

#endif
