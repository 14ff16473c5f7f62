#include "scene/scene.h"

#include "device/clock.h"
#include "structs.h"
#include <string.h>

/* A store of the host's memory; no other one has its key. */
static void begin_store(assets *assets, instances *store, const void *owner) {
  const host *host = assets->host;
  const instances_memory memory = {.allocate = host->allocate, .release = host->release, .user = host->user};
  uint64_t ticks;
  const double now = clock_ms();
  memcpy(&ticks, &now, sizeof ticks);
  instances_begin(store, &memory, handles_key(owner, ticks));
}

csm_result scene_create(assets *assets, csm_context *context, csm_scene **out) {
  csm_scene *scene = host_allocate(assets->host, sizeof *scene);
  if (!scene)
    return CSM_ERROR_OUT_OF_MEMORY;
  scene->context = context;
  scene->assets = assets;
  begin_store(assets, &scene->store, scene);
  scene->next = assets->scenes;
  scene->link = &assets->scenes;
  if (scene->next)
    scene->next->link = &scene->next;
  assets->scenes = scene;
  *out = scene;
  return CSM_SUCCESS;
}

void scene_destroy(csm_scene *scene) {
  const instances_meshes meshes = assets_meshes(scene->assets);
  *scene->link = scene->next;
  if (scene->next)
    scene->next->link = scene->link;
  instances_end(&scene->store, &meshes);
  host_release(scene->assets->host, scene);
}

bool scene_known(const assets *assets, const csm_scene *scene) {
  const csm_scene *known = assets->scenes;
  while (known && known != scene)
    known = known->next;
  return known;
}

/* ---- reading what the caller gives ---- */

static csm_result fail_batch(host *host, csm_result result, const char *what, const instances_error *error) {
  if (result == CSM_ERROR_OUT_OF_MEMORY)
    return host_fail(host, result, "%s: out of memory", what);
  return result ? host_fail(host, result, "%s %u: %s", what, error->index, error->text) : CSM_SUCCESS;
}

enum { least_instance = offsetof(csm_instance, layers) }; /* the first header's struct */

/* Checks the structs of a list, which all have the first one's size. */
static csm_result check_structs(host *host, const csm_instance *list, uint32_t count) {
  const char *next = (const char *)list;
  uint32_t stride = 0;
  for (uint32_t i = 0; i < count; ++i, next += stride) {
    csm_instance own;
    uint32_t size;
    memcpy(&size, next, sizeof size);
    csm_result result = struct_read(&own, sizeof own, next);
    if (!result && (size < least_instance || (i && size != stride)))
      result = CSM_ERROR_STRUCT_SIZE;
    if (result)
      return host_fail(host, result, "instance %u: a struct_size that is no csm_instance's, or not the first's", i);
    if (own.reserved)
      return host_fail(host, CSM_ERROR_INVALID_VALUE, "instance %u: reserved is not 0", i);
    stride = size;
  }
  return CSM_SUCCESS;
}

static const uint32_t no_layers;

/* The columns of a list whose structs have been checked. Those of an older header end before the layers. */
static instances_batch list_batch(const csm_instance *list, uint32_t count) {
  if (!count)
    return (instances_batch){0};
  const char *first = (const char *)list;
  const size_t stride = list->struct_size;
  const bool has_layers = stride >= offsetof(csm_instance, layers) + sizeof list->layers;
  return (instances_batch){
      .count = count,
      .transforms = {.first = first + offsetof(csm_instance, transform), .stride = stride},
      .meshes = {.first = first + offsetof(csm_instance, mesh), .stride = stride},
      .flags = {.first = first + offsetof(csm_instance, flags), .stride = stride},
      .layers = {.first = has_layers ? (const void *)(first + offsetof(csm_instance, layers)) : &no_layers,
                 .stride = has_layers ? stride : 0},
  };
}

