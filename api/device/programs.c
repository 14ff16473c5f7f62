#include "device/device.h"

#include <string.h>

typedef struct program_entry {
  retired retired;
  gpu_program *program;
  program_make make;
  unsigned char about[PROGRAM_KEY_BYTES];
  size_t size;
  uint32_t users;
  bool stays; /* somebody found it, who gives nothing back */
} program_entry;

/* ---- the table ---- */

/* FNV-1a. */
static uint64_t hash(const void *bytes, size_t size) {
  uint64_t value = 14695981039346656037u;
  for (size_t i = 0; i < size; ++i)
    value = (value ^ ((const unsigned char *)bytes)[i]) * 1099511628211u;
  return value;
}

static bool same(const program_entry *entry, const program_key *key) {
  return entry->make == key->make && entry->size == key->size &&
         (!key->size || memcmp(entry->about, key->about, key->size) == 0);
}

/* Where a key's entry is, or would be. */
static uint32_t place_of(const programs *programs, const program_key *key) {
  uint32_t place = (uint32_t)hash(key->about, key->size) & (programs->capacity - 1);
  while (programs->entries[place] && !same(programs->entries[place], key))
    place = (place + 1) & (programs->capacity - 1);
  return place;
}

static program_key key_of(const program_entry *entry) {
  return (program_key){.make = entry->make, .about = entry->about, .size = entry->size};
}

static csm_result reserve_place(device *device) {
  programs *old = &device->programs;
  if ((old->count + 1) * 4 <= old->capacity * 3)
    return CSM_SUCCESS;
  programs grown = {.capacity = old->capacity ? old->capacity * 2 : 32, .count = old->count};
  grown.entries = host_allocate(device->host, grown.capacity * sizeof(program_entry *));
  if (!grown.entries)
    return CSM_ERROR_OUT_OF_MEMORY;
  for (uint32_t i = 0; i < old->capacity; ++i) {
    if (!old->entries[i])
      continue;
    const program_key key = key_of(old->entries[i]);
    grown.entries[place_of(&grown, &key)] = old->entries[i];
  }
  host_release(device->host, old->entries);
  *old = grown;
  return CSM_SUCCESS;
}

/* Those that follow close up, so that a search never stops at a gap. */
static void remove_at(programs *programs, uint32_t place) {
  programs->entries[place] = NULL;
  --programs->count;
  const uint32_t mask = programs->capacity - 1;
  for (uint32_t next = (place + 1) & mask; programs->entries[next]; next = (next + 1) & mask) {
    program_entry *entry = programs->entries[next];
    const program_key key = key_of(entry);
    programs->entries[next] = NULL;
    programs->entries[place_of(programs, &key)] = entry;
  }
}

/* ---- entries ---- */

static void entry_free(device *device, retired *self) {
  program_entry *entry = (program_entry *)self;
  gpu_program_destroy(device->gpu, entry->program);
  host_release(device->host, entry);
}

static csm_result entry_make(device *device, const program_key *key, program_entry **out) {
  csm_result result = reserve_place(device);
  program_entry *entry = result ? NULL : host_allocate(device->host, sizeof *entry);
  if (!entry)
    return CSM_ERROR_OUT_OF_MEMORY;
  entry->make = key->make;
  entry->size = key->size;
  if (key->size)
    memcpy(entry->about, key->about, key->size);
  result = device_check(device, key->make(device->gpu, key->about, &entry->program), key->name);
  if (result) {
    host_release(device->host, entry);
    return result;
  }
  device->programs.entries[place_of(&device->programs, key)] = entry;
  ++device->programs.count;
  *out = entry;
  return CSM_SUCCESS;
}

static csm_result find(device *device, const program_key *key, program_entry **out) {
  const programs *programs = &device->programs;
  *out = programs->capacity ? programs->entries[place_of(programs, key)] : NULL;
  return *out ? CSM_SUCCESS : entry_make(device, key, out);
}

csm_result programs_find(device *device, const program_key *key, gpu_program **out) {
  program_entry *entry;
  const csm_result result = find(device, key, &entry);
  if (result)
    return result;
  entry->stays = true;
  *out = entry->program;
  return CSM_SUCCESS;
}

csm_result programs_take(device *device, const program_key *key, gpu_program **out) {
  program_entry *entry;
  const csm_result result = find(device, key, &entry);
  if (result)
    return result;
  ++entry->users;
  *out = entry->program;
  return CSM_SUCCESS;
}

void programs_give_back(device *device, const gpu_program *program) {
  programs *programs = &device->programs;
  for (uint32_t i = 0; i < programs->capacity && program; ++i) {
    program_entry *entry = programs->entries[i];
    if (!entry || entry->program != program)
      continue;
    if (--entry->users || entry->stays)
      return;
    remove_at(programs, i);
    retire(device, &entry->retired, entry_free);
    return;
  }
}

void programs_destroy(device *device) {
  programs *programs = &device->programs;
  for (uint32_t i = 0; i < programs->capacity; ++i)
    if (programs->entries[i])
      entry_free(device, &programs->entries[i]->retired);
  host_release(device->host, programs->entries);
}
