/* covering.h: configurations in which every level of every option meets every level of every other one. */
#ifndef COVERING_H
#define COVERING_H

#include "support.h"

enum { COVERING_OPTIONS = 96, COVERING_LEVELS = 20, COVERING_CASES = 512 };

/* A field of csm_config with the values that it takes here; the first is where other options are looked at alone. */
typedef struct covering_option {
  csm_config_field field;
  uint32_t levels;
  double values[COVERING_LEVELS][CSM_MAX_CASCADES];
} covering_option;

typedef struct covering_case {
  uint8_t level[COVERING_OPTIONS];
} covering_case;

/* Whether csm takes a configuration. */
typedef bool (*covering_takes)(void *user, const csm_config *config);

typedef struct covering {
  covering_option options[COVERING_OPTIONS];
  uint32_t option_count, level_count;
  covering_takes takes;
  void *user;
  uint64_t pairs, impossible; /* pairs of levels, and those of them that no configuration has */
  covering_case cases[COVERING_CASES];
  uint32_t case_count;
} covering;

/* The options and levels, from csm_config_describe. */
void covering_options(covering *out);
/* The cases: each level alone first, then all pairs that are not in one of those. */
void covering_make(covering *c);
/* A case that csm takes, chosen by `seed` alone. */
covering_case covering_random(const covering *c, uint64_t seed);

csm_config covering_config(const covering *c, const covering_case *the_case);
/* What of a case is not the first level, as "name=value ...". */
void covering_text(const covering *c, const covering_case *the_case, char *text, size_t size);

#endif
