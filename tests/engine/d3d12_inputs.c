/* d3d12_inputs.c: what an engine hands in on Direct3D 12: its camera's depth and normals, its vertices and indices. */
#include "d3d12_rig.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 192, HEIGHT = 128, PIXELS = WIDTH * HEIGHT };

/* A context with the scene, and the settings that tell normals apart. */
typedef struct side {
  csm_context *context;
  csm_cascades *cascades;
  csm_config config;
  support_scene scene;
} side;

static void side_open(side *side, csm_context *context) {
  *side = (struct side){.context = context, .config = support_config()};
  side->config.bias_normal_texels = 2;
  support_scene_make(&side->scene, context);
  assert_int_equal(csm_cascades_create(context, &side->config, &side->cascades), CSM_SUCCESS);
}

/* What a context with a device of its own draws, and the depth that its camera sees. */
static picture draw_own(float **depth) {
  record record = {0};
  side own;
  side_open(&own, support_open(&record));
  const csm_mask_info mask = {.struct_size = sizeof mask, .frame = &own.scene.frame, .width = WIDTH, .height = HEIGHT};
  own.scene.frame.instances = own.scene.instances;
  assert_int_equal(csm_render_cascades(own.cascades, &own.scene.frame), CSM_SUCCESS);
  assert_int_equal(csm_resolve_mask(own.cascades, &mask), CSM_SUCCESS);
  const picture out = picture_read(own.cascades, &own.config, WIDTH, HEIGHT);
  if (depth)
    *depth = support_read(own.cascades, CSM_READ_CAMERA_DEPTH, 0, WIDTH, HEIGHT);
  support_close(own.context, &record);
  return out;
}

static csm_d3d12_image image_of(ID3D12Resource *resource, DXGI_FORMAT format) {
  return (csm_d3d12_image){
      .struct_size = sizeof(csm_d3d12_image), .format = format, .resource = resource, .width = WIDTH, .height = HEIGHT};
}

/* The maps, and the mask of the engine's images; with its depth, the camera needs no instances. */
static picture draw_engines(d3d12_rig *rig, side *side, const csm_d3d12_image *depth, const csm_d3d12_image *normals) {
  ID3D12GraphicsCommandList *list = d3d12_engine_begin(&rig->engine);
  csm_frame frame = rig_frame(rig, &side->scene, list);
  rig_render(rig, side->cascades, &frame);
  if (depth)
    frame.instance_count = 0;
  const csm_mask_info mask = {.struct_size = sizeof mask,
                              .frame = &frame,
                              .width = WIDTH,
                              .height = HEIGHT,
                              .camera_depth = depth,
                              .normals = normals};
  const csm_result result = csm_resolve_mask(side->cascades, &mask);
  if (result)
    fail_msg("%s: %s", csm_result_name(result), csm_last_error(side->context));
  picture_copy copy = picture_record(rig, list, side->cascades, WIDTH, HEIGHT);
  d3d12_engine_end(&rig->engine);
  d3d12_engine_run(&rig->engine, rig->engine.frame);
  rig_retire(rig);
  return picture_take(&copy);
}

/* ---- depth ---- */

static void own_depth_gives_the_same_mask(void **state) {
  static const struct {
    DXGI_FORMAT format;
    D3D12_RESOURCE_FLAGS flags;
  } kinds[] = {{DXGI_FORMAT_R32_FLOAT, 0}, {DXGI_FORMAT_R32_TYPELESS, D3D12_RESOURCE_FLAG_ALLOW_DEPTH_STENCIL}};
  (void)state;
  float *depth;
  picture expected = draw_own(&depth);
  for (size_t i = 0; i < sizeof kinds / sizeof *kinds; ++i) {
    d3d12_rig rig;
    side side;
    rig_open(&rig);
    side_open(&side, rig.context);
    ID3D12Resource *resource =
        d3d12_engine_image(&rig.engine, kinds[i].format, kinds[i].flags, WIDTH, HEIGHT, sizeof(float), depth);
    const csm_d3d12_image image = image_of(resource, DXGI_FORMAT_R32_FLOAT);
    picture drawn = draw_engines(&rig, &side, &image, NULL);
    picture_expect_equal(&expected, &drawn);
    picture_free(&drawn);
    assert_int_equal(ID3D12Resource_Release(resource), 0);
    rig_close(&rig);
  }
  picture_free(&expected);
  free(depth);
}

/* ---- normals ---- */

