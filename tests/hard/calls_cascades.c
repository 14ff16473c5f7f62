/* calls_cascades.c: random cascades and views. */
#include "world.h"

#include <string.h>

/* ---- configurations ---- */

/* A value from a field's least to its greatest. */
static void roll_field(world *w, csm_config *config, const csm_config_field *field) {
  unsigned char *at = (unsigned char *)config + field->offset;
  const uint32_t element = dice_below(&w->dice, field->length);
  if (field->type == CSM_FIELD_DOUBLE || field->type == CSM_FIELD_DOUBLES) {
    const double low = field->minimum, high = field->maximum, ends[2] = {low, high};
    const double near = dice_scale(&w->dice, 1e-3, 1e3) * (field->default_value ? field->default_value : 1);
    const double inside = near < low ? low : near > high ? high : near;
    const double value = dice_one_in(&w->dice, 4) ? ends[dice_below(&w->dice, 2)] : inside;
    memcpy(at + element * sizeof value, &value, sizeof value);
  } else {
    const double low = field->minimum, width = field->maximum - low;
    const uint32_t value = (uint32_t)low + dice_below(&w->dice, (uint32_t)(width < 1000 ? width : 1000) + 1);
    memcpy(at + element * sizeof value, &value, sizeof value);
  }
}

static csm_config_field any_field(world *w) {
  csm_config_field field = {.struct_size = sizeof field};
  uint32_t count = 0;
  while (!csm_config_describe(count, &field))
    ++count;
  assert_int_equal(csm_config_describe(dice_below(&w->dice, count), &field), CSM_SUCCESS);
  return field;
}

/* Any number in any field. */
static void spoil_config(world *w, spoil_paper *paper) {
  const csm_config_field field = any_field(w);
  const bool real = field.type == CSM_FIELD_DOUBLE || field.type == CSM_FIELD_DOUBLES;
  const spoil_field fields[] = {{field.offset, field.length * (real ? 8 : 4), real ? FIELD_REAL : FIELD_WHOLE, 0}};
  const spoil_struct what = SPOIL_STRUCT(csm_config, fields);
  spoil(&w->dice, paper, &what);
}

static const char *any_preset(world *w) {
  csm_preset_info preset = {.struct_size = sizeof preset};
  uint32_t count = 0;
  while (!csm_config_preset_describe(count, &preset))
    ++count;
  assert_int_equal(csm_config_preset_describe(dice_below(&w->dice, count), &preset), CSM_SUCCESS);
  return preset.name;
}

static csm_config roll_config(world *w) {
  csm_config config = support_config();
  if (dice_one_in(&w->dice, 3))
    assert_int_equal(csm_config_preset(any_preset(w), &config), CSM_SUCCESS);
  for (uint32_t changes = dice_below(&w->dice, 5); changes; --changes) {
    const csm_config_field field = any_field(w);
    roll_field(w, &config, &field);
  }
  if (dice_one_in(&w->dice, 6))
    config.filter = CSM_FILTER_EXACT + dice_below(&w->dice, 2);
  if (dice_one_in(&w->dice, 6)) {
    config.budget = dice_below(&w->dice, 8);
    config.budget_ms = config.budget_wrong = config.budget_mib = dice_below(&w->dice, 4) ? 1 : 0;
  }
  config.resolution = 16 << dice_below(&w->dice, 3);
  for (uint32_t i = 0; i < CSM_MAX_CASCADES; ++i)
    config.resolutions[i] = dice_one_in(&w->dice, 8) ? 16 + dice_below(&w->dice, WORLD_SIDE - 16 + 1) : 0;
  if (dice_one_in(&w->dice, 30)) /* more than the memory limit */
    config.resolution = 16384;
  return config;
}

/* A map is small, or larger than the memory limit: never in between, which would take a while. */
static void keep_small(uint32_t *resolution) {
  if (*resolution > 2 * WORLD_SIDE && *resolution < 16384)
    *resolution = 16384;
}

/* What a budget chooses follows from times, masks and padding, which backends differ in: a target is kept by all maps, or refused,
   and where errors are counted maps have no coarser ones. */
static void keep_choice(csm_config *config) {
  const bool error = config->budget <= 7 && config->budget & CSM_BUDGET_ERROR;
  config->budget_ms = config->budget_ms > 0 && config->budget_ms < 1e5 ? 1e5 : config->budget_ms;
  config->budget_mib = config->budget_mib > 1e-4 && config->budget_mib < 1e5 ? 1e5 : config->budget_mib;
  config->resolution = error ? 16 : config->resolution;
  for (uint32_t i = 0; i < CSM_MAX_CASCADES && error; ++i)
    config->resolutions[i] = 0;
}

