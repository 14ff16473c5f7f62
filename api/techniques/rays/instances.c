#include "techniques/rays/instances.h"

#include "csm_constants.h"
#include "device/clock.h"
#include "device/tree_pool.h"
#include "plan/tree.h"
#include "techniques/rays/ray_record.h"

#include <math.h>
#include <string.h>

enum { node_size = sizeof(tree_node), record_unit = 1024 * node_size };
enum { most_changes = 1024 }; /* up to which records are uploaded one by one */
/* A tree that was fitted to what moved is built anew where a ray has so much more to do. */
static const double most_cost = 1.5;
/* What lies farther away, in metres or steps of the grid, leaves nothing of a float: shaders multiply such numbers. */
static const double farthest = 1e18;

/* Nodes, and from a multiple of record_unit on a record for each slot. */
typedef struct ray_buffer {
  retired retired;
  gpu_buffer *buffer;
  uint64_t size, records; /* bytes; where the records begin */
} ray_buffer;

/* What the tree was made of. */
typedef struct tree_source {
  uint64_t identity, revision;
  uint32_t layers, slots;
} tree_source;

/* The tree in host memory: one block for all arrays. */
typedef struct instance_tree {
  void *block;
  uint32_t capacity; /* slots */
  tree_node *nodes;
  tree_box *boxes; /* of what casts, relative to the anchor */
  uint32_t *order, *slots;
  void *scratch;
  uint32_t count, node_count; /* of what casts; 0: nothing does */
  tree_grid grid;
  double anchor[3];
  double cost; /* when it was built */
} instance_tree;

typedef struct ray_instances_state {
  ray_buffer *now, *fresh;
  instance_tree tree;
  double update_ms;  /* bringing the tree up to date, on the CPU */
  tree_source holds; /* what the buffer holds; identity 0: nothing that may be kept */
  bool draws;        /* the maps have a callback's draws */
  /* of the recording on its way */
  bool writes;
  uint32_t change_count; /* slots whose records are uploaded; 0: all */
  uint32_t changes[most_changes];
  tree_source source;
  ring_range ring;
} ray_instances_state;

/* ---- settings and devices ---- */

static bool wanted(const csm_config *config) {
  return plan_has_rays(config);
}

/* Whether the device can do it. */
static csm_result check(device *device, const csm_config *config) {
  const gpu_format mask = config->history == CSM_HISTORY_ON ? GPU_FORMAT_RG16_UNORM : GPU_FORMAT_R8_UNORM;
  if (!device->trees.wanted)
    return host_fail(device->host, CSM_ERROR_INVALID_STATE,
                     "filter: rays need trees, and the context was made without CSM_CREATE_RAYS");
  if (!device->info.can.compute || !device->info.can.indirect)
    return host_fail(device->host, CSM_ERROR_UNSUPPORTED,
                     "filter: the device cannot compute by indirect dispatches, which rays need");
  if (!(device->info.can.formats[mask] & GPU_CAN_STORE))
    return host_fail(device->host, CSM_ERROR_UNSUPPORTED,
                     "filter: the device's shaders cannot write masks, which rays need (Vulkan: "
                     "shaderStorageImageExtendedFormats)");
  return CSM_SUCCESS;
}

static uint64_t records_at(uint32_t slots) {
  const uint64_t nodes = slots ? tree_nodes_most(slots) * node_size : node_size;
  return (nodes + record_unit - 1) / record_unit * record_unit;
}

static uint64_t bytes_for(uint32_t slots) {
  return records_at(slots) + (uint64_t)(slots ? slots : 1) * RAY_RECORD_SIZE;
}

static csm_result make_buffer(device *device, uint32_t slots, ray_buffer **out) {
  const uint32_t room = slots + slots / 2;
  const uint64_t most = device->info.can.max_texels_size;
  ray_buffer *made = host_allocate(device->host, sizeof *made);
  if (!made)
    return CSM_ERROR_OUT_OF_MEMORY;
  made->records = records_at(room);
  made->size = bytes_for(room);
  csm_result result = made->size <= most
                          ? CSM_SUCCESS
                          : host_fail(device->host, CSM_ERROR_LIMIT_EXCEEDED,
                                      "filter: the tree of %u instances takes more than shaders see at once", slots);
  const gpu_buffer_info info = {.name = "instances' tree",
                                .kind = GPU_BUFFER_DEVICE,
                                .size = made->size,
                                .usage = GPU_BUFFER_READ | GPU_BUFFER_TEXELS};
  if (!result)
    result = device_buffer(device, &info, &made->buffer);
  if (result) {
    host_release(device->host, made);
    return result;
  }
  *out = made;
  return CSM_SUCCESS;
}

