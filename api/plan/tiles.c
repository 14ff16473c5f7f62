/* tiles.c: which parts of the cascades' maps a frame's camera looks at, and which cascades hold what they held before. */
#include "plan/internal.h"

#include <math.h>
#include <string.h>

uint32_t plan_tiles_across(uint32_t side) {
  return (side + PLAN_TILE - 1) / PLAN_TILE;
}

/* Where a cascade's map lies in light space, as its texels count: `low` and `high` of its columns or rows from `first` to
   `last`, of so many. */
static void texels_to_light(double *low, double *high, const plan_cascade *cascade, int axis, const double texels[2],
                            double side) {
  const double scale = cascade->to_clip[axis * 5], offset = cascade->to_clip[axis * 4 + 3];
  double at[2];
  for (int i = 0; i < 2; ++i) {
    const double share = 2.0 * texels[i] / side - 1.0; /* rows count down from clip y = 1 */
    at[i] = ((axis ? -share : share) - offset) / scale;
  }
  *low = fmin(at[0], at[1]);
  *high = fmax(at[0], at[1]);
}

void plan_seen_tiles(uint8_t *tiles, const plan_frame *frame, const csm_config *config, uint32_t cascade,
                     uint32_t side) {
  const plan_cascade *of = &frame->cascades[cascade];
  const uint32_t across = plan_tiles_across(side);
  const double room = fmax(of->texel[0], of->texel[1]) * plan_view_room_texels(config, cascade);
  plan_hull hull = {0};
  const double depths[2] = {frame->camera.near_depth, frame->cascades[frame->cascade_count - 1].info.far_depth};
  if (config->caster_set == CSM_CASTER_SET_VIEW)
    plan_view_hull(&hull, &frame->camera, frame->basis, depths, room);
  for (uint32_t y = 0; y < across; ++y)
    for (uint32_t x = 0; x < across; ++x) {
      const double columns[2] = {x * (double)PLAN_TILE, (x + 1) * (double)PLAN_TILE};
      const double rows[2] = {y * (double)PLAN_TILE, (y + 1) * (double)PLAN_TILE};
      double low[2], high[2];
      texels_to_light(&low[0], &high[0], of, 0, columns, side);
      texels_to_light(&low[1], &high[1], of, 1, rows, side);
      tiles[y * across + x] = !plan_outside_hull(&hull, low, high);
    }
}

/* The next one from `i` on that a cascade draws, or the end. */
static uint32_t next_drawn(const plan_frame *frame, uint32_t cascade, uint32_t i) {
  while (i < frame->drawn_count && !(frame->drawn[i].cascades >> cascade & 1))
    ++i;
  return i;
}

/* Whether a cascade's casters are those that it had, and none has changed; other parts of them may be drawn. */
static bool same_casters(const plan_frame *before, const plan_frame *now, uint32_t cascade, const plan_scene *scene,
                         uint64_t revision) {
  bool same = !before->unshadowed && !now->unshadowed && cascade < before->cascade_count &&
              before->slot_count == now->slot_count && memcmp(before->basis, now->basis, sizeof now->basis) == 0;
  uint32_t i = next_drawn(before, cascade, 0), k = next_drawn(now, cascade, 0);
  while (same && i < before->drawn_count && k < now->drawn_count) {
    const uint32_t slot = now->drawn[k].slot;
    same = before->drawn[i].slot == slot && scene->revisions[slot] <= revision;
    i = next_drawn(before, cascade, i + 1);
    k = next_drawn(now, cascade, k + 1);
  }
  return same && i == before->drawn_count && k == now->drawn_count;
}

static bool same_lists(const plan_list *a, const plan_list *b) {
  return a->draw_count == b->draw_count && a->instance_count == b->instance_count &&
         (!b->draw_count || (memcmp(a->draws, b->draws, b->draw_count * sizeof *b->draws) == 0 &&
                             memcmp(a->instances, b->instances, b->instance_count * sizeof *b->instances) == 0));
}

bool plan_cascade_same(const plan_frame *before, const plan_frame *now, uint32_t cascade, const plan_scene *scene,
                       uint64_t revision) {
  const plan_cascade *a = &before->cascades[cascade], *b = &now->cascades[cascade];
  return !now->pages && memcmp(a->to_clip, b->to_clip, sizeof a->to_clip) == 0 &&
         same_casters(before, now, cascade, scene, revision) &&
         same_lists(&before->windows[cascade].list, &now->windows[cascade].list);
}

/* Whether a cascade lies where it lay, but for its jitter, and is read for the same depths. */
static bool same_place(const plan_cascade *a, const plan_cascade *b) {
  return memcmp(a->texel, b->texel, sizeof a->texel) == 0 &&
         memcmp(a->origin_texels, b->origin_texels, sizeof a->origin_texels) == 0 &&
         memcmp(&a->to_clip[8], &b->to_clip[8], 4 * sizeof a->to_clip[0]) == 0 && a->resolution == b->resolution &&
         a->shift == b->shift && a->info.near_depth == b->info.near_depth && a->info.far_depth == b->info.far_depth;
}

/* Whether a surface moved that casts nothing, so that no map tells of it. */
static bool receiver_moved(const plan_scene *scene, uint64_t revision) {
  bool moved = false;
  for (uint32_t slot = 0; slot < scene->slot_count && !moved && scene->revision != revision; ++slot) {
    const plan_instance *instance = &scene->instances[slot];
    moved = scene->revisions[slot] > revision && plan_receives(instance) && !plan_casts(instance);
  }
  return moved;
}

/* Parts that one of the frames leaves out are read by none of its pixels, so shadows rest without them. */
bool plan_frame_rests(const plan_frame *before, const plan_frame *now, const plan_scene *scene, uint64_t revision) {
  bool rests = before->cascade_count == now->cascade_count && before->light_diameter == now->light_diameter &&
               before->shadow_end == now->shadow_end && !receiver_moved(scene, revision);
  for (uint32_t i = 0; i < now->cascade_count && rests; ++i)
    rests = same_place(&before->cascades[i], &now->cascades[i]) && same_casters(before, now, i, scene, revision);
  return rests;
}
