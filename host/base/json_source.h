/* base/json_source.h: where a value stands in a file, so that what is wrong with it can be told with its line. */
#ifndef HOST_JSON_SOURCE_H
#define HOST_JSON_SOURCE_H

#include <jansson.h>
#include <stddef.h>
#include <stdint.h>

typedef struct json_source {
  const char *name; /* of the option or file, as a message begins */
  const char *text; /* where the value begins in the file; NULL: unknown */
  uint32_t line;    /* of that place */
} json_source;

/* Prints "name: line N: 'key' problem", the line being that of the key. key may be NULL. Returns HOST_BAD_INPUT. */
int json_source_fail(const json_source *from, const char *key, const char *problem);

/* A list in a file: each element, and where it stands. */
typedef struct json_list {
  char name[512];
  char *text;
  json_t *root;
  size_t count;
  json_source *elements;
} json_list;

/* Loads a file that holds a list of at least one element. The option `name` begins its messages. 0, or HOST_BAD_INPUT
 * after a message; json_list_free is allowed in both cases. */
int json_list_load(json_list *out, const char *name, const char *path);
void json_list_free(json_list *list);

#endif
