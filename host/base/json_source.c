#include "base/json_source.h"
#include "base/host.h"
#include <ctype.h>
#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int json_source_fail(const json_source *from, const char *key, const char *problem) {
  char subject[128] = "", line[32] = "";
  if (key)
    snprintf(subject, sizeof subject, "'%s' ", key);
  if (from->text) {
    char quoted[128];
    uint32_t number = from->line;
    snprintf(quoted, sizeof quoted, "\"%s\"", key ? key : "");
    const char *at = key ? strstr(from->text, quoted) : NULL;
    for (const char *c = from->text; at && c < at; c++)
      number += *c == '\n';
    snprintf(line, sizeof line, "line %u: ", number);
  }
  return host_fail(HOST_BAD_INPUT, "%s: %s%s%s", from->name, line, subject, problem);
}

static char *read_text(const char *name, const char *path) {
  char *text = host_read_file(path, NULL);
  if (!text)
    host_fail(HOST_BAD_INPUT, "%s: cannot open '%s': %s", name, path, strerror(errno));
  return text;
}

/* Finds where each element of the outermost list begins. Precondition: the text is JSON. */
static void find_elements(json_list *list) {
  uint32_t line = 1, depth = 0;
  size_t found = 0;
  bool quoted = false, before_value = false;
  for (const char *at = list->text; *at && found < list->count; at++) {
    line += *at == '\n';
    if (before_value && !isspace((unsigned char)*at)) {
      list->elements[found++] = (json_source){.name = list->name, .text = at, .line = line};
      before_value = false;
    }
    if (quoted) {
      quoted = *at != '"';
      at += *at == '\\';
      continue;
    }
    quoted = *at == '"';
    depth += *at == '[' || *at == '{';
    depth -= *at == ']' || *at == '}';
    before_value = before_value || (depth == 1 && (*at == ',' || *at == '['));
  }
}

int json_list_load(json_list *out, const char *name, const char *path) {
  json_error_t error;
  *out = (json_list){.text = read_text(name, path)};
  snprintf(out->name, sizeof out->name, "%s: '%s'", name, path);
  if (!out->text)
    return HOST_BAD_INPUT;
  out->root = json_loads(out->text, JSON_REJECT_DUPLICATES, &error);
  if (!out->root)
    return host_fail(HOST_BAD_INPUT, "%s: '%s': line %d: %s", name, path, error.line, error.text);
  out->count = json_array_size(out->root);
  if (out->count == 0)
    return host_fail(HOST_BAD_INPUT, "%s: '%s' must be a list with at least one element", name, path);
  out->elements = host_allocate(out->count, sizeof *out->elements);
  find_elements(out);
  return 0;
}

void json_list_free(json_list *list) {
  json_decref(list->root);
  free(list->text);
  free(list->elements);
  *list = (json_list){0};
}
