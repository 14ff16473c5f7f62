/* calls_context.c: random creations, switches, and what an engine does with its frames. */
#include "world.h"

#include <string.h>

static const spoil_field create_fields[] = {
    {SPOIL_AT(csm_create_info, flags), FIELD_WHOLE, 0},       {SPOIL_AT(csm_create_info, version), FIELD_WHOLE, 0},
    {SPOIL_AT(csm_create_info, frame_slots), FIELD_WHOLE, 0}, {SPOIL_AT(csm_create_info, backend), FIELD_POINTER, 0},
    {SPOIL_AT(csm_create_info, allocate), FIELD_POINTER, 0},  {SPOIL_AT(csm_create_info, release), FIELD_POINTER, 0},
    {SPOIL_AT(csm_create_info, error), FIELD_POINTER, 0},
};
static const spoil_struct create_struct = SPOIL_STRUCT(csm_create_info, create_fields);

/* Asks for the engine's device, or for one of csm's own on any backend that draws. */
static csm_create_info roll_create(world *w, bool lent) {
  static const char *const wrong[] = {"", "nope", "Vulkan", "/", "/proc/self/status", "../", "null "};
  static const char *const drawing[] = {"vulkan", "d3d12"};
  csm_create_info info = world_create_info(w);
  const uint32_t other = dice_below(&w->dice, 2);
  info.frame_slots = dice_below(&w->dice, 10);
  if (!lent && strcmp(w->backend, "null") != 0)
    info.backend = drawing[other];
  if (lent)
    lent_give(w->lent, &info);
  if (dice_one_in(&w->dice, 3))
    info.backend = wrong[dice_below(&w->dice, sizeof wrong / sizeof *wrong)];
  if (dice_one_in(&w->dice, 20))
    info.memory_limit = 1;
  return info;
}

static csm_result create(world *w) {
  char text[64];
  csm_create_info good = roll_create(w, w->lent && dice_one_in(&w->dice, 2));
  good.error = text;
  good.error_size = dice_below(&w->dice, sizeof text + 1);
  csm_context *made = (csm_context *)w;
  csm_context **out = dice_one_in(&w->dice, 8) ? NULL : &made;
  csm_create_info *info = world_risk(w, &good, &create_struct);
  if (info && info->struct_size > offsetof(csm_create_info, vulkan) &&
      info->struct_size < offsetof(csm_create_info, error)) /* amid the two APIs, or callbacks without their user */
    info->struct_size = 0;
  const csm_result result = csm_create(info, out);
  if (out)
    assert_true((made != NULL) == !result);
  if (!result)
    csm_destroy(made);
  return result;
}

static csm_result switch_backend(world *w) {
  const bool lent = w->lent && dice_one_in(&w->dice, 2);
  const csm_create_info good = roll_create(w, lent);
  csm_create_info *info = world_risk(w, &good, &create_struct);
  if (info && info->struct_size < offsetof(csm_create_info, allocate)) /* the limit and the device stay */
    info->struct_size = 0;
  const csm_result result = csm_switch_backend(w->context, info);
  if (result)
    return result;
  w->own = !lent;
  for (uint32_t i = 0; i < WORLD_VIEWS; ++i)
    w->views[i].width = w->views[i].height = 0;
  return result;
}

static csm_result retire(world *w) {
  const uint64_t frame = w->lent ? lent_done(w->lent, &w->dice) : dice_bits(&w->dice);
  return csm_retire(dice_one_in(&w->dice, 30) ? NULL : w->context, frame);
}

static csm_result go_on(world *w) {
  lent_step(w->lent, &w->dice);
  return CSM_SUCCESS;
}

const world_call calls_context[] = {
    {.name = "csm_create", .weight = 1, .engine_weight = 2, .opens = true, .call = create},
    {.name = "csm_switch_backend", .weight = 2, .engine_weight = 4, .opens = true, .call = switch_backend},
    {.name = "csm_retire", .weight = 2, .engine_weight = 30, .call = retire},
    {.name = "a frame of the engine's", .engine_weight = 60, .call = go_on},
    {.name = NULL},
};
