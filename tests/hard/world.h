/*
 * world.h: a context with all that a caller has of it, alive or gone, for calls that are a function of a seed. Every
 * world of one seed makes the same calls, whatever its backend, as long as it gets the same answers.
 */
#ifndef WORLD_H
#define WORLD_H

#include "lent.h"
#include "spoil.h"
#include "../conformance/support.h"

enum {
  WORLD_MESHES = 12,
  WORLD_ALPHA_MASKS = 4,
  WORLD_SCENES = 3,
  WORLD_IDS = 48, /* of each scene */
  WORLD_CASCADES = 3,
  WORLD_VIEWS = 3,
  WORLD_VERTICES = 64, /* of a mesh, at most */
  WORLD_FLOATS = 2048,
  WORLD_BATCH = 80, /* instances of one call, at most */
  WORLD_SIDE = 64,  /* of maps, at most */
  WORLD_WIDTH = 24, /* of masks, mostly */
  WORLD_HEIGHT = 16,
  WORLD_PAPERS = 8
};

/* What was given out, and whether it is alive; what is not may be used by mistake. */
typedef struct world_handle {
  uint64_t value;
  bool live;
} world_handle;

typedef struct world_scene {
  csm_scene *scene; /* NULL: gone */
  world_handle ids[WORLD_IDS];
} world_scene;

typedef struct world_cascades {
  csm_cascades *cascades; /* NULL: gone */
  csm_config config;
  uint32_t list; /* instances of the last frame, if that had a list */
} world_cascades;

typedef struct world_view {
  csm_view *view; /* NULL: gone */
  uint32_t width, height;
} world_view;

/* Another context of its own, whose handles mean nothing here. */
typedef struct world_stranger {
  record record;
  csm_context *context;
  csm_mesh mesh;
  csm_scene *scene;
  csm_instance_id id;
  csm_cascades *cascades;
  csm_view *view;
} world_stranger;

typedef struct world {
  const char *backend; /* that it began with */
  bool rays;           /* meshes get trees */
  bool samples;        /* a configuration reads what views saw, which a backend that draws nothing does not know */
  dice dice;
  uint64_t answers;  /* what was answered so far, as any backend answers */
  uint64_t pictures; /* what was drawn so far */
  record record;
  csm_context *context;
  world_stranger stranger;
  lent *lent; /* an engine's device; NULL: none */
  bool own;   /* the device is csm's own now */
  world_handle meshes[WORLD_MESHES], alpha_masks[WORLD_ALPHA_MASKS];
  world_scene scenes[WORLD_SCENES];
  world_cascades cascades[WORLD_CASCADES];
  world_view views[WORLD_VIEWS];
  csm_view *looked; /* the view whose depth was reduced last, and of what; NULL: none */
  csm_camera looked_camera;
  csm_scene *looked_scene;
  void *gone; /* the scene, cascades or view that was destroyed last */
  /* What the calls read. */
  float floats[WORLD_FLOATS];
  uint32_t indices[WORLD_VERTICES * 3];
  unsigned char texels[1024];
  unsigned char list[WORLD_BATCH * 256];
  csm_instance_id ids[WORLD_BATCH];
  double matrices[WORLD_BATCH * 16];
  spoil_paper papers[WORLD_PAPERS];
  uint32_t papers_used;
} world;

/* Opens a context for a seed; with an engine's device, if there is one. */
void world_open(world *w, const char *backend, uint64_t seed, lent *lent);
/* Destroys it; asserts that nothing is left, and that nothing was warned of. */
void world_close(world *w);
csm_create_info world_create_info(world *w);

/* All that a caller can see of what was drawn, as one number. */
uint64_t world_looks(world *w);

/* ---- what calls are made of ---- */

/* Copies a good struct to paper. It stays until the next call. */
void *world_write(world *w, const void *good, size_t size);
/* Likewise, and makes something wrong with it once in a while. */
void *world_risk(world *w, const void *good, const spoil_struct *what);

/* Remembers what was answered: by all backends alike; likewise, but for what views saw; by those that draw. */
void world_answer(world *w, const void *bytes, size_t size);
void world_plan(world *w, const void *bytes, size_t size);
void world_picture(world *w, const void *bytes, size_t size);

/* One of the handles, mostly one that is alive; else one of any age, kind or context. */
uint64_t world_handle_of(world *w, const world_handle *handles, uint32_t count);
/* A place for a new one, which may hold one that is gone. NULL: all are alive. */
world_handle *world_place(world *w, world_handle *handles, uint32_t count);

/* One of those that are alive; NULL: none is, or once in a while. */
world_scene *world_any_scene(world *w);
world_cascades *world_any_cascades(world *w);
world_view *world_any_view(world *w);
/* A pointer that is compared, and not followed: of another context, kind, or of nothing. */
void *world_wild(world *w);

/* ---- the calls ---- */

typedef struct world_call {
  const char *name;
  uint32_t weight, engine_weight; /* how often it comes; and how much more often on an engine's device */
  bool opens;                     /* a device, which takes a while */
  csm_result (*call)(world *w);   /* changes the world after success only */
} world_call;

/* The next one. */
const world_call *world_choose(world *w);

/* Each ends with one that has no name. */
extern const world_call calls_assets[], calls_scenes[], calls_cascades[], calls_frames[], calls_questions[],
    calls_context[];

#endif
