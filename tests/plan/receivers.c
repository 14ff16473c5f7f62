/* What a camera sees asks for parts of the maps alone: what casts into them is drawn, and little else. */
#include "csm_constants.h"
#include "plan/internal.h"
#include "support.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- what filters read ---- */

/* How far, to the sides of a map, the centres of texels lie that a filter reads: less than a circle's radius and a square's
   half side together. */
typedef struct reading {
  double circle, square;
} reading;

/* A filter on moments reads between two texels, each of which is blurred: of a level, texels that are so many of the map's
   wide, and as many of those as there are samples. A search for blockers gathers four texels at each point of its disc. */
static reading reading_of(const csm_config *config) {
  const double wide = config->moment_halved ? 2.0 : 1.0, coarse = wide * ldexp(1.0, (int)config->moment_levels - 1);
  const double samples = config->moment_sampling == CSM_SAMPLING_ANISOTROPIC ? config->moment_anisotropy : 1.0;
  switch (config->filter) {
  case CSM_FILTER_PCF_N:
    return (reading){.square = (config->filter_taps + 1) / 2.0};
  case CSM_FILTER_PCSS:
  case CSM_FILTER_BACKPROJECTION:
    return (reading){.circle = config->soft_radius_max_texels, .square = 1.0};
  case CSM_FILTER_VSSM:
    return (reading){.square = 1.5 * coarse - 0.5 + config->moment_blur_texels * wide};
  default:
    return (reading){.square = 1.5 * coarse - 0.5 + config->moment_blur_texels * wide,
                     .circle = coarse * (samples - 1.0) / 2.0};
  }
}

static csm_config reading_config(random_state *random) {
  static const uint32_t filters[] = {CSM_FILTER_PCF_N, CSM_FILTER_PCSS, CSM_FILTER_BACKPROJECTION,
                                     CSM_FILTER_VSSM,  CSM_FILTER_VSM,  CSM_FILTER_EVSM4};
  csm_config config = default_config();
  config.caster_set = CSM_CASTER_SET_VIEW;
  config.cascade_count = 1 + random_below(random, 3);
  config.resolution = 2048;
  config.filter = filters[random_below(random, sizeof filters / sizeof *filters)];
  config.filter_taps = 31;
  config.soft_radius_max_texels = random_below(random, 2) ? 32.0 : 2.0;
  config.moment_blur_texels = random_below(random, 33);
  config.moment_levels = 2 + random_below(random, 4);
  config.moment_halved = random_below(random, 2);
  config.moment_sampling = CSM_SAMPLING_TRILINEAR + random_below(random, 2);
  config.moment_anisotropy = 8;
  return config;
}

/* Where a point lies in a cascade's map, in texels, rows down. */
static void texel_of(const plan_cascade *cascade, const double point[3], double at[3]) {
  transform_point(cascade->info.world_to_shadow, point, at);
  at[0] *= cascade->resolution;
  at[1] *= cascade->resolution;
}

/* A caster over what a filter reads of the map at a point that is seen, anywhere up the light; false where that does not lie
   in the map. No footprint leaves a map: half of what there is to its border is the samples', and a level's what is left. */
static bool place_reader(random_state *random, test_scene *scene, const plan_frame *frame, uint32_t c,
                         const double point[3], const reading *reads) {
  const plan_cascade *cascade = &frame->cascades[c];
  const double angle = random_between(random, 0.0, 2.0 * M_PI), up = random_scale(random, 0.1, 1000.0);
  double at[3], room = cascade->resolution;
  texel_of(cascade, point, at);
  for (int axis = 0; axis < 2; ++axis)
    room = fmin(room, fmin(at[axis], cascade->resolution - at[axis]));
  if (room < 2.0 * (reads->circle + reads->square))
    return false;
  const double corner[2] = {random_below(random, 2) ? 1.0 : -1.0, random_below(random, 2) ? 1.0 : -1.0};
  const double right = cascade->texel[0] * (reads->circle * cos(angle) + reads->square * corner[0]) * 0.999;
  const double above = cascade->texel[1] * (reads->circle * sin(angle) + reads->square * corner[1]) * 0.999;
  for (int i = 0; i < 3; ++i) {
    const double *basis = frame->basis;
    scene->meshes[0].extent[i] = 0.01 * cascade->texel[0];
    scene->instances[0].transform[i * 5] = 1.0;
    scene->instances[0].transform[i * 4 + 3] = point[i] + right * basis[i] + above * basis[3 + i] - up * basis[6 + i];
  }
  scene_place(scene);
  return true;
}