/* The scene's normal at every pixel, turned to the camera: all faces lie along axes. Up where nothing is. */
static void trace_normals(const support_scene *scene, double normals[PIXELS][3]) {
  static double corners[SUPPORT_TRIANGLES][3][3];
  const double *view = scene->frame.view, *projection = scene->frame.projection;
  double eye[3];
  support_triangles(scene, corners);
  for (int axis = 0; axis < 3; ++axis)
    eye[axis] = -(view[axis * 4] * view[12] + view[axis * 4 + 1] * view[13] + view[axis * 4 + 2] * view[14]);
  for (uint32_t pixel = 0; pixel < PIXELS; ++pixel) {
    const double x = ((pixel % WIDTH + 0.5) / WIDTH * 2 - 1) / projection[0];
    const double y = (1 - (pixel / WIDTH + 0.5) / HEIGHT * 2) / projection[5];
    double direction[3], nearest = INFINITY, *normal = normals[pixel];
    for (int axis = 0; axis < 3; ++axis)
      direction[axis] = view[axis * 4] * x + view[axis * 4 + 1] * y - view[axis * 4 + 2];
    memcpy(normal, (const double[]){0, 1, 0}, 3 * sizeof *normal);
    for (uint32_t i = 0; i < SUPPORT_TRIANGLES; ++i) {
      double edge;
      const double distance = support_trace(&corners[i], 1, eye, direction, &edge);
      if (distance < 0 || distance >= nearest)
        continue;
      nearest = distance;
      for (int axis = 0; axis < 3; ++axis) {
        const bool flat = corners[i][0][axis] == corners[i][1][axis] && corners[i][0][axis] == corners[i][2][axis];
        normal[axis] = flat ? (direction[axis] > 0 ? -1 : 1) : 0;
      }
    }
  }
}

typedef struct normal_format {
  DXGI_FORMAT format;
  uint32_t texel_bytes;
  double tolerance; /* by how much a mask may differ from that of float normals */
} normal_format;

static void encode(const double n[3], const normal_format *format, unsigned char *out) {
  for (int i = 0; i < 4; ++i) {
    const double value = i < 3 ? n[i] : 0, unorm = value * 0.5 + 0.5;
    const float whole = (float)value;
    const int16_t snorm = (int16_t)lrint(value * 32767);
    const uint16_t wide = (uint16_t)lrint(unorm * 65535);
    if (format->format == DXGI_FORMAT_R32G32B32A32_FLOAT)
      memcpy(out + i * 4, &whole, 4);
    else if (format->format == DXGI_FORMAT_R16G16B16A16_SNORM)
      memcpy(out + i * 2, &snorm, 2);
    else if (format->format == DXGI_FORMAT_R16G16B16A16_UNORM)
      memcpy(out + i * 2, &wide, 2);
    else
      out[i] = (unsigned char)lrint(unorm * 255);
  }
}

static ID3D12Resource *make_normals(d3d12_rig *rig, double normals[PIXELS][3], const normal_format *format) {
  unsigned char *texels = malloc((size_t)PIXELS * format->texel_bytes);
  assert_non_null(texels);
  for (uint32_t i = 0; i < PIXELS; ++i)
    encode(normals[i], format, texels + (size_t)i * format->texel_bytes);
  ID3D12Resource *image =
      d3d12_engine_image(&rig->engine, format->format, 0, WIDTH, HEIGHT, format->texel_bytes, texels);
  free(texels);
  return image;
}

/* Share of the mask's pixels that differ by more than one step of 255. */
static double mask_difference(const picture *a, const picture *b) {
  const picture_layer *x = &a->layers[a->count - 1], *y = &b->layers[b->count - 1];
  uint32_t different = 0;
  for (uint32_t i = 0; i < PIXELS; ++i)
    different += fabsf(x->texels[i] - y->texels[i]) > 1.5f / 255;
  return (double)different / PIXELS;
}

