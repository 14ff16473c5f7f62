#include "scene/gltf_document.h"
#include "base/host.h"
#include <ctype.h>
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

/* ---- what a file may name ---- */

static int hex_digit(char c) {
  const char *digits = "0123456789abcdef", *at = c ? strchr(digits, tolower((unsigned char)c)) : NULL;
  return at ? (int)(at - digits) : -1;
}

/* Undoes percent-encoding. `to` has room for the text. */
static void decode(char *to, const char *from) {
  for (; *from; from++) {
    const int high = *from == '%' ? hex_digit(from[1]) : -1, low = high >= 0 ? hex_digit(from[2]) : -1;
    *to++ = low >= 0 ? (char)(high * 16 + low) : *from;
    from += low >= 0 ? 2 : 0;
  }
  *to = '\0';
}

/* Whether a name leads to anywhere but beside the scene or below it. */
static bool leads_away(const char *name) {
  if (name[0] == '/' || name[0] == '\\' || strchr(name, ':'))
    return true;
  for (const char *part = name; part; part = strpbrk(part, "/\\")) {
    part += part > name;
    if (strncmp(part, "..", 2) == 0 && (part[2] == '\0' || part[2] == '/' || part[2] == '\\'))
      return true;
  }
  return false;
}

/* Of a file that is there: a device or a pipe would be read for ever. */
static bool is_no_file(const char *scene, const char *name) {
  char path[4096];
  struct stat status;
  const char *slash = strrchr(scene, '/');
  snprintf(path, sizeof path, "%.*s%s", slash ? (int)(slash - scene + 1) : 0, scene, name);
  return stat(path, &status) == 0 && !S_ISREG(status.st_mode);
}

static bool check_name(const char *path, const char *uri) {
  char *name = host_allocate(strlen(uri) + 1, 1);
  decode(name, uri);
  const bool away = leads_away(uri) || leads_away(name);
  const bool good = !away && !is_no_file(path, name) && !is_no_file(path, uri);
  if (!good)
    host_fail(HOST_BAD_INPUT, "the scene '%s' names '%.200s', which is %s", path, uri,
              away ? "neither beside it nor below it" : "no file");
  free(name);
  return good;
}

/* Assimp crashes where an image in the text does not say what it is. */
static bool check_data(const char *path, const char *uri, bool image) {
  const bool good = !image || strncmp(uri, "data:image/", 11) == 0;
  if (!good)
    host_fail(HOST_BAD_INPUT, "the scene '%s' has an image that does not say what it is", path);
  return good;
}

static bool check_names(const char *path, const json_t *document) {
  static const char *const kinds[] = {"buffers", "images"};
  bool good = true;
  for (int kind = 0; kind < 2; kind++) {
    size_t index;
    json_t *element;
    json_array_foreach(json_object_get(document, kinds[kind]), index, element) {
      const char *uri = json_string_value(json_object_get(element, "uri"));
      if (good && uri)
        good = strncmp(uri, "data:", 5) == 0 ? check_data(path, uri, kind == 1) : check_name(path, uri);
    }
  }
  return good;
}

/* Assimp crashes where a skin leaves out its matrices, which glTF allows. */
static bool has_bare_skin(const json_t *document) {
  size_t index;
  json_t *skin;
  json_array_foreach(json_object_get(document, "skins"), index, skin) {
    if (!json_object_get(skin, "inverseBindMatrices"))
      return true;
  }
  return false;
}

static const char *walk_nodes(const json_t *document, uint64_t *triangles);

static bool check(const char *path, const json_t *document) {
  const char *extension = unread_extension(document);
  uint64_t triangles;
  if (!json_is_object(json_object_get(document, "asset"))) {
    host_fail(HOST_BAD_INPUT, "the scene '%s' is not glTF: it has no 'asset'", path);
    return false;
  }
  if (extension) {
    host_fail(HOST_BAD_INPUT, "the scene '%s' needs %s, which is not read here", path, extension);
    return false;
  }
  if (has_bare_skin(document)) {
    host_fail(HOST_BAD_INPUT, "the scene '%s' has a skin without inverseBindMatrices, which is not read here", path);
    return false;
  }
  const char *problem = walk_nodes(document, &triangles);
  if (problem)
    host_fail(HOST_BAD_INPUT, "the scene '%s' %s", path, problem);
  return !problem && check_names(path, document);
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
  bool *seen_meshes;
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

/* Nodes of which some children are still to be walked. */
enum { DEEPEST = 513 }; /* the roots, and 512 below each other */

typedef struct walk {
  const json_t *children;
  size_t next;
} walk;

/* Each node once, as a tree is walked, without recursion. Returns what is wrong with the tree, or NULL. */
static const char *walk_tree(counter *c, bool *seen, const json_t *roots) {
  const size_t count = json_array_size(json_object_get(c->document, "nodes"));
  walk stack[DEEPEST] = {{.children = roots}};
  size_t depth = 1;
  while (depth > 0) {
    walk *top = &stack[depth - 1];
    const json_t *index = json_array_get(top->children, top->next++);
    const size_t at = (size_t)json_integer_value(index);
    if (!index) {
      depth--;
      continue;
    }
    if (!json_is_integer(index) || at >= count)
      return "names a node that it does not have";
    if (seen[at])
      return "has a node with two parents";
    seen[at] = true;
    const json_t *node = element(c->document, "nodes", index);
    count_mesh(c, json_object_get(node, "mesh"));
    if (depth == DEEPEST)
      return "has more than 512 nodes one below the other";
    stack[depth++] = (walk){.children = json_object_get(node, "children")};
  }
  return NULL;
}

static const char *walk_nodes(const json_t *document, uint64_t *triangles) {
  counter c = {.document = document};
  bool *seen = host_allocate(json_array_size(json_object_get(document, "nodes")), sizeof *seen);
  c.seen_meshes = host_allocate(json_array_size(json_object_get(document, "meshes")), sizeof *c.seen_meshes);
  const json_t *scene = element(document, "scenes", json_object_get(document, "scene"));
  const char *problem = walk_tree(&c, seen, json_object_get(scene, "nodes"));
  free(seen);
  free(c.seen_meshes);
  *triangles = c.triangles;
  return problem;
}

uint64_t gltf_document_triangles(const json_t *document) {
  uint64_t triangles;
  walk_nodes(document, &triangles);
  return triangles;
}
