/* d3d12_misuse.c: what an engine may get wrong on Direct3D 12 is told by name, and changes nothing. */
#include "d3d12_proxy.h"
#include "d3d12_rig.h"

#include "csm/csm_vulkan.h"

#include <string.h>

enum { SIDE = 64 };

/* ---- devices ---- */

static void expect_create(csm_create_info info, record *record, csm_result expected, const char *what) {
  char text[512] = "";
  csm_context *context = NULL;
  record->quiet = true;
  info.error = text;
  info.error_size = sizeof text;
  const csm_result result = csm_create(&info, &context);
  csm_destroy(context);
  if (result != expected)
    fail_msg("%s: %s (%s), not %s", what, csm_result_name(result), text, csm_result_name(expected));
  assert_true(!result || text[0]);
  assert_int_equal(record->blocks, 0);
}

static void expect_device(const csm_d3d12_device *native, csm_result expected, const char *what) {
  record record = {0};
  const csm_create_info info = rig_create_info(&record, native);
  expect_create(info, &record, expected, what);
}

static void devices_are_checked(void **state) {
  (void)state;
  d3d12_engine engine;
  d3d12_proxy proxy;
  d3d12_engine_open(&engine);
  const uint32_t references = d3d12_engine_references(engine.device);
  const csm_d3d12_device *good = &engine.native;
  struct {
    csm_d3d12_device device;
    uint64_t tail[2];
  } later = {.device = *good};
  csm_d3d12_device device = *good;
#define WITH(field, value) (device = *good, device.field = (value), &device)
  expect_device(good, CSM_SUCCESS, "a good device");
  expect_device(WITH(device, NULL), CSM_ERROR_NULL_POINTER, "no device");
  expect_device(WITH(serialize_root_signature, NULL), CSM_ERROR_NULL_POINTER, "no serialiser");
  expect_device(WITH(reserved, 1), CSM_ERROR_INVALID_VALUE, "reserved");
  expect_device(WITH(struct_size, 0), CSM_ERROR_STRUCT_SIZE, "no size");
  expect_device(WITH(struct_size, 17), CSM_ERROR_STRUCT_SIZE, "an odd size");
  expect_device(WITH(struct_size, offsetof(csm_d3d12_device, serialize_root_signature)), CSM_ERROR_NULL_POINTER,
                "an older struct, without a serialiser");
#undef WITH
  later.device.struct_size = sizeof later;
  expect_device(&later.device, CSM_SUCCESS, "a later struct, whose tail is zero");
  later.tail[1] = 1;
  expect_device(&later.device, CSM_ERROR_STRUCT_SIZE, "a later struct, whose tail is not");

  d3d12_proxy_open(&proxy, engine.device);
  device = *good;
  device.device = &proxy.device;
  expect_device(&device, CSM_SUCCESS, "a device within a device");
  proxy.level = D3D_FEATURE_LEVEL_10_1;
  expect_device(&device, CSM_ERROR_UNSUPPORTED, "a feature level that is too low");
  assert_int_equal(proxy.references, 1);
  assert_int_equal(d3d12_engine_references(engine.device), references);
  assert_int_equal(engine.messages, 0);
  d3d12_engine_close(&engine);
}

static void other_apis_are_refused(void **state) {
  (void)state;
  d3d12_engine engine;
  record record = {0};
  const csm_vulkan_device vulkan = {.struct_size = sizeof vulkan};
  d3d12_engine_open(&engine);
  csm_create_info info = rig_create_info(&record, NULL);
  info.vulkan = &vulkan;
  expect_create(info, &record, CSM_ERROR_UNSUPPORTED, "a Vulkan device");
  info.d3d12 = &engine.native;
  expect_create(info, &record, CSM_ERROR_INVALID_VALUE, "two devices");
  d3d12_engine_close(&engine);
}

/* ---- what is handed in later ---- */

typedef struct fixture {
  d3d12_rig rig;
  csm_cascades *cascades;
  support_scene scene;
  ID3D12Resource *image, *buffer;
} fixture;

