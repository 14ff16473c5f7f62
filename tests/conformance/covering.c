#include "covering.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- levels ---- */

/* Levels of numbers that tell more than the ends of their range do; every other field gets its levels from its type. */
static const struct {
  const char *name;
  uint32_t count;
  double values[5];
} chosen[] = {
    {"cascade_count", 4, {3, 1, 4, 8}},
    {"resolution", 2, {256, 100}},
    {"shadow_distance", 2, {40, 15}},
    {"caster_distance", 3, {1000, 0, 12}},
    {"filter_taps", 5, {9, 3, 12, 31, 64}},
    {"split_near", 2, {0, 2}},
    {"filter_radius_texels", 3, {2, 0, 7.5}},
    {"light_step_texels", 2, {0, 1}},
    {"bias_constant_texels", 3, {0.5, 0, 3}},
    {"bias_slope_texels", 3, {1, 0, 2}},
    {"bias_slope_max", 3, {10, 0, 1}},
    {"bias_plane_max", 3, {10000, 0, 20}},
    {"bias_normal_texels", 3, {0, 1.5, 4}},
    {"bias_constant_range", 3, {0, 0.001, -0.001}},
    {"bias_constant_m", 2, {0, 0.05}},
    {"bias_slope_range", 2, {0, 0.001}},
    {"bias_limit_range", 2, {0, 0.0005}},
    {"polygon_offset_constant", 3, {0, 40, -40}},
    {"polygon_offset_slope", 3, {0, 2, -1}},
    {"polygon_offset_clamp", 2, {0, 0.001}},
    {"moment_layers", 3, {1, 2, 4}},
    {"moment_blur_texels", 4, {2, 0, 3, 7}},
    {"moment_levels", 3, {1, 3, 12}},
    {"moment_anisotropy", 2, {8, 1}},
    {"moment_exponent", 2, {80, 4}},
    {"moment_exponent_negative", 2, {5, 40}},
    {"moment_bias", 2, {0, 0.01}},
    {"moment_deviation_range", 2, {0, 0.01}},
    {"moment_deviation_m", 2, {0, 0.1}},
    {"moment_deviation_slope", 2, {0.5, 0}},
    {"bleeding_reduction", 2, {0.2, 0}},
    {"bleeding_power", 2, {1, 3}},
    {"soft_search_taps", 2, {16, 3}},
    {"soft_taps", 2, {32, 5}},
    {"soft_radius_max_texels", 2, {32, 6}},
    {"soft_radius_least_texels", 2, {1, 4}},
    {"soft_light_range", 2, {0.01, 0.1}},
    {"history_frames", 2, {8, 2}},
    {"history_depth", 2, {0.02, 0}},
    {"history_normal_deg", 2, {20, 0}},
    {"ray_taps", 2, {16, 3}},
    {"ray_unsure_cosine", 3, {0.1, 1, 0}},
    {"ray_grazing_cosine", 2, {0, 0.4}},
    {"budget", 4, {0, 4, 1, 2}},
    {"budget_ms", 1, {1e6}}, /* which any machine keeps: what is drawn must not depend on times */
    {"budget_wrong", 1, {1}},
    {"budget_mib", 2, {0.6, 3}},
};

static void add_level(covering_option *option, double value) {
  for (uint32_t i = 0; i < option->levels; ++i)
    if (option->values[i][0] == value)
      return;
  assert_true(option->levels < COVERING_LEVELS);
  for (uint32_t k = 0; k < option->field.length; ++k)
    option->values[option->levels][k] = value;
  ++option->levels;
}

/* As they are; rising to 1; rising beyond it. */
static void array_levels(covering_option *option) {
  const bool whole = option->field.type == CSM_FIELD_UINTS;
  add_level(option, option->field.default_value);
  for (uint32_t k = 0; k < option->field.length; ++k) {
    option->values[1][k] = whole ? (k % 3 == 1 ? 0 : 160 + 8 * k) : (k + 1.0) / option->field.length;
    option->values[2][k] = whole ? (k % 2 ? 64 : 300) : 4.0 * (k + 1);
  }
  option->levels = 3;
}

