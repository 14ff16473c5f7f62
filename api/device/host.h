/* host.h: what a context lends to everything below it: memory, messages, and a place for the last error's text. */
#ifndef DEVICE_HOST_H
#define DEVICE_HOST_H

#include "csm/csm.h"

enum { HOST_CARVED = 16 };

typedef struct host {
  csm_allocate_function allocate;
  csm_release_function release;
  csm_log_function log;
  csm_budget_function budget; /* may be NULL */
  void *user;                 /* of all of these */
  char error[512];
} host;

/* malloc, and no log. */
host host_default(void);

/* Zeroed memory; NULL with the error set. */
void *host_allocate(host *host, size_t size);
/* NULL is allowed. */
void host_release(host *host, void *memory);
/* Makes *memory at least `size` bytes, losing what it held; keeps it as it was on failure. */
csm_result host_grow(host *host, void **memory, size_t *capacity, size_t size);
/* A larger copy of an array; NULL with the error set. `old` stays. */
void *host_grown_copy(host *host, const void *old, size_t count, size_t capacity, size_t size);
/* Takes an array off the front of a block; what follows is aligned to HOST_CARVED. */
void *host_carve(char **at, size_t size);

/* Keeps and logs an error's text, and returns `result`. */
csm_result host_fail(host *host, csm_result result, const char *format, ...) __attribute__((format(printf, 3, 4)));
/* host_fail for a struct that struct_read or struct_check refused; CSM_SUCCESS passes through. */
csm_result host_check_struct(host *host, csm_result result, const char *name);

#endif