static void fixture_open(fixture *f) {
  static const float texels[SIDE * SIDE];
  const csm_config config = support_config();
  rig_open(&f->rig);
  support_scene_make(&f->scene, f->rig.context);
  assert_int_equal(csm_cascades_create(f->rig.context, &config, &f->cascades), CSM_SUCCESS);
  f->image = d3d12_engine_image(&f->rig.engine, DXGI_FORMAT_R32_TYPELESS, D3D12_RESOURCE_FLAG_ALLOW_DEPTH_STENCIL, SIDE,
                                SIDE, sizeof(float), texels);
  f->buffer = d3d12_engine_buffer(&f->rig.engine, D3D12_HEAP_TYPE_UPLOAD, 4096, NULL);
  memset(d3d12_engine_map(f->buffer), 0, 4096);
  f->rig.record.quiet = true;
}

/* The context still draws, and holds nothing. */
static void fixture_close(fixture *f) {
  csm_frame frame = rig_frame(&f->rig, &f->scene, d3d12_engine_begin(&f->rig.engine));
  rig_render(&f->rig, f->cascades, &frame);
  d3d12_engine_end(&f->rig.engine);
  d3d12_engine_run(&f->rig.engine, f->rig.engine.frame);
  rig_retire(&f->rig);
  assert_int_equal(ID3D12Resource_Release(f->image), 0);
  assert_int_equal(ID3D12Resource_Release(f->buffer), 0);
  rig_close(&f->rig);
}

static void expect(const fixture *f, csm_result result, csm_result expected, const char *what) {
  if (result != expected)
    fail_msg("%s: %s (%s), not %s", what, csm_result_name(result), csm_last_error(f->rig.context),
             csm_result_name(expected));
  assert_true(!result || csm_last_error(f->rig.context)[0]);
}

static csm_mesh_info mesh_info(const csm_d3d12_mesh *native) {
  return (csm_mesh_info){.struct_size = sizeof(csm_mesh_info),
                         .vertex_count = 3,
                         .index_count = 3,
                         .index_size = 2,
                         .d3d12 = native,
                         .bounds_min = {-1, -1, -1},
                         .bounds_max = {1, 1, 1}};
}

static void expect_mesh(fixture *f, const csm_d3d12_mesh *native, csm_result expected, const char *what) {
  const csm_mesh_info info = mesh_info(native);
  csm_mesh mesh = 1;
  const csm_result result = csm_mesh_create(f->rig.context, &info, &mesh);
  expect(f, result, expected, what);
  assert_true((mesh != 0) == !result);
  if (!result)
    assert_int_equal(csm_mesh_destroy(f->rig.context, mesh), CSM_SUCCESS);
  assert_in_range(d3d12_engine_references(f->image), 1, 1);
}

