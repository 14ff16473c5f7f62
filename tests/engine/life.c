#include "life.h"

#include <stdlib.h>
#include <string.h>

enum { RESOLUTION = 64, CASCADES = 2, WIDTH = 32, HEIGHT = 24, STRIDE = 20, MOST_CORNERS = SUPPORT_TRIANGLES * 3 };

static const picture_size mask_size = {WIDTH, HEIGHT};

/* ---- props ---- */

void props_open(props *props, rig *rig) {
  static float depth[WIDTH * HEIGHT], normals[WIDTH * HEIGHT][4];
  *props = (struct props){.rig = rig};
  hill_make(&props->hill);
  if (!rig)
    return;
  for (int i = 0; i < WIDTH * HEIGHT; ++i) {
    depth[i] = (float)(i / WIDTH) / (8 * HEIGHT);
    normals[i][1] = 1;
  }
  props->vertices = rig_buffer_make(rig, RIG_GEOMETRY, HILL_VERTICES * STRIDE);
  props->indices = rig_buffer_make(rig, RIG_GEOMETRY, sizeof props->hill.indices);
  for (uint32_t i = 0; i < HILL_VERTICES; ++i)
    memcpy((char *)props->vertices.mapped + (size_t)i * STRIDE, props->hill.positions[i],
           sizeof props->hill.positions[i]);
  memcpy(props->indices.mapped, props->hill.indices, sizeof props->hill.indices);
  rig_image_info info = {.format = RIG_DEPTH_32, .width = WIDTH, .height = HEIGHT, .texels = depth};
  props->depth = rig_image_make(rig, &info);
  info.format = RIG_RGBA_FLOAT_32;
  info.texels = normals;
  props->normals = rig_image_make(rig, &info);
}

void props_close(props *props) {
  if (!props->rig)
    return;
  rig_buffer_free(props->rig, &props->vertices);
  rig_buffer_free(props->rig, &props->indices);
  rig_image_free(props->rig, props->depth);
  rig_image_free(props->rig, props->normals);
}

/* ---- steps ---- */

/* The hill, in the engine's buffers where there are some. */
static csm_mesh_info engines_mesh(const props *props, rig_native *native) {
  csm_mesh_info info = hill_info(&props->hill, 2);
  if (!props->rig)
    return info;
  info.positions = info.indices = NULL;
  for (int axis = 0; axis < 3; ++axis) {
    info.bounds_min[axis] = -1;
    info.bounds_max[axis] = 1;
  }
  rig_mesh_give(&(rig_mesh){.vertices = &props->vertices, .indices = &props->indices, .vertex_stride = STRIDE}, native,
                &info);
  return info;
}

/* What csm has no copy of, on the next device. */
static csm_result CSM_CALL supply(void *user, csm_mesh mesh, csm_mesh_info *info) {
  static rig_native native;
  const life *life = user;
  assert_true(mesh == life->instances[2].mesh);
  *info = engines_mesh(life->props, &native);
  return CSM_SUCCESS;
}

static csm_create_info create_info(life *life) {
  csm_create_info info = stage_create_info(life->props->rig, &life->record);
  life->record.quiet = true;
  info.flags = CSM_CREATE_KEEP_GEOMETRY | CSM_CREATE_RAYS;
  info.supply = supply;
  return info;
}

static csm_result create(life *life) {
  const csm_create_info info = create_info(life);
  return csm_create(&info, &life->context);
}

/* Mesh 0 is the ground, mesh 1 all boxes; in world space. */
static csm_result add_mesh(life *life, int mesh) {
  static double corners[SUPPORT_TRIANGLES][3][3];
  static float positions[MOST_CORNERS][3];
  static uint16_t indices[MOST_CORNERS];
  support_triangles(&life->scene, corners);
  const uint32_t first = mesh ? 6 : 0, count = (mesh ? MOST_CORNERS : 6) - first;
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
  const csm_result result = csm_mesh_create(life->context, &info, &handle);
  life->instances[mesh] = support_instance(handle, 0, 0, 0, 1, 1, 1);
  return result;
}

