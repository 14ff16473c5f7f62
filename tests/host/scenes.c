/* Scenes made by code and read from glTF, and what a camera sees of them. */
#include "base/linear.h"
#include "bench/scene_plan.h"
#include "picture/trace.h"
#include "plan.h"
#include "scene/scene.h"
#include "support.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <cmocka.h>

static const double pi = 3.14159265358979323846;

static void check_meshes(const scene *s) {
  bool narrow = false, wide = false;
  for (size_t m = 0; m < s->mesh_count; m++) {
    const scene_mesh *mesh = &s->meshes[m];
    narrow = narrow || mesh->index_size == 2;
    wide = wide || mesh->index_size == 4;
    assert_true(mesh->index_count > 0 && mesh->index_count % 3 == 0 && mesh->material < s->material_count);
    for (uint32_t i = 0; i < mesh->index_count; i++)
      assert_true(scene_index(mesh, i) < mesh->vertex_count);
    for (size_t i = 0; i < 3 * (size_t)mesh->vertex_count; i++)
      assert_true(isfinite(mesh->positions[i]));
  }
  assert_true(narrow && wide);
  for (size_t i = 0; i < s->instance_count; i++)
    assert_true(mat_determinant3(s->instances[i].transform) > 0.0);
}

static void scenes_are_what_they_promise(void **state) {
  (void)state;
  static const char *const names[] = {"valley", "town"};
  for (int i = 0; i < 2; i++) {
    scene s, again;
    double minimum[3], maximum[3];
    assert_int_equal(scene_load(&s, names[i]), 0);
    check_meshes(&s);
    scene_bounds(&s, minimum, maximum);
    if (i == 0) {
      assert_true(s.instance_count >= 2000 && scene_triangles(&s) >= 1000000);
      assert_true(s.camera.position[2] - minimum[2] >= 2000.0);
    } else {
      assert_true(maximum[0] - minimum[0] >= 300.0);
    }
    assert_int_equal(scene_load(&again, names[i]), 0);
    assert_int_equal(again.instance_count, s.instance_count);
    for (size_t k = 0; k < s.instance_count; k++) {
      assert_int_equal(again.instances[k].mesh, s.instances[k].mesh);
      assert_memory_equal(again.instances[k].transform, s.instances[k].transform, sizeof s.instances[k].transform);
    }
    scene_free(&s);
    scene_free(&again);
  }
}

/* A solid looks outwards: the signed volume of a closed mesh is positive. */
static void solids_face_outwards(void **state) {
  (void)state;
  scene s;
  assert_int_equal(scene_load(&s, "valley"), 0);
  uint32_t solids = 0;
  for (size_t m = 0; m < s.mesh_count; m++) {
    const scene_mesh *mesh = &s.meshes[m];
    if (strncmp(mesh->name, "ground", 6) == 0 || strcmp(mesh->name, "river") == 0)
      continue;
    double volume = 0.0;
    for (uint32_t t = 0; t < mesh->index_count; t += 3) {
      double corner[3][3], cross[3];
      for (uint32_t i = 0; i < 3; i++)
        for (int axis = 0; axis < 3; axis++)
          corner[i][axis] = mesh->positions[3 * (size_t)scene_index(mesh, t + i) + axis];
      vec_cross(cross, corner[1], corner[2]);
      volume += vec_dot(corner[0], cross) / 6.0;
    }
    assert_true(volume > 0.0);
    solids++;
  }
  assert_true(solids >= 10);
  scene_free(&s);
}

/* One triangle, in a node that is moved, within one that is scaled. */
static void gltf_is_read(void **state) {
  (void)state;
  char path[64];
  scene s;
  double minimum[3], maximum[3];
  make_path(path, ".gltf");
  write_text(path, triangle_gltf);
  assert_int_equal(scene_load(&s, path), 0);
  assert_int_equal(s.instance_count, 1);
  assert_int_equal(scene_triangles(&s), 1);
  assert_true(s.materials[s.meshes[0].material].color[1] == 0.25f && s.materials[s.meshes[0].material].two_sided);
  scene_bounds(&s, minimum, maximum);
  const double low[3] = {2, 3, 4}, high[3] = {4, 6, 4};
  for (int i = 0; i < 3; i++) {
    close_to(minimum[i], low[i], 1e-12);
    close_to(maximum[i], high[i], 1e-12);
  }
  assert_true(s.shadow_distance > 0.0 && camera_pose_check(&s.camera) == NULL);
  scene_free(&s);
  unlink(path);
}

/* The document with one place of it changed. */
static int load_changed(const char *from, const char *to) {
  char path[64], text[4096];
  const char *at = strstr(triangle_gltf, from);
  assert_non_null(at);
  snprintf(text, sizeof text, "%.*s%s%s", (int)(at - triangle_gltf), triangle_gltf, to, at + strlen(from));
  make_path(path, ".gltf");
  write_text(path, text);
  scene s;
  const int code = scene_load(&s, path);
  scene_free(&s);
  unlink(path);
  return code;
}