static void meshes_are_checked(void **state) {
  (void)state;
  fixture f;
  fixture_open(&f);
  const csm_d3d12_mesh good = {
      .struct_size = sizeof good, .vertex_stride = 16, .vertices = f.buffer, .indices = f.buffer, .index_offset = 1024};
  struct {
    csm_d3d12_mesh mesh;
    uint64_t tail;
  } later = {.mesh = good, .tail = 1};
  csm_d3d12_mesh mesh;
#define WITH(field, value) (mesh = good, mesh.field = (value), &mesh)
  expect_mesh(&f, &good, CSM_SUCCESS, "a good mesh");
  expect_mesh(&f, WITH(vertices, NULL), CSM_ERROR_NULL_POINTER, "no vertices");
  expect_mesh(&f, WITH(indices, NULL), CSM_ERROR_NULL_POINTER, "no indices");
  expect_mesh(&f, WITH(vertices, f.image), CSM_ERROR_INVALID_VALUE, "an image for vertices");
  expect_mesh(&f, WITH(indices, f.image), CSM_ERROR_INVALID_VALUE, "an image for indices");
  expect_mesh(&f, WITH(vertex_stride, 0), CSM_ERROR_INVALID_VALUE, "no stride");
  expect_mesh(&f, WITH(vertex_stride, 8), CSM_ERROR_INVALID_VALUE, "a stride below a position");
  expect_mesh(&f, WITH(vertex_stride, 18), CSM_ERROR_INVALID_VALUE, "a stride that is not aligned");
  expect_mesh(&f, WITH(vertex_stride, 2052), CSM_ERROR_INVALID_VALUE, "a stride beyond the API's");
  expect_mesh(&f, WITH(vertex_offset, 2), CSM_ERROR_INVALID_VALUE, "vertices that are not aligned");
  expect_mesh(&f, WITH(index_offset, 1026), CSM_ERROR_INVALID_VALUE, "indices that are not aligned");
  expect_mesh(&f, WITH(vertex_offset, 4096), CSM_ERROR_INVALID_VALUE, "vertices beyond the buffer");
  expect_mesh(&f, WITH(index_offset, 4096), CSM_ERROR_INVALID_VALUE, "indices beyond the buffer");
  expect_mesh(&f, WITH(struct_size, 0), CSM_ERROR_STRUCT_SIZE, "no size");
  expect_mesh(&f, WITH(struct_size, offsetof(csm_d3d12_mesh, indices)), CSM_ERROR_NULL_POINTER,
              "an older struct, without indices");
  expect_mesh(&f, WITH(struct_size, offsetof(csm_d3d12_mesh, index_offset)), CSM_SUCCESS,
              "an older struct, without an offset");
#undef WITH
  later.mesh.struct_size = sizeof later;
  expect_mesh(&f, &later.mesh, CSM_ERROR_STRUCT_SIZE, "a later struct, whose tail is not zero");
  csm_mesh_info other = mesh_info(NULL);
  const csm_vulkan_mesh vulkan = {.struct_size = sizeof vulkan, .vertex_stride = 12};
  csm_mesh none;
  other.vulkan = &vulkan;
  expect(&f, csm_mesh_create(f.rig.context, &other, &none), CSM_ERROR_UNSUPPORTED, "buffers of Vulkan");
  fixture_close(&f);
}

static void expect_image(fixture *f, const csm_d3d12_image *depth, const csm_d3d12_image *normals, csm_result expected,
                         const char *what) {
  csm_frame frame = rig_frame(&f->rig, &f->scene, d3d12_engine_begin(&f->rig.engine));
  rig_render(&f->rig, f->cascades, &frame);
  const csm_mask_info mask = {.struct_size = sizeof mask,
                              .frame = &frame,
                              .width = SIDE,
                              .height = SIDE,
                              .camera_depth = depth,
                              .normals = normals};
  expect(f, csm_resolve_mask(f->cascades, &mask), expected, what);
  d3d12_engine_end(&f->rig.engine);
  d3d12_engine_run(&f->rig.engine, f->rig.engine.frame);
  rig_retire(&f->rig);
}

static void images_are_checked(void **state) {
  (void)state;
  fixture f;
  fixture_open(&f);
  const csm_d3d12_image good = {
      .struct_size = sizeof good, .format = DXGI_FORMAT_R32_FLOAT, .resource = f.image, .width = SIDE, .height = SIDE};
  csm_d3d12_image image;
#define WITH(field, value) (image = good, image.field = (value), &image)
  expect_image(&f, &good, NULL, CSM_SUCCESS, "a good image");
  expect_image(&f, WITH(resource, NULL), NULL, CSM_ERROR_NULL_POINTER, "no image");
  expect_image(&f, WITH(resource, f.buffer), NULL, CSM_ERROR_INVALID_VALUE, "a buffer");
  expect_image(&f, WITH(format, DXGI_FORMAT_UNKNOWN), NULL, CSM_ERROR_INVALID_VALUE, "no format");
  expect_image(&f, WITH(format, DXGI_FORMAT_D32_FLOAT), NULL, CSM_ERROR_INVALID_VALUE, "a format of targets alone");
  expect_image(&f, WITH(format, DXGI_FORMAT_R32_TYPELESS), NULL, CSM_ERROR_INVALID_VALUE, "a format without a type");
  expect_image(&f, WITH(format, DXGI_FORMAT_R32_UINT), NULL, CSM_ERROR_INVALID_VALUE, "integers");
  expect_image(&f, WITH(width, SIDE + 1), NULL, CSM_ERROR_INVALID_VALUE, "a width beyond the image");
  expect_image(&f, WITH(height, 0), NULL, CSM_ERROR_INVALID_VALUE, "no height");
  expect_image(&f, WITH(struct_size, 0), NULL, CSM_ERROR_STRUCT_SIZE, "no size");
  expect_image(&f, &good, WITH(resource, NULL), CSM_ERROR_NULL_POINTER, "no normals");
#undef WITH
  fixture_close(&f);
}

