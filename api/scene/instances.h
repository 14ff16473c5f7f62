/*
 * instances.h: what stands in a scene from frame to frame. Instances are added, changed and removed by id, in batches.
 * A batch is done as a whole or not at all. What does not change costs nothing.
 *
 * No GPU: the store knows meshes by their handles and bounds, and is read by the plan.
 */
#ifndef SCENE_INSTANCES_H
#define SCENE_INSTANCES_H

#include "plan/plan.h"
#include "scene/handles.h"

typedef struct instances_memory {
  csm_allocate_function allocate; /* need not give zeroed memory */
  csm_release_function release;
  void *user;
} instances_memory;

/* The context's meshes, which calls look into; its arrays may move between calls. */
typedef struct instances_meshes {
  const handle_table *handles;
  const plan_bounds *bounds; /* by index */
  const plan_parts *parts;   /* by index; NULL: all are whole */
  uint32_t *users;           /* by index: instances of all stores but refilled ones; a mesh with users must stay */
} instances_meshes;

/* Transforms of a batch, in the caller's memory, of any alignment. */
typedef struct instances_transforms {
  const void *first; /* doubles: 4x4, column-major. Floats: three rows of four */
  size_t stride;     /* bytes from one to the next */
  bool floats;
  double origin[3]; /* floats: added to every translation */
} instances_transforms;

/* One value for each instance of a batch, in the caller's memory, of any alignment. */
typedef struct instances_column {
  const void *first; /* NULL: see the call */
  size_t stride;     /* bytes from one to the next */
} instances_column;

typedef struct instances_batch {
  uint32_t count;
  const uint64_t *ids;             /* of what is changed or removed */
  instances_transforms transforms; /* first may be NULL for a change: they stay */
  instances_column meshes;         /* csm_mesh; likewise */
  instances_column flags;          /* uint32_t of PLAN_FLAGS; NULL: they stay, or are 0 */
  instances_column layers;         /* uint32_t; likewise */
} instances_batch;

/* What is wrong with a batch. */
typedef struct instances_error {
  uint32_t index;   /* in the batch */
  const char *text; /* "mesh does not exist"; static */
} instances_error;

typedef struct instances {
  instances_memory memory;
  handle_table ids;
  bool refilled; /* by instances_replace: it has no ids, counts no users, and tells no changes */
  void *block;   /* that the arrays lie in, all of the ids' capacity, a power of two */
  plan_instance *slots;
  plan_box *boxes;
  uint64_t *revisions; /* by slot: after its last change */
  uint32_t *stamps;    /* by slot: the last removal that named it */
  uint32_t *journal;   /* the slots of the last changes */
  uint32_t *next,
      *previous;    /* by slot: others of the same mesh, counted from 1; 0 is an end. None in a refilled store */
  uint32_t *firsts; /* by mesh, of `meshes` of them: its first slot, likewise */
  uint32_t meshes;
  uint64_t revision, journal_from;
  uint32_t live, casters, receivers;
  uint32_t stamp;
} instances;

/* An empty store. It is told apart from others by its key. [no allocation] */
void instances_begin(instances *store, const instances_memory *memory, uint64_t key);
/* Frees all memory; the meshes lose their users. `meshes` may be NULL where they go too. */
void instances_end(instances *store, const instances_meshes *meshes);

/*
 * Each of these changes all of a batch, or leaves everything as it was and fills `error` in.
 * Errors of all: INVALID_HANDLE (an id, a mesh; an id twice in a batch that removes), NOT_FINITE, INVALID_MATRIX (a
 * transform that is not affine, or numbers above PLAN_LARGEST), INVALID_VALUE (flags), NULL_POINTER, LIMIT_EXCEEDED
 * (2^31 - 2 instances), OUT_OF_MEMORY.
 */
/* Gives each instance an id, in the batch's order. */
csm_result instances_add(instances *store, const instances_meshes *meshes, const instances_batch *batch, uint64_t *ids,
                         instances_error *error);
/*
 * Changes what the batch has; an id may come twice, and the last one stays. Moving is a batch of transforms alone. What
 * comes out as it was does not count as changed.
 */
csm_result instances_change(instances *store, const instances_meshes *meshes, const instances_batch *batch,
                            instances_error *error);
/* Only count and ids are read. */
csm_result instances_remove(instances *store, const instances_meshes *meshes, const instances_batch *batch,
                            instances_error *error);
/*
 * Makes the batch all that the store holds, in slots 0 to count - 1, for a list that comes anew in each frame. The
 * store must hold nothing else, and has no ids. After an error it is empty.
 */
csm_result instances_replace(instances *store, const instances_meshes *meshes, const instances_batch *batch,
                             instances_error *error);

/* A mesh has new bounds: its instances' boxes follow. */
void instances_mesh_changed(instances *store, const instances_meshes *meshes, uint32_t mesh);

/* The slot of an id, or UINT32_MAX. */
uint32_t instances_find(const instances *store, uint64_t id);

/* How many slots have changed since a revision, each counted once. */
uint32_t instances_changed_since(const instances *store, uint64_t revision);

/* What the plan reads; valid until the store or the meshes change. */
plan_scene instances_scene(const instances *store, const instances_meshes *meshes);

#endif
