/* base/parse.h: numbers out of text, strictly. */
#ifndef HOST_PARSE_H
#define HOST_PARSE_H

#include <stdbool.h>
#include <stdint.h>

/* The whole text is one finite decimal number. */
bool parse_number(const char *text, double *out);
/* Up to `capacity` finite numbers with `separator` between them, and nothing else. Returns how many, or 0. */
uint32_t parse_numbers(const char *text, char separator, double *out, uint32_t capacity);
/* "1280x720": both sides 1 to 16384. */
bool parse_size(const char *text, uint32_t *width, uint32_t *height);

#endif
