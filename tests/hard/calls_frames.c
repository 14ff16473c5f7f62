/* calls_frames.c: random frames and masks. */
#include "calls_scenes.h"

#include <math.h>
#include <string.h>

/* ---- cameras and lights ---- */

static const spoil_field camera_fields[] = {
    {SPOIL_AT(csm_camera, reversed), FIELD_WHOLE, 0},
    {SPOIL_AT(csm_camera, view), FIELD_REAL, 0},
    {SPOIL_AT(csm_camera, projection), FIELD_REAL, 0},
};
static const spoil_struct camera_struct = SPOIL_STRUCT(csm_camera, camera_fields);

static const spoil_field light_fields[] = {
    {SPOIL_AT(csm_light, layers), FIELD_WHOLE, 0},
    {SPOIL_AT(csm_light, direction), FIELD_REAL, 0},
    {SPOIL_AT(csm_light, angular_diameter), FIELD_REAL, 0},
};
static const spoil_struct light_struct = SPOIL_STRUCT(csm_light, light_fields);

static csm_camera roll_camera(world *w) {
  csm_camera camera = {.struct_size = sizeof camera};
  double eye[3], target[3];
  for (int i = 0; i < 3; ++i) {
    eye[i] = dice_between(&w->dice, -20, 20);
    target[i] = eye[i] + dice_between(&w->dice, -5, 5);
  }
  support_look_at(camera.view, eye, target);
  const double near = dice_scale(&w->dice, 1e-3, 100), far = near * dice_scale(&w->dice, 1.5, 1e5);
  support_perspective(camera.projection, dice_between(&w->dice, 1, 170), 1.5, near, dice_one_in(&w->dice, 3) ? 0 : far);
  if (dice_one_in(&w->dice, 4)) { /* orthographic */
    const double width = dice_scale(&w->dice, 0.1, 1000);
    memset(camera.projection, 0, sizeof camera.projection);
    camera.projection[0] = camera.projection[5] = 2 / width;
    camera.projection[10] = -1 / (far - near);
    camera.projection[14] = -near / (far - near);
    camera.projection[15] = 1;
  }
  if (dice_one_in(&w->dice, 8))
    camera.projection[8 + dice_below(&w->dice, 2)] = dice_between(&w->dice, -1, 1); /* off-centre */
  if (dice_one_in(&w->dice, 12))
    camera.reversed = dice_below(&w->dice, 3);
  return camera;
}

static csm_light roll_light(world *w) {
  csm_light light = {.struct_size = sizeof light,
                     .layers = dice_one_in(&w->dice, 4) ? (uint32_t)dice_bits(&w->dice) : 0,
                     .angular_diameter = dice_one_in(&w->dice, 4) ? dice_between(&w->dice, 0, 1) : 0};
  for (int i = 0; i < 3; ++i)
    light.direction[i] = dice_between(&w->dice, -1, 1);
  if (dice_one_in(&w->dice, 8)) {
    light.direction[0] = light.direction[2] = 0; /* at the zenith */
    light.direction[1] = -1;
  }
  return light;
}

/* ---- frames ---- */