static bool chosen_levels(covering_option *option) {
  for (size_t i = 0; i < sizeof chosen / sizeof *chosen; ++i)
    if (!strcmp(chosen[i].name, option->field.name)) {
      for (uint32_t k = 0; k < chosen[i].count; ++k)
        add_level(option, chosen[i].values[k]);
      return true;
    }
  return false;
}

static void make_levels(covering_option *option) {
  const csm_config_field *field = &option->field;
  if (field->length > 1) {
    array_levels(option);
  } else if (field->type == CSM_FIELD_ENUM) {
    add_level(option, field->default_value);
    for (uint32_t k = 0; field->values[k]; ++k)
      add_level(option, k);
  } else if (!chosen_levels(option)) {
    add_level(option, field->default_value);
    add_level(option, field->minimum);
    add_level(option, field->maximum < 100 ? field->maximum : field->default_value * 2 + 1);
  }
}

void covering_options(covering *out) {
  csm_config_field field = {.struct_size = sizeof field};
  out->option_count = out->level_count = 0;
  size_t found = 0;
  for (; csm_config_describe(out->option_count, &field) == CSM_SUCCESS; ++out->option_count) {
    assert_true(out->option_count < COVERING_OPTIONS);
    covering_option *option = &out->options[out->option_count];
    *option = (covering_option){.field = field};
    make_levels(option);
    out->level_count += option->levels;
    for (size_t i = 0; i < sizeof chosen / sizeof *chosen; ++i)
      found += !strcmp(chosen[i].name, field.name);
  }
  assert_int_equal(found, sizeof chosen / sizeof *chosen);
}

csm_config covering_config(const covering *c, const covering_case *the_case) {
  csm_config config = {.struct_size = sizeof config};
  for (uint32_t i = 0; i < c->option_count; ++i) {
    const csm_config_field *field = &c->options[i].field;
    const double *value = c->options[i].values[the_case->level[i]];
    const bool real = field->type == CSM_FIELD_DOUBLE || field->type == CSM_FIELD_DOUBLES;
    for (uint32_t k = 0; k < field->length; ++k)
      if (real)
        ((double *)(void *)((char *)&config + field->offset))[k] = value[k];
      else
        ((uint32_t *)(void *)((char *)&config + field->offset))[k] = (uint32_t)value[k];
  }
  return config;
}

void covering_text(const covering *c, const covering_case *the_case, char *text, size_t size) {
  size_t used = 0;
  text[0] = 0;
  for (uint32_t i = 0; i < c->option_count && used < size; ++i) {
    const csm_config_field *field = &c->options[i].field;
    const double value = c->options[i].values[the_case->level[i]][0];
    if (!the_case->level[i])
      continue;
    if (field->type == CSM_FIELD_ENUM)
      used += (size_t)snprintf(text + used, size - used, "%s=%s ", field->name, field->values[(int)value]);
    else
      used +=
          (size_t)snprintf(text + used, size - used, "%s=%g%s ", field->name, value, field->length > 1 ? ",..." : "");
  }
}

/* ---- what can be combined ---- */

static bool takes(const covering *c, const covering_case *the_case) {
  const csm_config config = covering_config(c, the_case);
  return c->takes(c->user, &config);
}

/* Changes up to `changes` options from `from` on, none of them pinned, until csm takes the case. */
static bool repair(const covering *c, covering_case *the_case, bool *pinned, uint32_t from, int changes) {
  if (takes(c, the_case))
    return true;
  for (uint32_t i = from; i < c->option_count && changes > 0; ++i) {
    if (pinned[i])
      continue;
    const uint8_t before = the_case->level[i];
    pinned[i] = true;
    for (uint32_t level = 0; level < c->options[i].levels; ++level) {
      the_case->level[i] = (uint8_t)level;
      if (level != before && repair(c, the_case, pinned, i + 1, changes - 1))
        return true;
    }
    pinned[i] = false;
    the_case->level[i] = before;
  }
  return false;
}