static void own_normals_are_used(void **state) {
  static const normal_format formats[] = {{DXGI_FORMAT_R32G32B32A32_FLOAT, 16, 0},
                                          {DXGI_FORMAT_R16G16B16A16_SNORM, 8, 0},
                                          {DXGI_FORMAT_R16G16B16A16_UNORM, 8, 1e-3},
                                          {DXGI_FORMAT_R8G8B8A8_UNORM, 4, 1e-2}};
  static double normals[PIXELS][3];
  (void)state;
  float *depth;
  d3d12_rig rig;
  side side;
  picture own = draw_own(&depth), floats = {0};
  rig_open(&rig);
  side_open(&side, rig.context);
  trace_normals(&side.scene, normals);
  ID3D12Resource *depth_image =
      d3d12_engine_image(&rig.engine, DXGI_FORMAT_R32_FLOAT, 0, WIDTH, HEIGHT, sizeof(float), depth);
  const csm_d3d12_image seen = image_of(depth_image, DXGI_FORMAT_R32_FLOAT);
  for (size_t i = 0; i < sizeof formats / sizeof *formats; ++i) {
    ID3D12Resource *resource = make_normals(&rig, normals, &formats[i]);
    const csm_d3d12_image image = image_of(resource, formats[i].format);
    picture drawn = draw_engines(&rig, &side, &seen, &image);
    if (i == 0)
      floats = drawn;
    /* Normals from depth are those of the faces, but for silhouettes. */
    assert_true(mask_difference(&own, &drawn) < 0.01);
    assert_true(mask_difference(&floats, &drawn) <= formats[i].tolerance);
    if (i)
      picture_free(&drawn);
    ID3D12Resource_Release(resource);
  }
  for (uint32_t i = 0; i < PIXELS; ++i) /* false ones: each along the next axis */
    memcpy(normals[i], (const double[]){normals[i][2], normals[i][0], normals[i][1]}, sizeof normals[i]);
  ID3D12Resource *false_resource = make_normals(&rig, normals, &formats[0]);
  const csm_d3d12_image false_image = image_of(false_resource, formats[0].format);
  picture wrong = draw_engines(&rig, &side, &seen, &false_image);
  assert_true(mask_difference(&floats, &wrong) > 0.02);
  picture_free(&wrong);
  picture_free(&floats);
  picture_free(&own);
  ID3D12Resource_Release(false_resource);
  ID3D12Resource_Release(depth_image);
  free(depth);
  rig_close(&rig);
}

/* csm holds what it is given for as long as a frame in flight reads it. */
static void images_are_held_while_in_flight(void **state) {
  (void)state;
  d3d12_rig rig;
  side side;
  rig_open(&rig);
  side_open(&side, rig.context);
  float *depth = calloc(PIXELS, sizeof *depth);
  ID3D12Resource *resource =
      d3d12_engine_image(&rig.engine, DXGI_FORMAT_R32_FLOAT, 0, WIDTH, HEIGHT, sizeof(float), depth);
  free(depth);
  const csm_d3d12_image image = image_of(resource, DXGI_FORMAT_R32_FLOAT);
  csm_frame frame = rig_frame(&rig, &side.scene, d3d12_engine_begin(&rig.engine));
  const csm_mask_info mask = {
      .struct_size = sizeof mask, .frame = &frame, .width = WIDTH, .height = HEIGHT, .camera_depth = &image};
  rig_render(&rig, side.cascades, &frame);
  assert_int_equal(csm_resolve_mask(side.cascades, &mask), CSM_SUCCESS);
  d3d12_engine_end(&rig.engine);
  assert_int_equal(d3d12_engine_references(resource), 2);
  d3d12_engine_run(&rig.engine, rig.engine.frame);
  assert_int_equal(d3d12_engine_references(resource), 2);
  rig_retire(&rig);
  assert_int_equal(d3d12_engine_references(resource), 1);
  ID3D12Resource_Release(resource);
  rig_close(&rig);
}

/* ---- meshes ---- */

typedef struct mesh_kind {
  uint32_t stride, index_size;
  uint32_t vertex_offset; /* of the first position */
  bool one_buffer;        /* vertices and indices, the indices behind */
} mesh_kind;

typedef struct engine_mesh {
  ID3D12Resource *vertices, *indices;
  csm_mesh mesh;
} engine_mesh;

/* Positions among vertices that are otherwise NaN. */
static engine_mesh make_engine_mesh(d3d12_rig *rig, const hill *hill, const mesh_kind *kind) {
  const uint32_t vertex_bytes = kind->vertex_offset + HILL_VERTICES * kind->stride;
  const uint32_t index_bytes = HILL_INDICES * kind->index_size;
  const uint32_t index_offset = kind->one_buffer ? (vertex_bytes + 3) / 4 * 4 : 8;
  const void *indices = kind->index_size == 2 ? (const void *)hill->indices : hill->wide_indices;
  engine_mesh out = {.vertices = d3d12_engine_buffer(&rig->engine, D3D12_HEAP_TYPE_UPLOAD,
                                                     index_offset + vertex_bytes + index_bytes, NULL)};
  char *memory = d3d12_engine_map(out.vertices);
  memset(memory, 0xff, vertex_bytes);
  for (uint32_t i = 0; i < HILL_VERTICES; ++i)
    memcpy(memory + kind->vertex_offset + (size_t)i * kind->stride, hill->positions[i], sizeof hill->positions[i]);
  out.indices = out.vertices;
  if (!kind->one_buffer)
    out.indices = d3d12_engine_buffer(&rig->engine, D3D12_HEAP_TYPE_UPLOAD, index_offset + index_bytes, NULL);
  memcpy((char *)d3d12_engine_map(out.indices) + index_offset, indices, index_bytes);

  const csm_d3d12_mesh native = {.struct_size = sizeof native,
                                 .vertex_stride = kind->stride,
                                 .vertices = out.vertices,
                                 .vertex_offset = kind->vertex_offset,
                                 .indices = out.indices,
                                 .index_offset = index_offset};
  const csm_mesh_info info = {.struct_size = sizeof info,
                              .vertex_count = HILL_VERTICES,
                              .index_count = HILL_INDICES,
                              .index_size = kind->index_size,
                              .d3d12 = &native,
                              .bounds_min = {-1, -1, -1},
                              .bounds_max = {1, 1, 1}};
  const csm_result result = csm_mesh_create(rig->context, &info, &out.mesh);
  if (result)
    fail_msg("%s: %s", csm_result_name(result), csm_last_error(rig->context));
  return out;
}