/* How much a list has in it is no field: more would be read than there is. */
static const spoil_field frame_fields[] = {
    {SPOIL_AT(csm_frame, flags), FIELD_WHOLE, 0},
    {SPOIL_AT(csm_frame, frame), FIELD_LONG, 0},
    {SPOIL_AT(csm_frame, command_buffer), FIELD_POINTER, 0},
    {SPOIL_AT(csm_frame, camera), FIELD_POINTER, 0},
    {SPOIL_AT(csm_frame, light), FIELD_POINTER, 0},
    {SPOIL_AT(csm_frame, origin), FIELD_POINTER, 0},
    {SPOIL_AT(csm_frame, scene), FIELD_POINTER, 0},
    {SPOIL_AT(csm_frame, instances), FIELD_POINTER, 0},
    {SPOIL_AT(csm_frame, reserved), FIELD_WHOLE, 0},
    {SPOIL_AT(csm_frame, draw), FIELD_POINTER, 0},
    {SPOIL_AT(csm_frame, depth_view), FIELD_POINTER, 0},
};
/* On an engine's device, whose later frames must not be refused for what a wild number said. */
static const spoil_field lent_frame_fields[] = {
    {SPOIL_AT(csm_frame, flags), FIELD_WHOLE, 0},    {SPOIL_AT(csm_frame, command_buffer), FIELD_POINTER, 0},
    {SPOIL_AT(csm_frame, camera), FIELD_POINTER, 0}, {SPOIL_AT(csm_frame, light), FIELD_POINTER, 0},
    {SPOIL_AT(csm_frame, scene), FIELD_POINTER, 0},  {SPOIL_AT(csm_frame, instances), FIELD_POINTER, 0},
    {SPOIL_AT(csm_frame, reserved), FIELD_WHOLE, 0},
};
static const spoil_struct frame_struct = SPOIL_STRUCT(csm_frame, frame_fields);
static const spoil_struct lent_frame_struct = SPOIL_STRUCT(csm_frame, lent_frame_fields);

/* A callback is told the same on every backend. */
static void CSM_CALL draw_nothing(void *user, const csm_draw_info *info) {
  world *w = user;
  if (!w) /* a frame whose struct_size ends before draw_user */
    return;
  world_plan(w, &info->cascade, sizeof info->cascade);
  world_plan(w, &info->resolution, sizeof info->resolution);
  world_plan(w, &info->reversed, sizeof info->reversed);
  world_plan(w, info->world_to_clip, sizeof info->world_to_clip);
  world_plan(w, info->planes, sizeof info->planes);
}

/* A scene, or a list; now and then both, or a scene that is none. */
static void give_instances(world *w, csm_frame *frame) {
  const world_scene *scene = world_any_scene(w);
  if (scene && !dice_one_in(&w->dice, 3)) {
    frame->scene = scene->scene;
  } else {
    frame->instance_count = world_fill_list(w, 10);
    frame->instances = (const csm_instance *)(const void *)w->list;
  }
  if (dice_one_in(&w->dice, 50))
    frame->scene = world_wild(w);
}

static csm_frame roll_frame(world *w) {
  static const double origin[3] = {10, -3, 5};
  const csm_camera camera = roll_camera(w);
  const csm_light light = roll_light(w);
  csm_frame frame = {.struct_size = sizeof frame,
                     .flags = dice_below(&w->dice, 2),
                     .camera = world_risk(w, &camera, &camera_struct),
                     .light = world_risk(w, &light, &light_struct),
                     .origin = dice_one_in(&w->dice, 4) ? origin : NULL};
  give_instances(w, &frame);
  if (w->lent && (!w->own || dice_one_in(&w->dice, 20)))
    lent_frame(w->lent, &w->dice, &frame);
  if (dice_one_in(&w->dice, w->own ? 40 : 3)) {
    frame.draw = draw_nothing;
    frame.draw_user = w;
  }
  return frame;
}

/* Makes a frame one that a view has looked at; now and then something of it is another's. */
static void give_depth(world *w, csm_frame *frame) {
  const world_view *any = world_any_view(w);
  if (dice_one_in(&w->dice, 30))
    frame->depth_view = dice_one_in(&w->dice, 2) && any ? any->view : world_wild(w);
  if (!w->looked || !dice_one_in(&w->dice, 3))
    return;
  frame->depth_view = w->looked;
  if (!dice_one_in(&w->dice, 12))
    frame->camera = world_write(w, &w->looked_camera, sizeof w->looked_camera);
  if (dice_one_in(&w->dice, 12))
    return;
  frame->scene = w->looked_scene;
  frame->instances = NULL;
  frame->instance_count = 0;
}

static const csm_frame *write_frame(world *w) {
  csm_frame good = roll_frame(w);
  give_depth(w, &good);
  return world_risk(w, &good, w->own ? &frame_struct : &lent_frame_struct);
}

