#include "base/json_file.h"
#include "base/host.h"
#include <errno.h>
#include <stdio.h>
#include <string.h>

json_t *json_file_load(const char *option, const char *path) {
  FILE *file = fopen(path, "rb");
  json_error_t error;
  if (!file) {
    host_fail(HOST_BAD_INPUT, "%s: cannot open '%s': %s", option, path, strerror(errno));
    return NULL;
  }
  json_t *root = json_loadf(file, JSON_REJECT_DUPLICATES, &error);
  fclose(file);
  if (!root)
    host_fail(HOST_BAD_INPUT, "%s: '%s': line %d: %s", option, path, error.line, error.text);
  else if (!json_is_object(root))
    host_fail(HOST_BAD_INPUT, "%s: '%s' is not a JSON object", option, path);
  else
    return root;
  json_decref(root);
  return NULL;
}
