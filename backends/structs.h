/* structs.h: for the front and for backends: reading and writing the caller's structs, whose size tells which version
 * of the header they come from. */
#ifndef STRUCTS_H
#define STRUCTS_H

#include "csm/csm_base.h"

/*
 * Copies a struct that begins with struct_size into `out`, of `size` bytes; what the caller's lacks is zero. Errors:
 * NULL_POINTER; STRUCT_SIZE (0, not a multiple of 4, absurdly large, or an unknown tail that is not zero).
 */
csm_result struct_read(void *out, uint32_t size, const void *in);

/* Checks a struct that is about to be written. Errors as struct_read. */
csm_result struct_check(uint32_t size, const void *in);

/* Writes as much of `from` (of `size` bytes) as the caller's struct holds, leaving its struct_size alone. */
void struct_write(void *out, uint32_t size, const void *from);

#endif
