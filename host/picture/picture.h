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
 * The same with each pixel in the colour of its cascade, which `cascades` holds as CSM_SHOW_CASCADE gives it. Grey
 * where there is none.
 */
void picture_cascades(image *out, const picture_view *view, const float *mask, const float *cascades);
/*
 * Texels for each pixel, as CSM_SHOW_DENSITY gives them: white is one, blue is fewer, down to an eighth, red is more,
 * up to eight. Dark where there are none.
 */
void picture_density(image *out, const picture_view *view, const float *density);
/*
 * Radii of penumbrae, as CSM_SHOW_PENUMBRA gives them: white is eight texels, blue is less, down to one, red is more, up to
 * 64. The scene in grey where there are none.
 */
void picture_penumbra(image *out, const picture_view *view, const float *penumbra);
/* Nodes that rays looked at, as CSM_SHOW_RAYS gives them: white is 128, blue is fewer, down to 16, red is more, up to 1024;
   grey where no ray was sent. */
void picture_rays(image *out, const picture_view *view, const float *rays);
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