/* The configuration that a call is to read. */
static csm_config *write_config(world *w, const csm_config *good) {
  csm_config *written = world_write(w, good, sizeof *good);
  if (dice_one_in(&w->dice, 40))
    return NULL;
  if (dice_one_in(&w->dice, 5))
    spoil_config(w, (spoil_paper *)(void *)written);
  keep_small(&written->resolution);
  for (uint32_t i = 0; i < CSM_MAX_CASCADES; ++i)
    keep_small(&written->resolutions[i]);
  keep_choice(written);
  return written;
}

/* What csm has taken of a configuration on paper. */
static csm_config taken(world *w, const csm_config *written) {
  csm_config config = {0};
  memcpy(&config, written, written->struct_size < sizeof config ? written->struct_size : sizeof config);
  w->samples = w->samples || config.depth_samples != CSM_DEPTH_SAMPLES_OFF;
  return config;
}

/* ---- cascades ---- */

static csm_result create_cascades(world *w) {
  world_cascades *place = &w->cascades[dice_below(&w->dice, WORLD_CASCADES)];
  if (place->cascades)
    return CSM_SUCCESS;
  const csm_config good = roll_config(w);
  const csm_config *config = write_config(w, &good);
  csm_cascades *made = (csm_cascades *)w;
  csm_cascades **out = dice_one_in(&w->dice, 20) ? NULL : &made;
  const csm_result result = csm_cascades_create(w->context, config, out);
  if (out)
    assert_true((made != NULL) == !result);
  if (!result)
    *place = (world_cascades){.cascades = made, .config = taken(w, config)};
  return result;
}

static csm_result configure_cascades(world *w) {
  world_cascades *cascades = world_any_cascades(w);
  csm_config good = roll_config(w);
  if (cascades && !dice_one_in(&w->dice, 3)) { /* a field of what there is */
    const csm_config_field field = any_field(w);
    const uint32_t resolution = cascades->config.resolution;
    good = cascades->config;
    good.struct_size = sizeof good;
    roll_field(w, &good, &field);
    good.resolution = resolution;
    memset(good.resolutions, 0, sizeof good.resolutions);
  }
  const csm_config *config = write_config(w, &good);
  const csm_result result = csm_cascades_configure(cascades ? cascades->cascades : NULL, config);
  if (!result)
    cascades->config = taken(w, config);
  return result;
}

static csm_result destroy_cascades(world *w) {
  world_cascades *cascades = world_any_cascades(w);
  const csm_result result = csm_cascades_destroy(cascades ? cascades->cascades : NULL);
  if (!result && cascades) {
    w->gone = cascades->cascades;
    cascades->cascades = NULL;
  }
  return result;
}

static csm_result ask_target(world *w) {
  world_cascades *cascades = world_any_cascades(w);
  const csm_draw_target good = {.struct_size = sizeof good};
  static const spoil_struct what = {.size = sizeof(csm_draw_target)};
  csm_draw_target *target = world_risk(w, &good, &what);
  return csm_get_draw_target(cascades ? cascades->cascades : NULL, target);
}

/* ---- views ---- */

static csm_result create_view(world *w) {
  world_view *place = &w->views[dice_below(&w->dice, WORLD_VIEWS)];
  if (place->view)
    return CSM_SUCCESS;
  csm_view *made = (csm_view *)w;
  csm_view **out = dice_one_in(&w->dice, 20) ? NULL : &made;
  const csm_result result = csm_view_create(w->context, out);
  if (out)
    assert_true((made != NULL) == !result);
  if (!result)
    *place = (world_view){.view = made};
  return result;
}

static csm_result destroy_view(world *w) {
  world_view *view = world_any_view(w);
  const csm_result result = csm_view_destroy(view ? view->view : NULL);
  if (!result && view) {
    w->gone = view->view;
    w->looked = w->looked == view->view ? NULL : w->looked;
    view->view = NULL;
  }
  return result;
}

const world_call calls_cascades[] = {
    {.name = "csm_cascades_create", .weight = 24, .call = create_cascades},
    {.name = "csm_cascades_configure", .weight = 8, .call = configure_cascades},
    {.name = "csm_cascades_destroy", .weight = 2, .call = destroy_cascades},
    {.name = "csm_get_draw_target", .weight = 4, .call = ask_target},
    {.name = "csm_view_create", .weight = 20, .call = create_view},
    {.name = "csm_view_destroy", .weight = 2, .call = destroy_view},
    {.name = NULL},
};
