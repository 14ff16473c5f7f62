/* calls_scenes.c: random scenes, their instances, and lists of instances. */
#include "calls_scenes.h"

#include <string.h>

/* ---- instances ---- */

static const spoil_field instance_fields[] = {
    {SPOIL_AT(csm_instance, flags), FIELD_WHOLE, 0},    {SPOIL_AT(csm_instance, mesh), FIELD_LONG, 0},
    {SPOIL_AT(csm_instance, transform), FIELD_REAL, 0}, {SPOIL_AT(csm_instance, layers), FIELD_WHOLE, 0},
    {SPOIL_AT(csm_instance, reserved), FIELD_WHOLE, 0},
};
static const spoil_struct instance_struct = SPOIL_STRUCT(csm_instance, instance_fields);

static void fill_transform(world *w, double m[16]) {
  memset(m, 0, 16 * sizeof *m);
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k)
      m[i * 4 + k] = dice_between(&w->dice, -0.4, 0.4) + (i == k ? 2 : 0);
  if (dice_one_in(&w->dice, 8)) /* mirrored */
    m[0] = -m[0];
  if (dice_one_in(&w->dice, 16)) /* scaled to little, much or nothing */
    m[5] = dice_one_in(&w->dice, 2) ? 0 : dice_scale(&w->dice, 1e-9, 1e9);
  for (int i = 0; i < 3; ++i)
    m[12 + i] = dice_between(&w->dice, -20, 20);
  m[15] = 1;
  if (dice_one_in(&w->dice, 32))
    m[12 + dice_below(&w->dice, 3)] = dice_scale(&w->dice, 1, 1e12);
}

static csm_instance random_instance(world *w) {
  const uint32_t flags = dice_one_in(&w->dice, 3) ? dice_below(&w->dice, 8) : 0;
  csm_instance out = {.struct_size = sizeof out,
                      .flags = flags % 4 == 3 && !dice_one_in(&w->dice, 20) ? 0 : flags,
                      .mesh = world_handle_of(w, w->meshes, WORLD_MESHES),
                      .layers = dice_one_in(&w->dice, 3) ? (uint32_t)dice_bits(&w->dice) : 0};
  fill_transform(w, out.transform);
  return out;
}

uint32_t world_fill_list(world *w, uint32_t most) {
  const uint32_t count = dice_one_in(&w->dice, 10) ? dice_below(&w->dice, WORLD_BATCH) : dice_below(&w->dice, most),
                 sizes[4] = {sizeof(csm_instance), sizeof(csm_instance), offsetof(csm_instance, layers),
                             sizeof(csm_instance) + 16},
                 size = sizes[dice_below(&w->dice, 4)];
  memset(w->list, 0, sizeof w->list);
  for (uint32_t i = 0; i < count; ++i) {
    csm_instance instance = random_instance(w);
    instance.struct_size = size;
    memcpy(w->list + (size_t)i * size, &instance, size < sizeof instance ? size : sizeof instance);
  }
  if (count && dice_one_in(&w->dice, 12)) {
    /* One is not as it should be; its size is at most what the list has room for. */
    spoil_paper *paper = world_write(w, w->list, sizeof(csm_instance));
    const uint32_t which = dice_below(&w->dice, count);
    memcpy(paper->bytes, w->list + (size_t)which * size, size < sizeof(csm_instance) ? size : sizeof(csm_instance));
    spoil(&w->dice, paper, &instance_struct);
    memcpy(w->list + (size_t)which * size, paper->bytes, size < sizeof(csm_instance) ? size : sizeof(csm_instance));
  }
  return count;
}

/* ---- scenes ---- */

static csm_result create_scene(world *w) {
  world_scene *place = &w->scenes[dice_below(&w->dice, WORLD_SCENES)];
  if (place->scene)
    return CSM_SUCCESS;
  csm_scene *made = (csm_scene *)w;
  csm_scene **out = dice_one_in(&w->dice, 20) ? NULL : &made;
  const csm_result result = csm_scene_create(w->context, out);
  if (out)
    assert_true((made != NULL) == !result);
  if (!result)
    place->scene = made; /* the ids of the one before stay, to be used by mistake */
  return result;
}

static csm_result destroy_scene(world *w) {
  world_scene *scene = world_any_scene(w);
  const csm_result result = csm_scene_destroy(scene ? scene->scene : NULL);
  if (!result && scene) {
    w->gone = scene->scene;
    w->looked = w->looked_scene == scene->scene ? NULL : w->looked;
    scene->scene = NULL;
    for (uint32_t i = 0; i < WORLD_IDS; ++i)
      scene->ids[i].live = false;
  }
  return result;
}

