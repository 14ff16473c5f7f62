/* stage.h: a context with its cascades and the scene that all tests know, on an engine's device or on its own. */
#ifndef STAGE_H
#define STAGE_H

#include "picture.h"

typedef struct stage {
  rig *rig; /* NULL: an own device */
  record record;
  csm_context *context;
  csm_cascades *cascades;
  csm_view *view;
  csm_config config;
  support_scene scene;
} stage;

/* A context that is about to be made on the rig, with its record. */
csm_create_info stage_create_info(rig *rig, record *record);
void stage_open(stage *stage, rig *rig);
/* Likewise, with more CSM_CREATE_*. */
void stage_open_with(stage *stage, rig *rig, uint32_t flags);
/* Runs and retires what was recorded, and destroys the context; asserts that nothing is left and nothing was said. */
void stage_close(stage *stage);

/* The scene at a time, which moves the camera and the sun, for the command buffer that is open. */
shot stage_shot(const stage *stage, double time);
void stage_configure(stage *stage);
void stage_render(stage *stage, shot *shot);
void stage_resolve(stage *stage, shot *shot, picture_size mask);
/* Records a copy of the maps and the mask. */
picture_copy stage_record(stage *stage, picture_size mask);
/* Ends the engine's frame, runs and retires it. */
void stage_finish(stage *stage);
/* Tells csm which frames are done. */
void stage_retire(stage *stage);
/* Renders, resolves, runs and reads a frame of the stage's own scene, or of `shot`. */
picture stage_draw(stage *stage, shot *shot, picture_size mask);
picture stage_draw_at(stage *stage, double time, picture_size mask);

/* ---- a mesh that both a context and an engine can hold: a hill on a square of half size 1 ---- */

enum { HILL_SIDE = 9, HILL_VERTICES = HILL_SIDE * HILL_SIDE, HILL_INDICES = (HILL_SIDE - 1) * (HILL_SIDE - 1) * 6 };

typedef struct hill {
  float positions[HILL_VERTICES][3];
  uint16_t indices[HILL_INDICES];
  uint32_t wide_indices[HILL_INDICES];
} hill;

void hill_make(hill *hill);
csm_mesh_info hill_info(const hill *hill, uint32_t index_size);
/* Copied into a context. */
csm_mesh hill_mesh(csm_context *context, const hill *hill, uint32_t index_size);

#endif
