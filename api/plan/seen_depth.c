/*
 * seen_depth.c: boxes around the surfaces that a camera sees, by the depth that was drawn of them in this frame.
 *
 * A tile of the picture holds which of 32 slots of depth have surfaces (Harada, "A 2.5D Culling for Forward+", 2012), so
 * what lies between a near surface and a far one is not taken for seen. Slots are counted in the bits of a float, which
 * are much like a logarithm: whole numbers, which every device and the plan divide alike.
 */
#include "plan/internal.h"

#include <string.h>

/* Slots that one box holds at most: the box of a long ray across the light is wide. */
enum { slots_of_box = 2 };

/* What a place in the picture is mapped to, the camera's position being 0; all but the last times that. */
enum { RIGHT, UP, ALONG, VIEW_DEPTH, W, NUMBERS };

/* From pixels and nearness: columns of x, y, nearness and 1. */
typedef struct space {
  double columns[4][NUMBERS];
  double position[3]; /* of the camera in light space */
  double end;         /* the view depth at which shadows end */
} space;

/* Of a tile at nearness 0: between which numbers all of it lies. */
typedef struct tile_range {
  double low[NUMBERS], high[NUMBERS];
} tile_range;

static void make_space(space *out, const plan_frame *frame, const plan_seen_depth *seen, double end) {
  double relative[16], apart[3];
  const plan_camera *camera = &seen->camera;
  plan_pixels_to_relative(relative, frame, camera, seen->width, seen->height);
  for (int axis = 0; axis < 3; ++axis) {
    apart[axis] = frame->origin[axis] - camera->position[axis];
    out->position[axis] = plan_dot(&frame->basis[axis * 3], camera->position);
  }
  for (int i = 0; i < 4; ++i) {
    double *to = out->columns[i], from[4];
    memcpy(from, &relative[i * 4], sizeof from);
    for (int axis = 0; axis < 3; ++axis)
      from[axis] += apart[axis] * from[3];
    for (int axis = RIGHT; axis <= ALONG; ++axis)
      to[axis] = plan_dot(&frame->basis[axis * 3], from);
    to[VIEW_DEPTH] = plan_dot(camera->forward, from);
    to[W] = from[3];
  }
  for (int k = 0; k < NUMBERS && !camera->reversed; ++k) { /* depth is 1 less nearness */
    out->columns[3][k] += out->columns[2][k];
    out->columns[2][k] = -out->columns[2][k];
  }
  out->end = end;
}

static void find_range(tile_range *out, const space *space, const plan_seen_depth *seen, const uint32_t tile[2]) {
  const double x[2] = {tile[0] * (double)PLAN_SEEN_PX, fmin((tile[0] + 1) * (double)PLAN_SEEN_PX, seen->width)};
  const double y[2] = {tile[1] * (double)PLAN_SEEN_PX, fmin((tile[1] + 1) * (double)PLAN_SEEN_PX, seen->height)};
  for (int k = 0; k < NUMBERS; ++k) {
    const double along = space->columns[0][k], down = space->columns[1][k];
    out->low[k] = space->columns[3][k] + along * x[along < 0.0] + down * y[down < 0.0];
    out->high[k] = space->columns[3][k] + along * x[along >= 0.0] + down * y[down >= 0.0];
  }
}

/* What is less near than this lies beyond the end of shadows. */
static double find_end(const tile_range *range, const space *space) {
  const double slope = space->columns[2][VIEW_DEPTH] - space->end * space->columns[2][W];
  const double beyond = range->low[VIEW_DEPTH] - space->end * range->high[W];
  return slope < 0.0 && beyond > 0.0 && beyond < -PLAN_LARGEST * slope ? beyond / -slope : 0.0;
}

/*
 * Around what lies between two nearnesses in a tile: all there is, if that goes too far for numbers. Seen from the camera,
 * either w changes with the nearness or the other numbers do, so the box is as wide as it must be; that of an oblique
 * camera, whose w changes across the tile, is a little wider.
 */
