/* lent.c: an engine's device, over a rig. */
#include "lent.h"

#include "../engine/stage.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 24, HEIGHT = 16, STRIDE = 20, NUMBERS = 16 };

struct lent {
  rig *rig;
  bool recording;
  uint32_t lists;            /* of the frame so far */
  uint64_t number;           /* that csm is told of the frame; an engine's own count may skip some */
  uint64_t numbers[NUMBERS]; /* by the rig's frame */
  rig_buffer vertices, indices;
  rig_image *depth, *normals, *small;
  rig_native native; /* what a call reads */
};

static rig_image *make_image(rig *rig, rig_format format, uint32_t width, const void *texels) {
  const rig_image_info info = {.format = format, .width = width, .height = HEIGHT, .texels = texels};
  return rig_image_make(rig, &info);
}

lent *lent_open(void) {
  static float depth[WIDTH * HEIGHT], normals[WIDTH * HEIGHT][4];
  hill hill;
  lent *lent = calloc(1, sizeof *lent);
  assert_non_null(lent);
  lent->rig = rig_open(RIG_TYPICAL);
  hill_make(&hill);
  lent->vertices = rig_buffer_make(lent->rig, RIG_GEOMETRY, HILL_VERTICES * STRIDE);
  lent->indices = rig_buffer_make(lent->rig, RIG_GEOMETRY, sizeof hill.indices);
  for (uint32_t i = 0; i < HILL_VERTICES; ++i) { /* a position, then a uv */
    const float uv[2] = {hill.positions[i][0], hill.positions[i][2]};
    char *at = (char *)lent->vertices.mapped + (size_t)i * STRIDE;
    memcpy(at, hill.positions[i], sizeof hill.positions[i]);
    memcpy(at + sizeof hill.positions[i], uv, sizeof uv);
  }
  memcpy(lent->indices.mapped, hill.indices, sizeof hill.indices);
  for (int i = 0; i < WIDTH * HEIGHT; ++i) {
    depth[i] = (float)(i / WIDTH) / (8 * HEIGHT);
    normals[i][1] = 1;
  }
  lent->depth = make_image(lent->rig, RIG_DEPTH_32, WIDTH, depth);
  lent->small = make_image(lent->rig, RIG_DEPTH_32, WIDTH / 2, depth);
  lent->normals = make_image(lent->rig, RIG_RGBA_FLOAT_32, WIDTH, normals);
  return lent;
}

void lent_close(lent *lent) {
  rig_buffer_free(lent->rig, &lent->vertices);
  rig_buffer_free(lent->rig, &lent->indices);
  rig_image_free(lent->rig, lent->depth);
  rig_image_free(lent->rig, lent->small);
  rig_image_free(lent->rig, lent->normals);
  rig_close(lent->rig);
  free(lent);
}

void lent_rest(lent *lent) {
  if (lent->recording)
    rig_end(lent->rig);
  lent->recording = false;
  rig_run(lent->rig, rig_frame(lent->rig));
  assert_int_equal(rig_messages(lent->rig), 0);
}

void lent_give(const lent *lent, csm_create_info *info) {
  rig_give(lent->rig, info);
}

static void begin(lent *lent, dice *dice) {
  if (rig_frame(lent->rig) - rig_done(lent->rig) == RIG_FRAMES)
    rig_run(lent->rig, rig_done(lent->rig) + 1);
  rig_begin(lent->rig);
  lent->recording = true;
  lent->lists = 1;
  lent->number += 1 + (dice_one_in(dice, 20) ? dice_below(dice, 1000) : 0);
  lent->numbers[rig_frame(lent->rig) % NUMBERS] = lent->number;
}

void lent_frame(lent *lent, dice *dice, csm_frame *frame) {
  if (!lent->recording && !dice_one_in(dice, 12))
    begin(lent, dice);
  frame->frame = lent->number;
  frame->command_buffer = lent->recording ? rig_commands(lent->rig) : NULL;
  if (dice_one_in(dice, 30)) /* one that came before would be a lie that csm may not notice */
    frame->frame = 0;
}

void lent_step(lent *lent, dice *dice) {
  const uint32_t choice = dice_below(dice, 4);
  if (!lent->recording) {
    begin(lent, dice);
  } else if (choice == 0 && lent->lists < RIG_LISTS) {
    rig_split(lent->rig);
    ++lent->lists;
  } else {
    rig_end(lent->rig);
    lent->recording = false;
    if (choice > 1)
      rig_run(lent->rig, rig_frame(lent->rig));
  }
}

uint64_t lent_done(const lent *lent, dice *dice) {
  const uint64_t done = rig_done(lent->rig);
  return dice_one_in(dice, 20) ? 0 : lent->numbers[done % NUMBERS];
}

void lent_mesh(lent *lent, dice *dice, csm_mesh_info *info) {
  const rig_mesh mesh = {.vertices = &lent->vertices, .indices = &lent->indices, .vertex_stride = STRIDE};
  info->positions = info->indices = info->uvs = NULL;
  info->vertex_count = HILL_VERTICES;
  info->index_count = HILL_INDICES;
  info->index_size = 2;
  for (int axis = 0; axis < 3; ++axis) {
    info->bounds_min[axis] = -1;
    info->bounds_max[axis] = 1;
  }
  rig_mesh_give(&mesh, &lent->native, info);
  if (dice_one_in(dice, 30))
    rig_give_foreign_mesh(info);
}

void lent_images(lent *lent, dice *dice, csm_mask_info *info) {
  rig_image *depths[] = {lent->depth, lent->depth, lent->depth, lent->depth, lent->small, lent->normals};
  rig_image *normals[] = {lent->normals, lent->normals, lent->normals, lent->normals, lent->small, lent->depth};
  info->camera_depth = rig_image_native(depths[dice_below(dice, 6)]);
  if (dice_one_in(dice, 2))
    info->normals = rig_image_native(normals[dice_below(dice, 6)]);
  if (dice_one_in(dice, 3)) /* read with a history alone; normals are four floats as well */
    info->motion = rig_image_native(normals[dice_below(dice, 6)]);
}
