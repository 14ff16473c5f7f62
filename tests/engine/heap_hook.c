/* heap_hook.c: stands before glibc's heap in the program that it is linked to. */
#include "heap_hook.h"

#include <dlfcn.h>
#include <errno.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *memory, size_t size);
void *__libc_memalign(size_t alignment, size_t size);

static atomic_bool counting;
static atomic_uint counted;

static void count(const void *caller) {
  Dl_info from;
  if (atomic_load(&counting) && dladdr(caller, &from) && from.dli_fname && strstr(from.dli_fname, "libcsm"))
    atomic_fetch_add(&counted, 1);
}

void heap_hook_start(void) {
  atomic_store(&counted, 0);
  atomic_store(&counting, true);
}

uint32_t heap_hook_stop(void) {
  atomic_store(&counting, false);
  return atomic_load(&counted);
}

void *malloc(size_t size) {
  count(__builtin_return_address(0));
  return __libc_malloc(size);
}

void *calloc(size_t elements, size_t size) {
  count(__builtin_return_address(0));
  return __libc_calloc(elements, size);
}

void *realloc(void *memory, size_t size) {
  count(__builtin_return_address(0));
  return __libc_realloc(memory, size);
}

void *aligned_alloc(size_t alignment, size_t size) {
  count(__builtin_return_address(0));
  return __libc_memalign(alignment, size);
}

int posix_memalign(void **memory, size_t alignment, size_t size) {
  count(__builtin_return_address(0));
  *memory = __libc_memalign(alignment, size);
  return *memory ? 0 : ENOMEM;
}
