/* rows.h: misuse in rows: a good struct, one field of which is set wrong, and the error that tells of it. */
#ifndef ROWS_H
#define ROWS_H

#include "csm/csm_base.h"

#include <stddef.h>

enum { MISUSE_ROWS = 32 };

typedef struct misuse {
  const char *what;
  uint32_t offset, size; /* of the field, FIELD(type, field) */
  union {
    uint64_t whole; /* its lowest bytes */
    double real;
    const void *pointer;
  } value;
  csm_result expected;
  const char *words; /* that the error's text has; NULL for success */
} misuse;

#define FIELD(type, field) offsetof(type, field), sizeof(((type *)0)->field)

/* Writes the row's value into a struct. */
void misuse_apply(const misuse *row, void *target);
/* Asserts that an answer is the row's, with its words in the text. */
void misuse_expect(const misuse *row, csm_result result, const char *text);

#endif
