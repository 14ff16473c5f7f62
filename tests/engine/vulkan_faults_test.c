/*
 * vulkan_faults_test.c: each Vulkan call that may fail, and each allocation, fails in turn over a context's whole life,
 * on an engine's device and on an own one. The error has its name; what failed succeeds when it is tried again, or the
 * context is lost and can be switched or destroyed; what is drawn in the end is what is drawn without faults; and
 * nothing is left behind.
 */
#include "../conformance/support.h"
#include "vulkan_engine.h"
#include "vulkan_faults.h"

#include <dlfcn.h>
#include <stdlib.h>
#include <string.h>

enum { resolution = 64, cascade_count = 2, mask_width = 32, mask_height = 24, most_corners = SUPPORT_TRIANGLES * 3 };

/* A backend that opens Vulkan by itself gets the faults', too. Takes the place of the C library's. */
void *dlopen(const char *name, int flags);
void *dlopen(const char *name, int flags) {
  void *const symbol = dlsym(RTLD_NEXT, "dlopen");
  void *(*real)(const char *, int);
  memcpy(&real, &symbol, sizeof real);
  return real(name && !strcmp(name, "libvulkan.so.1") ? FAKE_VULKAN : name, flags);
}

/* ---- a context's life, in steps that may be repeated ---- */

typedef struct picture {
  float map[resolution * resolution];
  uint8_t mask[mask_width * mask_height];
} picture;

typedef struct life {
  vulkan_engine *engine; /* NULL: an own device */
  record record;
  csm_context *context;
  csm_cascades *cascades;
  support_scene scene;
  csm_instance instances[2];
  engine_buffer readback;
  bool recording; /* the engine's command buffer is open */
  picture picture;
} life;

static csm_create_info create_info(life *l) {
  csm_create_info info = support_create_info(&l->record);
  l->record.quiet = true;
  info.flags = CSM_CREATE_KEEP_GEOMETRY;
  info.vulkan = l->engine ? &l->engine->native : NULL;
  return info;
}

static csm_result create(life *l) {
  const csm_create_info info = create_info(l);
  return csm_create(&info, &l->context);
}

/* Mesh 0 is the ground, mesh 1 all boxes; in world space. */
static csm_result add_mesh(life *l, int mesh) {
  static double corners[SUPPORT_TRIANGLES][3][3];
  static float positions[most_corners][3];
  static uint16_t indices[most_corners];
  support_triangles(&l->scene, corners);
  const uint32_t first = mesh ? 6 : 0, count = (mesh ? most_corners : 6) - first;
  for (uint32_t i = 0; i < count; ++i) {
    indices[i] = (uint16_t)i;
    for (int axis = 0; axis < 3; ++axis)
      positions[i][axis] = (float)corners[(first + i) / 3][(first + i) % 3][axis];
  }
  const csm_mesh_info info = {.struct_size = sizeof info,
                              .positions = positions,
                              .vertex_count = count,
                              .indices = indices,
                              .index_count = count,
                              .index_size = 2};
  csm_mesh handle;
  const csm_result result = csm_mesh_create(l->context, &info, &handle);
  l->instances[mesh] = support_instance(handle, 0, 0, 0, 1, 1, 1);
  return result;
}

static csm_result ground(life *l) {
  return add_mesh(l, 0);
}

static csm_result boxes(life *l) {
  return add_mesh(l, 1);
}

static csm_config config(uint32_t cascades) {
  csm_config config = support_config();
  config.cascade_count = cascades;
  config.resolution = resolution;
  return config;
}

static csm_result cascades(life *l) {
  const csm_config small = config(cascade_count);
  return csm_cascades_create(l->context, &small, &l->cascades);
}

static csm_result reconfigure(life *l) {
  const csm_config more = config(cascade_count + 1);
  return csm_cascades_configure(l->cascades, &more);
}

static csm_frame frame(life *l) {
  csm_frame frame = l->scene.frame;
  frame.flags = CSM_FRAME_TIMESTAMPS;
  frame.instances = l->instances;
  frame.instance_count = 2;
  if (!l->engine)
    return frame;
  if (!l->recording)
    vulkan_engine_begin(l->engine);
  l->recording = true;
  frame.frame = l->engine->frame;
  frame.command_buffer = l->engine->frames[frame.frame % VULKAN_ENGINE_FRAMES].commands;
  return frame;
}

