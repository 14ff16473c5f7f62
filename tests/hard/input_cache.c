/* input_cache.c: a truth that was kept in a file, and what somebody made of it since. */
#include "base/host.h"
#include "input.h"
#include "scene/scene.h"
#include "truth/store.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { SIDE = 4, PIXELS = SIDE * SIDE, HEADER = 32, MOST = 4096 };

/* A square and a light, asked for what is seen, whether it is lit, and whether another camera sees it. */
typedef struct world {
  scene scene;
  camera camera, other;
  truth_surface surfaces[PIXELS];
  float visibility[PIXELS];
  uint8_t seen[PIXELS];
} world;

static void make_world(world *w) {
  static float corners[12] = {-1, 0, -1, 1, 0, -1, 1, 0, 1, -1, 0, 1};
  static uint16_t indices[6] = {0, 2, 1, 0, 3, 2};
  const double identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  scene_mesh mesh = {.vertex_count = 4, .index_count = 6, .index_size = 2};
  *w = (world){0};
  mesh.positions = host_allocate(12, sizeof(float));
  mesh.indices = host_allocate(6, sizeof(uint16_t));
  memcpy(mesh.positions, corners, sizeof corners);
  memcpy(mesh.indices, indices, sizeof indices);
  scene_add_material(&w->scene, &(scene_material){.color = {1, 1, 1}});
  scene_add_instance(&w->scene, scene_add_mesh(&w->scene, &mesh), identity);
  w->scene.light = (scene_light){.direction = {0.3, -1, 0.2}, .disc_deg = 0.5};
  camera_pose pose = {.position = {0, 3, 2}, .vertical_fov_deg = 50, .near_depth = 0.1, .far_depth = 100};
  camera_from_pose(&w->camera, &pose, 1.0);
  pose.position[0] = 1;
  camera_from_pose(&w->other, &pose, 1.0);
}

static void ask(world *w, const char *folder) {
  truth_store store;
  truth_convergence convergence;
  const truth_view view = {.camera = &w->camera, .width = SIDE, .height = SIDE, .surfaces = w->surfaces};
  const truth_asked asked = {.light = &w->scene.light, .max_depth = 50, .samples = 4};
  if (truth_store_open(&store, &w->scene, true, folder) || truth_store_view(&store, &view) ||
      truth_store_visibility(&store, &view, &asked, w->visibility, &convergence) ||
      truth_store_seen(&store, &view, &w->other, w->seen))
    abort();
  for (int i = 0; i < PIXELS; i++)
    if (!(w->visibility[i] >= 0.0f && w->visibility[i] <= 1.0f) || w->seen[i] > 1)
      abort();
  truth_store_close(&store);
}

/* The names of what the store keeps, in their order. */
static int kept_names(const char *folder, char names[3][300]) {
  struct dirent **entries;
  const int count = scandir(folder, &entries, NULL, alphasort);
  int found = 0;
  for (int i = 0; i < count; i++) {
    if (strstr(entries[i]->d_name, ".truth") && found < 3)
      snprintf(names[found++], 300, "%s", entries[i]->d_name);
    free(entries[i]);
  }
  free(entries);
  return found;
}

/* The store's own checksum, as whoever forges a file would make it. */
static uint64_t checksum(const uint8_t *bytes, size_t size) {
  uint64_t hash = 14695981039346656037u;
  while (size > 0) {
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

static size_t read_kept(const char *folder, const char *name, uint8_t bytes[MOST]) {
  char path[400];
  snprintf(path, sizeof path, "%s/%s", folder, name);
  FILE *file = fopen(path, "rb");
  if (!file)
    abort();
  const size_t size = fread(bytes, 1, MOST, file);
  fclose(file);
  return size;
}

/* Which of the files, then whether the checksum is put right, then the file. */
uint32_t input_seeds(input_seed out[INPUT_SEEDS]) {
  static uint8_t bytes[3][MOST + 2];
  char names[3][300];
  world w;
  make_world(&w);
  ask(&w, input_folder());
  const int count = kept_names(input_folder(), names);
  for (int i = 0; i < count; i++) {
    bytes[i][0] = (uint8_t)i;
    bytes[i][1] = 1;
    out[i] = (input_seed){bytes[i], 2 + read_kept(input_folder(), names[i], bytes[i] + 2)};
  }
  scene_free(&w.scene);
  return (uint32_t)count;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static char names[3][300];
  static int count;
  char path[400];
  uint8_t forged[MOST];
  world w;
  make_world(&w);
  input_quiet();
  if (count == 0) {
    ask(&w, input_folder());
    count = kept_names(input_folder(), names);
  }
  if (size > 2 && size - 2 <= MOST) {
    snprintf(path, sizeof path, "%s/%s", input_folder(), names[data[0] % count]);
    memcpy(forged, data + 2, size - 2);
    if (data[1] && size - 2 >= HEADER) {
      const uint64_t check = checksum(forged + HEADER, size - 2 - HEADER);
      memcpy(forged + HEADER - sizeof check, &check, sizeof check);
    }
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(forged, size - 2, 1, file) != 1 || fclose(file) != 0)
      abort();
  }
  ask(&w, input_folder());
  scene_free(&w.scene);
  return 0;
}
