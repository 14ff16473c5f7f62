/*
 * mutate.c: changes seeds by a fixed chance, and tries what comes of them, in a child process: so what crashes, leaks or
 * hangs is told by its number, and kept in a file.
 *
 *   mutate_TARGET [--count N] [--seed N] [--minutes N] [--seeds FOLDER] [FILE ...]
 *
 * With FILEs, tries those. With --seeds, writes the seeds there, for libFuzzer to begin with.
 */
#include "dice.h"
#include "input.h"

#include <ctype.h>
#include <dlfcn.h>
#include <execinfo.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

enum { ROOM = 1 << 16, LONGEST_S = 60 };

typedef struct text {
  uint8_t bytes[ROOM];
  size_t size;
} text;

/* ---- changes ---- */

/* Puts bytes in the place of a part. */
static void replace(text *t, size_t at, size_t gone, const void *with, size_t size) {
  if (t->size - gone + size > ROOM)
    return;
  memmove(t->bytes + at + size, t->bytes + at + gone, t->size - at - gone);
  memcpy(t->bytes + at, with, size);
  t->size += size - gone;
}

static size_t any_place(dice *dice, const text *t) {
  return dice_below(dice, (uint32_t)t->size + 1);
}

/* A part of another seed, or of this one. */
static void splice(dice *dice, text *t, const input_seed *seeds, uint32_t count) {
  const input_seed *from = &seeds[dice_below(dice, count)];
  const size_t begin = dice_below(dice, (uint32_t)from->size + 1), most = from->size - begin;
  const size_t size = dice_below(dice, (uint32_t)(most < 200 ? most : 200) + 1), at = any_place(dice, t);
  const size_t gone = dice_below(dice, (uint32_t)(t->size - at < 50 ? t->size - at : 50) + 1);
  replace(t, at, gone, (const uint8_t *)from->data + begin, size);
}

/* Another number where there is one, or another word in place of a quoted one. */
static void change_token(dice *dice, text *t) {
  static const char *const numbers[] = {"-1",         "0",          "1",    "2",     "3",     "7",   "65535", "65536",
                                        "2147483648", "4294967295", "1e30", "-1e30", "1e300", "0.5", "1e-320"};
  static const char *const words[] = {
      "null", "true", "[]", "{}", "\"\"", "1e999", "[1,2,3]", "{\"a\":1}", "18446744073709551616"};
  const size_t from = any_place(dice, t);
  size_t at = from;
  while (at < t->size && !isdigit(t->bytes[at]))
    ++at;
  size_t end = at;
  while (end < t->size && (isdigit(t->bytes[end]) || strchr(".eE+-", t->bytes[end])))
    ++end;
  const char *with = dice_one_in(dice, 5) ? words[dice_below(dice, sizeof words / sizeof *words)]
                                          : numbers[dice_below(dice, sizeof numbers / sizeof *numbers)];
  replace(t, at, end - at, with, strlen(with));
}

/* Another digit where there is one. */
static void change_digit(dice *dice, text *t) {
  size_t at = any_place(dice, t);
  while (at < t->size && !isdigit(t->bytes[at]))
    ++at;
  if (at < t->size)
    t->bytes[at] = (uint8_t)('0' + dice_below(dice, 10));
}

/* Another number among those that are stored as bytes. */
static void change_number(dice *dice, text *t) {
  const bool wide = dice_one_in(dice, 2);
  const size_t each = wide ? 8 : 4, at = any_place(dice, t) / each * each;
  uint32_t whole;
  double real;
  if (at + each > t->size)
    return;
  memcpy(&whole, t->bytes + at, sizeof whole);
  memcpy(&real, t->bytes + at, wide ? sizeof real : 0);
  real = wide ? dice_odd_real(dice, real) : 0;
  whole = dice_odd_whole(dice, whole);
  memcpy(t->bytes + at, wide ? (const void *)&real : &whole, each);
}

static bool is_text(const text *t) {
  bool printable = true;
  for (size_t i = 1; i < t->size && i < 64; ++i)
    printable = printable && (isprint(t->bytes[i]) || isspace(t->bytes[i]));
  return printable;
}

static void change(dice *dice, text *t, const input_seed *seeds, uint32_t count) {
  const uint8_t byte = (uint8_t)dice_bits(dice);
  const size_t at = any_place(dice, t);
  const size_t most = t->size - at, part = dice_below(dice, (uint32_t)(most < 64 ? most : 64) + 1);
  switch (dice_below(dice, 8)) {
  case 0:
    if (at < t->size)
      t->bytes[at] ^= (uint8_t)(1u << byte % 8);
    break;
  case 1:
    replace(t, at, at < t->size, &byte, 1);
    break;
  case 2:
    replace(t, at, part, "", 0);
    break;
  case 3:
    splice(dice, t, seeds, count);
    break;
  case 4:
  case 5:
    (is_text(t) ? change_digit : change_number)(dice, t);
    break;
  default:
    (is_text(t) ? change_token : change_number)(dice, t);
  }
}