/* What lies outside of the view, but over a texel that the filter reads at a point inside, is drawn. */
static void keeps_what_filters_read_beside_the_view(void **state) {
  (void)state;
  random_state random = {7};
  test_scene scene = scene_make(1, 1);
  uint32_t kept = 0;
  for (int i = 0; i < 20000; ++i) {
    const csm_config config = reading_config(&random);
    const reading reads = reading_of(&config);
    test_camera camera = random_camera(&random, 10.0);
    camera.orthographic = false;
    camera.half_height = random_scale(&random, 0.02, 1.0);
    camera.half_width = random_scale(&random, 0.02, 1.0);
    camera.near = fabs(camera.near);
    double light[3], point[3], view[16], projection[16];
    random_unit(&random, light);
    plan_frame frame = plan_empty(&config, &camera, light);
    const uint32_t c = random_below(&random, config.cascade_count);
    slice_point(&random, &camera, &frame.cascades[c].info, point);
    if (frame.unshadowed || !place_reader(&random, &scene, &frame, c, point, &reads))
      continue;
    const char *error = "";
    camera_matrices(&camera, view, projection);
    assert_int_equal(plan_made(&frame, &config, &(test_shot){view, projection, camera_reversed(&camera), light},
                               &scene.scene, scene.memory, &error),
                     CSM_SUCCESS);
    if (!frame.windows[c].list.instance_count)
      fail_msg("frame %d: a caster that filter %u reads in cascade %u, %g and %g texels away, is not drawn", i,
               config.filter, c, reads.circle, reads.square);
    ++kept;
  }
  assert_true(kept > 2000);
  scene_free(&scene);
}

/* ---- what receivers read ---- */

/* Which cascades a receiver looks up, as csm_sample.inc chooses them, in floats. */
typedef struct chooser {
  float block[CSM_C_COUNT * 4];
  uint32_t count;
  float at[3], normal[3]; /* in light space, from the constants' origin */
  float offset_texels, view_depth;
} chooser;

static const float *row(const chooser *c, uint32_t index) {
  return &c->block[index * 4];
}

static float split(const chooser *c, uint32_t cascade) {
  return c->block[CSM_C_SPLITS * 4 + cascade];
}

/* From 0 at the map's middle to the share that samples may lie in; above it: not held. */
static float place_in(const chooser *c, uint32_t cascade, bool *held) {
  const float *scale = row(c, CSM_C_SCALES + cascade), *offset = row(c, CSM_C_OFFSETS + cascade);
  const float *texel = row(c, CSM_C_TEXELS + cascade);
  float at[3];
  for (int i = 0; i < 3; ++i)
    at[i] = (c->at[i] + c->normal[i] * c->offset_texels * texel[0]) * scale[i] + offset[i];
  const float across = fmaxf(fabsf(at[0]), fabsf(at[1]));
  *held = across <= texel[2] && fabsf(at[2] - 0.5f) <= 0.5f + 1.0f / 4096.0f;
  return across;
}

/* The cascade that holds it, from one on: by the interval the first, else the finest; the count: none. */
static uint32_t find_held(const chooser *c, uint32_t from, bool by_interval) {
  uint32_t best = c->count;
  float fine = -1e30f;
  for (uint32_t i = c->count; i-- > from;) {
    bool held;
    const float *scale = row(c, CSM_C_SCALES + i);
    place_in(c, i, &held);
    if (!held || (!by_interval && scale[0] * scale[1] < fine))
      continue;
    best = i;
    fine = scale[0] * scale[1];
  }
  return best;
}

