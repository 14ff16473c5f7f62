/* picture/outside.h: a camera and its cascades, seen by another one that stands outside. */
#ifndef HOST_PICTURE_OUTSIDE_H
#define HOST_PICTURE_OUTSIDE_H

#include "csm/csm.h"
#include "picture/picture.h"

/* Eight corners each: bit 0 of the index is right, bit 1 up (a map's v down), bit 2 far. World positions. */
typedef struct outside_cascade {
  double slice[8][3];         /* of what the camera sees */
  double box[8][3];           /* what the map holds */
  double world_to_shadow[16]; /* to the map's texture coordinates and depth */
  double far_depth;           /* where the slice ends */
} outside_cascade;

typedef struct outside_view {
  picture_view view; /* from behind, above and aside, with all slices in it */
  camera camera;
  double to_clip[16];  /* world to that camera's clip space */
  const camera *inner; /* that the cascades were fitted to */
  uint32_t cascade_count;
  outside_cascade cascades[CSM_MAX_CASCADES];
  trace_surface *surfaces;
  float *nearest; /* -1 / view depth of the surfaces, which is straight along a line on screen; 0: there is none */
} outside_view;

/*
 * Looks at what `inner` sees, with its scene, light, camera and size, which must live as long. 0, or HOST_BAD_INPUT
 * after a message; outside_view_free is always allowed.
 */
int outside_view_make(outside_view *out, const picture_view *inner, const csm_binding *binding);
void outside_view_free(outside_view *out);

/*
 * The scene in grey, and each cascade in its colour: its slice of the camera's view as bold lines, the surfaces in that
 * tinted, and its map's box as thin lines. Lines behind a surface are dim.
 */
void picture_frusta(image *out, const outside_view *outside);
/*
 * Each instance in the colour of the first cascade that draws it, as csm_get_casters tells; grey if all cull it. It is
 * pale where it reaches out of that cascade's map, and has dark stripes if a later cascade culls it. With the maps'
 * boxes.
 */
void picture_culled(image *out, const outside_view *outside, const uint8_t *drawn);

#endif
