/* app.h: what both mini-engines have around them: options, the end with an error, memory, time and the picture. */
#ifndef EXAMPLE_APP_H
#define EXAMPLE_APP_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { APP_FAILED = 1, APP_BAD_INPUT = 2, APP_NO_DEVICE = 3 }; /* exit codes */

typedef struct app_options {
  const char *csm; /* the library: --csm FILE */
  const char *out; /* the picture: --out FILE */
  bool validate;   /* --validate */
} app_options;

/* Ends the program after a message where an option is not known. */
void app_parse(app_options *out, int count, char **arguments);

/* Prints the message and ends the program. */
__attribute__((noreturn, format(printf, 2, 3))) void app_fail(int code, const char *format, ...);

/* Zeroed memory; ends the program when there is none. */
void *app_allocate(size_t count, size_t size);

double app_now_ms(void);

/* The median of a few numbers, which it sorts. */
double app_median(double *values, uint32_t count);

/* Writes the rows (four bytes a pixel, the last one ignored) as a PNG; ends the program where it cannot. */
void app_write_png(const char *path, const uint8_t *pixels, uint32_t width, uint32_t height);

#endif
