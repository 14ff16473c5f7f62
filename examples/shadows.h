/*
 * shadows.h: the engine's shadows, apart from its graphics API: csm, loaded at run time. Everything that the engine
 * does with csm is here and in the two programs, mini_vulkan.c and mini_d3d12.c, which hand over what they own.
 */
#ifndef EXAMPLE_SHADOWS_H
#define EXAMPLE_SHADOWS_H

#include "app.h"
#include "csm/csm_loader.h"
#include "csm_constants.h"
#include "world.h"

enum { SHADOWS_FRAMES_IN_FLIGHT = 3, SHADOWS_FRAMES = 10, SHADOWS_CONSTANTS_BYTES = 16 * CSM_C_COUNT };

typedef struct shadows {
  void *library;
  csm_functions csm; /* a table, because the library is not linked */
  csm_context *context;
  csm_scene *scene; /* the things that stand still */
  csm_cascades *cascades;
  csm_mesh meshes[WORLD_MESHES];
  double cpu_ms[SHADOWS_FRAMES]; /* what each csm_render_cascades took on the CPU */
  uint32_t frames;
} shadows;

/* Loads the library and makes a context on the engine's device, which `create` names, with cascades. */
void shadows_open(shadows *s, const char *library, csm_create_info *create);
/* Precondition: the GPU has finished every frame. */
void shadows_close(shadows *s);

/* Gives csm a mesh of the engine's, by its buffers, which `info` names. */
void shadows_add_mesh(shadows *s, uint32_t index, const mesh *m, csm_mesh_info *info);

/* The GPU has finished this frame; frames before the first one are ignored. */
void shadows_retire(shadows *s, int64_t frame);

/* Places what stands still, once: no frame has to tell csm of it again. The meshes have been added. */
void shadows_place(shadows *s, const world *w);

/* What the engine's own casters are drawn into: known before the first frame, so that their pipeline is, too. */
csm_draw_target shadows_target(shadows *s);

/* What an engine hands over with a frame. */
typedef struct shadows_frame {
  uint64_t number;      /* from 1 on */
  void *command_buffer; /* or list */
  csm_draw_function draw;
  void *user;
} shadows_frame;

/*
 * Records the maps of one frame: rigid things as csm's instances, the skinned one by `draw`. Then fills in what the
 * forward pass samples them with.
 */
void shadows_record(shadows *s, const world *w, const shadows_frame *frame, csm_binding *binding);

/* Writes the block that the forward shader declares, csm_c of CSM_C_COUNT: both of csm's blocks, each in its place. */
void shadows_write_constants(void *to, const csm_binding *binding);

/* Whether anything in a sphere can cast into the map of the cascade that is being drawn. */
bool shadows_reaches(const csm_draw_info *info, const double center[3], double radius);

/* One line with what was measured. */
void shadows_report(shadows *s, const char *program, const char *device, double frame_ms, uint32_t messages);

#endif