/* A buffer of the device's, with room for nothing yet. */
static csm_result make(void *self, device *device, const csm_config *config) {
  const csm_result result = check(device, config);
  return result ? result : make_buffer(device, 0, &((ray_instances_state *)self)->fresh);
}

static void buffer_free(device *device, retired *self) {
  ray_buffer *buffer = (ray_buffer *)self;
  device_buffer_free(device, buffer->buffer, buffer->size);
  host_release(device->host, buffer);
}

static void drop(void *self, device *device) {
  ray_instances_state *state = self;
  if (state->now)
    retire(device, &state->now->retired, buffer_free);
  state->now = NULL;
  state->holds = (tree_source){0};
}

static void adopt(void *self, device *from) {
  ray_instances_state *state = self;
  if (!state->fresh)
    return;
  drop(state, from);
  state->now = state->fresh;
  state->fresh = NULL;
}

static void forget(void *self, device *device) {
  ray_instances_state *state = self;
  if (state->fresh)
    buffer_free(device, &state->fresh->retired);
  state->fresh = NULL;
}

static void end(void *self, host *host) {
  host_release(host, ((ray_instances_state *)self)->tree.block);
}

/* ---- the tree ---- */

static csm_result make_room(instance_tree *tree, host *host, uint32_t slots) {
  if (slots <= tree->capacity)
    return CSM_SUCCESS;
  const uint32_t capacity = slots + slots / 2;
  const size_t nodes = tree_nodes_most(capacity) * sizeof(tree_node), boxes = capacity * sizeof(tree_box);
  const size_t list = capacity * sizeof(uint32_t), scratch = tree_scratch_size(capacity);
  char *block = host_allocate(host, nodes + boxes + 2 * list + scratch + 5 * HOST_CARVED), *at = block;
  if (!block)
    return CSM_ERROR_OUT_OF_MEMORY;
  host_release(host, tree->block);
  *tree = (instance_tree){.block = block, .capacity = capacity};
  tree->nodes = host_carve(&at, nodes);
  tree->boxes = host_carve(&at, boxes);
  tree->order = host_carve(&at, list);
  tree->slots = host_carve(&at, list);
  tree->scratch = host_carve(&at, scratch);
  return CSM_SUCCESS;
}

static bool casts(const plan_instance *instance, uint32_t layers) {
  return plan_casts(instance) && (!layers || !instance->layers || instance->layers & layers);
}

/* Lists what casts; whether that is what was listed before. */
static bool list_casters(instance_tree *tree, const plan_scene *scene, uint32_t layers) {
  uint32_t count = 0;
  bool same = true;
  for (uint32_t slot = 0; slot < scene->slot_count; ++slot)
    if (casts(&scene->instances[slot], layers)) {
      same = same && count < tree->count && tree->slots[count] == slot;
      tree->slots[count++] = slot;
    }
  same = same && count == tree->count;
  tree->count = count;
  return same;
}

static double within_reach(double value) {
  return fmin(fmax(value, -farthest), farthest);
}

/* A float at or below, or above, a number that is within reach. */
static float rounded(double value, float towards) {
  const float near = (float)value;
  const bool beyond = towards < 0.0f ? near <= value : near >= value;
  return beyond ? near : nextafterf(near, towards);
}

static void write_boxes(instance_tree *tree, const plan_scene *scene) {
  for (uint32_t i = 0; i < tree->count; ++i) {
    const plan_box *box = &scene->boxes[tree->slots[i]];
    for (int axis = 0; axis < 3; ++axis) {
      tree->boxes[i].low[axis] = rounded(within_reach(box->low[axis] - tree->anchor[axis]), -INFINITY);
      tree->boxes[i].high[axis] = rounded(within_reach(box->high[axis] - tree->anchor[axis]), INFINITY);
    }
  }
}

/* Leaves of one item each; they name its slot, once `order` has told which one it is. */
static void build(instance_tree *tree, const plan_scene *scene) {
  const plan_box *first = &scene->boxes[tree->slots[0]];
  for (int axis = 0; axis < 3; ++axis)
    tree->anchor[axis] = 0.5 * (first->low[axis] + first->high[axis]);
  write_boxes(tree, scene);
  tree->node_count = tree_build(tree->nodes, tree->order, tree->boxes, tree->count,
                                (tree_shape){.most_items = 1, .item_cost = 4.0f}, tree->scratch);
  tree->cost = tree_fit(tree->nodes, tree->node_count, tree->order, tree->boxes, &tree->grid, tree->scratch);
}

