/* heap_hook.h: counts what csm's own libraries ask of the C library's heap, past the allocator that they were given. */
#ifndef HEAP_HOOK_H
#define HEAP_HOOK_H

#include <stdint.h>

/* Calls of malloc, calloc, realloc, aligned_alloc and posix_memalign from libcsm*.so since counting began. */
void heap_hook_start(void);
uint32_t heap_hook_stop(void);

#endif
