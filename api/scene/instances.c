/* instances.c: the store of a scene's instances. */
#include "scene/instances.h"

#include <math.h>
#include <string.h>

enum { least_capacity = 64, most_instances = INT32_MAX - 1, alignment = 64 };

static csm_result fail(instances_error *error, csm_result result, uint32_t index, const char *text) {
  *error = (instances_error){.index = index, .text = text};
  return result;
}

/* ---- memory ---- */

void instances_begin(instances *store, const instances_memory *memory, uint64_t key) {
  *store = (instances){.memory = *memory, .ids.key = key};
}

void instances_end(instances *store, const instances_meshes *meshes) {
  for (uint32_t slot = 0; meshes && !store->refilled && slot < store->ids.count; ++slot)
    if (!(store->slots[slot].flags & PLAN_FREE))
      --meshes->users[store->slots[slot].mesh];
  if (store->block)
    store->memory.release(store->memory.user, store->block);
  if (store->firsts)
    store->memory.release(store->memory.user, store->firsts);
  *store = (instances){.memory = store->memory, .ids.key = store->ids.key};
}

/* Takes an array of the capacity off a block, and copies what there was. */
static void *carve(char **at, uint32_t capacity, size_t size, const void *old, uint32_t count) {
  void *array = *at;
  *at += ((size_t)capacity * size + alignment - 1) / alignment * alignment;
  if (count)
    memcpy(array, old, count * size);
  return array;
}

static csm_result check_limit(uint64_t wanted, instances_error *error) {
  return wanted <= most_instances ? CSM_SUCCESS
                                  : fail(error, CSM_ERROR_LIMIT_EXCEEDED, 0, "there are too many instances");
}

/* Makes room for so many instances in all, which are within the limit. */
static csm_result reserve(instances *store, uint32_t wanted, instances_error *error) {
  uint32_t capacity = store->ids.capacity ? store->ids.capacity : least_capacity;
  while (capacity < wanted)
    capacity *= 2;
  if (capacity == store->ids.capacity)
    return CSM_SUCCESS;
  const size_t each = sizeof(plan_instance) + sizeof(plan_box) + sizeof(handle_place) + sizeof(uint64_t) +
                      4 * sizeof(uint32_t); /* a capacity of 64 or more leaves no gaps */
  char *at = store->memory.allocate(store->memory.user, capacity * each, alignment);
  if (!at)
    return fail(error, CSM_ERROR_OUT_OF_MEMORY, 0, "there is no memory for more instances");
  memset(at, 0, capacity * each);
  void *old = store->block;
  const uint32_t count = store->ids.count;
  store->block = at;
  store->slots = carve(&at, capacity, sizeof *store->slots, store->slots, count);
  store->boxes = carve(&at, capacity, sizeof *store->boxes, store->boxes, count);
  handles_grow(&store->ids, carve(&at, capacity, sizeof(handle_place), NULL, 0), capacity);
  store->revisions = carve(&at, capacity, sizeof *store->revisions, store->revisions, count);
  store->stamps = carve(&at, capacity, sizeof *store->stamps, store->stamps, count);
  store->journal = carve(&at, capacity, sizeof *store->journal, NULL, 0);
  store->journal_from = store->revision;
  store->next = carve(&at, capacity, sizeof *store->next, store->next, count);
  store->previous = carve(&at, capacity, sizeof *store->previous, store->previous, count);
  if (old)
    store->memory.release(store->memory.user, old);
  return CSM_SUCCESS;
}

/* Makes room for the chains of all meshes. */
static csm_result reserve_chains(instances *store, const instances_meshes *meshes, instances_error *error) {
  const uint32_t capacity = meshes->handles->capacity;
  if (capacity <= store->meshes)
    return CSM_SUCCESS;
  const size_t size = (capacity * sizeof *store->firsts + alignment - 1) / alignment * alignment;
  uint32_t *firsts = store->memory.allocate(store->memory.user, size, alignment);
  if (!firsts)
    return fail(error, CSM_ERROR_OUT_OF_MEMORY, 0, "there is no memory for more meshes");
  memset(firsts, 0, size);
  if (store->firsts) {
    memcpy(firsts, store->firsts, store->meshes * sizeof *firsts);
    store->memory.release(store->memory.user, store->firsts);
  }
  store->firsts = firsts;
  store->meshes = capacity;
  return CSM_SUCCESS;
}