static csm_result render(life *l) {
  const csm_frame it = frame(l);
  return csm_render_cascades(l->cascades, &it);
}

static csm_result resolve(life *l) {
  const csm_frame it = frame(l);
  const csm_mask_info mask = {.struct_size = sizeof mask, .frame = &it, .width = mask_width, .height = mask_height};
  return csm_resolve_mask(l->cascades, &mask);
}

static void end_frame(life *l) {
  vulkan_engine_end(l->engine);
  vulkan_engine_run(l->engine, l->engine->frame);
  l->recording = false;
}

static csm_result finish_engines(life *l) {
  if (l->recording) {
    csm_binding binding = {.struct_size = sizeof binding};
    const VkCommandBuffer commands = l->engine->frames[l->engine->frame % VULKAN_ENGINE_FRAMES].commands;
    assert_int_equal(csm_bind(l->cascades, &binding), CSM_SUCCESS);
    vulkan_engine_copy(commands, (VkImage)binding.native_maps, VK_IMAGE_ASPECT_DEPTH_BIT, 1, resolution, resolution,
                       &l->readback, offsetof(picture, map));
    vulkan_engine_copy(commands, (VkImage)binding.native_mask, VK_IMAGE_ASPECT_COLOR_BIT, 0, mask_width, mask_height,
                       &l->readback, offsetof(picture, mask));
    end_frame(l);
    memcpy(&l->picture, l->readback.mapped, sizeof l->picture);
  }
  return csm_retire(l->context, l->engine->frame);
}

static csm_result finish(life *l) {
  static float mask[mask_width * mask_height];
  if (l->engine)
    return finish_engines(l);
  csm_stats stats = {.struct_size = sizeof stats};
  csm_result result = csm_get_stats(l->cascades, &stats);
  const csm_read_info map = {
      .struct_size = sizeof map, .cascade = 1, .data = l->picture.map, .size = sizeof l->picture.map};
  const csm_read_info masks = {.struct_size = sizeof masks, .source = CSM_READ_MASK, .data = mask, .size = sizeof mask};
  if (!result)
    result = csm_read(l->cascades, &map);
  if (!result)
    result = csm_read(l->cascades, &masks);
  for (int i = 0; i < mask_width * mask_height; ++i)
    l->picture.mask[i] = (uint8_t)(mask[i] * 255 + 0.5f);
  return result;
}

static csm_result change(life *l) {
  const csm_create_info info = create_info(l);
  return csm_switch_backend(l->context, &info);
}

typedef csm_result (*step)(life *l);

static const step steps[] = {create, ground,      boxes,  cascades, render, resolve, finish, render,  resolve,
                             finish, reconfigure, render, resolve,  finish, change,  render, resolve, finish};
enum { step_count = sizeof steps / sizeof steps[0], first_picture = 6, last_picture = step_count - 1 };

static bool opens(step step) {
  return step == create || step == change;
}

/* ---- what is expected ---- */

typedef struct fault {
  VkResult result; /* VK_SUCCESS: the host's allocator fails */
  csm_result expected;
} fault;

static const fault kinds[] = {
    {VK_ERROR_OUT_OF_HOST_MEMORY, CSM_ERROR_OUT_OF_MEMORY},
    {VK_ERROR_OUT_OF_DEVICE_MEMORY, CSM_ERROR_OUT_OF_DEVICE_MEMORY},
    {VK_ERROR_DEVICE_LOST, CSM_ERROR_DEVICE_LOST},
    {VK_ERROR_INITIALIZATION_FAILED, CSM_ERROR_DEVICE},
    {VK_SUCCESS, CSM_ERROR_OUT_OF_MEMORY},
};

/* A recording that cannot be submitted takes the context's state with it. */
static bool loses_recording(const char *function) {
  return function && (!strcmp(function, "vkEndCommandBuffer") || !strcmp(function, "vkResetFences") ||
                      !strcmp(function, "vkQueueSubmit"));
}