static void update(instance_tree *tree, const plan_scene *scene, uint32_t layers) {
  const bool same = list_casters(tree, scene, layers);
  if (!tree->count) {
    tree->node_count = 0;
    return;
  }
  if (same && tree->node_count) {
    write_boxes(tree, scene);
    const double cost = tree_fit(tree->nodes, tree->node_count, tree->order, tree->boxes, &tree->grid, tree->scratch);
    if (cost <= most_cost * tree->cost)
      return;
  }
  build(tree, scene);
}

/* ---- a frame ---- */

static tree_source source_of(const technique_run *run) {
  const plan_scene *scene = run->scene;
  return (tree_source){.identity = scene->identity,
                       .revision = scene->revision,
                       .layers = run->light_layers,
                       .slots = scene->slot_count};
}

/* A list that comes anew in each frame tells nothing of what it was. */
static bool is_stale(const ray_instances_state *state, const technique_run *run) {
  const tree_source now = source_of(run), *holds = &state->holds;
  return !state->now || !holds->identity || now.identity != holds->identity || now.revision != holds->revision ||
         now.layers != holds->layers || now.slots != holds->slots;
}

/* Whether the buffer holds the same scene, but for a few changes that the journal tells. */
static bool is_near(const ray_instances_state *state, const technique_run *run) {
  const plan_scene *scene = run->scene;
  const tree_source now = source_of(run), *holds = &state->holds;
  return state->now && holds->identity && now.identity == holds->identity && now.layers == holds->layers &&
         now.slots == holds->slots && scene->journal_from <= holds->revision &&
         now.revision - holds->revision <= most_changes;
}

/* The nodes, and records after them: all, or those of a few changes. */
static uint64_t size(const void *self, const technique_run *run) {
  const ray_instances_state *state = self;
  const uint32_t slots = run->scene->slot_count;
  if (!is_stale(state, run))
    return 0;
  return is_near(state, run) ? records_at(slots) + (run->scene->revision - state->holds.revision) * RAY_RECORD_SIZE
                             : bytes_for(slots);
}

/* Each slot that changed, once. */
static void list_changes(ray_instances_state *state, const plan_scene *scene) {
  state->change_count = 0;
  for (uint64_t i = state->holds.revision; i < scene->revision; ++i) {
    const uint32_t slot = scene->journal[i & (scene->journal_size - 1)];
    if (scene->revisions[slot] == i + 1)
      state->changes[state->change_count++] = slot;
  }
}

static bool has_room(const ray_buffer *buffer, uint32_t slots) {
  return buffer && records_at(slots) <= buffer->records &&
         (uint64_t)slots * RAY_RECORD_SIZE <= buffer->size - buffer->records;
}

static csm_result reserve(void *self, technique_run *run, const ring_range *ring) {
  ray_instances_state *state = self;
  const uint32_t slots = run->scene->slot_count;
  const double begin_ms = clock_ms();
  state->draws = run->frame->draw;
  state->writes = is_stale(state, run);
  state->update_ms = 0.0;
  if (!state->writes)
    return CSM_SUCCESS;
  state->source = source_of(run);
  state->ring = *ring;
  state->change_count = 0;
  if (is_near(state, run) && has_room(state->now, slots))
    list_changes(state, run->scene);
  state->holds = (tree_source){0}; /* the tree in host memory becomes another one */
  csm_result result = make_room(&state->tree, run->device->host, slots);
  if (!result && !has_room(state->now, slots))
    result = make_buffer(run->device, slots, &state->fresh);
  if (result)
    return result;
  update(&state->tree, run->scene, run->light_layers);
  state->update_ms = clock_ms() - begin_ms;
  return CSM_SUCCESS;
}

static void write_slot(char *to, const technique_run *run, uint32_t slot) {
  const plan_scene *scene = run->scene;
  const plan_instance *instance = &scene->instances[slot];
  if (casts(instance, run->light_layers))
    ray_record_write(to, instance, &scene->meshes[instance->mesh], run->device->geometry.meshes[instance->mesh].rays);
}

