/*
 * rays_model.h: a scene of a few triangles of every kind, and which pixels of it see the middle of the light: by rays in
 * doubles against all triangles, from where the camera's depth says that the pixel is.
 */
#ifndef RAYS_MODEL_H
#define RAYS_MODEL_H

#include "support.h"

enum {
  RAYS_WIDTH = 96,
  RAYS_HEIGHT = 64,
  RAYS_SIDE = 7, /* vertices along a cloth */
  RAYS_VERTICES = RAYS_SIDE * RAYS_SIDE,
  RAYS_INDICES = (RAYS_SIDE - 1) * (RAYS_SIDE - 1) * 6,
  RAYS_INSTANCES = 40,
  RAYS_TEXELS = 7 * 5,
};

/* What the model's scene begins with. */
enum { SHAPE_GROUND, SHAPE_BOX, SHAPE_WEDGE, SHAPE_LEAF, SHAPE_CLOTH, SHAPES, RAYS_SHAPES = SHAPES + 4 };

/* A mesh, with all that it was made of. */
typedef struct rays_shape {
  csm_mesh mesh; /* 0: none */
  uint32_t vertex_count, index_count;
  float positions[RAYS_VERTICES][3], uvs[RAYS_VERTICES][2];
  uint16_t indices[RAYS_INDICES];
  bool cut_out; /* by the model's alpha mask */
  float cutoff;
} rays_shape;

typedef struct rays_model {
  record record; /* first: what callbacks get is the model, too */
  csm_context *context;
  csm_view *view;
  csm_scene *scene;
  shot shot; /* without instances */
  uint8_t texels[RAYS_TEXELS];
  uint32_t wrap_u, wrap_v;
  csm_alpha_mask alpha_mask;
  rays_shape shapes[RAYS_SHAPES];
  uint32_t count; /* what the scene should hold */
  csm_instance instances[RAYS_INSTANCES];
  csm_instance_id ids[RAYS_INSTANCES];
  uint32_t sure, dark; /* pixels that were compared since the caller emptied them */
} rays_model;

/* Opens a context that makes trees, with a scene in which all shapes cast and receive. `flags` and `supply` are added. */
void rays_open(rays_model *m, uint32_t flags, csm_supply_function supply);
void rays_close(rays_model *m);

/* Three maps, filter exact, and every pixel's ray is sent. */
csm_config rays_config(void);
csm_cascades *rays_cascades(rays_model *m, const csm_config *config);

/* The mesh of a shape's positions. */
csm_mesh_info rays_mesh_info(const rays_model *m, uint32_t shape);
void rays_make_mesh(rays_model *m, uint32_t shape);
/* Gives the cloth's vertices other places; of a time, and so far from where they were. */
void rays_move_cloth(rays_shape *cloth, double time, double away);
void rays_update(rays_model *m, uint32_t shape);

/* Changes of the scene and the model alike. */
void rays_add(rays_model *m, const csm_instance *instance);
void rays_remove(rays_model *m, uint32_t place);
void rays_move(rays_model *m, uint32_t place);   /* to where the model's transform has been set to */
void rays_change(rays_model *m, uint32_t place); /* likewise, with mesh, flags and layers */

/* A picture of the model. */
typedef struct rays_picture {
  csm_cascades *cascades;
  csm_view *view;            /* NULL: the model's */
  bool list;                 /* a list of the instances, in place of the scene */
  uint32_t width, height;    /* 0: RAYS_WIDTH, RAYS_HEIGHT */
  double most_wrong_percent; /* of pixels whose ray does not pass within a hair's breadth of an edge; 0: none */
} rays_picture;

/* Draws it, and asserts that what is dark is what a ray from there says. Of a backend that draws nothing, that all calls
   succeed. Counts pixels in m->sure and m->dark. */
void rays_check(rays_model *m, const rays_picture *picture, const char *what);
/* The same with cascades alone. */
void rays_expect(rays_model *m, csm_cascades *cascades, const char *what);

/* Draws, and gives the mask, which the caller frees. */
float *rays_mask(rays_model *m, const rays_picture *picture);
/* What part of the light's disc each pixel sees, by so many rays; below 0 where nothing is, or no map reaches. */
void rays_seen(const rays_model *m, const float *depth, uint32_t rays, float *out);

bool rays_draw(void); /* whether the backend draws */

#endif
