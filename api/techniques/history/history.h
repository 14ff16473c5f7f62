/* history.h: what a view's earlier frames say of its mask: each pixel is the mean of those that saw its surface. */
#ifndef TECHNIQUES_HISTORY_H
#define TECHNIQUES_HISTORY_H

#include "techniques/technique.h"

/* Accumulates technique_picture.mask. The view's mask is what comes of it. */
extern const technique technique_history;

/* Whether a picture's mask is accumulated: the visibility is, and no other thing that a mask shows. */
bool history_takes(const csm_config *config, const technique_picture *picture);
/* The phase of the patterns (plan_history_phase) of the view's next accumulated mask. */
double history_phase(const technique_set *view);

#endif
