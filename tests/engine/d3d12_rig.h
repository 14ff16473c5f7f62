/* d3d12_rig.h: an engine with a csm context on its device, and the pictures that csm drew, read by the engine. */
#ifndef D3D12_RIG_H
#define D3D12_RIG_H

#include "../conformance/support.h"
#include "d3d12_engine.h"

typedef struct d3d12_rig {
  d3d12_engine engine;
  record record;
  csm_context *context;
  uint32_t references; /* that the device had before the context */
} d3d12_rig;

/* The engine, then a context on its device. */
void rig_open(d3d12_rig *rig);
/* What csm_create gets for a context on `native`. */
csm_create_info rig_create_info(record *record, const csm_d3d12_device *native);
/* Runs all frames; destroys the context; asserts that it held nothing and validation said nothing; closes the engine.
 */
void rig_close(d3d12_rig *rig);

/* Tells csm which frames are done. */
void rig_retire(d3d12_rig *rig);
/* A frame of the scene for the engine's current list. */
csm_frame rig_frame(const d3d12_rig *rig, const support_scene *scene, ID3D12GraphicsCommandList *list);
void rig_render(d3d12_rig *rig, csm_cascades *cascades, const csm_frame *frame);

/* ---- pictures: the maps, and the mask if it has a size ---- */

typedef struct picture_layer {
  uint32_t width, height;
  float *texels;
} picture_layer;

typedef struct picture {
  uint32_t count;
  picture_layer layers[CSM_MAX_CASCADES + 1];
} picture;

/* From a context with a device of its own. */
picture picture_read(csm_cascades *own, const csm_config *config, uint32_t mask_width, uint32_t mask_height);

/* Copies recorded into an engine's list, to be taken when it has run. */
typedef struct picture_copy {
  ID3D12Resource *buffer;
  uint32_t cascades, resolution, mask_width, mask_height;
} picture_copy;
picture_copy picture_record(d3d12_rig *rig, ID3D12GraphicsCommandList *list, csm_cascades *cascades,
                            uint32_t mask_width, uint32_t mask_height);
picture picture_take(picture_copy *copy);

void picture_free(picture *picture);
/* Asserts that every texel is the same. */
void picture_expect_equal(const picture *a, const picture *b);
/* Asserts that something that is not flat was drawn into each map. */
void picture_expect_casters(const picture *picture, uint32_t cascades);

/* ---- a mesh that both a context and an engine can hold ---- */

enum { HILL_SIDE = 9, HILL_VERTICES = HILL_SIDE * HILL_SIDE, HILL_INDICES = (HILL_SIDE - 1) * (HILL_SIDE - 1) * 6 };
typedef struct hill {
  float positions[HILL_VERTICES][3];
  uint16_t indices[HILL_INDICES];
  uint32_t wide_indices[HILL_INDICES];
} hill;
void hill_make(hill *hill);
/* Copied into a context. */
csm_mesh hill_mesh(csm_context *context, const hill *hill, uint32_t index_size);

#endif