/* Whether `cascade` is looked up: in place of all others, or blended with one. */
static bool chooses(const chooser *c, const csm_config *config, uint32_t cascade) {
  const bool by_interval = config->selection == CSM_SELECT_INTERVAL;
  uint32_t from = 0;
  while (by_interval && from < c->count && c->view_depth > split(c, from))
    ++from;
  const uint32_t first = find_held(c, from, by_interval);
  if (c->view_depth > split(c, c->count - 1) || first == c->count)
    return false;
  const float share = (float)config->blend_share, end = split(c, first);
  const float begin = first ? split(c, first - 1) : row(c, CSM_S_BAND)[3];
  bool held;
  const float edge = row(c, CSM_C_TEXELS + first)[2] - place_in(c, first, &held);
  const float blend = by_interval ? (c->view_depth - end) / ((end - begin) * share) + 1.0f : 1.0f - edge / share;
  const bool blends = config->blend_mode != CSM_BLEND_OFF && blend > 0.0f;
  return first == cascade || (blends && find_held(c, first + 1, by_interval) == cascade);
}

static void choose_for(chooser *out, random_state *random, const plan_frame *frame, const csm_config *config,
                       const double point[3]) {
  double normal[3], relative[3], seen[3];
  *out = (chooser){.count = frame->cascade_count,
                   .offset_texels = (float)random_between(random, 0.0, config->bias_normal_texels)};
  plan_write_constants(out->block, frame, config);
  random_unit(random, normal);
  for (int i = 0; i < 3; ++i) {
    relative[i] = point[i] - frame->origin[i];
    seen[i] = point[i] - frame->camera.position[i];
  }
  for (int i = 0; i < 3; ++i) {
    out->at[i] = (float)plan_dot(&frame->basis[i * 3], relative);
    out->normal[i] = (float)plan_dot(&frame->basis[i * 3], normal);
  }
  out->view_depth = (float)plan_dot(frame->camera.forward, seen);
}

/* A receiver around a point, which lies anywhere in it. */
static void place_receiver(random_state *random, test_scene *scene, const double point[3]) {
  plan_instance *receiver = &scene->instances[1];
  memset(receiver->transform, 0, sizeof receiver->transform);
  for (int i = 0; i < 3; ++i) {
    const double extent = random_scale(random, 0.01, 100.0);
    scene->meshes[1].extent[i] = extent;
    receiver->transform[i * 5] = 1.0;
    receiver->transform[i * 4 + 3] = point[i] + extent * random_between(random, -0.999, 0.999);
  }
  receiver->mesh = 1;
  receiver->flags = PLAN_RECEIVES_ONLY;
  scene->instances[0].flags = PLAN_CASTS_ONLY;
}

/* A first frame of whose scene the receivers are all that is asked for. */
static void plan_for_receivers(plan_frame *out, const csm_config *config, const test_shot *shot,
                               const plan_scene *scene, plan_memory *memory) {
  const plan_frame_info info = {.config = config,
                                .view = shot->view,
                                .projection = shot->projection,
                                .reversed = shot->reversed,
                                .light = shot->light,
                                .scene = scene,
                                .all_receivers = true};
  const char *error = "";
  if (plan_traced(out, &info, memory, &error))
    fail_msg("%s", error);
}

static csm_config receivers_config(random_state *random) {
  static const uint32_t fits[] = {CSM_FIT_MINIMUM_SPHERE, CSM_FIT_CASCADE, CSM_FIT_SCENE, CSM_FIT_SCENE_SQUARE};
  csm_config config = reading_config(random);
  config.selection = random_below(random, CSM_SELECT_BEST + 1);
  config.blend_mode = random_below(random, CSM_BLEND_DITHERED + 1);
  config.blend_share = random_between(random, 0.01, 0.5);
  config.fit_mode = fits[random_below(random, 4)];
  config.bias_normal_texels = random_below(random, 2) ? 0.0 : 3.0;
  config.resolution = random_below(random, 2) ? 512 : 2048;
  config.shadow_distance = random_scale(random, 10.0, 1000.0);
  return config;
}

