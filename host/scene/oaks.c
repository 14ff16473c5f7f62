/*
 * Five oaks on a small terrain, put together as the cascaded-shadow example of a public Vulkan sample collection does
 * it. The two files come from a folder that may lie beside the checkout.
 */
#include "base/host.h"
#include "base/linear.h"
#include "scene/scene.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define PATH_SIZE 4096

static bool has_files(const char *folder) {
  char path[PATH_SIZE + 64];
  snprintf(path, sizeof path, "%s/oaktree.gltf", folder);
  if (access(path, R_OK) != 0)
    return false;
  snprintf(path, sizeof path, "%s/terrain_gridlines.gltf", folder);
  return access(path, R_OK) == 0;
}

/* The folder three above this program's file: it is built as build/host/csm-host in the source folder. */
static bool source_root(char *out, size_t size) {
  const ssize_t length = readlink("/proc/self/exe", out, size - 1);
  if (length <= 0)
    return false;
  out[length] = '\0';
  for (int up = 0; up < 3; up++) {
    char *slash = strrchr(out, '/');
    if (!slash)
      return false;
    *slash = '\0';
  }
  return true;
}

static bool find_folder(char *out, size_t size) {
  const char *shared = getenv("CSM_SHARED");
  char root[PATH_SIZE / 2];
  if (shared) {
    snprintf(out, size, "%s/scenes", shared);
    if (has_files(out))
      return true;
  }
  snprintf(out, size, "../shared/scenes");
  if (has_files(out))
    return true;
  if (!source_root(root, sizeof root))
    return false;
  snprintf(out, size, "%s/../shared/scenes", root);
  return has_files(out);
}

int scene_make_oaks(scene *s) {
  static const double trees[5][3] = {
      {0, 0, 0}, {1.25, -0.25, 1.25}, {-1.25, 0.2, 1.25}, {1.25, -0.1, -1.25}, {-1.25, 0.25, -1.25}};
  char folder[PATH_SIZE], path[PATH_SIZE + 64];
  double root[16];
  if (!find_folder(folder, sizeof folder))
    return host_fail(HOST_BAD_INPUT, "the scene 'oaks' needs oaktree.gltf and terrain_gridlines.gltf in "
                                     "$CSM_SHARED/scenes or ../shared/scenes, and neither folder has them");
  mat_identity(root);
  snprintf(path, sizeof path, "%s/terrain_gridlines.gltf", folder);
  int code = scene_add_gltf(s, path, root);
  snprintf(path, sizeof path, "%s/oaktree.gltf", folder);
  const size_t first = s->instance_count;
  if (code == 0)
    code = scene_add_gltf(s, path, root);
  if (code)
    return code;
  const size_t parts = s->instance_count - first;
  for (int tree = 1; tree < 5; tree++)
    for (size_t part = 0; part < parts; part++) {
      const scene_instance at = s->instances[first + part];
      double placed[16];
      memcpy(placed, at.transform, sizeof placed);
      for (int i = 0; i < 3; i++)
        placed[12 + i] += trees[tree][i];
      scene_add_instance(s, at.mesh, placed);
    }
  s->camera = (camera_pose){.position = {0.12, 1.14, 2.25},
                            .target = {0.2365, 0.848, 1.301},
                            .vertical_fov_deg = 45.0,
                            .near_depth = 0.5,
                            .far_depth = 48.0};
  s->light = (scene_light){.direction = {-6.18, -20.0, -19.02}};
  s->shadow_distance = 48.0;
  s->haze_distance = INFINITY;
  return 0;
}