static void check_error(const life *l, int index, csm_result result, csm_result expected) {
  const char *where = faults.failed ? faults.failed : "an allocation";
  if (result != expected)
    fail_msg("step %d, %s fails: %s, not %s", index, where, csm_result_name(result), csm_result_name(expected));
  if (l->context && !csm_last_error(l->context)[0])
    fail_msg("step %d, %s fails: no text", index, where);
  if (steps[index] == create && l->context)
    fail_msg("step %d, %s fails: there is a context", index, where);
}

static void check_picture(const life *l, int index, const picture *expected) {
  if (memcmp(&l->picture, expected, sizeof *expected))
    fail_msg("step %d, after %s failed: another picture", index, faults.failed ? faults.failed : "an allocation");
}

static void check_leaks(const life *l) {
  assert_int_equal(l->record.blocks, 0);
  if (faults_leak())
    fail_msg("after %s failed: a %s is left", faults.failed ? faults.failed : "an allocation", faults_leak());
  assert_true(faults.allocated == 0);
}

static void expect_lost(life *l) {
  csm_binding binding = {.struct_size = sizeof binding};
  if (l->recording)
    end_frame(l);
  if (l->cascades) {
    assert_int_equal(csm_bind(l->cascades, &binding), CSM_ERROR_DEVICE_LOST);
    const csm_config other = config(1);
    assert_int_equal(csm_cascades_configure(l->cascades, &other), CSM_ERROR_DEVICE_LOST);
  }
  assert_int_equal(csm_mesh_destroy(l->context, 1), CSM_ERROR_DEVICE_LOST);
}

/* ---- a life with one fault ---- */

static void life_begin(life *l, vulkan_engine *engine) {
  *l = (life){.engine = engine};
  support_scene_make(&l->scene, NULL);
  if (engine)
    l->readback = vulkan_engine_buffer(engine, sizeof(picture));
}

static void life_end(life *l) {
  if (l->recording)
    end_frame(l);
  csm_destroy(l->context);
  check_leaks(l);
  if (l->engine) {
    vulkan_engine_buffer_destroy(l->engine, &l->readback);
    assert_int_equal(l->engine->messages, 0);
  }
}

/* A switch mends a lost context: its meshes and settings live on. */
static void mend(life *l) {
  expect_lost(l);
  faults.lost = false;
  assert_int_equal(change(l), CSM_SUCCESS);
}

static void arm(life *l, const fault *kind, uint32_t call) {
  faults.failed = NULL;
  faults.result = kind->result;
  faults.fail_at = kind->result ? faults.calls + call : 0;
  l->record.allocations_left = kind->result ? -1 : (int64_t)call - 1;
}

static void disarm(life *l) {
  faults.fail_at = 0;
  l->record.allocations_left = -1;
}

/* Opening a device fails at each of its calls, and then succeeds. A context that has one draws on with it. */
static void open_at_last(life *l, const fault *kind, int index, const picture *before) {
  for (uint32_t call = 1;; ++call) {
    arm(l, kind, call);
    const csm_result result = steps[index](l);
    disarm(l);
    if (!result) {
      assert_true(call > 4);
      return;
    }
    faults.lost = false; /* a device that was never used */
    check_error(l, index, result, kind->expected);
    if (!before) {
      check_leaks(l);
      continue;
    }
    assert_true(!render(l) && !resolve(l) && !finish(l));
    check_picture(l, index, before);
  }
}

/* What is left to do after step `index` failed as it should; returns the step to go on with. */
static int recover(life *l, const fault *kind, int index, csm_result result) {
  check_error(l, index, result, loses_recording(faults.failed) ? CSM_ERROR_DEVICE_LOST : kind->expected);
  if (result != CSM_ERROR_DEVICE_LOST)
    return index;
  mend(l);
  while (steps[index] == resolve || steps[index] == finish)
    --index; /* maps are drawn anew */
  return index;
}

/* Takes the steps, of each of which the given call fails once, if there are so many; false if there were not in any.
   `expected` holds a picture for each step that finishes a frame. */
