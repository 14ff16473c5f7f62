#include "scene/handles.h"

#include <string.h>

/*
 * A handle: the generation above, then the kind's bit, then the index counted from 1, all of it scrambled by the key.
 * The key is even where the generation is odd, so no handle comes out as 0.
 */
enum { KIND_BIT = 31 };

/* The last step of splitmix64, which spreads every bit over all. */
static uint64_t mix(uint64_t value) {
  value = (value ^ value >> 30) * 0xbf58476d1ce4e5b9u;
  value = (value ^ value >> 27) * 0x94d049bb133111ebu;
  return value ^ value >> 31;
}

uint64_t handles_key(const void *owner, uint64_t clock) {
  const uint64_t key = mix(mix((uint64_t)(uintptr_t)owner) + clock);
  return key & ~((uint64_t)1 << 32);
}

uint32_t handles_find(const handle_table *table, uint64_t handle) {
  const uint32_t index = ((uint32_t)(handle ^ table->key) & ~(1u << KIND_BIT)) - 1;
  const bool known = index < table->count && handles_live(table, index) && handles_at(table, index) == handle;
  return known ? index : UINT32_MAX;
}

bool handles_live(const handle_table *table, uint32_t index) {
  return table->places[index].generation % 2;
}

uint64_t handles_at(const handle_table *table, uint32_t index) {
  const uint64_t plain = (uint64_t)table->places[index].generation << 32 | table->kind << KIND_BIT | (index + 1);
  return plain ^ table->key;
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
