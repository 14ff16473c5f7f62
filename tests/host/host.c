/* test_host.c: the parts of csm-host that need no device: what it reads, what it writes, and what it calls equal. */
#include "base/linear.h"
#include "base/parse.h"
#include "base/statistics.h"
#include "bench/scene_plan.h"
#include "picture/trace.h"
#include "plan.h"
#include "scene/camera.h"
#include "scene/camera_json.h"
#include "scene/scene.h"
#include "setup/config_json.h"
#include "setup/options.h"
#include "setup/presets.h"
#include "stage/compare.h"
#include "stage/dump.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <cmocka.h>

static const double pi = 3.14159265358979323846;

/* A file that goes when the test ends. */
static void make_path(char path[64], const char *ending) {
  snprintf(path, 64, "csm-host-test-XXXXXX%s", ending);
  const int file = mkstemps(path, (int)strlen(ending));
  assert_true(file >= 0);
  close(file);
}

static void write_text(const char *path, const char *text) {
  FILE *file = fopen(path, "wb");
  assert_non_null(file);
  fputs(text, file);
  fclose(file);
}

static uint8_t *read_bytes(const char *path, size_t *size) {
  FILE *file = fopen(path, "rb");
  assert_non_null(file);
  fseek(file, 0, SEEK_END);
  *size = (size_t)ftell(file);
  rewind(file);
  uint8_t *bytes = malloc(*size + 1);
  assert_int_equal(fread(bytes, 1, *size, file), *size);
  bytes[*size] = '\0';
  fclose(file);
  return bytes;
}

/* ---- the command line ---- */

static int parse(host_options *options, const char *const *words) {
  char *arguments[16] = {(char *)"csm-host"};
  int count = 1;
  for (; *words; words++)
    arguments[count++] = (char *)*words;
  return options_parse(options, count, arguments);
}

static void numbers_are_strict(void **state) {
  (void)state;
  double value;
  assert_true(parse_number("-1.5e2", &value));
  assert_true(value == -150.0);
  const char *const refused[] = {"", " 1", "1 ", "nan", "inf", "1e400", "0x10", "1,2", "--1", "1f"};
  for (size_t i = 0; i < sizeof refused / sizeof refused[0]; i++)
    assert_false(parse_number(refused[i], &value));
  uint32_t width, height;
  assert_true(parse_size("640x360", &width, &height));
  assert_int_equal(width, 640);
  assert_int_equal(height, 360);
  const char *const sizes[] = {"640", "640x", "0x360", "640x360x1", "640.5x360", "16385x1", "-1x5"};
  for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++)
    assert_false(parse_size(sizes[i], &width, &height));
}

static void options_are_understood(void **state) {
  (void)state;
  host_options o;
  assert_int_equal(parse(&o, (const char *const[]){"run", "--scene", "town", "--light", "1,-2,3:0.5", "--size", "64x32",
                                                   "--backend", "d3d12", "--json", "-", NULL}),
                   0);
  assert_int_equal(o.command, COMMAND_RUN);
  assert_string_equal(o.scene, "town");
  assert_true(o.light.direction[1] == -2.0 && o.light.disc_deg == 0.5);
  assert_int_equal(o.width, 64);
  assert_false(o.backends[0]);
  assert_true(o.backends[1]);
}

static void bad_options_are_refused(void **state) {
  (void)state;
  host_options o;
  const char *const bad[][4] = {{"frobnicate"},
                                {"run", "--nope", "1"},
                                {"run", "--scene"},
                                {"run", "--light", "0,0,0"},
                                {"run", "--light", "1,2"},
                                {"run", "--light", "1,2,3:-1"},
                                {"run", "--shadow-distance", "0"},
                                {"run", "--shadow-distance", "inf"},
                                {"run", "--size", "10"},
                                {"run", "--backend", "metal"},
                                {"run", "--preset", "nobody"},
                                {"run", "--preset", "all"},
                                {"measure", "--presets", ","},
                                {"measure", "--presets", "low,nobody"},
                                {"measure", "--presets", "low,low"},
                                {"measure", "--sun-samples", "3"},
                                {"measure", "--sun-samples", "8.5"},
                                {"measure", "--sun-samples", "99999"},
                                {"report", "--cascades", "9"},
                                {"report", "--resolutions", "1024,1024"},
                                {"report", "--minutes", "0"}};
  for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
    assert_int_equal(parse(&o, (const char *const[]){bad[i][0], bad[i][1], bad[i][2], NULL}), 2);
  assert_int_equal(parse(&o, (const char *const[]){NULL}), 2);
  assert_int_equal(parse(&o, (const char *const[]){"--help", NULL}), 0);
}

