#include "truth/store.h"
#include "base/host.h"
#include "base/output_file.h"
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Changed whenever the same input casts to something else. */
#define VERSION 1

/* ---- hashes ---- */

/* FNV-1a over eight bytes at a time, with its high bits folded back in. */
static uint64_t hash_bytes(uint64_t hash, const void *data, size_t size) {
  const uint8_t *bytes = data;
  for (; size > 0;) {
    const size_t count = size < 8 ? size : 8;
    uint64_t word = 0;
    memcpy(&word, bytes, count);
    hash = (hash ^ word) * 0x100000001b3u;
    hash ^= hash >> 29;
    bytes += count;
    size -= count;
  }
  return hash;
}

#define HASH_START 14695981039346656037u

static uint64_t hash_material(uint64_t hash, const scene_material *material) {
  const scene_alpha_mask *o = &material->alpha_mask;
  const double numbers[] = {o->alpha ? o->width : 0.0, o->alpha ? o->height : 0.0, o->wrap[0], o->wrap[1], o->cutoff,
                            material->alpha_tested};
  hash = hash_bytes(hash, numbers, sizeof numbers);
  return o->alpha ? hash_bytes(hash, o->alpha, (size_t)o->width * o->height) : hash;
}

static uint64_t hash_mesh(uint64_t hash, const scene_mesh *mesh) {
  const uint32_t counts[] = {mesh->vertex_count, mesh->index_count, mesh->index_size, mesh->material,
                             mesh->uvs != NULL};
  hash = hash_bytes(hash, counts, sizeof counts);
  hash = hash_bytes(hash, mesh->positions, 3 * sizeof(float) * (size_t)mesh->vertex_count);
  hash = hash_bytes(hash, mesh->indices, (size_t)mesh->index_size * mesh->index_count);
  return mesh->uvs ? hash_bytes(hash, mesh->uvs, 2 * sizeof(float) * (size_t)mesh->vertex_count) : hash;
}

static uint64_t hash_scene(const scene *s, bool alpha_test) {
  const uint64_t start[] = {VERSION, alpha_test, s->instance_count};
  uint64_t hash = hash_bytes(HASH_START, start, sizeof start);
  for (size_t i = 0; alpha_test && i < s->material_count; i++)
    hash = hash_material(hash, &s->materials[i]);
  for (size_t m = 0; m < s->mesh_count; m++)
    hash = hash_mesh(hash, &s->meshes[m]);
  for (size_t i = 0; i < s->instance_count; i++) {
    hash = hash_bytes(hash, &s->instances[i].mesh, sizeof s->instances[i].mesh);
    hash = hash_bytes(hash, s->instances[i].transform, sizeof s->instances[i].transform);
  }
  return hash;
}

static uint64_t hash_camera(uint64_t hash, const camera *from) {
  const uint64_t reversed = from->reversed;
  hash = hash_bytes(hash, from->view, sizeof from->view);
  hash = hash_bytes(hash, from->projection, sizeof from->projection);
  return hash_bytes(hash, &reversed, sizeof reversed);
}

static uint64_t hash_view(const truth_store *store, const truth_view *view, const char *kind) {
  const uint64_t start[] = {store->scene_hash, view->width, view->height};
  const uint64_t hash = hash_bytes(HASH_START, start, sizeof start);
  return hash_camera(hash_bytes(hash, kind, strlen(kind)), view->camera);
}

/* ---- files ---- */

typedef struct file_header {
  char magic[8];
  uint64_t key, size, check; /* check: of the data */
} file_header;

static const char magic[8] = "csmtrue";

static bool file_name(char path[5000], const truth_store *store, uint64_t key) {
  snprintf(path, 5000, "%s/%016" PRIx64 ".truth", store->folder, key);
  return store->folder[0] != '\0';
}