static csm_result ground(life *life) {
  return add_mesh(life, 0);
}

static csm_result boxes(life *life) {
  return add_mesh(life, 1);
}

static csm_result hills(life *life) {
  rig_native native;
  const csm_mesh_info info = engines_mesh(life->props, &native);
  csm_mesh handle;
  const csm_result result = csm_mesh_create(life->context, &info, &handle);
  life->instances[2] = support_instance(handle, -6, 5, -9, 2, 1, 2);
  return result;
}

csm_config life_config(uint32_t cascades) {
  csm_config config = support_config();
  config.cascade_count = cascades;
  config.resolution = RESOLUTION;
  return config;
}

static csm_result cascades(life *life) {
  const csm_config small = life_config(CASCADES);
  return csm_cascades_create(life->context, &small, &life->cascades);
}

static csm_result view(life *life) {
  return csm_view_create(life->context, &life->view);
}

static csm_result reconfigure(life *life) {
  const csm_config more = life_config(CASCADES + 1);
  return csm_cascades_configure(life->cascades, &more);
}

static shot next_shot(life *life) {
  rig *rig = life->props->rig;
  shot shot = life->scene.shot;
  shot.frame.flags = CSM_FRAME_TIMESTAMPS;
  shot.frame.instances = life->instances;
  shot.frame.instance_count = 3;
  if (!rig)
    return shot;
  if (!life->recording)
    rig_begin(rig);
  life->recording = true;
  shot.frame.frame = rig_frame(rig);
  shot.frame.command_buffer = rig_commands(rig);
  return shot;
}

csm_result life_render(life *life) {
  shot shot = next_shot(life);
  return csm_render_cascades(life->cascades, shot_frame(&shot));
}

static csm_result resolve(life *life, bool images) {
  shot shot = next_shot(life);
  csm_mask_info mask = {.struct_size = sizeof mask, .frame = shot_frame(&shot), .width = WIDTH, .height = HEIGHT};
  if (images && life->props->rig) {
    mask.camera_depth = rig_image_native(life->props->depth);
    mask.normals = rig_image_native(life->props->normals);
  }
  return csm_resolve_mask(life->view, life->cascades, &mask);
}

csm_result life_resolve(life *life) {
  return resolve(life, false);
}

csm_result life_resolve_images(life *life) {
  return resolve(life, true);
}

static void end_frame(life *life) {
  rig_end(life->props->rig);
  rig_run(life->props->rig, rig_frame(life->props->rig));
  life->recording = false;
}

/* Reading waits, and may fail; after it csm_read of picture_read does not wait. */
static csm_result finish_own(life *life) {
  static float map[RESOLUTION * RESOLUTION], mask[WIDTH * HEIGHT];
  csm_stats stats = {.struct_size = sizeof stats};
  csm_result result = csm_get_stats(life->cascades, &stats);
  const csm_read_info maps = {
      .struct_size = sizeof maps, .cascades = life->cascades, .cascade = 1, .data = map, .size = sizeof map};
  const csm_read_info masks = {
      .struct_size = sizeof masks, .source = CSM_READ_MASK, .view = life->view, .data = mask, .size = sizeof mask};
  if (!result)
    result = csm_read(life->context, &maps);
  if (!result)
    result = csm_read(life->context, &masks);
  picture_free(&life->picture);
  life->picture = (picture){.count = 2};
  life->picture.layers[0] = (picture_layer){RESOLUTION, RESOLUTION, malloc(sizeof map)};
  life->picture.layers[1] = (picture_layer){WIDTH, HEIGHT, malloc(sizeof mask)};
  memcpy(life->picture.layers[0].texels, map, sizeof map);
  memcpy(life->picture.layers[1].texels, mask, sizeof mask);
  return result;
}

