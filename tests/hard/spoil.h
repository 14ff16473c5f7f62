/* spoil.h: a struct of the caller's with one thing wrong in it, which is no lie about what its pointers lead to. */
#ifndef SPOIL_H
#define SPOIL_H

#include "dice.h"

typedef enum field_kind {
  FIELD_WHOLE,  /* 32 bits, of any value */
  FIELD_SMALL,  /* 32 bits, as they say how much is read: up to `most` */
  FIELD_LONG,   /* 64 bits, of any value: a handle, a number */
  FIELD_REAL,   /* doubles */
  FIELD_FLOAT,  /* floats */
  FIELD_POINTER /* which may be NULL */
} field_kind;

typedef struct spoil_field {
  uint32_t offset, size;
  field_kind kind;
  uint32_t most;
} spoil_field;

/* What a struct is made of, beside its struct_size. */
typedef struct spoil_struct {
  uint32_t size;
  uint32_t count;
  const spoil_field *fields;
} spoil_struct;

#define SPOIL_AT(type, field) offsetof(type, field), sizeof(((type *)0)->field)
#define SPOIL_STRUCT(type, list)                                                                                       \
  { sizeof(type), sizeof(list) / sizeof(list)[0], list }

/* A struct where it is read far beyond its end, as one of a later header is. */
enum { SPOIL_ROOM = 6144, SPOIL_TAIL = 4096 };
typedef struct spoil_paper {
  _Alignas(16) unsigned char bytes[SPOIL_ROOM];
} spoil_paper;

/* Makes one thing wrong, or odd, in a good struct on paper. */
void spoil(dice *dice, spoil_paper *paper, const spoil_struct *what);

#endif