/* What Assimp would leave out without a word. */
static void what_is_not_understood_is_refused(void **state) {
  (void)state;
  assert_int_equal(load_changed("\"scene\":0,", ""), 0);
  assert_int_equal(load_changed("\"scene\":0,", "\"extensionsRequired\":[\"KHR_materials_unlit\"],"), 0);
  assert_int_equal(load_changed("\"scene\":0,", "\"extensionsRequired\":[\"KHR_draco_mesh_compression\"],"), 2);
  /* six indices that begin six bytes early, in the positions: 16256, 0, 0 and the triangle's own */
  assert_int_equal(load_changed("\"count\":3,\"type\":\"SCALAR\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36},"
                                "{\"buffer\":0,\"byteOffset\":36,\"byteLength\":6}]",
                                "\"count\":6,\"type\":\"SCALAR\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36},"
                                "{\"buffer\":0,\"byteOffset\":30,\"byteLength\":12}]"),
                   2);
}

/* A file leads nowhere but beside itself, and its nodes are a tree. */
static void what_leads_astray_is_refused(void **state) {
  (void)state;
  static const char *const images[] = {"/dev/zero",         "../picture.png",    "a/../../picture.png",
                                       "..%2fpicture.png",  "%2Fdev%2fzero",     "file:picture.png",
                                       "..\\\\picture.png", "data:;base64,AAAA", "."};
  char changed[200];
  for (size_t i = 0; i < sizeof images / sizeof images[0]; i++) {
    snprintf(changed, sizeof changed, "\"scene\":0,\"images\":[{\"uri\":\"%s\"}],", images[i]);
    assert_int_equal(load_changed("\"scene\":0,", changed), 2);
  }
  assert_int_equal(load_changed("\"scene\":0,", "\"scene\":0,\"images\":[{\"uri\":\"a..b/c%20d.png\"}],"), 0);
  assert_int_equal(load_changed("\"children\":[1]", "\"children\":[0]"), 2);
  assert_int_equal(load_changed("\"children\":[1]", "\"children\":[1,1]"), 2);
  assert_int_equal(load_changed("\"children\":[1]", "\"children\":[7]"), 2);
  assert_int_equal(load_changed("\"scene\":0,", "\"scene\":0,\"skins\":[{\"joints\":[0]}],"), 2);
}

/* A chain of nodes, which whoever reads it by recursion goes down. */
static int load_chain(uint32_t nodes) {
  char path[64];
  make_path(path, ".gltf");
  FILE *file = fopen(path, "wb");
  assert_non_null(file);
  fprintf(file, "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[0]}],\"nodes\":[");
  for (uint32_t i = 0; i + 1 < nodes; i++)
    fprintf(file, "{\"children\":[%u]},", i + 1);
  fprintf(file, "{\"mesh\":0}]%s", strstr(triangle_gltf, ",\"meshes\""));
  fclose(file);
  scene s;
  const int code = scene_load(&s, path);
  scene_free(&s);
  unlink(path);
  return code;
}

static void a_deep_file_is_refused(void **state) {
  (void)state;
  assert_int_equal(load_chain(512), 0);
  assert_int_equal(load_chain(513), 2);
  assert_int_equal(load_chain(300000), 2);
}

static void broken_gltf_is_refused(void **state) {
  (void)state;
  char path[64], text[4096];
  scene s;
  make_path(path, ".gltf");
  for (size_t length = 0; length + 1 < strlen(triangle_gltf); length += 41) {
    memcpy(text, triangle_gltf, length);
    text[length] = '\0';
    write_text(path, text);
    assert_int_equal(scene_load(&s, path), 2);
    scene_free(&s);
  }
  unlink(path);
  assert_int_equal(scene_load(&s, path), 2);
  scene_free(&s);
  assert_int_equal(scene_load(&s, "nowhere"), 2);
  scene_free(&s);
  make_path(path, ".glb");
  write_text(path, "glTF\2");
  assert_int_equal(scene_load(&s, path), 2);
  scene_free(&s);
  unlink(path);
}

/* A ray through a pixel's centre finds the triangle where it must lie. */
static void views_are_traced(void **state) {
  (void)state;
  char path[64];
  scene s;
  make_path(path, ".gltf");
  write_text(path, triangle_gltf);
  assert_int_equal(scene_load(&s, path), 0);
  unlink(path);
  const camera_pose pose = {.position = {2.5, 3.2, 14},
                            .target = {2.5, 3.2, 4},
                            .vertical_fov_deg = 20.0,
                            .near_depth = 0.1,
                            .far_depth = INFINITY};
  camera from;
  camera_from_pose(&from, &pose, 1.0);
  trace_surface out[9];
  assert_int_equal(trace_camera(&s, &from, 3, 3, out), 0);
  close_to(out[4].view_depth, 10.0, 1e-6);
  close_to(out[4].normal[2], 1.0, 1e-6);
  assert_true(out[0].view_depth < 0.0); /* to the left of x = 2 */
  close_to(out[5].view_depth, 10.0, 1e-6);
  close_to(out[5].position[0], 10.0 * tan(10.0 * pi / 180.0) * 2.0 / 3.0, 1e-5);
  scene_free(&s);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(scenes_are_what_they_promise),
      cmocka_unit_test(solids_face_outwards),
      cmocka_unit_test(gltf_is_read),
      cmocka_unit_test(what_is_not_understood_is_refused),
      cmocka_unit_test(what_leads_astray_is_refused),
      cmocka_unit_test(a_deep_file_is_refused),
      cmocka_unit_test(broken_gltf_is_refused),
      cmocka_unit_test(views_are_traced),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