/* ---- the chain of a mesh's instances ---- */

static void chain(instances *store, uint32_t slot, uint32_t mesh) {
  const uint32_t first = store->firsts[mesh];
  store->previous[slot] = 0;
  store->next[slot] = first;
  if (first)
    store->previous[first - 1] = slot + 1;
  store->firsts[mesh] = slot + 1;
}

static void unchain(instances *store, uint32_t slot, uint32_t mesh) {
  const uint32_t next = store->next[slot], previous = store->previous[slot];
  if (next)
    store->previous[next - 1] = previous;
  if (previous)
    store->next[previous - 1] = next;
  else
    store->firsts[mesh] = next;
}

/* ---- reading a batch ---- */

static uint32_t read_uint(const instances_column *column, uint32_t index) {
  uint32_t value;
  memcpy(&value, (const char *)column->first + index * column->stride, sizeof value);
  return value;
}

static uint64_t read_handle(const instances_column *column, uint32_t index) {
  uint64_t value;
  memcpy(&value, (const char *)column->first + index * column->stride, sizeof value);
  return value;
}

/* Three rows of four. NOT_FINITE: any of a 4x4's sixteen; INVALID_MATRIX: its last row is not 0 0 0 1. */
static csm_result read_rows(double rows[12], const instances_transforms *from, uint32_t index) {
  const double last_row = 1e-6; /* an engine that inverts matrices in floats leaves as much there */
  const char *at = (const char *)from->first + index * from->stride;
  if (from->floats) {
    float given[12];
    memcpy(given, at, sizeof given);
    if (!plan_finite_floats(given, 12) || !plan_finite(from->origin, 3))
      return CSM_ERROR_NOT_FINITE;
    for (int i = 0; i < 12; ++i)
      rows[i] = given[i] + (i % 4 == 3 ? from->origin[i / 4] : 0.0);
    return CSM_SUCCESS;
  }
  double m[16];
  memcpy(m, at, sizeof m);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      rows[row * 4 + column] = m[column * 4 + row];
  const double last[4] = {m[3], m[7], m[11], m[15]};
  if (!plan_finite(m, 16))
    return CSM_ERROR_NOT_FINITE;
  for (int column = 0; column < 4; ++column)
    if (fabs(last[column] - (column == 3)) > last_row)
      return CSM_ERROR_INVALID_MATRIX;
  return CSM_SUCCESS;
}

static csm_result take_transform(plan_instance *instance, const instances_transforms *from, uint32_t index,
                                 instances_error *error) {
  const csm_result read = read_rows(instance->transform, from, index);
  const csm_result result = read ? read : plan_instance_check(instance);
  return !result ? CSM_SUCCESS
                 : fail(error, result, index,
                        result == CSM_ERROR_NOT_FINITE ? "the transform is not finite"
                        : read                         ? "the transform is not affine"
                                                       : "the transform has numbers above 1e30");
}

/* Changes an instance as the batch says; it is spoilt after an error. */
static csm_result take(plan_instance *instance, const instances_meshes *meshes, const instances_batch *batch,
                       uint32_t index, instances_error *error) {
  if (batch->meshes.first) {
    instance->mesh = handles_find(meshes->handles, read_handle(&batch->meshes, index));
    if (instance->mesh == UINT32_MAX)
      return fail(error, CSM_ERROR_INVALID_HANDLE, index, "the mesh does not exist");
  }
  if (batch->flags.first) {
    const uint32_t flags = read_uint(&batch->flags, index);
    if (flags & ~(uint32_t)PLAN_FLAGS)
      return fail(error, CSM_ERROR_INVALID_VALUE, index, "there are unknown flags");
    if (flags & PLAN_CASTS_ONLY && flags & PLAN_RECEIVES_ONLY)
      return fail(error, CSM_ERROR_INVALID_VALUE, index, "flags say both that it only casts and that it only receives");
    instance->flags = flags | (instance->flags & PLAN_DEGENERATE);
  }
  if (batch->layers.first)
    instance->layers = read_uint(&batch->layers, index);
  return batch->transforms.first ? take_transform(instance, &batch->transforms, index, error) : CSM_SUCCESS;
}