/* ---- cameras ---- */

static void close_to(double a, double b, double tolerance) {
  if (!(fabs(a - b) <= tolerance * fmax(1.0, fabs(b))))
    fail_msg("%.17g is not %.17g", a, b);
}

static void pose_makes_reversed_right_handed_cameras(void **state) {
  (void)state;
  for (int infinite = 0; infinite < 2; infinite++) {
    const camera_pose pose = {.position = {3, 4, 5},
                              .target = {3, 4, -5},
                              .vertical_fov_deg = 60.0,
                              .near_depth = 0.5,
                              .far_depth = infinite ? INFINITY : 100.0};
    camera made, found;
    assert_null(camera_pose_check(&pose));
    camera_from_pose(&made, &pose, 2.0);
    double view[4], clip[4];
    const double edge[3] = {3.0, 4.0 + 2.0 * tan(pi / 6.0), 3.0}; /* 2 m ahead, at the top of the picture */
    mat_transform(view, made.view, edge, 1.0);
    mat_transform(clip, made.projection, view, view[3]);
    close_to(clip[1] / clip[3], 1.0, 1e-12);
    close_to(clip[2] / clip[3], infinite ? 0.25 : 0.5 / 99.5 * (100.0 / 2.0 - 1.0), 1e-12);
    assert_null(camera_from_matrices(&found, made.view, made.projection));
    assert_true(found.reversed);
    close_to(found.near_depth, 0.5, 1e-12);
    assert_true(infinite ? isinf(found.far_depth) : fabs(found.far_depth - 100.0) < 1e-9);
    close_to(found.position[2], 5.0, 1e-12);
    close_to(found.forward[2], -1.0, 1e-12);
  }
}

/* Left-handed, not reversed, off-centre; and an orthographic one. */
static void any_projection_is_understood(void **state) {
  (void)state;
  camera found;
  double view[16], projection[16] = {0};
  mat_identity(view);
  projection[0] = projection[5] = 1.0;
  projection[8] = 0.3;
  projection[10] = 10.0 / 9.0;
  projection[11] = 1.0;
  projection[14] = -10.0 / 9.0;
  assert_null(camera_from_matrices(&found, view, projection));
  assert_false(found.reversed);
  close_to(found.near_depth, 1.0, 1e-12);
  close_to(found.far_depth, 10.0, 1e-12);
  close_to(found.forward[2], 1.0, 1e-12);

  const double orthographic[16] = {0.1, 0, 0, 0, 0, 0.1, 0, 0, 0, 0, -1.0 / 40.0, 0, 0, 0, -10.0 / 40.0, 1};
  assert_null(camera_from_matrices(&found, view, orthographic));
  assert_false(found.reversed);
  close_to(found.near_depth, 10.0, 1e-12);
  close_to(found.far_depth, 50.0, 1e-12);
  close_to(found.forward[2], -1.0, 1e-12);

  projection[0] = 0.0;
  assert_non_null(camera_from_matrices(&found, view, projection));
  projection[0] = NAN;
  assert_non_null(camera_from_matrices(&found, view, projection));
}

static void bad_poses_are_refused(void **state) {
  (void)state;
  const camera_pose good = {.target = {0, 0, -1}, .vertical_fov_deg = 45.0, .near_depth = 0.1, .far_depth = 10.0};
  camera_pose pose = good;
  pose.target[2] = 0.0;
  assert_non_null(camera_pose_check(&pose));
  pose = good;
  pose.near_depth = 0.0;
  assert_non_null(camera_pose_check(&pose));
  pose = good;
  pose.far_depth = 0.1;
  assert_non_null(camera_pose_check(&pose));
  pose = good;
  pose.vertical_fov_deg = 180.0;
  assert_non_null(camera_pose_check(&pose));
}