static picture draw_mesh(d3d12_rig *rig, side *side, csm_mesh mesh) {
  side->scene.instances[1] = support_instance(mesh, -1, 2, 1, 3, 2, 3);
  side->scene.instances[3] = support_instance(mesh, -6, 5, -9, 2, 1, 2);
  return draw_engines(rig, side, NULL, NULL);
}

static void engines_meshes_are_as_copied_ones(void **state) {
  static const mesh_kind kinds[] = {{12, 2, 0, false},  {12, 4, 12, true},  {16, 4, 0, false},  {20, 2, 4, true},
                                    {32, 2, 64, false}, {52, 4, 20, false}, {2048, 4, 0, true}, {32, 4, 8, true}};
  (void)state;
  d3d12_rig rig;
  side side;
  hill hill;
  rig_open(&rig);
  side_open(&side, rig.context);
  hill_make(&hill);
  picture before = draw_engines(&rig, &side, NULL, NULL);
  const csm_mesh copied = hill_mesh(rig.context, &hill, 4);
  picture expected = draw_mesh(&rig, &side, copied);
  assert_true(mask_difference(&before, &expected) > 0.01);
  engine_mesh meshes[sizeof kinds / sizeof *kinds];
  for (size_t i = 0; i < sizeof kinds / sizeof *kinds; ++i) {
    meshes[i] = make_engine_mesh(&rig, &hill, &kinds[i]);
    picture drawn = draw_mesh(&rig, &side, meshes[i].mesh);
    picture_expect_equal(&expected, &drawn);
    picture_free(&drawn);
    assert_int_equal(csm_mesh_destroy(rig.context, meshes[i].mesh), CSM_SUCCESS);
  }
  picture last = draw_mesh(&rig, &side, copied);
  for (size_t i = 0; i < sizeof kinds / sizeof *kinds; ++i) {
    assert_int_equal(ID3D12Resource_Release(meshes[i].vertices), 0);
    if (!kinds[i].one_buffer)
      assert_int_equal(ID3D12Resource_Release(meshes[i].indices), 0);
  }
  picture_free(&last);
  picture_free(&before);
  picture_free(&expected);
  rig_close(&rig);
}

/* A mesh that is destroyed while a frame in flight draws it stays until that frame is retired. */
static void meshes_are_held_while_in_flight(void **state) {
  static const mesh_kind kind = {16, 2, 0, false};
  (void)state;
  d3d12_rig rig;
  side side;
  hill hill;
  rig_open(&rig);
  side_open(&side, rig.context);
  hill_make(&hill);
  engine_mesh mesh = make_engine_mesh(&rig, &hill, &kind);
  side.scene.instances[1] = support_instance(mesh.mesh, -1, 2, 1, 3, 2, 3);
  csm_frame frame = rig_frame(&rig, &side.scene, d3d12_engine_begin(&rig.engine));
  rig_render(&rig, side.cascades, &frame);
  d3d12_engine_end(&rig.engine);
  assert_int_equal(csm_mesh_destroy(rig.context, mesh.mesh), CSM_SUCCESS);
  assert_int_equal(d3d12_engine_references(mesh.vertices), 2);
  assert_int_equal(d3d12_engine_references(mesh.indices), 2);
  d3d12_engine_run(&rig.engine, rig.engine.frame);
  rig_retire(&rig);
  assert_int_equal(ID3D12Resource_Release(mesh.vertices), 0);
  assert_int_equal(ID3D12Resource_Release(mesh.indices), 0);
  rig_close(&rig);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(own_depth_gives_the_same_mask),   cmocka_unit_test(own_normals_are_used),
      cmocka_unit_test(images_are_held_while_in_flight), cmocka_unit_test(engines_meshes_are_as_copied_ones),
      cmocka_unit_test(meshes_are_held_while_in_flight),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