/* Nodes, whose leaves name slots, and records. */
static void write(void *self, const technique_run *run) {
  ray_instances_state *state = self;
  const instance_tree *tree = &state->tree;
  const double begin_ms = clock_ms();
  if (!state->writes)
    return;
  tree_node *nodes = state->ring.memory;
  for (uint32_t i = 0; i < tree->node_count; ++i) {
    nodes[i] = tree->nodes[i];
    if (tree_is_leaf(&nodes[i]))
      nodes[i].link = TREE_LEAF | tree->slots[tree->order[tree_first_item(&nodes[i])]];
  }
  char *records = (char *)state->ring.memory + records_at(run->scene->slot_count);
  for (uint32_t i = 0; i < state->change_count; ++i)
    write_slot(records + (size_t)i * RAY_RECORD_SIZE, run, state->changes[i]);
  for (uint32_t i = 0; i < tree->count && !state->change_count; ++i)
    write_slot(records + (size_t)tree->slots[i] * RAY_RECORD_SIZE, run, tree->slots[i]);
  state->update_ms += clock_ms() - begin_ms;
}

static void record(void *self, const technique_run *run) {
  ray_instances_state *state = self;
  const gpu gpu = run->device->gpu;
  const ray_buffer *to = state->now;
  const ring_range *ring = &state->ring;
  const uint64_t records = ring->offset + records_at(run->scene->slot_count);
  if (!state->writes)
    return;
  if (state->tree.node_count)
    gpu_copy_buffer(gpu, to->buffer, 0, ring->buffer, ring->offset, (uint64_t)state->tree.node_count * node_size);
  for (uint32_t i = 0; i < state->change_count; ++i)
    gpu_copy_buffer(gpu, to->buffer, to->records + (uint64_t)state->changes[i] * RAY_RECORD_SIZE, ring->buffer,
                    records + (uint64_t)i * RAY_RECORD_SIZE, RAY_RECORD_SIZE);
  if (state->tree.node_count && !state->change_count)
    gpu_copy_buffer(gpu, to->buffer, to->records, ring->buffer, records,
                    (uint64_t)run->scene->slot_count * RAY_RECORD_SIZE);
  state->holds = state->source;
}

/* ---- what came of it ---- */

static void tell(const void *self, const device *device, csm_stats *stats) {
  const ray_instances_state *state = self;
  stats->tree_bytes = tree_pool_bytes(device) + (state->now ? state->now->size : 0);
  stats->instance_tree_ms = state->update_ms;
}

gpu_buffer *ray_instances_buffer(const technique_set *cascades) {
  const ray_instances_state *state = technique_state(cascades, &technique_ray_instances);
  return state->now ? state->now->buffer : NULL;
}

void ray_instances_write(const technique_set *cascades, const plan_frame *frame, void *constants) {
  const ray_instances_state *state = technique_state(cascades, &technique_ray_instances);
  const instance_tree *tree = &state->tree;
  csm_rays_block *rays = &((csm_constants *)constants)->rays;
  rays->unsure[2] = state->draws;
  if (!state->now)
    return;
  rays->low[3] = (float)(state->now->records / record_unit);
  rays->scale[3] = (float)tree->node_count;
  for (int axis = 0; axis < 3 && tree->node_count; ++axis) {
    rays->scale[axis] = (float)tree->grid.scale[axis];
    rays->offset[axis] = (float)within_reach((frame->origin[axis] - tree->anchor[axis]) * tree->grid.scale[axis] +
                                             tree->grid.offset[axis]);
  }
}

static void bind(const void *self, device *device, csm_binding *binding) {
  const ray_instances_state *state = self;
  if (!state->now)
    return;
  const tree_held instances = {.buffer = state->now->buffer, .size = state->now->size}, held = tree_pool_held(device);
  const tree_held meshes = held.buffer ? held : instances;
  binding->native_ray_meshes = gpu_buffer_native(device->gpu, meshes.buffer);
  binding->ray_meshes_size = meshes.size;
  binding->native_ray_instances = gpu_buffer_native(device->gpu, instances.buffer);
  binding->ray_instances_size = instances.size;
}

const technique technique_ray_instances = {
    .name = "instances of rays",
    .state_size = sizeof(ray_instances_state),
    .wanted = wanted,
    .make = make,
    .adopt = adopt,
    .forget = forget,
    .drop = drop,
    .end = end,
    .size = size,
    .reserve = reserve,
    .write = write,
    .record = record,
    .bind = bind,
    .tell = tell,
};
