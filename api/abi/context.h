/*
 * context.h: what a context keeps whatever its device is: the caller's callbacks, meshes by handle (meshes.c), cascades
 * (cascades.c), the last error (errors.c).
 */
#ifndef CONTEXT_H
#define CONTEXT_H

#include "device/device.h"
#include "scene/handles.h"
#include "structs.h"

/* Arrays are by index of the handle. */
typedef struct mesh_table {
  handle_table handles;
  csm_mesh_info *infos; /* shapes; positions, uvs and indices point into the copy, or are NULL */
  void **copies;
  plan_bounds *bounds; /* as the plan wants them */
} mesh_table;

typedef struct alpha_mask_table {
  handle_table handles;
  csm_alpha_mask_info *infos; /* texels are the context's copy */
  uint32_t *users;         /* meshes */
} alpha_mask_table;

struct csm_context {
  csm_allocate_function allocate;
  csm_release_function release;
  csm_log_function log;
  csm_supply_function supply;
  csm_budget_function budget;
  void *user;
  char error[512];

  device *device;
  device *former; /* engines' devices that the context was switched away from, until their last frame is retired */
  mesh_table meshes;
  alpha_mask_table alpha_masks;
  bool keep_geometry;
  csm_cascades *cascades; /* all of them */

  void *scratch; /* instances that a mask's camera sees */
  size_t scratch_size;
};

/* ---- errors.c ---- */

/* Records and logs an error, and returns `result`. */
csm_result context_fail(csm_context *context, csm_result result, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
/* context_fail for a backend's result, with what was tried; a lost device is marked. CSM_SUCCESS passes through. */
csm_result device_check(device *device, csm_result result, const char *what);
/* context_fail for a struct that struct_read or struct_check refused. */
csm_result context_check_struct(csm_context *context, csm_result result, const char *name);
/* DEVICE_LOST once the context's device is lost. */
csm_result context_usable(csm_context *context);

/* ---- memory.c ---- */

void *context_allocate(csm_context *context, size_t size); /* zeroed; fails with an error set */
void context_release(csm_context *context, void *memory);
/* Makes *memory at least `size` bytes, losing what it held; keeps it as it was on failure. */
csm_result context_grow(csm_context *context, void **memory, size_t *capacity, size_t size);

/* ---- meshes.c ---- */

/* Places every mesh on another device, from copies or what `supply` gives. */
csm_result meshes_move(csm_context *context, device *to);
void meshes_destroy(csm_context *context);

/* ---- alpha_mask.c ---- */

/* Makes every texture on another device. */
csm_result alpha_masks_move(csm_context *context, device *to);
void alpha_masks_destroy(csm_context *context);

/* ---- scene.c ---- */

/* Bytes that scene_read needs for so many instances. */
size_t scene_size(uint32_t instance_count);
/* Checks a frame's instances and copies them into `memory`. */
csm_result scene_read(csm_context *context, const csm_frame *frame, void *memory, plan_scene *scene);
/* Reads and checks a frame's struct but for its instances. */
csm_result frame_read(csm_context *context, const csm_frame *in, csm_frame *out);

/* ---- context.c ---- */

/* malloc, and no log: for what is done without a context. */
gpu_host default_host(void);

#endif