/* ---- changing slots ---- */

static void note_change(instances *store, uint32_t slot) {
  const uint32_t capacity = store->ids.capacity;
  store->journal[store->revision++ & (capacity - 1)] = slot;
  store->revisions[slot] = store->revision;
  if (store->revision - store->journal_from > capacity)
    store->journal_from = store->revision - capacity;
}

static void count_instance(instances *store, const plan_instance *instance, uint32_t change) {
  store->casters += plan_casts(instance) ? change : 0;
  store->receivers += plan_receives(instance) ? change : 0;
}

static void put(instances *store, const instances_meshes *meshes, uint32_t slot, const plan_instance *instance) {
  store->slots[slot] = *instance;
  plan_instance_box(&store->boxes[slot], instance, &meshes->bounds[instance->mesh]);
  count_instance(store, instance, 1);
}

/* ---- batches ---- */

csm_result instances_add(instances *store, const instances_meshes *meshes, const instances_batch *batch, uint64_t *ids,
                         instances_error *error) {
  plan_instance made;
  if (batch->count && (!batch->transforms.first || !batch->meshes.first || !ids))
    return fail(error, CSM_ERROR_NULL_POINTER, 0, "there are no transforms, no meshes, or no room for ids");
  csm_result result = check_limit((uint64_t)store->live + batch->count, error);
  for (uint32_t i = 0; i < batch->count && !result; ++i) {
    made = (plan_instance){0};
    result = take(&made, meshes, batch, i, error);
  }
  if (!result)
    result = reserve_chains(store, meshes, error);
  if (!result)
    result = reserve(store, store->live + batch->count, error);
  if (result)
    return result;
  for (uint32_t i = 0; i < batch->count; ++i) {
    made = (plan_instance){0};
    (void)take(&made, meshes, batch, i, error); /* as checked above */
    const uint32_t slot = handles_next(&store->ids);
    ids[i] = handles_take(&store->ids);
    put(store, meshes, slot, &made);
    note_change(store, slot);
    chain(store, slot, made.mesh);
    ++meshes->users[made.mesh];
  }
  store->live += batch->count;
  return CSM_SUCCESS;
}

csm_result instances_change(instances *store, const instances_meshes *meshes, const instances_batch *batch,
                            instances_error *error) {
  plan_instance made;
  if (batch->count && !batch->ids)
    return fail(error, CSM_ERROR_NULL_POINTER, 0, "there are no ids");
  for (uint32_t i = 0; i < batch->count; ++i) {
    const uint32_t slot = instances_find(store, batch->ids[i]);
    if (slot == UINT32_MAX)
      return fail(error, CSM_ERROR_INVALID_HANDLE, i, "the instance does not exist");
    made = store->slots[slot];
    const csm_result result = take(&made, meshes, batch, i, error);
    if (result)
      return result;
  }
  const csm_result result = batch->meshes.first ? reserve_chains(store, meshes, error) : CSM_SUCCESS;
  if (result)
    return result;
  for (uint32_t i = 0; i < batch->count; ++i) {
    const uint32_t slot = instances_find(store, batch->ids[i]);
    plan_instance *const old = &store->slots[slot];
    made = *old;
    (void)take(&made, meshes, batch, i, error); /* as checked above */
    if (memcmp(old, &made, sizeof made) == 0)
      continue;
    if (old->mesh != made.mesh) {
      unchain(store, slot, old->mesh);
      chain(store, slot, made.mesh);
      --meshes->users[old->mesh];
      ++meshes->users[made.mesh];
    }
    count_instance(store, old, UINT32_MAX);
    put(store, meshes, slot, &made);
    note_change(store, slot);
  }
  return CSM_SUCCESS;
}