/* What lies over a texel that is read at a receiver's point is drawn in the cascades that the point looks up. */
static void draws_what_is_read_for_receivers(void **state) {
  (void)state;
  random_state random = {11};
  test_scene scene = scene_make(2, 2);
  uint32_t read[CSM_MAX_CASCADES] = {0};
  for (int i = 0; i < 40000; ++i) {
    const csm_config config = receivers_config(&random);
    const reading reads = reading_of(&config);
    test_camera camera = random_camera(&random, 10.0);
    double light[3], point[3], view[16], projection[16];
    random_unit(&random, light);
    plan_frame frame = plan_empty(&config, &camera, light);
    const uint32_t c = random_below(&random, config.cascade_count);
    if (frame.unshadowed)
      continue;
    slice_point(&random, &camera, &frame.cascades[random_below(&random, config.cascade_count)].info, point);
    place_receiver(&random, &scene, point);
    if (!place_reader(&random, &scene, &frame, c, point, &reads))
      continue;
    camera_matrices(&camera, view, projection);
    plan_for_receivers(&frame, &config, &(test_shot){view, projection, camera_reversed(&camera), light}, &scene.scene,
                       scene.memory);
    chooser chooser;
    choose_for(&chooser, &random, &frame, &config, point);
    if (!chooses(&chooser, &config, c))
      continue;
    if (!frame.windows[c].list.instance_count)
      fail_msg("frame %d: selection %u, blending %u, fit %u: what is read of cascade %u is not drawn", i,
               config.selection, config.blend_mode, config.fit_mode, c);
    ++read[c];
  }
  assert_true(read[0] > 2000 && read[1] > 1000 && read[2] > 500);
  scene_free(&scene);
}

/* ---- parts ---- */

enum { meshes_in_parts = 2 }; /* what casts, and what receives */

typedef struct divided {
  plan_part parts[meshes_in_parts][PLAN_MOST_PARTS];
  plan_parts tables[meshes_in_parts];
  uint32_t at[meshes_in_parts]; /* the part that matters */
} divided;

/* Boxes anywhere in a mesh's, and one of them around a point of it. */
static void divide(random_state *random, divided *out, uint32_t mesh, const plan_bounds *bounds,
                   const double point[3]) {
  const uint32_t count = 1 + random_below(random, PLAN_MOST_PARTS), at = random_below(random, count);
  for (uint32_t i = 0; i < count; ++i) {
    plan_part *part = &out->parts[mesh][i];
    *part = (plan_part){.first_index = 3 * i, .index_count = 3};
    for (int axis = 0; axis < 3; ++axis) {
      const double most = bounds->extent[axis], extent = most * random_between(random, 0.001, 0.3);
      const double near = point[axis] + random_between(random, -1.0, 1.0) * extent;
      const double anywhere = random_between(random, -1.0, 1.0) * most;
      part->extent[axis] = extent;
      part->center[axis] = fmin(fmax(i == at ? near : anywhere, extent - most), most - extent);
    }
  }
  out->tables[mesh] = (plan_parts){.parts = out->parts[mesh], .count = count};
  out->at[mesh] = at;
}

/* Makes the receiver's mesh large, and the point a place in one of its parts. */
static void divide_receiver(random_state *random, test_scene *scene, divided *out, const double point[3]) {
  plan_instance *receiver = &scene->instances[1];
  double within[3];
  for (int i = 0; i < 3; ++i) {
    const double extent = random_scale(random, 1.0, 500.0);
    within[i] = extent * random_between(random, -0.999, 0.999);
    scene->meshes[1].extent[i] = extent;
    receiver->transform[i * 4 + 3] = point[i] - within[i];
  }
  divide(random, out, 1, &scene->meshes[1], within);
}

/* Makes the caster's mesh large, and what it was before one of its parts. */
static void divide_caster(random_state *random, test_scene *scene, divided *out) {
  plan_instance *caster = &scene->instances[0];
  double within[3], extent[3];
  for (int i = 0; i < 3; ++i) {
    const double most = random_scale(random, 1.0, 500.0);
    extent[i] = scene->meshes[0].extent[i];
    within[i] = (most - extent[i]) * random_between(random, -1.0, 1.0);
    scene->meshes[0].extent[i] = most;
    caster->transform[i * 4 + 3] -= within[i];
  }
  divide(random, out, 0, &scene->meshes[0], within);
  plan_part *part = &out->parts[0][out->at[0]];
  for (int i = 0; i < 3; ++i) {
    part->center[i] = within[i];
    part->extent[i] = extent[i];
  }
}

