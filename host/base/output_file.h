/* base/output_file.h: files that are there whole, or not at all. */
#ifndef HOST_OUTPUT_FILE_H
#define HOST_OUTPUT_FILE_H

#include "base/interrupt.h"
#include <stdio.h>

enum { OUTPUT_PATH_SIZE = 4096 };

/* A file in a folder. 0, or HOST_BAD_INPUT after a message: `path` has no room for it. */
__attribute__((format(printf, 3, 4))) int output_path(char path[OUTPUT_PATH_SIZE], const char *folder,
                                                      const char *format, ...);

typedef struct output_file {
  FILE *stream;
  char path[OUTPUT_PATH_SIZE];         /* where it goes, links followed */
  char partial[OUTPUT_PATH_SIZE + 32]; /* where it lies until it is whole; "": in place */
  interrupt_hold hold;
} output_file;

/*
 * Begins a file that replaces what was there only once it is whole; interrupts wait until then. What is no file (a
 * pipe, a terminal) is written as it comes. NULL, or why it cannot be: then there is nothing to close.
 */
const char *output_file_open(output_file *out, const char *path);
/*
 * Puts the file in its place, unless there is a problem, or the stream had one: then what was there stays. NULL, or the
 * problem.
 */
const char *output_file_close(output_file *file, const char *problem);

#endif