static plan_receiver_box box_between(const tile_range *range, const space *space, const double nearness[2]) {
  static const plan_receiver_box all = {{-PLAN_LARGEST, -PLAN_LARGEST, -PLAN_LARGEST},
                                        {PLAN_LARGEST, PLAN_LARGEST, PLAN_LARGEST},
                                        {-PLAN_LARGEST, PLAN_LARGEST}};
  double low[NUMBERS], high[NUMBERS];
  for (int k = 0; k < NUMBERS; ++k) {
    const double step = space->columns[2][k];
    low[k] = range->low[k] + step * nearness[step < 0.0];
    high[k] = range->high[k] + step * nearness[step >= 0.0];
  }
  if (!(-low[VIEW_DEPTH] < PLAN_LARGEST * low[W] && high[VIEW_DEPTH] < PLAN_LARGEST * low[W]))
    return all;
  const double inverse[2] = {1.0 / low[W], 1.0 / high[W]};
  for (int k = 0; k < W; ++k) {
    low[k] *= inverse[low[k] >= 0.0];
    high[k] *= inverse[high[k] < 0.0];
  }
  plan_receiver_box box = {.depths = {low[VIEW_DEPTH], high[VIEW_DEPTH]}};
  for (int axis = RIGHT; axis <= ALONG; ++axis) {
    box.low[axis] = low[axis] + space->position[axis];
    box.high[axis] = high[axis] + space->position[axis];
  }
  return box;
}

/* ---- slots ---- */

static uint32_t bits_of(float value) {
  uint32_t bits;
  memcpy(&bits, &value, sizeof bits);
  return bits;
}

static float float_of(uint32_t bits) {
  float value;
  memcpy(&value, &bits, sizeof value);
  return value;
}

/* So many bits are left out of floats where slots are counted; seen_depth.ps.hlsl does likewise. */
static uint32_t slot_shift(uint32_t range) {
  uint32_t shift = 0;
  while (range >> shift >= PLAN_SEEN_SLOTS)
    ++shift;
  return shift;
}

static bool is_sound(const plan_seen_tile *tile) {
  const float *n = tile->nearness, *s = tile->slots;
  return isgreaterequal(n[0], 0.0f) && islessequal(n[0], n[1]) && islessequal(n[1], 1.0f) &&
         isgreaterequal(s[0], 0.0f) && isless(s[0], 65536.0f) && isgreaterequal(s[1], 0.0f) && isless(s[1], 65536.0f);
}

/* How far a surface's nearness may be from what the tile says. */
static double slack(const plan_seen_depth *seen, double nearness) {
  const double depth = seen->camera.reversed ? nearness : 1.0;
  const double subtracted = seen->camera.reversed ? 0.0 : 0x1p-24;
  return seen->rounding.share * depth + seen->rounding.step + subtracted;
}

/* The boxes of a tile, as many as are returned. */
static uint32_t find_boxes(plan_receiver_box boxes[PLAN_SEEN_SLOTS], const space *space, const plan_seen_depth *seen,
                           const uint32_t at[2]) {
  const plan_seen_tile *tile = &seen->tiles[at[1] * seen->columns + at[0]];
  uint32_t count = 0;
  if (!is_sound(tile))
    return 0;
  tile_range range;
  find_range(&range, space, seen, at);
  const double end = find_end(&range, space);
  const uint32_t first = bits_of(tile->nearness[0]), last = bits_of(tile->nearness[1]);
  const uint32_t slots = (uint32_t)tile->slots[0] | (uint32_t)tile->slots[1] << 16, shift = slot_shift(last - first);
  for (uint32_t from = 0, to; from < PLAN_SEEN_SLOTS; from = to) {
    for (to = from; to < PLAN_SEEN_SLOTS && to < from + slots_of_box && slots >> to & 1;)
      ++to;
    if (to == from) {
      ++to;
      continue;
    }
    const uint64_t past = first + ((uint64_t)to << shift);
    const double low = float_of(first + (from << shift)), high = float_of(past < last ? (uint32_t)past : last);
    const double nearness[2] = {fmax(low - slack(seen, low), end), high + slack(seen, high)};
    if (nearness[1] >= end && nearness[0] <= nearness[1]) /* a slot beyond the last surface is none */
      boxes[count++] = box_between(&range, space, nearness);
  }
  return count;
}

void plan_seen_walk(const plan_seen_depth *seen, const plan_frame *frame, double end, const plan_box_sink *sink) {
  space space;
  make_space(&space, frame, seen, end);
  for (uint32_t row = 0; row < seen->rows; ++row)
    for (uint32_t column = 0; column < seen->columns; ++column) {
      plan_receiver_box boxes[PLAN_SEEN_SLOTS];
      const uint32_t count = find_boxes(boxes, &space, seen, (uint32_t[]){column, row});
      for (uint32_t i = 0; i < count; ++i)
        sink->take(sink->user, &boxes[i]);
    }
}
