/* pictures.h: pictures of scenes whose depths are known, and what a plan that is fitted to them must hold. */
#ifndef TEST_PLAN_PICTURES_H
#define TEST_PLAN_PICTURES_H

#include "support.h"

enum { width = 64, height = 36, tile_px = 8, columns = 8, rows = 5 };

/* What a camera's buffer holds: the view depth at a pixel; negative infinity: no surface. */
typedef double depth_field(const test_camera *camera, double x, double y);

typedef struct picture {
  test_camera camera;
  double depths[height][width]; /* of view, where the buffer's depth leads back to */
  float tiles[rows * columns][2];
  plan_depth_samples samples;
} picture;

/* The light that frames are planned with. */
extern const double picture_light[3];

/* Clip x and y of a pixel's centre. */
void pixel_clip(int column, int row, double out[2]);
void take(picture *out, const test_camera *camera, depth_field *field);

depth_field ground_and_wall, ground, nothing;

csm_config sampled_config(uint32_t distribution);
/* A frame that is fitted to a picture, which may be NULL, as the history before may. */
plan_frame plan_with(const csm_config *config, const test_camera *camera, const picture *seen,
                     const plan_history *before);
double end_of(const plan_frame *frame);
/* A surface at a view depth lies in a slice, and there in its map, with its filter. */
void check_point(const csm_config *config, const plan_frame *frame, const double p[3], double depth);
/* So does every surface of a picture before the end of shadows. */
void check_covered(const csm_config *config, const plan_frame *frame, const picture *now);

#endif