static bool repair_least(const covering *c, covering_case *the_case, bool *pinned) {
  for (int changes = 0; changes <= 2; ++changes)
    if (repair(c, the_case, pinned, 0, changes))
      return true;
  return false;
}

/* ---- pairs ---- */

/* Whether two levels have met, by the number of each level among all. */
typedef struct pair_set {
  uint32_t first[COVERING_OPTIONS];
  uint32_t levels;
  uint64_t left;
  bool *met;
} pair_set;

static bool *pair_at(const pair_set *set, uint32_t a, uint32_t level_a, uint32_t b, uint32_t level_b) {
  const uint32_t i = set->first[a] + level_a, k = set->first[b] + level_b;
  return &set->met[i < k ? i * set->levels + k : k * set->levels + i];
}

static void pairs_begin(pair_set *set, covering *c) {
  *set = (pair_set){.levels = c->level_count};
  set->met = calloc((size_t)c->level_count * c->level_count, sizeof *set->met);
  assert_non_null(set->met);
  uint64_t of_one_option = 0, levels = 0;
  for (uint32_t i = 0; i < c->option_count; ++i) {
    set->first[i] = (uint32_t)levels;
    levels += c->options[i].levels;
    of_one_option += (uint64_t)c->options[i].levels * c->options[i].levels;
  }
  c->pairs = set->left = (levels * levels - of_one_option) / 2;
}

static void meet(pair_set *set, const covering *c, const covering_case *the_case) {
  for (uint32_t a = 0; a < c->option_count; ++a)
    for (uint32_t b = 0; b < a; ++b) {
      bool *met = pair_at(set, a, the_case->level[a], b, the_case->level[b]);
      set->left -= !*met;
      *met = true;
    }
}

static uint32_t gain(const pair_set *set, const covering *c, const covering_case *the_case, const bool *pinned,
                     uint32_t option, uint32_t level) {
  uint32_t fresh = 0;
  for (uint32_t i = 0; i < c->option_count; ++i)
    if (pinned[i] && i != option)
      fresh += !*pair_at(set, option, level, i, the_case->level[i]);
  return fresh;
}

/* ---- cases ---- */

static uint32_t pick(uint64_t *state, uint32_t count) {
  *state = *state * 6364136223846793005ull + 1442695040888963407ull;
  return (uint32_t)((*state >> 33) % count);
}

static void shuffle(uint32_t *order, uint32_t count, uint64_t *state) {
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t k = pick(state, i + 1);
    order[i] = order[k];
    order[k] = i;
  }
}

/* Gives an option that is not pinned the level that meets most others for the first time, of those that csm takes. */
static void fill_option(const pair_set *set, const covering *c, covering_case *the_case, bool *pinned,
                        uint32_t option) {
  bool refused[COVERING_LEVELS] = {false};
  const uint32_t levels = c->options[option].levels;
  for (uint32_t tries = 0; tries < levels; ++tries) {
    uint32_t best = 0, most = 0;
    bool any = false;
    for (uint32_t level = 0; level < levels; ++level) {
      const uint32_t fresh = gain(set, c, the_case, pinned, option, level);
      if (!refused[level] && (!any || fresh > most)) {
        best = level;
        most = fresh;
        any = true;
      }
    }
    const uint8_t before = the_case->level[option];
    the_case->level[option] = (uint8_t)best;
    if (takes(c, the_case))
      break;
    the_case->level[option] = before;
    refused[best] = true;
  }
  pinned[option] = true;
}

static void fill(const pair_set *set, const covering *c, covering_case *the_case, bool *pinned, uint64_t seed) {
  uint32_t order[COVERING_OPTIONS];
  shuffle(order, c->option_count, &seed);
  for (uint32_t i = 0; i < c->option_count; ++i)
    if (!pinned[order[i]])
      fill_option(set, c, the_case, pinned, order[i]);
}

