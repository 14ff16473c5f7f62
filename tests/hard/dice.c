#include "dice.h"

#include <math.h>
#include <string.h>

uint64_t dice_bits(dice *dice) {
  if (dice->left >= 2) {
    dice->state = (uint64_t)dice->bytes[0] << 8 | dice->bytes[1];
    dice->bytes += 2;
    dice->left -= 2;
  }
  uint64_t x = dice->state += 0x9e3779b97f4a7c15u; /* splitmix64 */
  x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
  x = (x ^ x >> 27) * 0x94d049bb133111ebu;
  return x ^ x >> 31;
}

uint32_t dice_below(dice *dice, uint32_t count) {
  return (uint32_t)((dice_bits(dice) >> 32) * count >> 32);
}

bool dice_one_in(dice *dice, uint32_t count) {
  return dice_below(dice, count) == 0;
}

double dice_between(dice *dice, double low, double high) {
  return low + (high - low) * ((double)(dice_bits(dice) >> 11) * 0x1p-53);
}

double dice_scale(dice *dice, double low, double high) {
  return exp2(dice_between(dice, log2(low), log2(high)));
}

double dice_odd_real(dice *dice, double old) {
  const double special[] = {0.0,   -0.0,   1.0,    -1.0,   NAN,     INFINITY, -INFINITY,
                            1e300, -1e300, 5e-324, 1e-310, 1.7e308, 1e16,     -1e-16};
  const uint64_t bits = dice_bits(dice);
  double value;
  switch (dice_below(dice, 4)) {
  case 0:
    memcpy(&value, &bits, sizeof value);
    return value;
  case 1:
    return special[dice_below(dice, sizeof special / sizeof *special)];
  case 2:
    return old * dice_scale(dice, 1e-300, 1e300);
  default:
    return old + dice_between(dice, -2.0, 2.0);
  }
}

uint32_t dice_odd_whole(dice *dice, uint32_t old) {
  const uint32_t special[] = {0, 1, 2, 3, 7, 8, 9, 255, 256, 65535, 65536, INT32_MAX, 1u << 31, UINT32_MAX};
  switch (dice_below(dice, 4)) {
  case 0:
    return (uint32_t)dice_bits(dice);
  case 1:
    return old ^ 1u << dice_below(dice, 32);
  case 2:
    return old + dice_below(dice, 5) - 2;
  default:
    return special[dice_below(dice, sizeof special / sizeof *special)];
  }
}

uint64_t dice_fold(uint64_t hash, const void *bytes, size_t size) {
  const unsigned char *at = bytes;
  for (; size >= 8; size -= 8, at += 8) {
    uint64_t word;
    memcpy(&word, at, sizeof word);
    hash = (hash ^ word) * 0x9e3779b97f4a7c15u;
    hash ^= hash >> 29;
  }
  for (; size; --size)
    hash = (hash ^ *at++) * 0x100000001b3u;
  return hash;
}
