/*
 * input.h: ways for input to come in, each a program with mutate.c, which changes small seeds, or with libFuzzer, which
 * looks where a change leads (./dev fuzz).
 */
#ifndef INPUT_H
#define INPUT_H

#include <stddef.h>
#include <stdint.h>

/* Tries one input, which must not crash, leak or hang; always 0. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

typedef struct input_seed {
  const void *data;
  size_t size;
} input_seed;

/* Good inputs; returns how many, at most INPUT_SEEDS. */
enum { INPUT_SEEDS = 8 };
uint32_t input_seeds(input_seed out[INPUT_SEEDS]);

/* The exit status of a process that crashed in somebody else's code. */
enum { INPUT_FOREIGN = 77 };

/* ---- input_file.c ---- */

/* The path of a file with the input in it, which the next one of this process overwrites. */
const char *input_file(const uint8_t *data, size_t size, const char *ending);
/* A folder of this process's own, which is removed with what it holds at its end. */
const char *input_folder(void);
/* Messages about bad input are expected: they go nowhere. */
void input_quiet(void);

#endif
