/* loader.h: finds a backend's library, opens it, and agrees with it on a version of gpu.h. */
#ifndef LOADER_H
#define LOADER_H

#include "gpu.h"
#include <limits.h>

/* The versions of gpu.h that this front speaks. */
enum { LOADER_OLDEST = GPU_INTERFACE_VERSION, LOADER_NEWEST = GPU_INTERFACE_VERSION };

typedef struct loader_library {
  void *handle;
  const gpu_backend *backend;
  char path[PATH_MAX]; /* the library's file */
} loader_library;

/*
 * Opens a backend by its name ("vulkan": libcsm-vulkan.so beside libcsm, then in the folder it was installed to), or by
 * its library's path if there is a slash in it. `out` is zero after an error, but for the path that was found;
 * `error`, of error_size bytes, gets a text that names the path and the versions.
 * Errors: INVALID_VALUE (a name that is not of a-z, 0-9, - and _), BACKEND_NOT_FOUND, BACKEND_BROKEN, BACKEND_TOO_OLD,
 * BACKEND_TOO_NEW.
 */
csm_result loader_open(loader_library *out, const char *name, char *error, size_t error_size);

/* Keeps what is static in an open library for as long as the process runs, whether it is closed or not. */
void loader_keep(const loader_library *library);

/* Closes the library; nothing of the backend may be in use. A zero loader_library is allowed. */
void loader_close(loader_library *library);

/*
 * What to make of a backend's answer to a handshake: CSM_SUCCESS and the newest common version, or BACKEND_TOO_OLD,
 * BACKEND_TOO_NEW, or BACKEND_BROKEN (no sound range, or no table for a version that both speak).
 */
csm_result loader_negotiate(const gpu_handshake *answer, uint32_t *version);

#endif