static void a_camera_survives_json(void **state) {
  (void)state;
  const camera_pose pose = {.position = {0.1, 1e7 + 1.0 / 3.0, -7},
                            .target = {1, 1e7, 2},
                            .vertical_fov_deg = 33.0,
                            .near_depth = 0.1,
                            .far_depth = INFINITY};
  camera made, found;
  camera_from_pose(&made, &pose, 1.7);
  char path[64];
  make_path(path, ".json");
  json_t *object = camera_to_json(&made);
  assert_int_equal(json_dump_file(object, path, JSON_REAL_PRECISION(17)), 0);
  json_decref(object);
  uint32_t width = 0, height = 0;
  assert_int_equal(camera_from_json(&found, &width, &height, path), 0);
  assert_int_equal(width, 0);
  assert_memory_equal(found.view, made.view, sizeof made.view);
  assert_memory_equal(found.projection, made.projection, sizeof made.projection);
  assert_memory_equal(found.position, made.position, sizeof made.position);
  assert_true(found.near_depth == made.near_depth && isinf(found.far_depth) && found.reversed);
  write_text(path, "{\"view\": [1, 2], \"projection\": []}");
  assert_int_equal(camera_from_json(&found, &width, &height, path), 2);
  write_text(path, "{\"view\": ");
  assert_int_equal(camera_from_json(&found, &width, &height, path), 2);
  unlink(path);
}

/* ---- configurations ---- */

static void configurations_are_read(void **state) {
  (void)state;
  char path[64];
  csm_config config, standard = {.struct_size = sizeof standard};
  csm_config_default(&standard);
  make_path(path, ".json");
  assert_int_equal(config_load(&config, NULL, NULL, 77.0), 0);
  assert_true(config.shadow_distance == 77.0 && config.cascade_count == standard.cascade_count);
  write_text(path,
             "{\"cascade_count\": 3.0, \"filter\": \"pcf_2x2\", \"split_lambda\": 1, \"split_distances\": [1, 2.5]}");
  assert_int_equal(config_load(&config, NULL, path, 77.0), 0);
  assert_int_equal(config.cascade_count, 3);
  assert_int_equal(config.filter, CSM_FILTER_PCF_2X2);
  assert_true(config.split_lambda == 1.0 && config.split_distances[1] == 2.5 && config.split_distances[2] == 0.0);
  assert_true(config.shadow_distance == 77.0);
  write_text(path, "{\"shadow_distance\": 12}");
  assert_int_equal(config_load(&config, NULL, path, 77.0), 0);
  assert_true(config.shadow_distance == 12.0);
  const char *const bad[] = {"{\"nope\": 1}",
                             "{\"cascade_count\": \"3\"}",
                             "{\"cascade_count\": 2.5}",
                             "{\"filter\": \"box\"}",
                             "{\"split_lambda\": null}",
                             "{\"split_distances\": 3}",
                             "[]",
                             "{\"split_lambda\": 1",
                             "{\"cascade_count\": -1}"};
  for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
    write_text(path, bad[i]);
    assert_int_equal(config_load(&config, NULL, path, 77.0), 2);
  }
  unlink(path);
}

static void presets_keep_the_scenes_distance(void **state) {
  (void)state;
  csm_preset_info info = {.struct_size = sizeof info};
  uint32_t own = 0, count = 0;
  for (; csm_config_preset_describe(count, &info) == CSM_SUCCESS; count++) {
    csm_config config, library = {.struct_size = sizeof library};
    assert_int_equal(config_load(&config, info.name, NULL, 77.0), 0);
    assert_int_equal(csm_config_preset(info.name, &library), CSM_SUCCESS);
    if (info.flags & CSM_PRESET_SHADOW_DISTANCE)
      own++;
    else
      library.shadow_distance = 77.0;
    assert_memory_equal(&config, &library, sizeof config);
  }
  assert_true(own > 0 && own < count);
  json_t *listed = presets_to_json();
  assert_int_equal(json_object_size(listed), count);
  json_decref(listed);
}

static void presets_are_found_by_name(void **state) {
  (void)state;
  char path[64];
  csm_config config;
  assert_null(preset_find("--preset", "nobody"));
  const char *bevy = preset_find("--preset", "bevy");
  assert_string_equal(bevy, "bevy");
  make_path(path, ".json");
  write_text(path, "{\"resolution\": 512}");
  assert_int_equal(config_load(&config, bevy, path, 77.0), 0);
  assert_true(config.resolution == 512 && config.shadow_distance == 150.0 && config.map_reversed);
  json_t *bad = json_pack("{s:i}", "nope", 1);
  assert_int_equal(config_read(&config, "--preset", bad), 2);
  json_decref(bad);
  unlink(path);
}

