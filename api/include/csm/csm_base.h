/* csm_base.h: what every public header and every backend shares: result codes, callbacks, the calling convention. */
#ifndef CSM_BASE_H
#define CSM_BASE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(_WIN32)
#define CSM_CALL __cdecl
#define CSM_API __declspec(dllexport)
#else
#define CSM_CALL
#define CSM_API __attribute__((visibility("default")))
#endif

#define CSM_VERSION_MAJOR 1u
#define CSM_VERSION_MINOR 0u
#define CSM_VERSION_PATCH 0u
/* major << 22 | minor << 12 | patch, as Vulkan packs its versions */
#define CSM_VERSION ((CSM_VERSION_MAJOR << 22) | (CSM_VERSION_MINOR << 12) | CSM_VERSION_PATCH)

/* 0 is success; every error is negative and has a name, see csm_result_name. */
typedef int32_t csm_result;

enum {
  CSM_SUCCESS = 0,
  CSM_ERROR_NULL_POINTER = -1,    /* a pointer that must point at something is NULL */
  CSM_ERROR_STRUCT_SIZE = -2,     /* struct_size is 0, or its unknown tail is not zero */
  CSM_ERROR_NOT_FINITE = -3,      /* a number is NaN or infinite */
  CSM_ERROR_INVALID_VALUE = -4,   /* a value outside its documented range, or an unknown flag */
  CSM_ERROR_INVALID_MATRIX = -5,  /* a matrix is singular, or not affine where it must be */
  CSM_ERROR_INVALID_CAMERA = -6,  /* the projection has near >= far, or no usable near plane */
  CSM_ERROR_INVALID_LIGHT = -7,   /* the light's direction is zero */
  CSM_ERROR_INVALID_HANDLE = -8,  /* a handle that was never given out, or is stale */
  CSM_ERROR_INVALID_INDEX = -9,   /* an index out of range: of a vertex, a cascade, a configuration key */
  CSM_ERROR_INVALID_STATE = -10,  /* the call does not fit what went before, such as a mask before any map */
  CSM_ERROR_LIMIT_EXCEEDED = -11, /* the device, or the caller's memory limit, does not allow it */
  CSM_ERROR_OUT_OF_MEMORY = -12,  /* host memory */
  CSM_ERROR_OUT_OF_DEVICE_MEMORY = -13,
  CSM_ERROR_DEVICE_LOST = -14, /* only csm_destroy and csm_switch_backend are of use now */
  CSM_ERROR_DEVICE = -15,      /* the device or its driver refused something for another reason */
  CSM_ERROR_NO_DEVICE = -16,   /* no driver, or no device that fits */
  CSM_ERROR_BACKEND_NOT_FOUND = -17,
  CSM_ERROR_BACKEND_BROKEN = -18, /* not a library, no entry, or an entry that does not keep its word */
  CSM_ERROR_BACKEND_TOO_OLD = -19,
  CSM_ERROR_BACKEND_TOO_NEW = -20,
  CSM_ERROR_UNSUPPORTED = -21 /* not in this version, or not on this device; never silently something else */
};

/* What kind of device one is. */
enum {
  CSM_DEVICE_OTHER = 0,
  CSM_DEVICE_INTEGRATED = 1,
  CSM_DEVICE_DISCRETE = 2,
  CSM_DEVICE_VIRTUAL = 3,
  CSM_DEVICE_CPU = 4
};

enum { CSM_LOG_ERROR = 0, CSM_LOG_WARNING = 1, CSM_LOG_INFO = 2, CSM_LOG_TRACE = 3 };

/* Receives a message (UTF-8, no newline) of a CSM_LOG level. Must not call back into csm. */
typedef void(CSM_CALL *csm_log_function)(void *user, int32_t level, const char *message);

/* Gives `size` bytes aligned to `alignment` (a power of two, at most 64), or NULL. Must not call back into csm. */
typedef void *(CSM_CALL *csm_allocate_function)(void *user, size_t size, size_t alignment);
/* Takes back what csm_allocate_function gave; never called with NULL. */
typedef void(CSM_CALL *csm_release_function)(void *user, void *memory);

#ifdef __cplusplus
}
#endif
#endif
