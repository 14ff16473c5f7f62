/* calls_questions.c: random questions: what came of frames, and what the library says of itself. */
#include "world.h"

#include <stdlib.h>
#include <string.h>

/* ---- of cascades and views ---- */

static const spoil_struct binding_struct = {.size = sizeof(csm_binding)};

static csm_result bind(world *w) {
  const world_cascades *cascades = world_any_cascades(w);
  const world_view *view = world_any_view(w);
  csm_binding good = {.struct_size = sizeof good, .view = view ? view->view : NULL};
  if (dice_one_in(&w->dice, 20))
    good.view = world_wild(w);
  csm_binding *binding = world_risk(w, &good, &binding_struct);
  const csm_result result = csm_bind(cascades ? cascades->cascades : NULL, binding);
  if (result || binding->struct_size < sizeof *binding)
    return result;
  world_answer(w, &binding->cascade_count, sizeof binding->cascade_count);
  world_answer(w, binding->resolutions, sizeof binding->resolutions);
  world_plan(w, binding->origin, sizeof binding->origin);
  world_plan(w, binding->cascades, sizeof binding->cascades);
  world_plan(w, binding->cascade_constants, binding->cascade_constants_size);
  world_plan(w, binding->setting_constants, binding->setting_constants_size);
  return result;
}

static const spoil_struct stats_struct = {.size = sizeof(csm_stats)};

static csm_result ask_stats(world *w) {
  const world_cascades *cascades = world_any_cascades(w);
  const csm_stats good = {.struct_size = sizeof good};
  csm_stats *stats = world_risk(w, &good, &stats_struct);
  const csm_result result = csm_get_stats(cascades ? cascades->cascades : NULL, stats);
  if (result || stats->struct_size < sizeof *stats)
    return result;
  world_plan(w, &stats->plan_hash, sizeof stats->plan_hash);
  world_answer(w, &stats->cascade_count, sizeof stats->cascade_count);
  world_answer(w, &stats->geometry_bytes, sizeof stats->geometry_bytes);
  world_answer(w, &stats->instances, sizeof stats->instances);
  world_answer(w, &stats->instances_changed, sizeof stats->instances_changed);
  for (uint32_t i = 0; i < stats->cascade_count; ++i) {
    world_plan(w, &stats->cascades[i].casters_drawn, sizeof stats->cascades[i].casters_drawn);
    world_plan(w, &stats->cascades[i].casters_culled, sizeof stats->cascades[i].casters_culled);
    world_plan(w, &stats->cascades[i].triangles_drawn, sizeof stats->cascades[i].triangles_drawn);
  }
  return result;
}

static const spoil_struct view_stats_struct = {.size = sizeof(csm_view_stats)};

static csm_result ask_view_stats(world *w) {
  const world_view *view = world_any_view(w);
  const csm_view_stats good = {.struct_size = sizeof good};
  csm_view_stats *stats = world_risk(w, &good, &view_stats_struct);
  const csm_result result = csm_get_view_stats(view ? view->view : NULL, stats);
  if (!result && stats->struct_size == sizeof *stats) {
    world_answer(w, &stats->width, sizeof stats->width);
    world_answer(w, &stats->height, sizeof stats->height);
  }
  return result;
}

static csm_result ask_casters(world *w) {
  const world_cascades *cascades = world_any_cascades(w);
  const world_scene *scene = world_any_scene(w);
  uint8_t drawn[WORLD_BATCH] = {0};
  uint32_t count = cascades ? cascades->list : 0;
  const csm_instance_id *ids = NULL;
  if (scene && !dice_one_in(&w->dice, 4)) {
    count = dice_below(&w->dice, WORLD_BATCH);
    for (uint32_t i = 0; i < count; ++i)
      w->ids[i] = world_handle_of(w, scene->ids, WORLD_IDS);
    ids = w->ids;
  }
  if (dice_one_in(&w->dice, 20))
    count = dice_below(&w->dice, WORLD_BATCH);
  uint8_t *out = dice_one_in(&w->dice, 30) ? NULL : drawn;
  const csm_result result = csm_get_casters(cascades ? cascades->cascades : NULL, count, ids, out);
  world_plan(w, drawn, sizeof drawn);
  return result;
}