/* What views saw is known once their frames are done: a caller who wants the same plan twice waits for it. */
static void wait_for_samples(world *w) {
  csm_stats stats = {.struct_size = sizeof stats};
  if (w->own && w->samples)
    for (uint32_t i = 0; i < WORLD_CASCADES; ++i)
      if (w->cascades[i].cascades)
        assert_int_equal(csm_get_stats(w->cascades[i].cascades, &stats), CSM_SUCCESS);
}

static csm_result render(world *w) {
  world_cascades *cascades = world_any_cascades(w);
  const csm_frame *frame = write_frame(w);
  wait_for_samples(w);
  const csm_result result = csm_render_cascades(cascades ? cascades->cascades : NULL, frame);
  if (!result)
    cascades->list = frame->struct_size > offsetof(csm_frame, instance_count) ? frame->instance_count : 0;
  w->samples = w->samples || (!result && frame->struct_size > offsetof(csm_frame, depth_view) && frame->depth_view);
  return result;
}

static const spoil_field mask_fields[] = {
    {SPOIL_AT(csm_mask_info, flags), FIELD_WHOLE, 0},  {SPOIL_AT(csm_mask_info, frame), FIELD_POINTER, 0},
    {SPOIL_AT(csm_mask_info, width), FIELD_SMALL, 40}, {SPOIL_AT(csm_mask_info, height), FIELD_SMALL, 40},
    {SPOIL_AT(csm_mask_info, show), FIELD_WHOLE, 0},   {SPOIL_AT(csm_mask_info, reserved), FIELD_WHOLE, 0},
};
static const spoil_struct mask_struct = SPOIL_STRUCT(csm_mask_info, mask_fields);

/* Of a frame; the images are an engine's, where there are any. */
static const csm_mask_info *write_mask(world *w, const csm_frame *frame) {
  csm_mask_info good = {.struct_size = sizeof good,
                        .flags = dice_below(&w->dice, 2),
                        .frame = frame,
                        .width = dice_one_in(&w->dice, 10) ? 1 + dice_below(&w->dice, 40) : WORLD_WIDTH,
                        .height = dice_one_in(&w->dice, 10) ? 1 + dice_below(&w->dice, 40) : WORLD_HEIGHT,
                        .show =
                            dice_one_in(&w->dice, 3) ? dice_below(&w->dice, CSM_SHOW_PAGES + 2) : CSM_SHOW_VISIBILITY};
  if (w->lent && dice_one_in(&w->dice, 2))
    lent_images(w->lent, &w->dice, &good);
  return world_risk(w, &good, &mask_struct);
}

static csm_result resolve(world *w) {
  world_cascades *cascades = world_any_cascades(w);
  world_view *view = world_any_view(w);
  const csm_mask_info *info = write_mask(w, write_frame(w));
  csm_view *chosen = dice_one_in(&w->dice, 60) ? world_wild(w) : view ? view->view : NULL;
  const csm_result result = csm_resolve_mask(chosen, cascades ? cascades->cascades : NULL, info);
  if (!result) {
    view->width = info->width;
    view->height = info->height;
  }
  return result;
}

static csm_result reduce(world *w) {
  const world_view *view = world_any_view(w);
  const csm_mask_info *info = write_mask(w, write_frame(w));
  csm_view *chosen = view ? view->view : NULL;
  const csm_result result = csm_reduce_depth(chosen, info);
  if (!result) {
    w->looked = chosen;
    w->looked_camera = (csm_camera){.struct_size = sizeof w->looked_camera};
    const uint32_t size = info->frame->camera->struct_size;
    memcpy(&w->looked_camera, info->frame->camera, size < sizeof w->looked_camera ? size : sizeof w->looked_camera);
    w->looked_camera.struct_size = sizeof w->looked_camera;
    w->looked_scene = info->frame->scene;
  }
  return result;
}

const world_call calls_frames[] = {
    {.name = "csm_render_cascades", .weight = 60, .call = render},
    {.name = "csm_reduce_depth", .weight = 15, .call = reduce},
    {.name = "csm_resolve_mask", .weight = 40, .call = resolve},
    {.name = NULL},
};