/* Whether the caster's part that matters is drawn; *left_out grows by the parts that are not. */
static bool draws_part(const plan_list *list, const divided *d, uint64_t *left_out) {
  bool drawn = false;
  uint32_t indices = 0;
  const plan_part *part = &d->parts[0][d->at[0]];
  for (uint32_t i = 0; i < list->draw_count; ++i) {
    const plan_draw *draw = &list->draws[i];
    drawn |= !draw->index_count ||
             (draw->first_index <= part->first_index && part->first_index < draw->first_index + draw->index_count);
    indices += draw->index_count ? draw->index_count : 3 * d->tables[0].count;
  }
  *left_out += d->tables[0].count - indices / 3;
  return drawn;
}

/* What part of a caster lies over a texel that is read at a point of a receiver's part is drawn. */
static void draws_parts_that_are_read_for_parts(void **state) {
  (void)state;
  random_state random = {13};
  test_scene scene = scene_make(2, 2);
  static divided d;
  uint32_t read[CSM_MAX_CASCADES] = {0};
  uint64_t left_out = 0;
  scene.scene.parts = d.tables;
  for (int i = 0; i < 40000; ++i) {
    const csm_config config = receivers_config(&random);
    const reading reads = reading_of(&config);
    test_camera camera = random_camera(&random, 10.0);
    double light[3], point[3], view[16], projection[16];
    random_unit(&random, light);
    plan_frame frame = plan_empty(&config, &camera, light);
    const uint32_t c = random_below(&random, config.cascade_count);
    if (frame.unshadowed || camera.orthographic) /* whose maps are as wide as what casts */
      continue;
    slice_point(&random, &camera, &frame.cascades[random_below(&random, config.cascade_count)].info, point);
    place_receiver(&random, &scene, point);
    divide_receiver(&random, &scene, &d, point);
    if (!place_reader(&random, &scene, &frame, c, point, &reads))
      continue;
    divide_caster(&random, &scene, &d);
    scene_place(&scene);
    camera_matrices(&camera, view, projection);
    plan_for_receivers(&frame, &config, &(test_shot){view, projection, camera_reversed(&camera), light}, &scene.scene,
                       scene.memory);
    chooser chooser;
    choose_for(&chooser, &random, &frame, &config, point);
    if (!chooses(&chooser, &config, c))
      continue;
    if (!draws_part(&frame.windows[c].list, &d, &left_out))
      fail_msg("frame %d: selection %u, blending %u, fit %u: what is read of cascade %u is not drawn", i,
               config.selection, config.blend_mode, config.fit_mode, c);
    ++read[c];
  }
  printf("%llu parts are left out\n", (unsigned long long)left_out);
  assert_true(read[0] > 1000 && read[1] > 500 && read[2] > 250 && left_out > 20000);
  scene_free(&scene);
}

static uint32_t plan_drawn(const plan_frame *frame) {
  uint32_t sum = 0;
  for (uint32_t i = 0; i < frame->cascade_count; ++i)
    sum += frame->windows[i].list.instance_count;
  return sum;
}