/* The input of a number. */
static void make(text *t, uint64_t seed, const input_seed *seeds, uint32_t count) {
  dice dice = {.state = seed * 0x9e3779b97f4a7c15u};
  const input_seed *from = &seeds[dice_below(&dice, count)];
  memcpy(t->bytes, from->data, from->size);
  t->size = from->size;
  for (uint32_t changes = 1 + dice_below(&dice, 1 + dice_below(&dice, 4)); changes; --changes)
    change(&dice, t, seeds, count);
}

/* ---- trying ---- */

/* What parent and child both see. */
typedef struct shared {
  uint64_t at;
  text input;
} shared;

/* Whether Assimp is among those that called what crashed. */
static bool is_foreign(void) {
  void *frames[100];
  const int count = backtrace(frames, sizeof frames / sizeof *frames);
  bool found = false;
  for (int i = 0; i < count; ++i) {
    Dl_info object = {0};
    found = found || (dladdr(frames[i], &object) && object.dli_fname && strstr(object.dli_fname, "libassimp"));
  }
  return found;
}

/* A crash, or a hang, of a library that is not csm's own cannot be mended here. */
static void crashed(int sent) {
  if (is_foreign())
    _exit(INPUT_FOREIGN);
  signal(sent, SIG_DFL);
  raise(sent);
}

static void watch(void) {
  const struct sigaction action = {.sa_handler = crashed, .sa_flags = SA_ONSTACK};
  void *first[1];
  backtrace(first, 1); /* loads what it needs */
  sigaction(SIGSEGV, &action, NULL);
  sigaction(SIGBUS, &action, NULL);
  sigaction(SIGALRM, &action, NULL);
}

typedef struct settings {
  uint64_t seed, count;
  double end; /* seconds of the clock; 0: none */
} settings;

static double seconds(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static bool more(const settings *s, uint64_t at) {
  return s->end > 0 ? seconds() < s->end : at < s->count;
}

static void try_all(shared *shared, const settings *s) {
  input_seed seeds[INPUT_SEEDS];
  const uint32_t count = input_seeds(seeds);
  watch();
  for (; more(s, shared->at); ++shared->at) {
    make(&shared->input, s->seed + shared->at, seeds, count);
    alarm(LONGEST_S);
    LLVMFuzzerTestOneInput(shared->input.bytes, shared->input.size);
  }
}

static void keep_input(const shared *shared, const settings *s, int status) {
  char name[64];
  snprintf(name, sizeof name, "mutated-%llu", (unsigned long long)(s->seed + shared->at));
  FILE *file = fopen(name, "wb");
  if (file) {
    fwrite(shared->input.bytes, shared->input.size, 1, file);
    fclose(file);
  }
  printf("input %llu of %zu bytes: %s %d; it is in the file %s\n", (unsigned long long)(s->seed + shared->at),
         shared->input.size, WIFSIGNALED(status) ? "signal" : "exit status",
         WIFSIGNALED(status) ? WTERMSIG(status) : WEXITSTATUS(status), name);
}

/* Goes on behind what crashed in a library. */
static int try_in_children(const settings *s) {
  shared *shared = mmap(NULL, sizeof *shared, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  uint64_t foreign = 0;
  if (shared == MAP_FAILED)
    return 1;
  while (more(s, shared->at)) {
    int status = 0;
    fflush(stdout);
    const pid_t child = fork();
    if (child == 0) {
      try_all(shared, s);
      exit(0);
    }
    if (child < 0 || waitpid(child, &status, 0) != child)
      return 1;
    if (WIFEXITED(status) && WEXITSTATUS(status) == INPUT_FOREIGN) {
      ++foreign;
      ++shared->at;
    } else if (status) {
      keep_input(shared, s, status);
      return 1;
    }
  }
  printf("%llu inputs tried; Assimp crashed or hung in %llu of them\n", (unsigned long long)shared->at,
         (unsigned long long)foreign);
  return 0;
}

static void try_file(const char *path) {
  static text input;
  FILE *file = fopen(path, "rb");
  if (!file)
    exit(2);
  input.size = fread(input.bytes, 1, ROOM, file);
  fclose(file);
  LLVMFuzzerTestOneInput(input.bytes, input.size);
}

static void write_seeds(const char *folder) {
  input_seed seeds[INPUT_SEEDS];
  const uint32_t count = input_seeds(seeds);
  for (uint32_t i = 0; i < count; ++i) {
    char path[4096];
    snprintf(path, sizeof path, "%s/seed%u", folder, i);
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(seeds[i].data, seeds[i].size, 1, file) != 1 || fclose(file) != 0)
      exit(2);
  }
}

int main(int argc, char **argv) {
  settings s = {.count = 1000};
  bool files = false;
  for (int i = 1; i < argc; ++i) {
    const char *value = i + 1 < argc ? argv[i + 1] : "";
    if (argv[i][0] != '-') {
      try_file(argv[i]);
      files = true;
      continue;
    }
    if (!strcmp(argv[i], "--count"))
      s.count = strtoull(value, NULL, 10);
    else if (!strcmp(argv[i], "--seed"))
      s.seed = strtoull(value, NULL, 10);
    else if (!strcmp(argv[i], "--minutes"))
      s.end = seconds() + 60 * strtod(value, NULL);
    else if (!strcmp(argv[i], "--seeds"))
      write_seeds(value);
    files = files || !strcmp(argv[i], "--seeds");
    ++i;
  }
  return files ? 0 : try_in_children(&s);
}
