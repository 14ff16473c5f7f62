#include "scene/gltf_document.h"
#include "base/host.h"
#include <errno.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { GLB_MAGIC = 0x46546c67, GLB_JSON = 0x4e4f534a };

/* ---- reading ---- */

static json_t *parse(const char *path, const char *text, size_t size) {
  json_error_t error;
  json_t *document = json_loadb(text, size, 0, &error);
  if (!document)
    host_fail(HOST_BAD_INPUT, "the scene '%s' is truncated or broken: line %d: %s", path, error.line, error.text);
  return document;
}

/* A header of magic, version and length; then the length and type of the first chunk, which is the JSON. */
static json_t *parse_binary(const char *path, const char *data, size_t size) {
  uint32_t header[5] = {0};
  memcpy(header, data, size < sizeof header ? size : sizeof header);
  if (header[0] != GLB_MAGIC || header[1] != 2)
    host_fail(HOST_BAD_INPUT, "the scene '%s' is not binary glTF 2.0", path);
  else if (header[2] > size)
    host_fail(HOST_BAD_INPUT, "the scene '%s' is truncated: it has %zu of %u bytes", path, size, header[2]);
  else if (size < sizeof header || header[4] != GLB_JSON || header[3] > size - sizeof header)
    host_fail(HOST_BAD_INPUT, "the scene '%s' is broken: it does not begin with a chunk of JSON", path);
  else
    return parse(path, data + sizeof header, header[3]);
  return NULL;
}

static char *read_whole(const char *path, size_t *size) {
  struct stat status;
  FILE *file = stat(path, &status) == 0 ? fopen(path, "rb") : NULL;
  if (!file) {
    host_fail(HOST_BAD_INPUT, "cannot open the scene '%s': %s", path, strerror(errno));
    return NULL;
  }
  if (!S_ISREG(status.st_mode)) {
    fclose(file);
    host_fail(HOST_BAD_INPUT, "the scene '%s' is not a file", path);
    return NULL;
  }
  char *data = host_allocate((size_t)status.st_size, 1);
  *size = fread(data, 1, (size_t)status.st_size, file);
  fclose(file);
  return data;
}

/* These change how positions or indices are stored. */
static const char *unread_extension(const json_t *document) {
  static const char *const unread[] = {"KHR_draco_mesh_compression", "EXT_meshopt_compression",
                                       "KHR_mesh_quantization"};
  size_t index;
  json_t *name;
  json_array_foreach(json_object_get(document, "extensionsRequired"), index, name) {
    for (size_t i = 0; i < sizeof unread / sizeof unread[0]; i++)
      if (json_is_string(name) && strcmp(json_string_value(name), unread[i]) == 0)
        return unread[i];
  }
  return NULL;
}

static bool check(const char *path, const json_t *document) {
  const char *extension = unread_extension(document);
  if (!json_is_object(json_object_get(document, "asset")))
    host_fail(HOST_BAD_INPUT, "the scene '%s' is not glTF: it has no 'asset'", path);
  else if (extension)
    host_fail(HOST_BAD_INPUT, "the scene '%s' needs %s, which is not read here", path, extension);
  else
    return true;
  return false;
}

json_t *gltf_document_load(const char *path) {
  const char *dot = strrchr(path, '.');
  const bool text = dot && strcmp(dot, ".gltf") == 0, binary = dot && strcmp(dot, ".glb") == 0;
  size_t size;
  char *data = read_whole(path, &size);
  json_t *document = NULL;
  if (!data)
    return NULL;
  if (text)
    document = parse(path, data, size);
  else if (binary)
    document = parse_binary(path, data, size);
  else
    host_fail(HOST_BAD_INPUT, "the scene '%s' is neither .gltf nor .glb", path);
  free(data);
  if (document && !check(path, document)) {
    json_decref(document);
    document = NULL;
  }
  return document;
}

/* ---- counting ---- */

typedef struct counter {
  const json_t *document;
  bool *seen_nodes, *seen_meshes;
  uint64_t triangles;
} counter;

static const json_t *element(const json_t *document, const char *array, const json_t *index) {
  return json_array_get(json_object_get(document, array), (size_t)json_integer_value(index));
}

static uint64_t accessor_count(const json_t *document, const json_t *index) {
  return (uint64_t)json_integer_value(json_object_get(element(document, "accessors", index), "count"));
}

static uint64_t primitive_triangles(const json_t *document, const json_t *primitive) {
  enum { TRIANGLES = 4, STRIP = 5, FAN = 6 };
  const json_t *mode = json_object_get(primitive, "mode"), *indices = json_object_get(primitive, "indices");
  const json_t *positions = json_object_get(json_object_get(primitive, "attributes"), "POSITION");
  const json_int_t kind = mode ? json_integer_value(mode) : TRIANGLES;
  if (!positions)
    return 0;
  const uint64_t count = accessor_count(document, indices ? indices : positions);
  if (kind == TRIANGLES)
    return count / 3;
  return (kind == STRIP || kind == FAN) && count >= 3 ? count - 2 : 0;
}

static bool first_visit(bool *seen, size_t count, const json_t *index) {
  const size_t at = (size_t)json_integer_value(index);
  if (!json_is_integer(index) || at >= count || seen[at])
    return false;
  return seen[at] = true;
}

static void count_mesh(counter *c, const json_t *index) {
  size_t i;
  json_t *primitive;
  if (!first_visit(c->seen_meshes, json_array_size(json_object_get(c->document, "meshes")), index))
    return;
  json_array_foreach(json_object_get(element(c->document, "meshes", index), "primitives"), i, primitive) {
    c->triangles += primitive_triangles(c->document, primitive);
  }
}

static void count_nodes(counter *c, const json_t *indices) {
  size_t i;
  json_t *index;
  json_array_foreach(indices, i, index) {
    if (!first_visit(c->seen_nodes, json_array_size(json_object_get(c->document, "nodes")), index))
      continue;
    const json_t *node = element(c->document, "nodes", index);
    count_mesh(c, json_object_get(node, "mesh"));
    count_nodes(c, json_object_get(node, "children"));
  }
}

uint64_t gltf_document_triangles(const json_t *document) {
  counter c = {.document = document};
  c.seen_nodes = host_allocate(json_array_size(json_object_get(document, "nodes")), sizeof(bool));
  c.seen_meshes = host_allocate(json_array_size(json_object_get(document, "meshes")), sizeof(bool));
  count_nodes(&c, json_object_get(element(document, "scenes", json_object_get(document, "scene")), "nodes"));
  free(c.seen_nodes);
  free(c.seen_meshes);
  return c.triangles;
}
