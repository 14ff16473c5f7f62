/* dice.h: chance that is a function of a seed, and values that hurt. */
#ifndef DICE_H
#define DICE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct dice {
  uint64_t state;
  const uint8_t *bytes; /* that decide in the place of the seed, two for each throw, while there are any */
  size_t left;
} dice;

uint64_t dice_bits(dice *dice);
/* 0 to count - 1. */
uint32_t dice_below(dice *dice, uint32_t count);
bool dice_one_in(dice *dice, uint32_t count);
double dice_between(dice *dice, double low, double high);
/* Between two positive numbers, each power as likely as another. */
double dice_scale(dice *dice, double low, double high);

/* What a caller may have put by mistake where `old` should be. */
double dice_odd_real(dice *dice, double old);
uint32_t dice_odd_whole(dice *dice, uint32_t old);

/* Folds bytes into a hash. */
uint64_t dice_fold(uint64_t hash, const void *bytes, size_t size);

#endif
