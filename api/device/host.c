#include "device/host.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { alignment = 64 };

static void *CSM_CALL default_allocate(void *user, size_t size, size_t aligned) {
  (void)user;
  return aligned_alloc(aligned, (size + aligned - 1) / aligned * aligned);
}

static void CSM_CALL default_release(void *user, void *memory) {
  (void)user;
  free(memory);
}

static void CSM_CALL default_log(void *user, int32_t level, const char *message) {
  (void)user;
  (void)level;
  (void)message;
}

host host_default(void) {
  return (host){.allocate = default_allocate, .release = default_release, .log = default_log};
}

void *host_allocate(host *host, size_t size) {
  void *memory = host->allocate(host->user, size, alignment);
  if (memory)
    memset(memory, 0, size);
  else
    host_fail(host, CSM_ERROR_OUT_OF_MEMORY, "out of memory: %zu bytes", size);
  return memory;
}

void host_release(host *host, void *memory) {
  if (memory)
    host->release(host->user, memory);
}

csm_result host_grow(host *host, void **memory, size_t *capacity, size_t size) {
  if (size <= *capacity)
    return CSM_SUCCESS;
  const size_t grown = size + size / 2;
  void *fresh = host_allocate(host, grown);
  if (!fresh)
    return CSM_ERROR_OUT_OF_MEMORY;
  host_release(host, *memory);
  *memory = fresh;
  *capacity = grown;
  return CSM_SUCCESS;
}

void *host_grown_copy(host *host, const void *old, size_t count, size_t capacity, size_t size) {
  void *grown = host_allocate(host, capacity * size);
  if (grown && count)
    memcpy(grown, old, count * size);
  return grown;
}

void *host_carve(char **at, size_t size) {
  char *piece = *at;
  *at += (size + HOST_CARVED - 1) / HOST_CARVED * HOST_CARVED;
  return piece;
}

csm_result host_fail(host *host, csm_result result, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(host->error, sizeof host->error, format, arguments);
  va_end(arguments);
  host->log(host->user, CSM_LOG_ERROR, host->error);
  return result;
}

csm_result host_check_struct(host *host, csm_result result, const char *name) {
  if (result == CSM_ERROR_NULL_POINTER)
    return host_fail(host, result, "%s is NULL", name);
  if (result)
    return host_fail(host, result,
                     "%s has a struct_size that is not its size in any version, or a tail that this version does not "
                     "know and that is not zero",
                     name);
  return CSM_SUCCESS;
}
