/* sides.h: two backends in one process, and what they must agree in. */
#ifndef SIDES_H
#define SIDES_H

#include "support.h"

typedef struct side {
  record record;
  csm_context *context;
  csm_mesh meshes[2]; /* a square, a box */
  csm_cascades *cascades;
  csm_view *view;
} side;

void side_open(side *side, const char *backend);
void side_close(side *side);

/* The plans, and what shaders get of them, are equal in every byte; something was drawn. */
void sides_same_plan(const side *a, const side *b);

typedef struct sides_difference {
  uint32_t texels;    /* that differ by more than the tolerance */
  float largest;      /* difference of any */
  double lit, shaded; /* shares of a mask at 1, and at 0 */
} sides_difference;

/* What is compared. */
typedef struct sides_image {
  uint32_t source, cascade; /* CSM_READ_* */
  uint32_t width, height;
} sides_image;

sides_difference sides_compare(const side *a, const side *b, const sides_image *image, float tolerance);
/* Maps and camera depth bit for bit, masks within 1/255 on all but 0.01 % of pixels; returns the masks' difference. */
sides_difference sides_same_images(const side *a, const side *b, const csm_config *config, uint32_t width,
                                   uint32_t height);

#endif
