#include "world.h"

#include <string.h>

/* ---- the stranger ---- */

static void stranger_open(world_stranger *s) {
  static const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  static const uint16_t indices[3] = {0, 1, 2};
  const csm_mesh_info mesh = {.struct_size = sizeof mesh,
                              .positions = corners,
                              .vertex_count = 3,
                              .indices = indices,
                              .index_count = 3,
                              .index_size = 2};
  csm_config config = support_config();
  config.resolution = 16;
  s->record = (record){.backend = "null", .quiet = true, .allocations_left = -1};
  s->context = support_open(&s->record);
  assert_int_equal(csm_mesh_create(s->context, &mesh, &s->mesh), CSM_SUCCESS);
  assert_int_equal(csm_scene_create(s->context, &s->scene), CSM_SUCCESS);
  const csm_instance instance = support_instance(s->mesh, 0, 0, 0, 1, 1, 1);
  const csm_scene_batch batch = {.struct_size = sizeof batch, .count = 1, .ids = &s->id, .instances = &instance};
  assert_int_equal(csm_scene_add(s->scene, &batch), CSM_SUCCESS);
  assert_int_equal(csm_cascades_create(s->context, &config, &s->cascades), CSM_SUCCESS);
  s->view = support_view(s->context);
}

/* ---- opening and closing ---- */

csm_create_info world_create_info(world *w) {
  csm_create_info info = support_create_info(&w->record);
  info.backend = w->backend;
  info.flags |= CSM_CREATE_KEEP_GEOMETRY | (w->rays ? CSM_CREATE_RAYS : 0);
  info.memory_limit = 64 << 20; /* above what small things take, and below what large ones ask for */
  return info;
}

void world_open(world *w, const char *backend, uint64_t seed, lent *lent) {
  *w = (world){.backend = backend, .dice = {.state = seed}, .answers = 1, .pictures = 1, .lent = lent, .own = !lent};
  w->rays = !dice_one_in(&w->dice, 4);
  w->record = (record){.backend = backend, .quiet = true, .allocations_left = -1};
  stranger_open(&w->stranger);
  csm_create_info info = world_create_info(w);
  if (lent)
    lent_give(lent, &info);
  const csm_result result = csm_create(&info, &w->context);
  if (result)
    fail_msg("csm_create: %s: %s", csm_result_name(result), w->record.said);
}

void world_close(world *w) {
  if (w->lent)
    lent_rest(w->lent);
  csm_destroy(w->stranger.context);
  assert_int_equal(w->stranger.record.blocks, 0);
  support_close(w->context, &w->record);
}

/* ---- looking ---- */

static uint64_t look_at(uint64_t hash, csm_cascades *cascades) {
  csm_stats stats = {.struct_size = sizeof stats};
  csm_binding binding = {.struct_size = sizeof binding};
  assert_int_equal(csm_get_stats(cascades, &stats), CSM_SUCCESS);
  const csm_result bound = csm_bind(cascades, &binding);
  hash = dice_fold(hash, &stats.plan_hash, sizeof stats.plan_hash);
  hash = dice_fold(hash, &stats.instances, sizeof stats.instances);
  hash = dice_fold(hash, &stats.map_bytes, sizeof stats.map_bytes);
  hash = dice_fold(hash, &bound, sizeof bound);
  if (bound)
    return hash;
  hash = dice_fold(hash, binding.cascades, sizeof binding.cascades);
  hash = dice_fold(hash, binding.cascade_constants, binding.cascade_constants_size);
  return dice_fold(hash, binding.setting_constants, binding.setting_constants_size);
}

uint64_t world_looks(world *w) {
  uint64_t hash = 0;
  for (uint32_t i = 0; i < WORLD_CASCADES; ++i)
    if (w->cascades[i].cascades)
      hash = look_at(hash, w->cascades[i].cascades);
  for (uint32_t i = 0; i < WORLD_VIEWS; ++i) {
    csm_view_stats stats = {.struct_size = sizeof stats};
    if (!w->views[i].view)
      continue;
    assert_int_equal(csm_get_view_stats(w->views[i].view, &stats), CSM_SUCCESS);
    hash = dice_fold(hash, &stats.width, sizeof stats.width);
    hash = dice_fold(hash, &stats.height, sizeof stats.height);
    hash = dice_fold(hash, &stats.bytes, sizeof stats.bytes);
  }
  return hash;
}

/* ---- what calls are made of ---- */

void *world_write(world *w, const void *good, size_t size) {
  spoil_paper *paper = &w->papers[w->papers_used++ % WORLD_PAPERS];
  assert_in_range(size, 1, SPOIL_ROOM - SPOIL_TAIL - 16);
  memset(paper->bytes, 0, sizeof paper->bytes);
  memcpy(paper->bytes, good, size);
  return paper->bytes;
}

