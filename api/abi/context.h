/*
 * context.h: what a context keeps whatever its device is: the caller's callbacks, meshes, alpha masks and scenes,
 * cascades, views, and the last error.
 */
#ifndef ABI_CONTEXT_H
#define ABI_CONTEXT_H

#include "abi/loader.h"
#include "scene/scene.h"
#include "structs.h"

/* A backend's library, and the device that it drives. */
typedef struct opened {
  struct opened *next;
  loader_library library;
  device *device;
} opened;

struct csm_context {
  host host;
  opened *opened; /* the present one; its device is that of the assets */
  opened *former; /* engines' devices that the context was switched away from, until their last frame is retired */
  assets assets;
  csm_cascades *cascades; /* all of them */
  csm_view *views;        /* likewise */
  uint64_t settings;      /* counts configurations of cascades */

  /* What the camera of a picture without a scene sees. */
  instances list;
  plan_memory view_memory; /* of the last view's list */
  size_t view_memory_size;
};

/* ---- context.c ---- */

/* What is wrong with a checked-out csm_create_info, or CSM_SUCCESS. */
csm_result create_info_check(const csm_create_info *info, const char **text);
/* Leaves the text of a creation that failed where the caller finds it. */
csm_result create_info_refuse(const csm_create_info *info, csm_result result, const char *text);
/* Opens the backend that `info` names, which is checked, and its device. */
csm_result context_open(csm_context *context, const csm_create_info *info, opened **out);
/* Closes the device and its library; the GPU is done with it, or is waited for. */
void context_close(csm_context *context, opened *opened);

/* DEVICE_LOST once the context's device is lost. */
csm_result context_usable(csm_context *context);

static inline device *context_device(const csm_context *context) {
  return context->assets.device;
}

#endif