/* ---- reading ---- */

static const spoil_field read_fields[] = {
    {SPOIL_AT(csm_read_info, source), FIELD_WHOLE, 0},
    {SPOIL_AT(csm_read_info, cascades), FIELD_POINTER, 0},
    {SPOIL_AT(csm_read_info, view), FIELD_POINTER, 0},
    {SPOIL_AT(csm_read_info, cascade), FIELD_WHOLE, 0},
    {SPOIL_AT(csm_read_info, reserved), FIELD_WHOLE, 0},
    {SPOIL_AT(csm_read_info, data), FIELD_POINTER, 0},
    {SPOIL_AT(csm_read_info, size), FIELD_LONG, 0},
    {SPOIL_AT(csm_read_info, level), FIELD_WHOLE, 0},
    {SPOIL_AT(csm_read_info, reserved_level), FIELD_WHOLE, 0},
};
static const spoil_struct read_struct = SPOIL_STRUCT(csm_read_info, read_fields);

/* Floats that a texel of moments takes, all layers of depth together; 1 of filters that read none. */
static uint32_t moments_of(const csm_config *config) {
  switch (config->filter) {
  case CSM_FILTER_VSM:
    return 2 * config->moment_layers;
  case CSM_FILTER_EVSM2:
  case CSM_FILTER_VSSM:
    return 2;
  case CSM_FILTER_EVSM4:
  case CSM_FILTER_MSM4:
    return 4;
  default:
    return 1;
  }
}

/* The size that the answer should have; it is what the memory has room for, too. */
static csm_read_info roll_read(world *w, const world_cascades *cascades, const world_view *view) {
  csm_read_info info = {.struct_size = sizeof info,
                        .source = dice_below(&w->dice, CSM_READ_MOMENTS + 1),
                        .cascades = cascades ? cascades->cascades : NULL,
                        .view = view ? view->view : NULL,
                        .cascade = dice_below(&w->dice, 3)};
  uint64_t width = view ? view->width : 1, height = view ? view->height : 1;
  if ((info.source == CSM_READ_MAP || info.source == CSM_READ_MOMENTS) && cascades) {
    const csm_config *config = &cascades->config;
    width = config->resolutions[info.cascade] ? config->resolutions[info.cascade] : config->resolution;
    if (info.source == CSM_READ_MOMENTS)
      width >>= config->moment_halved;
    height = width;
    width *= info.source == CSM_READ_MOMENTS ? moments_of(config) : 1;
  }
  info.size = width * height * sizeof(float);
  if (dice_one_in(&w->dice, 20))
    info.view = world_wild(w);
  if (dice_one_in(&w->dice, 20))
    info.cascades = world_wild(w);
  return info;
}

static csm_result read_back(world *w) {
  const world_cascades *cascades = world_any_cascades(w);
  const world_view *view = world_any_view(w);
  csm_read_info good = roll_read(w, cascades, view);
  const uint64_t room = 4 * (8 * WORLD_SIDE * WORLD_SIDE + 1);
  float *data = calloc(1, room);
  assert_non_null(data);
  good.data = data;
  csm_read_info *info = world_risk(w, &good, &read_struct);
  if (info && info->size > room) /* no caller has so much */
    info->size = 0;
  const csm_result result = csm_read(w->context, info);
  if (!result)
    world_picture(w, data, info->size);
  free(data);
  return result;
}

/* ---- the library ---- */