static uint64_t fresh_pairs(const pair_set *set, const covering *c, const covering_case *the_case) {
  uint64_t fresh = 0;
  for (uint32_t a = 0; a < c->option_count; ++a)
    for (uint32_t b = 0; b < a; ++b)
      fresh += !*pair_at(set, a, the_case->level[a], b, the_case->level[b]);
  return fresh;
}

static void add_case(covering *c, pair_set *set, const covering_case *the_case) {
  assert_true(c->case_count < COVERING_CASES);
  c->cases[c->case_count++] = *the_case;
  meet(set, c, the_case);
}

/* The best of a few cases that hold the pair. */
static void cover_pair(covering *c, pair_set *set, const covering_case *start, const bool *pinned) {
  enum { tries = 6 };
  covering_case best = *start;
  uint64_t most = 0;
  for (uint32_t i = 0; i < tries; ++i) {
    covering_case filled = *start;
    bool fixed[COVERING_OPTIONS];
    memcpy(fixed, pinned, sizeof fixed);
    fill(set, c, &filled, fixed, c->case_count * 101 + i);
    const uint64_t fresh = fresh_pairs(set, c, &filled);
    if (fresh > most) {
      best = filled;
      most = fresh;
    }
  }
  add_case(c, set, &best);
}

/* Begins a case with two levels, and what else it takes to combine them. */
static void cover_levels(covering *c, pair_set *set, uint32_t a, uint32_t level_a, uint32_t b, uint32_t level_b) {
  bool *met = pair_at(set, a, level_a, b, level_b);
  if (*met)
    return;
  covering_case start = {{0}};
  bool pinned[COVERING_OPTIONS] = {false};
  start.level[a] = (uint8_t)level_a;
  start.level[b] = (uint8_t)level_b;
  pinned[a] = pinned[b] = true;
  if (repair_least(c, &start, pinned)) {
    cover_pair(c, set, &start, pinned);
  } else {
    *met = true;
    --set->left;
    ++c->impossible;
  }
}

static void cover_alone(covering *c, pair_set *set) {
  for (uint32_t i = 0; i < c->option_count; ++i)
    for (uint32_t level = i ? 1 : 0; level < c->options[i].levels; ++level) {
      covering_case alone = {{0}};
      bool pinned[COVERING_OPTIONS] = {false};
      alone.level[i] = (uint8_t)level;
      pinned[i] = true;
      if (!repair_least(c, &alone, pinned))
        fail_msg("%s: nothing makes level %u possible", c->options[i].field.name, level);
      add_case(c, set, &alone);
    }
}

void covering_make(covering *c) {
  pair_set set;
  c->case_count = 0;
  c->impossible = 0;
  pairs_begin(&set, c);
  cover_alone(c, &set);
  for (uint32_t a = 0; a < c->option_count; ++a)
    for (uint32_t b = 0; b < a; ++b)
      for (uint32_t i = 0; i < c->options[a].levels; ++i)
        for (uint32_t k = 0; k < c->options[b].levels; ++k)
          cover_levels(c, &set, a, i, b, k);
  assert_int_equal(set.left, 0);
  free(set.met);
}

covering_case covering_random(const covering *c, uint64_t seed) {
  uint64_t state = seed * 7919 + 1;
  covering_case out = {{0}};
  uint32_t order[COVERING_OPTIONS];
  for (int round = 0; round < 2; ++round) { /* in the second, what another option stood against in the first */
    shuffle(order, c->option_count, &state);
    for (uint32_t i = 0; i < c->option_count; ++i) {
      const uint8_t before = out.level[order[i]];
      out.level[order[i]] = (uint8_t)pick(&state, c->options[order[i]].levels);
      if (!takes(c, &out))
        out.level[order[i]] = before;
    }
  }
  return out;
}