void *world_risk(world *w, const void *good, const spoil_struct *what) {
  void *written = world_write(w, good, what->size);
  if (dice_one_in(&w->dice, 40))
    return NULL;
  if (dice_one_in(&w->dice, 5))
    spoil(&w->dice, (spoil_paper *)written, what);
  return written;
}

void world_answer(world *w, const void *bytes, size_t size) {
  w->answers = dice_fold(w->answers, bytes, size);
}

void world_plan(world *w, const void *bytes, size_t size) {
  (w->samples ? world_picture : world_answer)(w, bytes, size);
}

void world_picture(world *w, const void *bytes, size_t size) {
  w->pictures = dice_fold(w->pictures, bytes, size);
}

/* A handle that is none here. */
static uint64_t wild_handle(world *w) {
  const world_stranger *s = &w->stranger;
  const uint64_t bits = dice_bits(&w->dice);
  switch (dice_below(&w->dice, 7)) {
  case 0:
    return 0;
  case 1:
    return s->mesh;
  case 2:
    return s->id;
  case 3:
    return w->meshes[dice_below(&w->dice, WORLD_MESHES)].value ^ 1ull << dice_below(&w->dice, 64);
  case 4:
    return w->meshes[dice_below(&w->dice, WORLD_MESHES)].value;
  case 5:
    return w->alpha_masks[dice_below(&w->dice, WORLD_ALPHA_MASKS)].value;
  default:
    return bits;
  }
}

uint64_t world_handle_of(world *w, const world_handle *handles, uint32_t count) {
  const uint32_t first = dice_below(&w->dice, count);
  const bool careless = dice_one_in(&w->dice, 24);
  if (dice_one_in(&w->dice, 24))
    return wild_handle(w);
  for (uint32_t i = 0; i < count && !careless; ++i)
    if (handles[(first + i) % count].live)
      return handles[(first + i) % count].value;
  return handles[first].value;
}

world_handle *world_place(world *w, world_handle *handles, uint32_t count) {
  const uint32_t first = dice_below(&w->dice, count);
  for (uint32_t i = 0; i < count; ++i)
    if (!handles[(first + i) % count].live)
      return &handles[(first + i) % count];
  return NULL;
}

/* Of a table's elements, which begin with a pointer: the first that has one, from anywhere on. */
static void *any_live(world *w, void *table, uint32_t count, size_t size) {
  const uint32_t first = dice_below(&w->dice, count);
  const bool none = dice_one_in(&w->dice, 60);
  for (uint32_t i = 0; i < count && !none; ++i) {
    char *element = (char *)table + (first + i) % count * size;
    const void *pointer;
    memcpy(&pointer, element, sizeof pointer);
    if (pointer)
      return element;
  }
  return NULL;
}

world_scene *world_any_scene(world *w) {
  return any_live(w, w->scenes, WORLD_SCENES, sizeof w->scenes[0]);
}

world_cascades *world_any_cascades(world *w) {
  return any_live(w, w->cascades, WORLD_CASCADES, sizeof w->cascades[0]);
}

world_view *world_any_view(world *w) {
  return any_live(w, w->views, WORLD_VIEWS, sizeof w->views[0]);
}

static bool is_live(const world *w, const void *pointer) {
  bool live = false;
  for (uint32_t i = 0; i < WORLD_SCENES; ++i)
    live = live || pointer == w->scenes[i].scene;
  for (uint32_t i = 0; i < WORLD_CASCADES; ++i)
    live = live || pointer == w->cascades[i].cascades;
  for (uint32_t i = 0; i < WORLD_VIEWS; ++i)
    live = live || pointer == w->views[i].view;
  return live;
}

void *world_wild(world *w) {
  switch (dice_below(&w->dice, 5)) {
  case 0:
    return w->stranger.scene;
  case 1:
    return w->stranger.cascades;
  case 2:
    return w->stranger.view;
  case 3:
    return w;
  default:
    return is_live(w, w->gone) ? w : w->gone; /* its memory may have been given out again */
  }
}

/* ---- the calls ---- */

static uint32_t weight_of(const world *w, const world_call *call) {
  return call->weight + (w->lent ? call->engine_weight : 0);
}

const world_call *world_choose(world *w) {
  static const world_call *const tables[] = {calls_assets, calls_scenes,    calls_cascades,
                                             calls_frames, calls_questions, calls_context};
  enum { TABLES = sizeof tables / sizeof tables[0] };
  uint32_t all = 0;
  for (int i = 0; i < TABLES; ++i)
    for (const world_call *call = tables[i]; call->name; ++call)
      all += weight_of(w, call);
  uint32_t at = dice_below(&w->dice, all);
  for (int i = 0; i < TABLES; ++i)
    for (const world_call *call = tables[i]; call->name; ++call) {
      if (at < weight_of(w, call))
        return call;
      at -= weight_of(w, call);
    }
  return NULL;
}