csm_result life_finish(life *life) {
  rig *rig = life->props->rig;
  if (!rig)
    return finish_own(life);
  if (life->recording) {
    picture_copy copy = picture_record(rig, life->cascades, life->view, mask_size, sizeof(float));
    end_frame(life);
    picture_free(&life->picture);
    life->picture = picture_take(rig, &copy);
  }
  return csm_retire(life->context, rig_frame(rig));
}

csm_result life_switch(life *life) {
  const csm_create_info info = create_info(life);
  return csm_switch_backend(life->context, &info);
}

typedef csm_result (*step)(life *life);

static const step steps[] = {create,
                             ground,
                             boxes,
                             hills,
                             cascades,
                             view,
                             life_render,
                             life_resolve,
                             life_finish,
                             life_render,
                             life_resolve_images,
                             life_finish,
                             reconfigure,
                             life_render,
                             life_resolve,
                             life_finish,
                             life_switch,
                             life_render,
                             life_resolve,
                             life_finish};
enum { STEPS = sizeof steps / sizeof steps[0], FIRST_PICTURE = 8, LAST_PICTURE = STEPS - 1 };

static bool opens(step step) {
  return step == create || step == life_switch;
}

/* ---- what is expected ---- */

static const char *where(void) {
  return rig_failed() ? rig_failed() : "an allocation";
}

static void check_error(const life *life, int index, csm_result result, csm_result expected) {
  if (result != expected)
    fail_msg("step %d, %s fails: %s (%s), not %s", index, where(), csm_result_name(result),
             csm_last_error(life->context), csm_result_name(expected));
  if (life->context && !csm_last_error(life->context)[0])
    fail_msg("step %d, %s fails: no text", index, where());
  if (steps[index] == create && life->context)
    fail_msg("step %d, %s fails: there is a context", index, where());
}

static void check_picture(const life *life, int index, const picture *expected) {
  if (!picture_equal(&life->picture, expected))
    fail_msg("step %d, after %s failed: another picture", index, where());
}

static void check_leaks(const life *life) {
  assert_int_equal(life->record.blocks, 0);
  if (rig_leak())
    fail_msg("after %s failed: csm holds a %s still", where(), rig_leak());
}

void life_expect_lost(life *life) {
  const csm_config other = life_config(1);
  csm_binding binding = {.struct_size = sizeof binding};
  csm_cascades *none;
  if (life->recording)
    end_frame(life);
  if (life->cascades) {
    assert_int_equal(csm_bind(life->cascades, &binding), CSM_ERROR_DEVICE_LOST);
    assert_int_equal(csm_cascades_configure(life->cascades, &other), CSM_ERROR_DEVICE_LOST);
  }
  assert_int_equal(csm_cascades_create(life->context, &other, &none), CSM_ERROR_DEVICE_LOST);
  const csm_mesh_update_info update = {.struct_size = sizeof update, .positions = life->props->hill.positions};
  assert_int_equal(csm_mesh_update(life->context, life->instances[2].mesh, &update), CSM_ERROR_DEVICE_LOST);
  assert_int_equal(csm_mesh_destroy(life->context, 1), CSM_ERROR_INVALID_HANDLE); /* destroying works */
}

/* ---- a life with one fault ---- */

static void life_begin(life *life, props *props) {
  *life = (struct life){.props = props};
  support_scene_make(&life->scene, NULL);
  create_info(life);
}

void life_end(life *life) {
  if (life->recording)
    end_frame(life);
  csm_destroy(life->context);
  picture_free(&life->picture);
  check_leaks(life);
  if (life->props->rig)
    assert_int_equal(rig_messages(life->props->rig), 0);
}

void life_open(life *life, props *props) {
  life_begin(life, props);
  for (int i = 0; i <= FIRST_PICTURE; ++i)
    assert_int_equal(steps[i](life), CSM_SUCCESS);
}

static void arm(life *life, const rig_fault *fault, uint32_t call) {
  rig_fail(fault, call);
  life->record.allocations_left = fault->code ? -1 : (int64_t)call - 1;
}