static void every_field_is_described(void **state) {
  (void)state;
  csm_config config = {.struct_size = sizeof config};
  csm_config_default(&config);
  json_t *all = config_describe_json(), *values = config_to_json(&config);
  assert_int_equal(json_object_size(all), json_object_size(values));
  const char *key;
  json_t *value;
  json_object_foreach(all, key, value) {
    assert_true(json_is_string(json_object_get(value, "unit")));
    assert_true(json_is_array(json_object_get(value, "range")));
    assert_true(json_equal(json_object_get(value, "default"), json_object_get(values, key)));
  }
  json_decref(all);
  json_decref(values);
}

/* ---- scenes ---- */

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
static const char triangle_gltf[] =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
    "\"nodes\":[{\"scale\":[2,3,4],\"children\":[1]},{\"translation\":[1,1,1],\"mesh\":0}],"
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,\"material\":0}]}],"
    "\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.5,0.25,0.125,1]},\"doubleSided\":true}],"
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\","
    "\"min\":[0,0,0],\"max\":[1,1,0]},{\"bufferView\":1,\"componentType\":5123,\"count\":3,\"type\":\"SCALAR\"}],"
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36},{\"buffer\":0,\"byteOffset\":36,\"byteLength\":6}],"
    "\"buffers\":[{\"byteLength\":42,\"uri\":\"data:application/octet-stream;base64,"
    "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAABAAIA\"}]}";

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
  char path[64], text[2 * sizeof triangle_gltf];
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

static void broken_gltf_is_refused(void **state) {
  (void)state;
  char path[64], text[sizeof triangle_gltf];
  scene s;
  make_path(path, ".gltf");
  for (size_t length = 0; length < sizeof triangle_gltf - 2; length += 41) {
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

/* ---- what is written ---- */

static void pfm_has_the_bottom_row_first(void **state) {
  (void)state;
  const float values[6] = {1, 2, 3, 4, 5, 6};
  const float expected[6] = {4, 5, 6, 1, 2, 3};
  static const char header[] = "Pf\n3 2\n-1.0\n";
  char path[64];
  size_t size;
  make_path(path, ".pfm");
  assert_int_equal(dump_pfm(values, 3, 2, path), 0);
  uint8_t *bytes = read_bytes(path, &size);
  assert_int_equal(size, sizeof header - 1 + sizeof values);
  assert_memory_equal(bytes, header, sizeof header - 1);
  assert_memory_equal(bytes + sizeof header - 1, expected, sizeof expected);
  free(bytes);
  unlink(path);
}

static void ply_holds_the_world(void **state) {
  (void)state;
  char path[64], ply[64];
  size_t size;
  scene s;
  make_path(path, ".gltf");
  make_path(ply, ".ply");
  write_text(path, triangle_gltf);
  assert_int_equal(scene_load(&s, path), 0);
  assert_int_equal(dump_ply(&s, ply), 0);
  uint8_t *bytes = read_bytes(ply, &size);
  const char *end = strstr((const char *)bytes, "end_header\n");
  assert_non_null(end);
  const uint8_t *body = (const uint8_t *)end + strlen("end_header\n");
  assert_int_equal(size - (size_t)(body - bytes), 3 * 24 + 14);
  double corners[9];
  memcpy(corners, body, sizeof corners);
  const double first[3] = {2, 3, 4};
  assert_memory_equal(corners, first, sizeof first);
  assert_int_equal(body[72], 3);
  free(bytes);
  scene_free(&s);
  unlink(path);
  unlink(ply);
}

/* ---- what is called equal ---- */

static void ulps_are_counted(void **state) {
  (void)state;
  const float a[4] = {0.5f, 0.0f, 1.0f, 0.25f};
  float b[4] = {0.5f, 0.0f, 1.0f, 0.25f};
  assert_int_equal(compare_depths(a, b, 4).differing, 0);
  b[0] = nextafterf(0.5f, 1.0f);
  b[2] = nextafterf(nextafterf(1.0f, 0.0f), 0.0f);
  const depth_difference difference = compare_depths(a, b, 4);
  assert_int_equal(difference.differing, 2);
  assert_int_equal(difference.max_ulp, 2);
}

typedef struct twin {
  host_setup setup;
  stage stages[2];
  stage_frame frames[2];
  float cascade_constants[2][4], setting_constants[2][4];
  float maps[2][16 * 16], masks[2][200 * 100], depths[2][200 * 100];
} twin;

static twin *make_twin(void) {
  twin *t = calloc(1, sizeof *t);
  t->setup.width = 200;
  t->setup.height = 100;
  for (int i = 0; i < 2; i++) {
    t->stages[i].setup = &t->setup;
    t->frames[i].binding.cascade_count = 1;
    t->frames[i].binding.resolutions[0] = 16;
    t->frames[i].binding.cascade_constants = t->cascade_constants[i];
    t->frames[i].binding.cascade_constants_size = sizeof t->cascade_constants[i];
    t->frames[i].binding.setting_constants = t->setting_constants[i];
    t->frames[i].binding.setting_constants_size = sizeof t->setting_constants[i];
    t->frames[i].maps[0] = t->maps[i];
    t->frames[i].mask = t->masks[i];
    t->frames[i].camera_depth = t->depths[i];
  }
  return t;
}

static agreement compare_twin(const twin *t) {
  agreement result;
  compare_frames(&result, &t->stages[0], &t->frames[0], &t->stages[1], &t->frames[1]);
  return result;
}

static void agreement_keeps_to_the_contract(void **state) {
  (void)state;
  twin *t = make_twin();
  assert_true(compare_twin(t).agrees);

  t->masks[1][0] = t->masks[1][1] = 1.0f; /* 2 of 20,000 are 0.01 % */
  t->masks[1][2] = 1.0f / 255.0f;
  assert_true(compare_twin(t).agrees);
  t->masks[1][3] = 2.0f / 255.0f;
  assert_false(compare_twin(t).agrees);
  assert_int_equal(compare_twin(t).mask_beyond, 3);
  t->masks[1][3] = 0.0f;

  t->maps[1][5] = nextafterf(0.0f, 1.0f);
  assert_false(compare_twin(t).agrees); /* one device: the same bits */
  snprintf(t->stages[1].device, sizeof t->stages[1].device, "another");
  assert_true(compare_twin(t).agrees);
  t->maps[1][5] = 1e-3f;
  assert_false(compare_twin(t).agrees);
  t->maps[1][5] = 0.0f;

  t->frames[1].stats.maps.plan_hash = 1;
  assert_false(compare_twin(t).agrees);
  t->frames[1].stats.maps.plan_hash = 0;
  t->cascade_constants[1][3] = 1e-30f;
  assert_false(compare_twin(t).agrees);
  t->cascade_constants[1][3] = 0.0f;
  t->setting_constants[1][0] = -0.0f;
  assert_false(compare_twin(t).agrees);
  t->setting_constants[1][0] = 0.0f;
  t->frames[1].binding.cascades[0].texel_size = 1e-300;
  assert_false(compare_twin(t).agrees);
  free(t);
}

/* The interval of 31 samples is that of the sign test: the 10th to the 22nd. */
static void medians_have_intervals(void **state) {
  (void)state;
  double samples[31];
  for (int i = 0; i < 31; i++)
    samples[i] = (i * 7) % 31 + 1;
  const estimate result = estimate_median(samples, 31);
  assert_true(result.median == 16.0 && result.low == 10.0 && result.high == 22.0);
  double few[2] = {3.0, 1.0};
  const estimate two = estimate_median(few, 2);
  assert_true(two.median == 2.0 && two.low == 1.0 && two.high == 3.0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(numbers_are_strict),
      cmocka_unit_test(options_are_understood),
      cmocka_unit_test(bad_options_are_refused),
      cmocka_unit_test(pose_makes_reversed_right_handed_cameras),
      cmocka_unit_test(any_projection_is_understood),
      cmocka_unit_test(bad_poses_are_refused),
      cmocka_unit_test(a_camera_survives_json),
      cmocka_unit_test(configurations_are_read),
      cmocka_unit_test(presets_keep_the_scenes_distance),
      cmocka_unit_test(presets_are_found_by_name),
      cmocka_unit_test(every_field_is_described),
      cmocka_unit_test(scenes_are_what_they_promise),
      cmocka_unit_test(solids_face_outwards),
      cmocka_unit_test(gltf_is_read),
      cmocka_unit_test(what_is_not_understood_is_refused),
      cmocka_unit_test(broken_gltf_is_refused),
      cmocka_unit_test(views_are_traced),
      cmocka_unit_test(pfm_has_the_bottom_row_first),
      cmocka_unit_test(ply_holds_the_world),
      cmocka_unit_test(ulps_are_counted),
      cmocka_unit_test(agreement_keeps_to_the_contract),
      cmocka_unit_test(medians_have_intervals),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
