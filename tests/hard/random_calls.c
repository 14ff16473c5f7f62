/*
 * random_calls.c: calls of the whole ABI, right and wrong, that are a function of a seed. Each seed is the life of one
 * context. Prints a line for each, which is the same for every backend, but for what is drawn and for a backend that
 * draws nothing: same_answers.py compares them.
 *
 *   random_calls BACKEND [--seed N] [--lives N] [--calls N] [--minutes N] [--trace]
 */
#include "world.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

typedef struct settings {
  const char *backend;
  uint64_t seed, lives, calls; /* calls: of each life */
  double minutes;              /* lives go on for so long; 0: as many as are asked for */
  bool trace;
} settings;

/* Where it is, for whoever reads that it failed. */
typedef struct place {
  uint64_t seed, step;
  const char *call;
} place;

static void say_place(const place *at) {
  fprintf(stderr, "seed %" PRIu64 ", step %" PRIu64 ", %s\n", at->seed, at->step, at->call);
}

/* ---- a call ---- */

static bool is_memory(csm_result result) {
  return result == CSM_ERROR_OUT_OF_MEMORY || result == CSM_ERROR_OUT_OF_DEVICE_MEMORY;
}

static void expect_same_looks(world *w, uint64_t before, const char *why) {
  if (world_looks(w) != before)
    fail_msg("a call that failed, %s, changed what there is", why);
}

/* Each allocation of the call fails in turn, until it has them all. */
static csm_result call_with_failures(world *w, const world_call *call) {
  const dice dice = w->dice;
  const uint64_t before = world_looks(w);
  csm_result result = CSM_ERROR_OUT_OF_MEMORY;
  for (int64_t left = 0; is_memory(result); ++left) {
    w->dice = dice;
    w->record.allocations_left = left;
    result = call->call(w);
    w->record.allocations_left = -1;
    if (is_memory(result))
      expect_same_looks(w, before, "for want of memory");
    if (left > 1000)
      fail_msg("1000 allocations are not enough");
  }
  return result;
}

static csm_result make_call(world *w, const world_call *call, bool failures, bool looks) {
  if (failures && !call->opens)
    return call_with_failures(w, call);
  const uint64_t before = looks ? world_looks(w) : 0;
  const csm_result result = call->call(w);
  if (result && looks)
    expect_same_looks(w, before, csm_result_name(result));
  return result;
}

/* ---- a life ---- */

static void live(const settings *s, lent *lent, place *at) {
  static world w; /* it is large */
  dice chance = {.state = ~at->seed};
  at->step = 0;
  at->call = "opening";
  world_open(&w, s->backend, at->seed, lent);
  for (; at->step < s->calls; ++at->step) {
    const world_call *call = world_choose(&w);
    const bool failures = dice_one_in(&chance, 8), looks = dice_one_in(&chance, 8);
    at->call = call->name;
    const csm_result result = make_call(&w, call, failures, looks);
    assert_string_not_equal(csm_result_name(result), "CSM_RESULT_UNKNOWN");
    if (result == CSM_ERROR_DEVICE_LOST || is_memory(result) || result == CSM_ERROR_DEVICE)
      fail_msg("%s: %s", csm_result_name(result), csm_last_error(w.context));
    world_answer(&w, &result, sizeof result);
    if (s->trace)
      printf("%" PRIu64 " %s: %s, answers %016" PRIx64 ", pictures %016" PRIx64 "%s\n", at->step, call->name,
             csm_result_name(result), w.answers, w.pictures, result ? csm_last_error(w.context) : "");
  }
  at->call = "closing";
  const uint64_t answers = w.answers, pictures = w.pictures;
  world_close(&w);
  printf("seed %" PRIu64 ": %" PRIu64 " calls, answers %016" PRIx64 ", pictures %016" PRIx64 "\n", at->seed, s->calls,
         answers, pictures);
  fflush(stdout);
}

static settings chosen;
static place now;

static int name_place(void **state) {
  (void)state;
  if (now.call)
    say_place(&now);
  return 0;
}

static double minutes(void) {
  struct timespec time;
  clock_gettime(CLOCK_MONOTONIC, &time);
  return ((double)time.tv_sec + 1e-9 * (double)time.tv_nsec) / 60;
}

static void lives(void **state) {
  (void)state;
  const double begin = minutes();
  lent *lent = lent_open();
  for (uint64_t i = 0; chosen.minutes > 0 ? minutes() - begin < chosen.minutes : i < chosen.lives; ++i) {
    now.seed = chosen.seed + i;
    live(&chosen, lent, &now);
  }
  now.call = NULL;
  if (lent)
    lent_close(lent);
}

int main(int argc, char **argv) {
  chosen = (settings){.seed = 1, .lives = 20, .calls = 500};
  for (int i = 1; i < argc; ++i) {
    const char *value = i + 1 < argc ? argv[i + 1] : "";
    if (!strcmp(argv[i], "--trace")) {
      chosen.trace = true;
    } else if (argv[i][0] != '-') {
      chosen.backend = argv[i];
    } else {
      uint64_t *number = !strcmp(argv[i], "--seed")    ? &chosen.seed
                         : !strcmp(argv[i], "--lives") ? &chosen.lives
                         : !strcmp(argv[i], "--calls") ? &chosen.calls
                                                       : NULL;
      if (number)
        *number = strtoull(value, NULL, 10);
      else
        chosen.minutes = strtod(value, NULL);
      ++i;
    }
  }
  if (!chosen.backend) {
    fprintf(stderr, "usage: %s BACKEND [--seed N] [--lives N] [--calls N] [--minutes N] [--trace]\n", argv[0]);
    return 2;
  }
  const struct CMUnitTest tests[] = {cmocka_unit_test_teardown(lives, name_place)};
  return cmocka_run_group_tests_name("random calls", tests, NULL, NULL);
}