/* Stamps every slot of a batch that removes. */
static csm_result check_removal(instances *store, const instances_batch *batch, instances_error *error) {
  if (batch->count && !batch->ids)
    return fail(error, CSM_ERROR_NULL_POINTER, 0, "there are no ids");
  if (++store->stamp == 0) {
    memset(store->stamps, 0, store->ids.capacity * sizeof *store->stamps);
    store->stamp = 1;
  }
  for (uint32_t i = 0; i < batch->count; ++i) {
    const uint32_t slot = instances_find(store, batch->ids[i]);
    if (slot == UINT32_MAX)
      return fail(error, CSM_ERROR_INVALID_HANDLE, i, "the instance does not exist");
    if (store->stamps[slot] == store->stamp)
      return fail(error, CSM_ERROR_INVALID_HANDLE, i, "the instance comes twice");
    store->stamps[slot] = store->stamp;
  }
  return CSM_SUCCESS;
}

csm_result instances_remove(instances *store, const instances_meshes *meshes, const instances_batch *batch,
                            instances_error *error) {
  const csm_result result = check_removal(store, batch, error);
  if (result)
    return result;
  for (uint32_t i = 0; i < batch->count; ++i) {
    const uint32_t slot = instances_find(store, batch->ids[i]);
    --meshes->users[store->slots[slot].mesh];
    unchain(store, slot, store->slots[slot].mesh);
    count_instance(store, &store->slots[slot], UINT32_MAX);
    store->slots[slot].flags = PLAN_FREE;
    handles_free(&store->ids, slot);
    note_change(store, slot);
  }
  store->live -= batch->count;
  return CSM_SUCCESS;
}

csm_result instances_replace(instances *store, const instances_meshes *meshes, const instances_batch *batch,
                             instances_error *error) {
  store->refilled = true;
  store->live = store->casters = store->receivers = 0;
  if (batch->count && (!batch->transforms.first || !batch->meshes.first))
    return fail(error, CSM_ERROR_NULL_POINTER, 0, "there are no transforms, or no meshes");
  csm_result result = check_limit(batch->count, error);
  if (!result)
    result = reserve(store, batch->count, error);
  for (uint32_t i = 0; i < batch->count && !result; ++i) {
    plan_instance made = {0};
    result = take(&made, meshes, batch, i, error);
    if (!result)
      put(store, meshes, i, &made);
  }
  if (result)
    store->casters = store->receivers = 0;
  else
    store->live = batch->count;
  return result;
}

void instances_mesh_changed(instances *store, const instances_meshes *meshes, uint32_t mesh) {
  for (uint32_t at = mesh < store->meshes ? store->firsts[mesh] : 0; at; at = store->next[at - 1]) {
    plan_instance_box(&store->boxes[at - 1], &store->slots[at - 1], &meshes->bounds[mesh]);
    note_change(store, at - 1);
  }
}

/* ---- looking ---- */

uint32_t instances_find(const instances *store, uint64_t id) {
  return handles_find(&store->ids, id);
}

uint32_t instances_changed_since(const instances *store, uint64_t revision) {
  uint32_t changed = 0;
  if (revision < store->journal_from) { /* the journal does not reach back so far */
    for (uint32_t slot = 0; slot < store->ids.count; ++slot)
      changed += store->revisions[slot] > revision;
    return changed;
  }
  for (uint64_t i = revision; i < store->revision; ++i) /* each slot by its last change */
    changed += store->revisions[store->journal[i & (store->ids.capacity - 1)]] == i + 1;
  return changed;
}

plan_scene instances_scene(const instances *store, const instances_meshes *meshes) {
  return (plan_scene){.instances = store->slots,
                      .boxes = store->boxes,
                      .revisions = store->revisions,
                      .slot_count = store->refilled ? store->live : store->ids.count,
                      .caster_count = store->casters,
                      .receiver_count = store->receivers,
                      .meshes = meshes->bounds,
                      .parts = meshes->parts,
                      .mesh_count = meshes->handles->count,
                      .identity = store->refilled ? 0 : store->ids.key,
                      .revision = store->revision,
                      .journal_from = store->journal_from,
                      .journal = store->journal,
                      .journal_size = store->ids.capacity};
}