static bool live(vulkan_engine *engine, const fault *kind, uint32_t call, const picture *expected) {
  life l;
  bool tried[step_count] = {false}, failed = false;
  life_begin(&l, engine);
  faults = (vulkan_faults){0};
  create_info(&l);
  for (int i = 0; i < step_count; ++i) {
    if (opens(steps[i]) && call == 1) {
      open_at_last(&l, kind, i, i ? &expected[i - 1] : NULL);
      continue;
    }
    if (!tried[i] && !opens(steps[i]))
      arm(&l, kind, call);
    csm_result result = steps[i](&l);
    disarm(&l);
    if (result && !tried[i]) {
      tried[i] = failed = true;
      i = recover(&l, kind, i, result);
      result = steps[i](&l);
    }
    if (result)
      fail_msg("step %d, after %s failed: %s", i, faults.failed, csm_result_name(result));
    if (steps[i] == finish)
      check_picture(&l, i, &expected[i]);
  }
  life_end(&l);
  return failed;
}

static void lives(vulkan_engine *engine) {
  static picture expected[step_count];
  life l;
  life_begin(&l, engine);
  faults = (vulkan_faults){0};
  for (int i = 0; i < step_count; ++i) {
    assert_int_equal(steps[i](&l), CSM_SUCCESS);
    expected[i] = l.picture;
  }
  life_end(&l);
  assert_memory_not_equal(&expected[first_picture], &expected[last_picture], sizeof(picture));
  for (size_t kind = 0; kind < sizeof kinds / sizeof kinds[0]; ++kind) {
    uint32_t call = 1;
    while (live(engine, &kinds[kind], call, expected))
      ++call;
    assert_true(call > 8); /* fewer than a frame makes */
  }
}

static void faults_on_an_engines_device(void **state) {
  (void)state;
  vulkan_engine engine;
  vulkan_engine_open(&engine, VULKAN_ENGINE_BARE);
  engine.native.get_instance_proc_addr = faults_get_instance_proc_addr;
  lives(&engine);
  vulkan_engine_close(&engine);
}

static void faults_on_an_own_device(void **state) {
  (void)state;
  lives(NULL);
}

/* ---- a budget ---- */

static void keeps_a_budget(vulkan_engine *engine) {
  enum { mebibyte = 1 << 20 };
  life l;
  life_begin(&l, engine);
  faults = (vulkan_faults){.tells_budget = true, .budget = 160 * (uint64_t)mebibyte, .used = 40 * (uint64_t)mebibyte};
  for (int i = 0; i <= first_picture; ++i)
    assert_int_equal(steps[i](&l), CSM_SUCCESS);
  csm_config wanted = config(4);
  wanted.resolution = 2048; /* 64 MiB */
  assert_int_equal(csm_cascades_configure(l.cascades, &wanted), CSM_SUCCESS);
  csm_cascades *more = NULL;
  assert_int_equal(csm_cascades_create(l.context, &wanted, &more), CSM_ERROR_LIMIT_EXCEEDED);
  assert_non_null(strstr(csm_last_error(l.context), "budget"));
  assert_null(more);
  assert_int_equal(render(&l), CSM_SUCCESS);
  assert_int_equal(resolve(&l), CSM_SUCCESS);
  faults.used = 0; /* others have gone */
  assert_int_equal(csm_cascades_create(l.context, &wanted, &more), CSM_SUCCESS);
  faults.used = 200 * (uint64_t)mebibyte; /* others take more than there is */
  csm_cascades *none = NULL;
  const csm_config small = config(1);
  assert_int_equal(csm_cascades_create(l.context, &small, &none), CSM_ERROR_LIMIT_EXCEEDED);
  assert_true(faults.most <= 160 * (uint64_t)mebibyte);
  life_end(&l);
}

static void a_budget_is_kept_on_an_engines_device(void **state) {
  (void)state;
  const char *const extensions[] = {"VK_KHR_maintenance9", VK_EXT_MEMORY_BUDGET_EXTENSION_NAME};
  vulkan_engine engine;
  vulkan_engine_open(&engine, VULKAN_ENGINE_TYPICAL);
  engine.native.get_instance_proc_addr = faults_get_instance_proc_addr;
  engine.native.extensions = extensions;
  engine.native.extension_count = 2;
  keeps_a_budget(&engine);
  vulkan_engine_close(&engine);
}

static void a_budget_is_kept_on_an_own_device(void **state) {
  (void)state;
  keeps_a_budget(NULL);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_budget_is_kept_on_an_engines_device),
      cmocka_unit_test(a_budget_is_kept_on_an_own_device),
      cmocka_unit_test(faults_on_an_engines_device),
      cmocka_unit_test(faults_on_an_own_device),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
