#include "stage/dump.h"
#include "base/host.h"
#include "base/linear.h"
#include "base/output_file.h"
#include "scene/camera_json.h"
#include "setup/config_json.h"
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#define PATH_SIZE 4096
#define WRITE_BUFFER (1u << 20)

/* Many small writes, so with a large buffer. */
static int open_for_writing(output_file *out, const char *path) {
  const char *problem = output_file_open(out, path);
  if (problem)
    return host_fail(HOST_BAD_INPUT, "cannot write '%s': %s", path, problem);
  setvbuf(out->stream, NULL, _IOFBF, WRITE_BUFFER);
  return 0;
}

static int finish_writing(output_file *file, const char *path) {
  const char *problem = output_file_close(file, NULL);
  return problem ? host_fail(HOST_BAD_INPUT, "cannot write '%s': %s", path, problem) : 0;
}

int dump_pfm(const float *values, uint32_t width, uint32_t height, const char *path) {
  output_file file;
  if (open_for_writing(&file, path))
    return HOST_BAD_INPUT;
  fprintf(file.stream, "Pf\n%u %u\n-1.0\n", width, height);
  for (uint32_t row = height; row-- > 0;)
    fwrite(values + (size_t)row * width, sizeof *values, width, file.stream);
  return finish_writing(&file, path);
}

/* ---- scene.ply ---- */

static void write_vertices(FILE *file, const scene_mesh *mesh, const double transform[16]) {
  for (uint32_t v = 0; v < mesh->vertex_count; v++) {
    const float *p = mesh->positions + 3 * (size_t)v;
    double world[4];
    mat_transform(world, transform, (const double[3]){p[0], p[1], p[2]}, 1.0);
    fwrite(world, sizeof *world, 3, file);
  }
}

static void write_faces(FILE *file, const scene_mesh *mesh, uint32_t base, bool alpha_tested) {
  for (uint32_t i = 0; i < mesh->index_count; i += 3) {
    uint8_t face[1 + 3 * sizeof(int32_t) + 1] = {3};
    face[sizeof face - 1] = alpha_tested;
    for (uint32_t corner = 0; corner < 3; corner++) {
      const uint32_t index = base + scene_index(mesh, i + corner);
      memcpy(face + 1 + corner * sizeof index, &index, sizeof index);
    }
    fwrite(face, 1, sizeof face, file);
  }
}

int dump_ply(const scene *s, const char *path) {
  uint64_t vertices = 0;
  for (size_t i = 0; i < s->instance_count; i++)
    vertices += s->meshes[s->instances[i].mesh].vertex_count;
  if (vertices > INT32_MAX)
    return host_fail(HOST_BAD_INPUT, "the scene has %" PRIu64 " vertices, more than a PLY file can index", vertices);
  output_file file;
  if (open_for_writing(&file, path))
    return HOST_BAD_INPUT;
  fprintf(file.stream,
          "ply\nformat binary_little_endian 1.0\nelement vertex %" PRIu64
          "\nproperty double x\nproperty double y\nproperty double z\nelement face %" PRIu64
          "\nproperty list uchar int vertex_indices\nproperty uchar alpha_tested\nend_header\n",
          vertices, scene_triangles(s));
  for (size_t i = 0; i < s->instance_count; i++)
    write_vertices(file.stream, &s->meshes[s->instances[i].mesh], s->instances[i].transform);
  uint32_t base = 0;
  for (size_t i = 0; i < s->instance_count; i++) {
    const scene_mesh *mesh = &s->meshes[s->instances[i].mesh];
    write_faces(file.stream, mesh, base, scene_cut_out(s, mesh) != NULL);
    base += mesh->vertex_count;
  }
  return finish_writing(&file, path);
}

/* ---- frame.json ---- */

static json_t *cascade_to_json(const csm_cascade_info *cascade) {
  json_t *object = json_object();
  json_object_set_new(object, "near", json_real(cascade->near_depth));
  json_object_set_new(object, "far", json_real(cascade->far_depth));
  json_object_set_new(object, "world_to_shadow", json_from_doubles(cascade->world_to_shadow, 16));
  json_object_set_new(object, "texel_size", json_real(cascade->texel_size));
  json_object_set_new(object, "depth_range", json_real(cascade->depth_range));
  return object;
}

static json_t *frame_to_json(const stage *s, const csm_binding *binding, json_t *metrics) {
  const host_setup *setup = s->setup;
  json_t *object = json_object(), *cascades = json_array();
  for (uint32_t k = 0; k < binding->cascade_count; k++)
    json_array_append_new(cascades, cascade_to_json(&binding->cascades[k]));
  json_object_set_new(object, "width", json_integer(setup->width));
  json_object_set_new(object, "height", json_integer(setup->height));
  json_object_set_new(object, "camera", camera_to_json(&setup->camera));
  json_object_set_new(object, "light", light_to_json(&setup->light));
  json_object_set_new(object, "shadow_distance", json_real(setup->shadow_distance));
  json_object_set_new(object, "cascades", cascades);
  json_object_set_new(object, "config", config_to_json(&setup->config));
  if (metrics)
    json_object_set(object, "metrics", metrics);
  return object;
}

static int write_frame_json(const stage *s, const csm_binding *binding, json_t *metrics, const char *path) {
  output_file file;
  if (open_for_writing(&file, path))
    return HOST_BAD_INPUT;
  json_t *object = frame_to_json(s, binding, metrics);
  json_dumpf(object, file.stream, JSON_INDENT(2) | JSON_REAL_PRECISION(17));
  json_decref(object);
  fputc('\n', file.stream);
  return finish_writing(&file, path);
}

int dump_frame(const char *folder, const stage *s, const stage_frame *frame, json_t *metrics) {
  char path[PATH_SIZE], name[PATH_SIZE];
  const host_setup *setup = s->setup;
  if ((size_t)snprintf(name, sizeof name, "%s/%s", folder, s->backend) >= sizeof name - 32)
    return host_fail(HOST_BAD_INPUT, "--dump: the folder's name is too long");
  int code = host_make_folder(name);
  snprintf(path, sizeof path, "%s/frame.json", name);
  if (code == 0)
    code = write_frame_json(s, &frame->binding, metrics, path);
  snprintf(path, sizeof path, "%s/scene.ply", name);
  if (code == 0)
    code = dump_ply(&setup->scene, path);
  for (uint32_t k = 0; code == 0 && k < frame->binding.cascade_count; k++) {
    snprintf(path, sizeof path, "%s/depth_%u.pfm", name, k);
    code = dump_pfm(frame->maps[k], frame->binding.resolutions[k], frame->binding.resolutions[k], path);
  }
  snprintf(path, sizeof path, "%s/camera_depth.pfm", name);
  if (code == 0)
    code = dump_pfm(frame->camera_depth, setup->width, setup->height, path);
  snprintf(path, sizeof path, "%s/mask.pfm", name);
  if (code == 0)
    code = dump_pfm(frame->mask, setup->width, setup->height, path);
  return code;
}
