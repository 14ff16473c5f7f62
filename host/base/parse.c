#include "base/parse.h"
#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* One number up to `end`; hexadecimal, names such as inf, and leading blanks are not numbers here. */
static bool parse_range(const char *text, const char *end, double *out) {
  if (text == end)
    return false;
  for (const char *at = text; at < end; at++)
    if (!isdigit((unsigned char)*at) && !strchr("+-.eE", *at))
      return false;
  char *stopped;
  *out = strtod(text, &stopped);
  return stopped == end && isfinite(*out);
}

bool parse_number(const char *text, double *out) {
  return parse_range(text, text + strlen(text), out);
}

uint32_t parse_numbers(const char *text, char separator, double *out, uint32_t capacity) {
  for (uint32_t count = 0; count < capacity; count++) {
    const char *end = strchr(text, separator);
    if (!parse_range(text, end ? end : text + strlen(text), &out[count]))
      return 0;
    if (!end)
      return count + 1;
    text = end + 1;
  }
  return 0;
}

bool parse_size(const char *text, uint32_t *width, uint32_t *height) {
  double sides[2];
  if (parse_numbers(text, 'x', sides, 2) != 2)
    return false;
  for (int i = 0; i < 2; i++)
    if (!(sides[i] >= 1.0 && sides[i] <= 16384.0) || sides[i] != floor(sides[i]))
      return false;
  *width = (uint32_t)sides[0];
  *height = (uint32_t)sides[1];
  return true;
}
