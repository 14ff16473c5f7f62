#include "handles.h"

#include <string.h>

/* A handle: the generation above, then the kind's bit, then the index counted from 1, so that 0 is none. */
enum { KIND_BIT = 31 };

uint32_t handles_find(const handle_table *table, uint64_t handle) {
  const uint32_t index = ((uint32_t)handle & ~(1u << KIND_BIT)) - 1;
  const bool known = index < table->count && handles_live(table, index) && handles_at(table, index) == handle;
  return known ? index : UINT32_MAX;
}

bool handles_live(const handle_table *table, uint32_t index) {
  return table->places[index].generation % 2;
}

uint64_t handles_at(const handle_table *table, uint32_t index) {
  return (uint64_t)table->places[index].generation << 32 | table->kind << KIND_BIT | (index + 1);
}

uint32_t handles_next(const handle_table *table) {
  return table->first_free ? table->first_free - 1 : table->count;
}

uint64_t handles_take(handle_table *table) {
  const uint32_t index = handles_next(table);
  handle_place *place = &table->places[index];
  if (table->first_free)
    table->first_free = place->next_free;
  else
    ++table->count;
  ++place->generation;
  return handles_at(table, index);
}

void handles_free(handle_table *table, uint32_t index) {
  handle_place *place = &table->places[index];
  ++place->generation;
  place->next_free = table->first_free;
  table->first_free = index + 1;
}

uint32_t handles_grown(const handle_table *table, uint32_t least) {
  return table->capacity ? table->capacity * 2 : least;
}

handle_place *handles_grow(handle_table *table, handle_place *places, uint32_t capacity) {
  handle_place *old = table->places;
  if (table->count)
    memcpy(places, old, table->count * sizeof *places);
  table->places = places;
  table->capacity = capacity;
  return old;
}