/* One call of the step fails, if it makes so many. */
static csm_result try_step(life *life, const rig_fault *fault, uint32_t call, int index) {
  arm(life, fault, call);
  const csm_result result = steps[index](life);
  rig_fail(NULL, 0);
  life->record.allocations_left = -1;
  return result;
}

/* Opening a device fails at each of its calls, and then succeeds. A context that has one draws on with it. Returns how
   often it failed. */
static uint32_t open_at_last(life *life, const rig_fault *fault, int index, const picture *before) {
  for (uint32_t call = 1;; ++call) {
    const csm_result result = try_step(life, fault, call, index);
    if (!result) {
      assert_true(call > 4);
      return call - 1;
    }
    rig_find(); /* a device that was never used */
    check_error(life, index, result, fault->expected);
    if (!before) {
      check_leaks(life);
      continue;
    }
    assert_true(!life_render(life) && !life_resolve(life) && !life_finish(life));
    check_picture(life, index, before);
  }
}

/* What is left to do after step `index` failed as it should; returns the step to go on with. */
static int recover(life *life, const rig_fault *fault, int index, csm_result result) {
  check_error(life, index, result, rig_loses_recording(rig_failed()) ? CSM_ERROR_DEVICE_LOST : fault->expected);
  if (result != CSM_ERROR_DEVICE_LOST)
    return index;
  life_expect_lost(life);
  rig_find();
  assert_int_equal(life_switch(life), CSM_SUCCESS); /* meshes and settings live on */
  while (steps[index] == life_resolve || steps[index] == life_resolve_images || steps[index] == life_finish)
    --index; /* maps are drawn anew */
  return index;
}

/* Takes the steps, of each of which the given call fails once, if there are so many; returns how many failed.
   `expected` holds a picture for each step that finishes a frame. */
static uint32_t live(props *props, const rig_fault *fault, uint32_t call, const picture *expected) {
  life life;
  bool tried[STEPS] = {false};
  uint32_t failures = 0;
  life_begin(&life, props);
  for (int i = 0; i < STEPS; ++i) {
    if (opens(steps[i]) && call == 1) {
      failures += open_at_last(&life, fault, i, i ? &expected[i - 1] : NULL);
      continue;
    }
    csm_result result = tried[i] || opens(steps[i]) ? steps[i](&life) : try_step(&life, fault, call, i);
    if (result && !tried[i]) {
      tried[i] = true;
      ++failures;
      i = recover(&life, fault, i, result);
      result = steps[i](&life);
    }
    if (result)
      fail_msg("step %d, after %s failed: %s", i, where(), csm_result_name(result));
    if (steps[i] == life_finish)
      check_picture(&life, i, &expected[i]);
  }
  life_end(&life);
  return failures;
}

static void live_without_faults(props *props, picture *expected) {
  life life;
  life_begin(&life, props);
  rig_fail(NULL, 0);
  for (int i = 0; i < STEPS; ++i) {
    assert_int_equal(steps[i](&life), CSM_SUCCESS);
    expected[i] = life.picture;
    if (steps[i] == life_finish)
      life.picture = (picture){0};
    else
      expected[i] = (picture){0};
  }
  life_end(&life);
  picture_expect_casters(&expected[LAST_PICTURE], 1);
}

void live_with_faults(props *props) {
  picture expected[STEPS];
  live_without_faults(props, expected);
  assert_false(picture_equal(&expected[FIRST_PICTURE], &expected[LAST_PICTURE]));
  for (uint32_t i = 0; i < rig_fault_count; ++i) {
    uint32_t failures = 0, before = 0, call = 1;
    do {
      before = failures;
      failures += live(props, &rig_faults[i], call++, expected);
    } while (failures > before);
    if (failures < 40)
      fail_msg("%s: only %u calls failed", rig_faults[i].what, failures);
  }
  for (int i = 0; i < STEPS; ++i)
    picture_free(&expected[i]);
}
