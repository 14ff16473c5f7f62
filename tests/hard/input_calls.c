/* input_calls.c: calls of the whole ABI, as random_calls makes them, but that the input's bytes decide. */
#include "input.h"
#include "world.h"

#include <string.h>

uint32_t input_seeds(input_seed out[INPUT_SEEDS]) {
  static uint8_t bytes[4][4096];
  dice dice = {.state = 1};
  for (int i = 0; i < 4; ++i) {
    for (size_t at = 0; at < sizeof bytes[i]; at += 8) {
      const uint64_t bits = dice_bits(&dice);
      memcpy(bytes[i] + at, &bits, sizeof bits);
    }
    out[i] = (input_seed){bytes[i], sizeof bytes[i]};
  }
  return 4;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static world w; /* it is large */
  world_open(&w, "null", 1, NULL);
  w.dice.bytes = data;
  w.dice.left = size;
  while (w.dice.left >= 2)
    world_choose(&w)->call(&w);
  world_close(&w);
  return 0;
}
