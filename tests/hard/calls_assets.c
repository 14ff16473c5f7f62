/* calls_assets.c: random meshes and alpha masks. */
#include "world.h"

#include <math.h>
#include <string.h>

/* ---- alpha masks ---- */

static const spoil_field alpha_mask_fields[] = {
    {SPOIL_AT(csm_alpha_mask_info, flags), FIELD_WHOLE, 0},
    {SPOIL_AT(csm_alpha_mask_info, width), FIELD_SMALL, 32},
    {SPOIL_AT(csm_alpha_mask_info, height), FIELD_SMALL, 15},
    {SPOIL_AT(csm_alpha_mask_info, wrap_u), FIELD_WHOLE, 0},
    {SPOIL_AT(csm_alpha_mask_info, wrap_v), FIELD_WHOLE, 0},
    {SPOIL_AT(csm_alpha_mask_info, texels), FIELD_POINTER, 0},
    {SPOIL_AT(csm_alpha_mask_info, row_stride), FIELD_SMALL, 64},
    {SPOIL_AT(csm_alpha_mask_info, reserved), FIELD_WHOLE, 0},
};
static const spoil_struct alpha_mask_struct = SPOIL_STRUCT(csm_alpha_mask_info, alpha_mask_fields);

static csm_result create_alpha_mask(world *w) {
  world_handle *place = world_place(w, w->alpha_masks, WORLD_ALPHA_MASKS);
  if (!place)
    return CSM_SUCCESS;
  const csm_alpha_mask_info good = {.struct_size = sizeof good,
                                    .width = 1 + dice_below(&w->dice, 32),
                                    .height = 1 + dice_below(&w->dice, 15),
                                    .wrap_u = dice_below(&w->dice, 3),
                                    .wrap_v = dice_below(&w->dice, 3),
                                    .texels = w->texels,
                                    .row_stride = dice_one_in(&w->dice, 2) ? 0 : 48};
  for (size_t i = 0; i < sizeof w->texels; i += 8) {
    const uint64_t bits = dice_bits(&w->dice);
    memcpy(w->texels + i, &bits, sizeof bits);
  }
  csm_alpha_mask made = 1;
  csm_alpha_mask *out = dice_one_in(&w->dice, 60) ? NULL : &made;
  const csm_result result = csm_alpha_mask_create(w->context, world_risk(w, &good, &alpha_mask_struct), out);
  if (out)
    assert_true((made != 0) == !result);
  if (!result)
    *place = (world_handle){made, true};
  return result;
}

/* Marks what a handle stood for as gone. */
static void forget(world_handle *handles, uint32_t count, uint64_t value) {
  for (uint32_t i = 0; i < count; ++i)
    if (handles[i].live && handles[i].value == value)
      handles[i].live = false;
}

static csm_result destroy_alpha_mask(world *w) {
  const csm_alpha_mask gone = world_handle_of(w, w->alpha_masks, WORLD_ALPHA_MASKS);
  const csm_result result = csm_alpha_mask_destroy(w->context, gone);
  if (!result)
    forget(w->alpha_masks, WORLD_ALPHA_MASKS, gone);
  return result;
}

/* ---- meshes ---- */

static const spoil_field mesh_fields[] = {
    {SPOIL_AT(csm_mesh_info, flags), FIELD_WHOLE, 0},
    {SPOIL_AT(csm_mesh_info, positions), FIELD_POINTER, 0},
    {SPOIL_AT(csm_mesh_info, position_stride), FIELD_SMALL, 24},
    {SPOIL_AT(csm_mesh_info, vertex_count), FIELD_SMALL, WORLD_VERTICES},
    {SPOIL_AT(csm_mesh_info, indices), FIELD_POINTER, 0},
    {SPOIL_AT(csm_mesh_info, index_count), FIELD_SMALL, WORLD_VERTICES * 3},
    {SPOIL_AT(csm_mesh_info, index_size), FIELD_SMALL, 4},
    {SPOIL_AT(csm_mesh_info, bounds_min), FIELD_FLOAT, 0},
    {SPOIL_AT(csm_mesh_info, bounds_max), FIELD_FLOAT, 0},
    {SPOIL_AT(csm_mesh_info, alpha_mask), FIELD_LONG, 0},
    {SPOIL_AT(csm_mesh_info, uvs), FIELD_POINTER, 0},
    {SPOIL_AT(csm_mesh_info, uv_stride), FIELD_SMALL, 24},
    {SPOIL_AT(csm_mesh_info, alpha_cutoff), FIELD_FLOAT, 0},
};
static const spoil_struct mesh_struct = SPOIL_STRUCT(csm_mesh_info, mesh_fields);
/* In an engine's buffers, whose size and content csm is not told. */
static const spoil_field lent_mesh_fields[] = {
    {SPOIL_AT(csm_mesh_info, flags), FIELD_WHOLE, 0},
    {SPOIL_AT(csm_mesh_info, vertex_count), FIELD_SMALL, WORLD_VERTICES},
    {SPOIL_AT(csm_mesh_info, index_count), FIELD_SMALL, WORLD_VERTICES * 3},
    {SPOIL_AT(csm_mesh_info, bounds_min), FIELD_FLOAT, 0},
    {SPOIL_AT(csm_mesh_info, bounds_max), FIELD_FLOAT, 0},
    {SPOIL_AT(csm_mesh_info, alpha_mask), FIELD_LONG, 0},
    {SPOIL_AT(csm_mesh_info, alpha_cutoff), FIELD_FLOAT, 0},
};
static const spoil_struct lent_mesh_struct = SPOIL_STRUCT(csm_mesh_info, lent_mesh_fields);

