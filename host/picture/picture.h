/* picture/picture.h: pictures that a person understands at once. */
#ifndef HOST_PICTURE_H
#define HOST_PICTURE_H

#include "base/image.h"
#include "csm/csm.h"
#include "picture/trace.h"
#include "scene/scene.h"

/* What one camera sees, ready to be shaded. */
typedef struct picture_view {
  const scene *scene;
  const scene_light *light;
  const camera *camera; /* that the surfaces were found from */
  uint32_t width, height;
  const trace_surface *surfaces; /* top row first */
} picture_view;

/* The scene in sun and sky; `mask` (visibility, top row first) decides where the sun comes through. */
void picture_lit(image *out, const picture_view *view, const float *mask);
/* Linear, of each cascade, in every picture. */
extern const float picture_cascade_colors[CSM_MAX_CASCADES][3];
/*
 * The same with what a view of CSM_SHOW_* holds:
 * - CASCADE: each pixel in the colour of its cascade, grey where there is none.
 * - PAGES: the same, lighter and darker by turns.
 * - DENSITY: white is one texel for each pixel, blue is fewer, down to an eighth, red is more, up to eight. Dark where there
 *   are none.
 * - PENUMBRA: white is eight texels, blue is less, down to one, red is more, up to 64. Grey where there are none.
 * - RAYS: white is 128 nodes, blue is fewer, down to 16, red is more, up to 1024. Grey where no ray was sent.
 */
void picture_shown(image *out, const picture_view *view, const float *mask, uint32_t show, const float *values);
/* Visibility: white lit, black shadowed; the sky is blue. */
void picture_mask(image *out, const picture_view *view, const float *mask);
/*
 * Depth maps side by side. The nearest to the light is brightest, each map in its own range. Texels without a caster
 * are blue.
 */
void picture_maps(image *out, const float *const *maps, uint32_t count, const uint32_t *resolutions, bool reversed);

/* The scene in grey, with a red cross at every pixel that differs. The frame is red if there is one, else green. */
void picture_difference(image *out, const picture_view *view, const float *mask_a, const float *mask_b,
                        float tolerance);

#endif