/* Leaves casters out, and changes nothing else: maps lie where they lie without. */
static void receivers_leave_maps_where_they_are(void **state) {
  (void)state;
  enum { instances = 300, meshes = 5 };
  random_state random = {12};
  test_scene scene = scene_make(instances, meshes);
  plan_memory *memory = memory_make(instances, meshes, PLAN_WINDOWS_MOST);
  plan_memory *more = memory_make(instances, meshes, PLAN_WINDOWS_MOST);
  uint64_t all = 0, drawn = 0;
  for (int i = 0; i < 400; ++i) {
    const csm_config config = receivers_config(&random);
    const test_camera camera = random_camera(&random, 10.0);
    csm_config of_maps = config;
    plan_frame receivers, seen, whole;
    double light[3], view[16], projection[16];
    const char *error = "";
    random_unit(&random, light);
    camera_matrices(&camera, view, projection);
    scene_scatter(&scene, &random, camera.eye, random_scale(&random, 10.0, 2000.0));
    const test_shot shot = {view, projection, camera_reversed(&camera), light};
    plan_for_receivers(&receivers, &config, &shot, &scene.scene, scene.memory);
    assert_int_equal(plan_made(&seen, &config, &shot, &scene.scene, memory, &error), CSM_SUCCESS);
    of_maps.caster_set = CSM_CASTER_SET_MAP;
    assert_int_equal(plan_made(&whole, &of_maps, &shot, &scene.scene, more, &error), CSM_SUCCESS);
    const bool none = plan_drawn(&receivers) == 0;
    for (uint32_t c = 0; c < seen.cascade_count; ++c) {
      if (!whole.camera.orthographic) { /* whose maps are no wider than what casts into the view */
        assert_memory_equal(seen.cascades[c].to_clip, whole.cascades[c].to_clip, sizeof seen.cascades[c].to_clip);
        assert_true(seen.cascades[c].shift == whole.cascades[c].shift);
      }
      if (!none) /* where no receiver is in sight nothing is looked up */
        assert_memory_equal(seen.cascades[c].to_clip, receivers.cascades[c].to_clip, sizeof seen.cascades[c].to_clip);
      for (uint32_t slot = 0; slot < instances; ++slot)
        assert_true(!(plan_drawn_by(&receivers, slot) & ~plan_drawn_by(&seen, slot)));
    }
    all += plan_drawn(&seen);
    drawn += plan_drawn(&receivers);
  }
  printf("%llu of %llu casters are drawn\n", (unsigned long long)drawn, (unsigned long long)all);
  assert_true(drawn > all / 20 && drawn < all * 9 / 10);
  memory_free(more);
  memory_free(memory);
  scene_free(&scene);
}

/* ---- what a depth shows ---- */

enum { seen_width = 200, seen_height = 120, seen_columns = 13, seen_rows = 8, most_seen = 4 };

/* A picture's depth, tile by tile. */
typedef struct seen_picture {
  plan_seen_tile tiles[seen_rows * seen_columns];
  plan_seen_depth depth;
} seen_picture;

static void see_nothing(seen_picture *out, const double view[16], const double projection[16], uint32_t reversed) {
  const char *error = "";
  *out = (seen_picture){.depth = {.width = seen_width,
                                  .height = seen_height,
                                  .columns = seen_columns,
                                  .rows = seen_rows,
                                  .rounding = {.share = 0x1p-24}}};
  assert_int_equal(plan_camera_make(&out->depth.camera, view, projection, reversed, &error), CSM_SUCCESS);
  for (int i = 0; i < seen_rows * seen_columns; ++i)
    out->tiles[i] = (plan_seen_tile){.nearness = {2.0f, -2.0f}};
  out->depth.tiles = out->tiles;
}

/* The bits of a float above 0, as a number that grows with it, by its exponent and mantissa. */
static uint32_t rank_of(float value) {
  int exponent;
  const float mantissa = frexpf(value, &exponent);
  return (uint32_t)(exponent + 126) * (1u << 23) + (uint32_t)ldexpf(mantissa - 0.5f, 24);
}

/* Tells a tile what surfaces it holds. */
static void fill_tile(plan_seen_tile *out, const float *nearness, int count) {
  float least = nearness[0], most = nearness[0];
  uint32_t width = 1, bits = 0;
  for (int i = 1; i < count; ++i) {
    least = fminf(least, nearness[i]);
    most = fmaxf(most, nearness[i]);
  }
  while ((rank_of(most) - rank_of(least)) / width > 31)
    width *= 2;
  for (int i = 0; i < count; ++i)
    bits |= 1u << (rank_of(nearness[i]) - rank_of(least)) / width;
  *out = (plan_seen_tile){{least, most}, {(float)(bits % 65536), (float)(bits / 65536)}};
}