/* Vertices on and about a unit box, now and then far away or not finite. */
static void fill_floats(world *w) {
  const double size = dice_one_in(&w->dice, 8) ? dice_scale(&w->dice, 1e-6, 1e9) : 1.0;
  for (uint32_t i = 0; i < WORLD_FLOATS; ++i)
    w->floats[i] = (float)dice_between(&w->dice, -size, size);
  if (dice_one_in(&w->dice, 20))
    w->floats[dice_below(&w->dice, 3 * WORLD_VERTICES)] = dice_one_in(&w->dice, 2) ? NAN : INFINITY;
}

/* Indices of 2 bytes lie in the same memory. */
static void fill_indices(world *w, uint32_t vertices, uint32_t size) {
  const uint32_t most = vertices + dice_one_in(&w->dice, 40);
  uint16_t narrow[WORLD_VERTICES * 3];
  for (uint32_t i = 0; i < WORLD_VERTICES * 3; ++i) {
    w->indices[i] = dice_below(&w->dice, most);
    narrow[i] = (uint16_t)w->indices[i];
  }
  if (size == 2)
    memcpy(w->indices, narrow, sizeof narrow);
}

static csm_result create_mesh(world *w) {
  world_handle *place = world_place(w, w->meshes, WORLD_MESHES);
  if (!place)
    return CSM_SUCCESS;
  const uint32_t vertices = 3 + dice_below(&w->dice, WORLD_VERTICES - 2), strides[4] = {0, 12, 16, 24};
  csm_mesh_info good = {.struct_size = sizeof good,
                        .flags = dice_below(&w->dice, 4),
                        .positions = w->floats,
                        .position_stride = strides[dice_below(&w->dice, 4)],
                        .vertex_count = vertices,
                        .indices = w->indices,
                        .index_count = 3 * (1 + dice_below(&w->dice, WORLD_VERTICES)),
                        .index_size = dice_one_in(&w->dice, 2) ? 2 : 4};
  fill_floats(w);
  fill_indices(w, vertices, good.index_size);
  if (w->lent && dice_one_in(&w->dice, 3))
    lent_mesh(w->lent, &w->dice, &good);
  if (dice_one_in(&w->dice, 4)) {
    good.alpha_mask = world_handle_of(w, w->alpha_masks, WORLD_ALPHA_MASKS);
    good.uvs = good.positions ? w->floats + 3 : NULL;
    good.alpha_cutoff = (float)dice_between(&w->dice, 0.01, 1);
  }
  csm_mesh made = 1;
  csm_mesh *out = dice_one_in(&w->dice, 60) ? NULL : &made;
  csm_mesh_info *info = world_risk(w, &good, good.positions ? &mesh_struct : &lent_mesh_struct);
  if (info && !good.positions && info->struct_size <= offsetof(csm_mesh_info, d3d12)) /* it ends amid the two APIs */
    info->struct_size = 0;
  const csm_result result = csm_mesh_create(w->context, info, out);
  if (out)
    assert_true((made != 0) == !result);
  if (!result)
    *place = (world_handle){made, true};
  return result;
}

static const spoil_field update_fields[] = {
    {SPOIL_AT(csm_mesh_update_info, flags), FIELD_WHOLE, 0},
    {SPOIL_AT(csm_mesh_update_info, positions), FIELD_POINTER, 0},
    {SPOIL_AT(csm_mesh_update_info, position_stride), FIELD_SMALL, 24},
    {SPOIL_AT(csm_mesh_update_info, reserved), FIELD_WHOLE, 0},
    {SPOIL_AT(csm_mesh_update_info, bounds_min), FIELD_FLOAT, 0},
    {SPOIL_AT(csm_mesh_update_info, bounds_max), FIELD_FLOAT, 0},
};
static const spoil_struct update_struct = SPOIL_STRUCT(csm_mesh_update_info, update_fields);

static csm_result update_mesh(world *w) {
  const csm_mesh mesh = world_handle_of(w, w->meshes, WORLD_MESHES);
  const csm_mesh_update_info good = {.struct_size = sizeof good,
                                     .positions = w->lent && dice_one_in(&w->dice, 3) ? NULL : w->floats,
                                     .position_stride = dice_one_in(&w->dice, 2) ? 0 : 16,
                                     .bounds_min = {-1, -1, -1},
                                     .bounds_max = {1, 1, 1}};
  fill_floats(w);
  return csm_mesh_update(w->context, mesh, world_risk(w, &good, &update_struct));
}

static csm_result destroy_mesh(world *w) {
  const csm_mesh gone = world_handle_of(w, w->meshes, WORLD_MESHES);
  const csm_result result = csm_mesh_destroy(w->context, gone);
  if (!result)
    forget(w->meshes, WORLD_MESHES, gone);
  return result;
}

const world_call calls_assets[] = {
    {.name = "csm_alpha_mask_create", .weight = 8, .call = create_alpha_mask},
    {.name = "csm_alpha_mask_destroy", .weight = 6, .call = destroy_alpha_mask},
    {.name = "csm_mesh_create", .weight = 40, .call = create_mesh},
    {.name = "csm_mesh_update", .weight = 20, .call = update_mesh},
    {.name = "csm_mesh_destroy", .weight = 20, .call = destroy_mesh},
    {.name = NULL},
};