static const spoil_field batch_fields[] = {
    {SPOIL_AT(csm_scene_batch, count), FIELD_SMALL, 2},       {SPOIL_AT(csm_scene_batch, ids), FIELD_POINTER, 0},
    {SPOIL_AT(csm_scene_batch, instances), FIELD_POINTER, 0}, {SPOIL_AT(csm_scene_batch, matrices), FIELD_POINTER, 0},
    {SPOIL_AT(csm_scene_batch, rows), FIELD_POINTER, 0},      {SPOIL_AT(csm_scene_batch, origin), FIELD_REAL, 0},
};
static const spoil_struct batch_struct = SPOIL_STRUCT(csm_scene_batch, batch_fields);

/* Transforms beside those of the instances: none, matrices, rows, or by mistake both. */
static void give_transforms(world *w, csm_scene_batch *batch, bool needed) {
  const uint32_t choice = dice_one_in(&w->dice, 30) ? 3
                          : needed                  ? 1 + dice_below(&w->dice, 2)
                                                    : dice_below(&w->dice, 3);
  for (uint32_t i = 0; i < batch->count && choice; ++i)
    fill_transform(w, w->matrices + (size_t)i * 16);
  if (dice_one_in(&w->dice, 16))
    w->matrices[dice_below(&w->dice, 16)] = dice_odd_real(&w->dice, 1);
  for (uint32_t i = 0; i < WORLD_BATCH * 12; ++i)
    w->floats[i] = (float)dice_between(&w->dice, -3, 3);
  if (choice & 1)
    batch->matrices = w->matrices;
  if (choice & 2)
    batch->rows = w->floats;
}

static csm_result add_instances(world *w) {
  world_scene *scene = world_any_scene(w);
  csm_scene_batch good = {.struct_size = sizeof good,
                          .count = world_fill_list(w, 8),
                          .ids = w->ids,
                          .instances = (const csm_instance *)(const void *)w->list};
  give_transforms(w, &good, false);
  const csm_scene_batch *batch = world_risk(w, &good, &batch_struct);
  const csm_result result = csm_scene_add(scene ? scene->scene : NULL, batch);
  for (uint32_t i = 0; !result && batch->struct_size >= 8 && i < batch->count; ++i) {
    world_handle *place = world_place(w, scene->ids, WORLD_IDS);
    if (place)
      *place = (world_handle){w->ids[i], true};
  }
  return result;
}

/* Instances of a scene, of which some may come twice. */
static void choose_ids(world *w, const world_scene *scene, uint32_t count) {
  const uint32_t first = dice_below(&w->dice, WORLD_IDS);
  for (uint32_t i = 0, k = 0; i < count; ++i, ++k) {
    while (scene && k < WORLD_IDS && !scene->ids[(first + k) % WORLD_IDS].live)
      ++k;
    w->ids[i] = scene && k < WORLD_IDS && !dice_one_in(&w->dice, 80)
                    ? scene->ids[(first + k) % WORLD_IDS].value
                    : world_handle_of(w, scene ? scene->ids : w->meshes, scene ? WORLD_IDS : WORLD_MESHES);
  }
}

static csm_result move_instances(world *w) {
  world_scene *scene = world_any_scene(w);
  csm_scene_batch good = {.struct_size = sizeof good, .count = dice_below(&w->dice, 6), .ids = w->ids};
  choose_ids(w, scene, good.count);
  give_transforms(w, &good, true);
  return csm_scene_move(scene ? scene->scene : NULL, world_risk(w, &good, &batch_struct));
}

static csm_result change_instances(world *w) {
  world_scene *scene = world_any_scene(w);
  csm_scene_batch good = {.struct_size = sizeof good,
                          .count = world_fill_list(w, 6),
                          .ids = w->ids,
                          .instances = (const csm_instance *)(const void *)w->list};
  choose_ids(w, scene, good.count);
  give_transforms(w, &good, false);
  return csm_scene_change(scene ? scene->scene : NULL, world_risk(w, &good, &batch_struct));
}

static csm_result remove_instances(world *w) {
  world_scene *scene = world_any_scene(w);
  const uint32_t count = dice_below(&w->dice, 12);
  choose_ids(w, scene, count);
  const csm_instance_id *ids = dice_one_in(&w->dice, 40) ? NULL : w->ids;
  const csm_result result = csm_scene_remove(scene ? scene->scene : NULL, count, ids);
  for (uint32_t i = 0; !result && i < count; ++i)
    for (uint32_t k = 0; k < WORLD_IDS; ++k)
      if (scene->ids[k].live && scene->ids[k].value == w->ids[i])
        scene->ids[k].live = false;
  return result;
}

const world_call calls_scenes[] = {
    {.name = "csm_scene_create", .weight = 20, .call = create_scene},
    {.name = "csm_scene_destroy", .weight = 2, .call = destroy_scene},
    {.name = "csm_scene_add", .weight = 40, .call = add_instances},
    {.name = "csm_scene_move", .weight = 40, .call = move_instances},
    {.name = "csm_scene_change", .weight = 20, .call = change_instances},
    {.name = "csm_scene_remove", .weight = 20, .call = remove_instances},
    {.name = NULL},
};