/* Where a camera's picture shows a point: its tile, and how near it is. False: it does not. */
static bool show_point(const double view[16], const double projection[16], bool reversed, const double point[3],
                       uint32_t *tile, float *nearness) {
  long double eye[4] = {0, 0, 0, 1}, clip[4];
  for (int row = 0; row < 3; ++row)
    for (int k = 0; k < 4; ++k)
      eye[row] += (long double)view[k * 4 + row] * (k < 3 ? point[k] : 1.0L);
  for (int row = 0; row < 4; ++row) {
    clip[row] = 0;
    for (int k = 0; k < 4; ++k)
      clip[row] += projection[k * 4 + row] * eye[k];
  }
  const float depth = (float)(clip[2] / clip[3]);
  const long double x = (clip[0] / clip[3] + 1) / 2 * seen_width, y = (1 - clip[1] / clip[3]) / 2 * seen_height;
  if (!(x >= 0 && x < seen_width && y >= 0 && y < seen_height && depth > 0.0f && depth < 1.0f))
    return false;
  *tile = (uint32_t)y / 16 * seen_columns + (uint32_t)x / 16;
  *nearness = reversed ? depth : 1.0f - depth;
  return true;
}

/* A point among other surfaces of its tile, nearer and farther. */
static void see(seen_picture *out, random_state *random, uint32_t tile, float nearness) {
  float all[most_seen] = {nearness};
  const int count = 1 + (int)random_below(random, most_seen);
  for (int i = 1; i < count; ++i)
    all[i] = (float)fmin(nearness * random_scale(random, 0.01, 100.0), 1.0);
  fill_tile(&out->tiles[tile], all, count);
}

static void plan_for_depth(plan_frame *out, const csm_config *config, const test_shot *shot, const plan_scene *scene,
                           void *memory, const seen_picture *seen) {
  const plan_frame_info info = {.config = config,
                                .view = shot->view,
                                .projection = shot->projection,
                                .reversed = shot->reversed,
                                .light = shot->light,
                                .scene = scene,
                                .seen = &seen->depth};
  const char *error = "";
  if (plan_traced(out, &info, memory, &error))
    fail_msg("%s", error);
  assert_int_equal(out->cells_by, out->unshadowed ? CSM_CELLS_ALL : CSM_CELLS_DEPTH);
}

/* What lies over a texel that is read at a surface that the depth shows is drawn in the cascades that it looks up. */
static void draws_what_is_read_for_what_is_seen(void **state) {
  (void)state;
  random_state random = {17};
  test_scene scene = scene_make(1, 1);
  uint32_t read[CSM_MAX_CASCADES] = {0};
  for (int i = 0; i < 60000; ++i) {
    const csm_config config = receivers_config(&random);
    const reading reads = reading_of(&config);
    test_camera camera = random_camera(&random, 10.0);
    double light[3], point[3], view[16], projection[16];
    random_unit(&random, light);
    plan_frame frame = plan_empty(&config, &camera, light);
    const uint32_t c = random_below(&random, config.cascade_count);
    uint32_t tile;
    float nearness;
    if (frame.unshadowed)
      continue;
    slice_point(&random, &camera, &frame.cascades[random_below(&random, config.cascade_count)].info, point);
    camera_matrices(&camera, view, projection);
    if (!show_point(view, projection, camera.reversed, point, &tile, &nearness) ||
        !place_reader(&random, &scene, &frame, c, point, &reads))
      continue;
    seen_picture seen;
    see_nothing(&seen, view, projection, camera_reversed(&camera));
    see(&seen, &random, tile, nearness);
    plan_for_depth(&frame, &config, &(test_shot){view, projection, camera_reversed(&camera), light}, &scene.scene,
                   scene.memory, &seen);
    chooser chooser;
    choose_for(&chooser, &random, &frame, &config, point);
    if (!chooses(&chooser, &config, c))
      continue;
    if (!frame.windows[c].list.instance_count)
      fail_msg("frame %d: selection %u, blending %u, fit %u: what is read of cascade %u is not drawn", i,
               config.selection, config.blend_mode, config.fit_mode, c);
    ++read[c];
  }
  printf("%u, %u and %u lookups\n", read[0], read[1], read[2]);
  assert_true(read[0] > 1000 && read[1] > 500 && read[2] > 200);
  scene_free(&scene);
}