csm_result scene_take_list(assets *assets, instances *store, const csm_instance *list, uint32_t count) {
  const instances_meshes meshes = assets_meshes(assets);
  instances_error error = {0};
  if (!store->memory.allocate)
    begin_store(assets, store, store);
  csm_result result = check_structs(assets->host, list, count);
  if (result)
    return result;
  const instances_batch batch = list_batch(list, count);
  result = instances_replace(store, &meshes, &batch, &error);
  return fail_batch(assets->host, result, "instance", &error);
}

plan_scene scene_of(const assets *assets, const instances *store) {
  const instances_meshes meshes = assets_meshes(assets);
  return instances_scene(store, &meshes);
}

/* Transforms that a batch gives besides its instances take the place of theirs. */
static void take_transforms(instances_transforms *transforms, const csm_scene_batch *batch) {
  if (batch->matrices)
    *transforms = (instances_transforms){.first = batch->matrices, .stride = 16 * sizeof(double)};
  if (batch->rows)
    *transforms = (instances_transforms){.first = batch->rows,
                                         .stride = 12 * sizeof(float),
                                         .floats = true,
                                         .origin = {batch->origin[0], batch->origin[1], batch->origin[2]}};
}

/* What a call reads of its batch. */
static csm_result read_batch(csm_scene *scene, const csm_scene_batch *in, bool moves, instances_batch *out) {
  host *host = scene->assets->host;
  csm_scene_batch own;
  csm_result result = host_check_struct(host, struct_read(&own, sizeof own, in), "csm_scene_batch");
  if (result)
    return result;
  const char *missing = !own.count                            ? NULL
                        : !own.ids                            ? "ids"
                        : !moves && !own.instances            ? "instances"
                        : moves && !own.matrices && !own.rows ? "matrices, and rows,"
                                                              : NULL;
  if (missing)
    return host_fail(host, CSM_ERROR_NULL_POINTER, "csm_scene_batch: %s is NULL", missing);
  if ((own.matrices && own.rows) || (moves && own.instances))
    return host_fail(host, CSM_ERROR_INVALID_VALUE, "csm_scene_batch: transforms are given twice");
  if (!moves)
    result = check_structs(host, own.instances, own.count);
  if (result)
    return result;
  *out = moves ? (instances_batch){.count = own.count} : list_batch(own.instances, own.count);
  out->ids = own.ids;
  take_transforms(&out->transforms, &own);
  return CSM_SUCCESS;
}

/* ---- the calls ---- */

csm_result scene_add(csm_scene *scene, const csm_scene_batch *in) {
  const instances_meshes meshes = assets_meshes(scene->assets);
  instances_error error = {0};
  instances_batch batch;
  csm_result result = read_batch(scene, in, false, &batch);
  if (result)
    return result;
  result = instances_add(&scene->store, &meshes, &batch, (uint64_t *)batch.ids, &error);
  return fail_batch(scene->assets->host, result, "instance", &error);
}

static csm_result change(csm_scene *scene, const csm_scene_batch *in, bool moves) {
  const instances_meshes meshes = assets_meshes(scene->assets);
  instances_error error = {0};
  instances_batch batch;
  csm_result result = read_batch(scene, in, moves, &batch);
  if (result)
    return result;
  result = instances_change(&scene->store, &meshes, &batch, &error);
  return fail_batch(scene->assets->host, result, "instance", &error);
}

csm_result scene_move(csm_scene *scene, const csm_scene_batch *batch) {
  return change(scene, batch, true);
}

csm_result scene_change(csm_scene *scene, const csm_scene_batch *batch) {
  return change(scene, batch, false);
}

csm_result scene_remove(csm_scene *scene, uint32_t count, const csm_instance_id *ids) {
  host *host = scene->assets->host;
  const instances_meshes meshes = assets_meshes(scene->assets);
  const instances_batch batch = {.count = count, .ids = ids};
  instances_error error = {0};
  if (count && !ids)
    return host_fail(host, CSM_ERROR_NULL_POINTER, "ids is NULL");
  return fail_batch(host, instances_remove(&scene->store, &meshes, &batch, &error), "instance", &error);
}
