/*
 * programs.h: the programs of a device, each once, by key. A key is what its maker makes it from, so two keys with the
 * same bytes and the same maker are one program.
 */
#ifndef DEVICE_PROGRAMS_H
#define DEVICE_PROGRAMS_H

#include "gpu_calls.h"

struct device;

enum { PROGRAM_KEY_BYTES = 64 };

/* Makes the program that `about` says. */
typedef csm_result (*program_make)(gpu gpu, const void *about, gpu_program **out);

typedef struct program_key {
  program_make make;
  const char *name;  /* for errors: "a mask program" */
  const void *about; /* compared byte by byte, so padding is zero; NULL where the maker says it all */
  size_t size;       /* up to PROGRAM_KEY_BYTES */
} program_key;

/* Open addressing; the capacity is a power of two, and at most three quarters are in use. */
typedef struct programs {
  struct program_entry **entries;
  uint32_t capacity, count;
} programs;

/* The program of a key, made if it is not there; it stays as long as the device. Errors: those of creation. */
csm_result programs_find(struct device *device, const program_key *key, gpu_program **out);
/* The same, but it goes with its last user, who gives it back. */
csm_result programs_take(struct device *device, const program_key *key, gpu_program **out);
/* NULL is allowed. */
void programs_give_back(struct device *device, const gpu_program *program);
void programs_destroy(struct device *device);

#endif