/* What lies between a near surface and a far one of a tile is not read, nor anything where nothing is seen. */
static void leaves_out_what_is_not_seen(void **state) {
  (void)state;
  const double light[3] = {0.1, -1.0, 0.05};
  test_camera camera = plain_camera();
  test_scene scene = scene_make(1, 1);
  csm_config config = default_config();
  double view[16], projection[16];
  uint32_t tile[2], counts[3];
  float nearness[2];
  plan_frame frame;
  config.caster_set = CSM_CASTER_SET_VIEW;
  config.shadow_distance = 200.0;
  camera_matrices(&camera, view, projection);
  const test_shot shot = {view, projection, camera_reversed(&camera), light};
  const double near[3] = {0.01, 0.01, -4.0}, far[3] = {0.4, 0.4, -150.0};
  assert_true(show_point(view, projection, camera.reversed, near, &tile[0], &nearness[0]));
  assert_true(show_point(view, projection, camera.reversed, far, &tile[1], &nearness[1]));
  assert_int_equal(tile[0], tile[1]);
  seen_picture seen;
  see_nothing(&seen, view, projection, camera_reversed(&camera));
  plan_for_depth(&frame, &config, &shot, &scene.scene, scene.memory, &seen);
  assert_int_equal(frame.cells_read, 0);
  for (int i = 0; i < 3; ++i) {
    fill_tile(&seen.tiles[tile[0]], i == 1 ? nearness + 1 : nearness, i == 2 ? 2 : 1);
    plan_for_depth(&frame, &config, &shot, &scene.scene, scene.memory, &seen);
    counts[i] = frame.cells_read;
  }
  assert_true(counts[0] && counts[1]);
  assert_true(counts[2] >= counts[0] && counts[2] >= counts[1]);
  fill_tile(&seen.tiles[tile[0]], nearness, 2);
  seen.tiles[tile[0]].slots[0] = seen.tiles[tile[0]].slots[1] = 65535.0f; /* all that lies between, too */
  plan_for_depth(&frame, &config, &shot, &scene.scene, scene.memory, &seen);
  printf("%u, %u, %u of %u cells\n", counts[0], counts[1], counts[2], frame.cells_read);
  assert_true(frame.cells_read > 3 * counts[2]);
  scene_free(&scene);
}

static float wild_float(random_state *random) {
  static const float wild[] = {0.0f, -0.0f, 1.0f, -1.0f, 1e-45f, 3e38f, -3e38f, INFINITY, -INFINITY, NAN, 65536.0f};
  const uint32_t which = random_below(random, 2 * sizeof wild / sizeof *wild);
  return which < sizeof wild / sizeof *wild ? wild[which] : (float)random_scale(random, 1e-30, 1e6);
}

/* Whatever a tile holds, planning goes on, and raises no exception. */
static void bears_any_tile(void **state) {
  (void)state;
  random_state random = {19};
  test_scene scene = scene_make(20, 2);
  for (int i = 0; i < 2000; ++i) {
    const csm_config config = receivers_config(&random);
    const test_camera camera = random_camera(&random, 1e6);
    double light[3], view[16], projection[16];
    seen_picture seen;
    plan_frame frame;
    random_unit(&random, light);
    camera_matrices(&camera, view, projection);
    scene_scatter(&scene, &random, camera.eye, 100.0);
    see_nothing(&seen, view, projection, camera_reversed(&camera));
    for (int t = 0; t < seen_rows * seen_columns; ++t)
      for (int k = 0; k < 2; ++k) {
        seen.tiles[t].nearness[k] = wild_float(&random);
        seen.tiles[t].slots[k] = wild_float(&random);
      }
    plan_for_depth(&frame, &config, &(test_shot){view, projection, camera_reversed(&camera), light}, &scene.scene,
                   scene.memory, &seen);
  }
  scene_free(&scene);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(keeps_what_filters_read_beside_the_view),
      cmocka_unit_test(draws_what_is_read_for_receivers),
      cmocka_unit_test(draws_parts_that_are_read_for_parts),
      cmocka_unit_test(receivers_leave_maps_where_they_are),
      cmocka_unit_test(draws_what_is_read_for_what_is_seen),
      cmocka_unit_test(leaves_out_what_is_not_seen),
      cmocka_unit_test(bears_any_tile),
  };
  return cmocka_run_group_tests_name("plan-receivers", tests, NULL, NULL);
}
