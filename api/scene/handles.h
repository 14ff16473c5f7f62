/*
 * handles.h: handles of the caller's. Each is a place in a table, and the generation of what lies there, so that a
 * handle to what is gone is known for what it is. The table's key scrambles them, so that another table's handle is not
 * found here.
 */
#ifndef SCENE_HANDLES_H
#define SCENE_HANDLES_H

#include "csm/csm.h"
#include <stdbool.h>

typedef struct handle_place {
  uint32_t generation; /* odd: taken */
  uint32_t next_free;  /* counted from 1; 0 is the end */
} handle_place;

/* What the handles stand for lies in arrays of the owner's, by index, of the same capacity. */
typedef struct handle_table {
  handle_place *places;
  uint64_t key;  /* handles_key */
  uint32_t kind; /* 0 or 1: handles of one kind mean nothing to a table of the other */
  uint32_t count, capacity, first_free;
} handle_table;

/* A key for the tables of one owner. `clock` differs where owners follow each other at one address. */
uint64_t handles_key(const void *owner, uint64_t clock);

/* Index of what a handle stands for, or UINT32_MAX. No handle is 0. */
uint32_t handles_find(const handle_table *table, uint64_t handle);
bool handles_live(const handle_table *table, uint32_t index);
uint64_t handles_at(const handle_table *table, uint32_t index);

/* The index that handles_take gives next, which may be the capacity: then the table must grow first. */
uint32_t handles_next(const handle_table *table);
uint64_t handles_take(handle_table *table);
void handles_free(handle_table *table, uint32_t index);

/* The capacity to grow to, from `least` on. */
uint32_t handles_grown(const handle_table *table, uint32_t least);
/* Moves the table into `places`, zeroed, of a larger capacity; returns the old ones. */
handle_place *handles_grow(handle_table *table, handle_place *places, uint32_t capacity);

#endif