static csm_result ask_defines(world *w) {
  const csm_config good = support_config();
  csm_config *config = world_write(w, &good, sizeof good);
  const uint32_t enumerator = (uint32_t)offsetof(csm_config, filter),
                 value = dice_below(&w->dice, CSM_FILTER_BACKPROJECTION + 3);
  char text[4096];
  uint64_t size = dice_one_in(&w->dice, 4) ? dice_below(&w->dice, 200) : sizeof text;
  memset(text, 0, sizeof text);
  memcpy((char *)config + enumerator, &value, sizeof value);
  const csm_result result =
      csm_shader_defines(dice_one_in(&w->dice, 20) ? NULL : config, dice_one_in(&w->dice, 4) ? NULL : text,
                         dice_one_in(&w->dice, 20) ? NULL : &size);
  world_answer(w, text, sizeof text);
  world_answer(w, &size, sizeof size);
  return result;
}

static csm_result ask_config(world *w) {
  const csm_config_field good = {.struct_size = sizeof good};
  const csm_config empty = {.struct_size = sizeof empty};
  const csm_preset_info none = {.struct_size = sizeof none};
  static const spoil_struct field_struct = {.size = sizeof(csm_config_field)},
                            config_struct = {.size = sizeof(csm_config)},
                            preset_struct = {.size = sizeof(csm_preset_info)};
  csm_config *config = world_risk(w, &empty, &config_struct);
  csm_result result;
  switch (dice_below(&w->dice, 4)) {
  case 0:
    return csm_config_describe(dice_below(&w->dice, 120), world_risk(w, &good, &field_struct));
  case 1:
    return csm_config_preset_describe(dice_below(&w->dice, 50), world_risk(w, &none, &preset_struct));
  case 2:
    result = csm_config_preset(dice_one_in(&w->dice, 4) ? NULL : "high", config);
    break;
  default:
    result = csm_config_default(config);
  }
  if (config)
    world_answer(w, config, sizeof *config);
  return result;
}

/* Mostly how many there are, for each that is described has its device looked for. */
static csm_result ask_backends(world *w) {
  static csm_backend_info infos[2];
  uint32_t count = dice_one_in(&w->dice, 60) ? 1 + dice_below(&w->dice, 2) : 0;
  infos[0].struct_size =
      dice_one_in(&w->dice, 4) ? dice_odd_whole(&w->dice, 8) % sizeof infos[0] / 8 * 8 : sizeof infos[0];
  const bool told = dice_one_in(&w->dice, 2), whole = infos[0].struct_size == sizeof infos[0];
  const uint32_t wanted = count;
  const csm_result result = csm_query_backends(dice_one_in(&w->dice, 8) ? NULL : &count, told ? infos : NULL);
  world_answer(w, &count, sizeof count);
  for (uint32_t i = 0; i < wanted && i < 2 && told && whole && !result; ++i)
    world_answer(w, infos[i].name, strlen(infos[i].name));
  return result;
}

static csm_result ask_names(world *w) {
  const csm_result any =
      dice_one_in(&w->dice, 2) ? -(csm_result)dice_below(&w->dice, 30) : (csm_result)dice_bits(&w->dice);
  const char *name = csm_result_name(any);
  const uint32_t version = csm_version();
  world_answer(w, name, strlen(name));
  world_answer(w, &version, sizeof version);
  assert_non_null(csm_last_error(w->context));
  assert_string_equal(csm_last_error(NULL), "");
  return CSM_SUCCESS;
}

const world_call calls_questions[] = {
    {.name = "csm_bind", .weight = 25, .call = bind},
    {.name = "csm_get_stats", .weight = 20, .call = ask_stats},
    {.name = "csm_get_view_stats", .weight = 10, .call = ask_view_stats},
    {.name = "csm_get_casters", .weight = 15, .call = ask_casters},
    {.name = "csm_read", .weight = 25, .call = read_back},
    {.name = "csm_shader_defines", .weight = 3, .call = ask_defines},
    {.name = "csm_config_*", .weight = 6, .call = ask_config},
    {.name = "csm_query_backends", .weight = 1, .call = ask_backends},
    {.name = "csm_result_name", .weight = 2, .call = ask_names},
    {.name = NULL},
};
