/*
 * lent.h: what a device is lent: memory, a log, and while it is being opened a place for texts of errors. Backends of
 * drivers share it.
 */
#ifndef LENT_H
#define LENT_H

#include "gpu.h"

typedef struct gpu_lent {
  gpu_host host;
  char *error; /* while the device is being opened: where texts of errors go instead of the log; else NULL */
  size_t error_size;
} gpu_lent;

/* As it is when a device begins to be opened; the text is empty. */
gpu_lent lent_begin(const gpu_open_info *info);

void *lent_allocate(const gpu_lent *lent, size_t size); /* zeroed; NULL */
void lent_release(const gpu_lent *lent, void *memory);  /* NULL is allowed */

/* snprintf, whose text may be cut. */
__attribute__((format(printf, 3, 4))) void lent_text(char *out, size_t size, const char *format, ...);
/* Reports an error in words, and returns it. */
__attribute__((format(printf, 3, 4))) csm_result lent_fail(const gpu_lent *lent, csm_result result, const char *format,
                                                           ...);

#endif