/* ---- frames ---- */

static void frames_are_checked(void **state) {
  (void)state;
  fixture f;
  fixture_open(&f);
  const csm_frame good = rig_frame(&f.rig, &f.scene, d3d12_engine_begin(&f.rig.engine));
  csm_frame frame;
#define WITH(field, value) (frame = good, frame.field = (value), &frame)
  expect(&f, csm_render_cascades(f.cascades, WITH(command_buffer, NULL)), CSM_ERROR_NULL_POINTER, "no list");
  expect(&f, csm_render_cascades(f.cascades, WITH(frame, 0)), CSM_ERROR_INVALID_VALUE, "frame 0");

  ID3D12CommandAllocator *allocator;
  ID3D12GraphicsCommandList *compute;
  d3d12_engine_must(ID3D12Device_CreateCommandAllocator(f.rig.engine.device, D3D12_COMMAND_LIST_TYPE_COMPUTE,
                                                        &IID_ID3D12CommandAllocator, (void **)&allocator),
                    "an allocator");
  d3d12_engine_must(ID3D12Device_CreateCommandList(f.rig.engine.device, 0, D3D12_COMMAND_LIST_TYPE_COMPUTE, allocator,
                                                   NULL, &IID_ID3D12GraphicsCommandList, (void **)&compute),
                    "a list");
  expect(&f, csm_render_cascades(f.cascades, WITH(command_buffer, compute)), CSM_ERROR_INVALID_VALUE, "a compute list");
  d3d12_engine_must(ID3D12GraphicsCommandList_Close(compute), "closing a list");
  ID3D12GraphicsCommandList_Release(compute);
  ID3D12CommandAllocator_Release(allocator);

  const uint64_t first = good.frame;
  for (uint64_t i = 0; i < 3; ++i)
    expect(&f, csm_render_cascades(f.cascades, WITH(frame, first + i)), CSM_SUCCESS, "a frame");
  expect(&f, csm_render_cascades(f.cascades, WITH(frame, first + 3)), CSM_ERROR_INVALID_STATE, "too many in flight");
  expect(&f, csm_render_cascades(f.cascades, WITH(frame, first + 1)), CSM_ERROR_INVALID_VALUE, "a frame that fell");
  expect(&f, csm_render_cascades(f.cascades, WITH(frame, first + 2)), CSM_SUCCESS, "the same frame");
#undef WITH
  float texels[4];
  const csm_read_info read = {.struct_size = sizeof read, .data = texels, .size = sizeof texels};
  expect(&f, csm_read(f.cascades, &read), CSM_ERROR_UNSUPPORTED, "reading");
  d3d12_engine_end(&f.rig.engine);
  while (f.rig.engine.frame < first + 2) {
    d3d12_engine_begin(&f.rig.engine);
    d3d12_engine_end(&f.rig.engine);
  }
  d3d12_engine_run(&f.rig.engine, f.rig.engine.frame);
  rig_retire(&f.rig);
  fixture_close(&f);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(devices_are_checked), cmocka_unit_test(other_apis_are_refused),
      cmocka_unit_test(meshes_are_checked),  cmocka_unit_test(images_are_checked),
      cmocka_unit_test(frames_are_checked),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