/* A file that lies in the folder itself: no link that leads elsewhere, no pipe that would be waited for. */
static FILE *open_kept(const char *path) {
  struct stat status;
  const int file = open(path, O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (file < 0)
    return NULL;
  FILE *stream = fstat(file, &status) == 0 && S_ISREG(status.st_mode) ? fdopen(file, "rb") : NULL;
  if (!stream)
    close(file);
  return stream;
}

/* Whether data can be an answer: the checksum of a file that somebody forged is right, too. */
typedef bool (*sound)(const truth_store *store, const void *data, size_t size);

static bool load(truth_store *store, uint64_t key, void *data, size_t size, sound sound) {
  char path[5000];
  file_header header = {0};
  FILE *file = file_name(path, store, key) ? open_kept(path) : NULL;
  if (!file)
    return false;
  const bool whole = fread(&header, sizeof header, 1, file) == 1 && memcmp(header.magic, magic, sizeof magic) == 0 &&
                     header.key == key && header.size == size && fread(data, 1, size, file) == size &&
                     header.check == hash_bytes(HASH_START, data, size) && sound(store, data, size);
  fclose(file);
  store->loaded += whole;
  return whole;
}

/* What cannot be kept is cast again. A link or a pipe in a file's place goes. */
static void keep(truth_store *store, uint64_t key, const void *data, size_t size) {
  char path[5000];
  struct stat status;
  output_file file;
  if (!file_name(path, store, key))
    return;
  if (lstat(path, &status) == 0 && !S_ISREG(status.st_mode))
    remove(path);
  if (output_file_open(&file, path))
    return;
  file_header header = {.key = key, .size = size, .check = hash_bytes(HASH_START, data, size)};
  memcpy(header.magic, magic, sizeof magic);
  fwrite(&header, sizeof header, 1, file.stream);
  fwrite(data, 1, size, file.stream);
  output_file_close(&file, NULL);
}

/* ---- what answers can be ---- */

static bool sound_triangles(const truth_store *store, const void *data, size_t size) {
  const uint32_t *triangles = data;
  bool good = true;
  for (size_t i = 0; i < size / sizeof *triangles; i++)
    good = good && (triangles[i] == TRUTH_NOTHING || triangles[i] < store->triangles);
  return good;
}

static bool sound_visibility(const truth_store *store, const void *data, size_t size) {
  (void)store;
  const size_t count = (size - sizeof(truth_convergence)) / sizeof(float);
  bool good = true;
  for (size_t i = 0; i < count; i++) {
    float share;
    memcpy(&share, (const uint8_t *)data + i * sizeof share, sizeof share);
    good = good && share >= 0.0f && share <= 1.0f;
  }
  return good;
}

static bool sound_seen(const truth_store *store, const void *data, size_t size) {
  (void)store;
  const uint8_t *seen = data;
  bool good = true;
  for (size_t i = 0; i < size; i++)
    good = good && seen[i] <= 1;
  return good;
}

/* ---- store ---- */

/* Without a folder the store still works; it keeps nothing. */
static void take_default_folder(truth_store *store) {
  const char *cache = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
  if (cache && *cache)
    snprintf(store->folder, sizeof store->folder, "%s/csm", cache);
  else if (home && *home)
    snprintf(store->folder, sizeof store->folder, "%s/.cache/csm", home);
  if (store->folder[0] && host_make_folder(store->folder) != 0)
    store->folder[0] = '\0';
}

int truth_store_open(truth_store *out, const scene *s, bool alpha_test, const char *folder) {
  *out = (truth_store){.scene_hash = hash_scene(s, alpha_test), .triangles = scene_triangles(s)};
  out->caster = truth_create(s, alpha_test);
  if (!folder) {
    take_default_folder(out);
    return 0;
  }
  if ((size_t)snprintf(out->folder, sizeof out->folder, "%s", folder) >= sizeof out->folder)
    return host_fail(HOST_BAD_INPUT, "--cache: the folder's name is too long");
  const int code = host_make_folder(folder);
  if (code == 0 && access(folder, W_OK) != 0)
    return host_fail(HOST_BAD_INPUT, "--cache: cannot write to '%s': %s", folder, strerror(errno));
  return code;
}

void truth_store_close(truth_store *store) {
  truth_destroy(store->caster);
  *store = (truth_store){0};
}

static void note_cast(truth_store *store, double begun_ms) {
  store->cast_ms += host_now_ms() - begun_ms;
  store->cast++;
}

int truth_store_view(truth_store *store, const truth_view *view) {
  const size_t pixels = (size_t)view->width * view->height;
  const uint64_t key = hash_view(store, view, "view");
  uint32_t *triangles = host_allocate(pixels, sizeof *triangles);
  int code = 0;
  if (!load(store, key, triangles, pixels * sizeof *triangles, sound_triangles)) {
    const double begun = host_now_ms();
    code = truth_find(store->caster, view->camera, view->width, view->height, triangles);
    note_cast(store, begun);
    if (code == 0)
      keep(store, key, triangles, pixels * sizeof *triangles);
  }
  if (code == 0)
    code = truth_view_fill(store->caster, view, triangles);
  free(triangles);
  return code;
}

int truth_store_visibility(truth_store *store, const truth_view *view, const truth_asked *asked, float *visibility,
                           truth_convergence *convergence) {
  const scene_light *light = asked->light;
  const size_t bytes = (size_t)view->width * view->height * sizeof *visibility;
  const double numbers[] = {light->direction[0], light->direction[1], light->direction[2],
                            light->disc_deg,     asked->max_depth,    light->disc_deg > 0.0 ? asked->samples : 1.0};
  const uint64_t key = hash_bytes(hash_view(store, view, "sun"), numbers, sizeof numbers);
  uint8_t *data = host_allocate(bytes + sizeof *convergence, 1);
  int code = 0;
  if (load(store, key, data, bytes + sizeof *convergence, sound_visibility)) {
    memcpy(visibility, data, bytes);
    memcpy(convergence, data + bytes, sizeof *convergence);
  } else {
    const double begun = host_now_ms();
    code = truth_visibility(store->caster, view, asked, visibility, convergence);
    note_cast(store, begun);
    memcpy(data, visibility, bytes);
    memcpy(data + bytes, convergence, sizeof *convergence);
    if (code == 0)
      keep(store, key, data, bytes + sizeof *convergence);
  }
  free(data);
  return code;
}

int truth_store_seen(truth_store *store, const truth_view *view, const camera *other, uint8_t *seen) {
  const size_t bytes = (size_t)view->width * view->height;
  const uint64_t key = hash_camera(hash_view(store, view, "seen"), other);
  if (load(store, key, seen, bytes, sound_seen))
    return 0;
  const double begun = host_now_ms();
  const int code = truth_seen(store->caster, view, other, seen);
  note_cast(store, begun);
  if (code == 0)
    keep(store, key, seen, bytes);
  return code;
}
