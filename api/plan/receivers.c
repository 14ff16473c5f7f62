/* receivers.c: which receivers a camera sees, and which cells of the cascades' maps are read for them. */
#include "plan/internal.h"

#include <string.h>

/* ---- what a camera sees ---- */

enum { CLIP_PLANES = 6, MOST_PLANES = CLIP_PLANES + 1 };

/* Half-spaces, for world positions relative to the camera's. */
typedef struct view_planes {
  double normals[MOST_PLANES][3], offsets[MOST_PLANES];
  int count;
} view_planes;

/* The six of clip space, -w <= x, y <= w and 0 <= z <= w. */
static void clip_planes(view_planes *out, const plan_camera *camera) {
  double rows[4][4];
  for (int row = 0; row < 4; ++row) {
    const double *p = &camera->projection[row];
    for (int axis = 0; axis < 3; ++axis)
      rows[row][axis] = plan_dot((double[]){p[0], p[4], p[8]}, &camera->view[axis * 4]);
    rows[row][3] = p[12];
  }
  for (int plane = 0; plane < CLIP_PLANES; ++plane) {
    const double sign = plane & 1 ? -1.0 : 1.0, w = plane == 4 ? 0.0 : 1.0;
    for (int k = 0; k < 3; ++k)
      out->normals[plane][k] = w * rows[3][k] + sign * rows[plane / 2][k];
    out->offsets[plane] = w * rows[3][3] + sign * rows[plane / 2][3];
  }
  out->count = CLIP_PLANES;
}

/* Those of clip space, and of the view depth at which shadows end. */
static void shadow_planes(view_planes *out, const plan_camera *camera, double end) {
  const double float_rounding = 1.0 + 1e-6;
  clip_planes(out, camera);
  for (int axis = 0; axis < 3; ++axis)
    out->normals[out->count][axis] = -camera->forward[axis];
  out->offsets[out->count++] = end * float_rounding;
}

/* Relative to the camera's position. */
static void place_before(plan_placed *out, const plan_camera *camera, const plan_instance *instance,
                         const double center[3], const double extent[3]) {
  plan_place_box(out, instance, center, extent);
  for (int i = 0; i < 3; ++i)
    out->center[i] -= camera->position[i];
}

static bool outside_planes(const view_planes *planes, const plan_placed *box) {
  const double rounding = 1.0 + 1e-12;
  bool outside = false;
  for (int i = 0; i < planes->count && !outside; ++i) {
    const double *normal = planes->normals[i];
    outside = plan_dot(box->center, normal) + planes->offsets[i] < -rounding * plan_reach(box, normal);
  }
  return outside;
}

/* Whether an instance receives shadows and lies in sight; its box, too, where it receives. */
static bool is_seen(plan_placed *box, const view_planes *planes, const plan_camera *camera, const plan_scene *scene,
                    const plan_instance *instance) {
  if (!plan_receives(instance))
    return false;
  const plan_bounds *bounds = &scene->meshes[instance->mesh];
  place_before(box, camera, instance, bounds->center, bounds->extent);
  return !outside_planes(planes, box);
}

/* Receivers in sight, one after the other. */
typedef struct sight {
  const view_planes *planes;
  const plan_camera *camera;
  const plan_scene *scene;
  plan_walk walk;
  uint32_t place, end;
} sight;

/* Which of 64 boxes may hold something that is seen; with more room for rounding than an instance's own box has. */
static uint64_t meet_view(const void *with, const plan_bounds_block *bounds) {
  const sight *of = with;
  const double rounding = 1e-10, *eye = of->camera->position;
  uint64_t mask = 0;
  for (uint32_t i = 0; i < PLAN_BLOCK; ++i) {
    double at[3], reach[3];
    for (int axis = 0; axis < 3; ++axis) {
      const double middle = 0.5 * (bounds->low[axis][i] + bounds->high[axis][i]);
      const double half = 0.5 * (bounds->high[axis][i] - bounds->low[axis][i]);
      at[axis] = middle - eye[axis];
      reach[axis] = half + rounding * (fabs(middle) + half + fabs(eye[axis]));
    }
    bool outside = !(bounds->low[0][i] <= bounds->high[0][i]);
    for (int plane = 0; plane < of->planes->count && !outside; ++plane) {
      const double *normal = of->planes->normals[plane], offset = of->planes->offsets[plane];
      const double most = fabs(normal[0]) * reach[0] + fabs(normal[1]) * reach[1] + fabs(normal[2]) * reach[2];
      outside = plan_dot(at, normal) + offset < -(most + rounding * fabs(offset));
    }
    mask |= (uint64_t)!outside << i;
  }
  return mask;
}

/* `box` is the receiver's, before the camera. */
static bool next_seen(sight *of, uint32_t *slot, plan_placed *box) {
  for (;;) {
    while (of->place < of->end) {
      *slot = plan_slot_at(of->walk.order, of->place++);
      if (*slot < of->scene->slot_count &&
          is_seen(box, of->planes, of->camera, of->scene, &of->scene->instances[*slot]))
        return true;
    }
    uint32_t block;
    if (!plan_walk_next(&of->walk, &block))
      return false;
    of->place = block * PLAN_BLOCK;
    of->end = of->place + PLAN_BLOCK;
  }
}

/* From the first one on. */
static void look(sight *out, const view_planes *planes, const plan_camera *camera, const plan_scene *scene,
                 const plan_order *order) {
  *out = (sight){.planes = planes, .camera = camera, .scene = scene};
  out->walk = plan_walk_begin(order, scene->slot_count, meet_view, out);
}

bool plan_view_make(plan_list *out, const plan_camera *camera, const plan_scene *scene, const plan_cache *cache,
                    plan_memory *memory) {
  *out = (plan_list){0};
  plan_lists lists = {.lists = {out}, .count = 1, .among = scene->receiver_count};
  const plan_order order = plan_cache_order(cache, scene);
  view_planes planes;
  plan_placed box;
  sight of;
  clip_planes(&planes, camera);
  look(&of, &planes, camera, scene, &order);
  plan_lists_begin(&lists, memory);
  for (uint32_t slot; next_seen(&of, &slot, &box);)
    plan_lists_add(&lists, &(plan_found){.mask = 1, .slot = slot, .place = slot});
  if (!plan_lists_fit(&lists))
    return false;
  plan_lists_sort(&lists, &order);
  plan_lists_end(&lists, scene);
  return true;
}

bool plan_sees_receivers(const plan_camera *camera, const plan_scene *scene, const plan_order *order, double end) {
  view_planes planes;
  plan_placed box;
  sight of;
  uint32_t slot;
  shadow_planes(&planes, camera, end);
  look(&of, &planes, camera, scene, order);
  return scene->receiver_count && next_seen(&of, &slot, &box);
}

/* ---- cells of maps ---- */

/* Cells that a box meets: rows from the first to the last, and in each of them these columns. */
typedef struct cell_rect {
  uint32_t first, last, count;
  uint64_t columns;
} cell_rect;

static inline bool find_cells(cell_rect *out, const plan_cells *cells, const double low[2], const double high[2]) {
  uint32_t from[2], to[2];
  for (int axis = 0; axis < 2; ++axis) {
    const double first = (low[axis] - cells->begin[axis]) / cells->size[axis];
    const double last = (high[axis] - cells->begin[axis]) / cells->size[axis];
    if (!(first < PLAN_CELLS) || !(last >= 0.0))
      return false;
    from[axis] = first > 0.0 ? (uint32_t)first : 0;
    to[axis] = last < PLAN_CELLS ? (uint32_t)last : PLAN_CELLS - 1;
  }
  out->first = from[1];
  out->last = to[1];
  out->count = (to[1] - from[1] + 1) * (to[0] - from[0] + 1);
  out->columns = UINT64_MAX >> (PLAN_CELLS - 1 - (to[0] - from[0])) << from[0];
  return true;
}

void plan_cells_lay(plan_cells *out, const plan_area *area) {
  *out = (plan_cells){0};
  for (int axis = 0; axis < 2; ++axis) {
    out->begin[axis] = area->min[axis];
    out->size[axis] = (area->max[axis] - area->min[axis]) / PLAN_CELLS;
  }
}

void plan_cells_add(plan_cells *cells, const double low[2], const double high[2]) {
  cell_rect rect;
  if (find_cells(&rect, cells, low, high))
    for (uint32_t y = rect.first; y <= rect.last; ++y)
      cells->read[y] |= rect.columns;
}

bool plan_cells_meet(const plan_cells *cells, const double low[2], const double high[2]) {
  cell_rect rect;
  bool meets = false;
  if (find_cells(&rect, cells, low, high))
    for (uint32_t y = rect.first; y <= rect.last; ++y)
      meets |= (cells->read[y] & rect.columns) != 0;
  return meets;
}

static bool lies_over_few(const cell_rect *rect) {
  return rect->count <= 2;
}

bool plan_cells_meet_some(const plan_cells *cells, const double low[2], const double high[2]) {
  cell_rect rect;
  bool all = true;
  if (!find_cells(&rect, cells, low, high) || lies_over_few(&rect))
    return false;
  for (uint32_t y = rect.first; y <= rect.last && all; ++y)
    all = (cells->read[y] & rect.columns) == rect.columns;
  return !all;
}

/* Who reads a map. */
typedef struct reader {
  plan_cells *cells;
  double depths[2];                             /* receivers between these view depths */
  double room;                                  /* so many metres around them */
  double held[2];                               /* what lies between, along the light, is in the map's range */
  uint64_t seen[PLAN_CELLS];                    /* cells that the camera's sight meets, with that room */
  uint64_t finer[CSM_MAX_CASCADES][PLAN_CELLS]; /* those that a finer map, by cascade, holds with that room */
} reader;

/* What the readers of a frame follow from. */
typedef struct reading {
  const plan_frame *frame;
  const plan_area *areas;
  const csm_config *config;
  bool narrowed;                    /* a map may be narrower than its slice */
  double borders[CSM_MAX_CASCADES]; /* of each map: see find_border */
} reading;

static double largest_texel(const plan_cascade *cascade) {
  return fmax(cascade->texel[0], cascade->texel[1]);
}

/* A shader computes view depths in floats. */
static double depth_rounding(double depth) {
  return 1e-4 * fabs(depth);
}

/*
 * View depths of receivers that read a cascade's map. By intervals it is read from its slice's begin on, and from the
 * band before that blends with it; before that only where the slice's own map does not hold what lies in it.
 */
static void find_depths(double depths[2], const reading *of, uint32_t cascade) {
  const plan_frame *frame = of->frame;
  const csm_cascade_info *last = &frame->cascades[frame->cascade_count - 1].info;
  const bool by_interval = of->config->selection == CSM_SELECT_INTERVAL;
  const double end = by_interval ? frame->cascades[cascade].info.far_depth : last->far_depth;
  depths[0] = frame->camera.near_depth;
  depths[1] = end + depth_rounding(end);
  if (!by_interval || of->narrowed || cascade == 0)
    return;
  const csm_cascade_info *before = &frame->cascades[cascade - 1].info;
  const double share = of->config->blend_mode == CSM_BLEND_OFF ? 0.0 : of->config->blend_share;
  const double begin = before->far_depth - share * (before->far_depth - before->near_depth);
  depths[0] = fmax(depths[0], begin - depth_rounding(before->far_depth));
}

/* Within so many metres of its border a map may not be taken, or another one blends with it. */
static double find_border(const reading *of, uint32_t cascade) {
  const plan_cascade *map = &of->frame->cascades[cascade];
  const double band = of->config->blend_mode == CSM_BLEND_OFF ? 0.0 : of->config->blend_share * map->resolution / 2.0;
  return largest_texel(map) * (plan_padding_texels(of->config) + 1.0 + band);
}

/* Whether each cascade's map is clearly finer than the next one's, so that the first one that holds a receiver is the
 * finest. */
static bool coarsen(const reading *of) {
  bool coarsen = of->config->selection != CSM_SELECT_INTERVAL;
  for (uint32_t i = 1; i < of->frame->cascade_count && coarsen; ++i) {
    const double *fine = of->frame->cascades[i - 1].texel, *coarse = of->frame->cascades[i].texel;
    coarsen = coarse[0] * coarse[1] > (1.0 + 1e-5) * fine[0] * fine[1];
  }
  return coarsen;
}

static bool within(const plan_area *area, const double low[2], const double high[2], double room) {
  return low[0] - room >= area->min[0] && high[0] + room <= area->max[0] && low[1] - room >= area->min[1] &&
         high[1] + room <= area->max[1];
}

static void cell_box(double low[2], double high[2], const plan_cells *cells, const uint32_t at[2]) {
  for (int axis = 0; axis < 2; ++axis) {
    low[axis] = cells->begin[axis] + at[axis] * cells->size[axis];
    high[axis] = low[axis] + cells->size[axis];
  }
}

static void note_cell(reader *out, const reading *of, const plan_hull *hull, uint32_t finer, const uint32_t at[2]) {
  double low[2], high[2];
  cell_box(low, high, out->cells, at);
  out->seen[at[1]] |= (uint64_t)!plan_outside_hull(hull, low, high) << at[0];
  for (uint32_t i = 0; i < finer; ++i)
    out->finer[i][at[1]] |= (uint64_t)within(&of->areas[i], low, high, out->room + of->borders[i]) << at[0];
}

/* What lies in a map's range along the light, but for what is near its ends. */
static void find_held(double held[2], const reading *of, uint32_t cascade) {
  const plan_cascade *map = &of->frame->cascades[cascade];
  const double scale = map->to_clip[10], offset = map->to_clip[11];
  const double ends[2] = {-offset / scale, (1.0 - offset) / scale};
  held[0] = fmin(ends[0], ends[1]) + map->shift + of->borders[cascade];
  held[1] = fmax(ends[0], ends[1]) - of->borders[cascade];
}

static void make_reader(reader *out, plan_cells *cells, const reading *of, uint32_t cascade) {
  const plan_area *area = &of->areas[cascade];
  const double texel = largest_texel(&of->frame->cascades[cascade]);
  *out = (reader){.cells = cells, .room = texel * plan_view_room_texels(of->config, cascade)};
  find_held(out->held, of, cascade);
  plan_cells_lay(cells, area);
  find_depths(out->depths, of, cascade);
  plan_hull hull;
  plan_view_hull(&hull, &of->frame->camera, of->frame->basis, out->depths, out->room);
  const uint32_t finer = coarsen(of) ? cascade : 0;
  for (uint32_t y = 0; y < PLAN_CELLS; ++y)
    for (uint32_t x = 0; x < PLAN_CELLS; ++x)
      note_cell(out, of, &hull, finer, (uint32_t[]){x, y});
}

static void find_box(plan_receiver_box *out, const plan_frame *frame, const plan_placed *placed) {
  for (int axis = 0; axis < 3; ++axis) {
    const double *direction = &frame->basis[axis * 3];
    const double middle = plan_dot(placed->center, direction) + plan_dot(frame->camera.position, direction);
    const double reach = plan_reach(placed, direction);
    out->low[axis] = middle - reach;
    out->high[axis] = middle + reach;
  }
  const double depth = plan_dot(placed->center, frame->camera.forward);
  const double reach = plan_reach(placed, frame->camera.forward);
  out->depths[0] = depth - reach;
  out->depths[1] = depth + reach;
}

/* The cells of a map that may be read for what lies in a box; false: none. */
static bool find_reach(cell_rect *out, const reader *to, const plan_receiver_box *box) {
  const double low[2] = {box->low[0] - to->room, box->low[1] - to->room};
  const double high[2] = {box->high[0] + to->room, box->high[1] + to->room};
  return box->depths[0] <= to->depths[1] && box->depths[1] >= to->depths[0] && find_cells(out, to->cells, low, high);
}

/* Marks the cells that are read for what lies in a box; a finer map that holds all of it along the light is read in
 * its stead. */
static void mark(const reader *readers, uint32_t count, const plan_receiver_box *box) {
  bool held[CSM_MAX_CASCADES];
  for (uint32_t i = 0; i < count; ++i) {
    const reader *to = &readers[i];
    cell_rect rect;
    held[i] = box->low[2] >= to->held[0] && box->high[2] <= to->held[1];
    if (!find_reach(&rect, to, box))
      continue;
    for (uint32_t y = rect.first; y <= rect.last; ++y) {
      uint64_t read = to->seen[y] & rect.columns;
      for (uint32_t k = 0; k < i; ++k)
        read &= held[k] ? ~to->finer[k][y] : UINT64_MAX;
      to->cells->read[y] |= read;
    }
  }
}

/* Whether a box lies over so many cells of a map that it is worth looking at its parts. */
static bool lies_over_many(const reader *readers, uint32_t count, const plan_receiver_box *box) {
  bool many = false;
  cell_rect rect;
  for (uint32_t i = 0; i < count && !many; ++i)
    many = find_reach(&rect, &readers[i], box) && !lies_over_few(&rect);
  return many;
}

/* Marks what is read for those parts of a receiver that are seen. */
static void mark_parts(const reader *readers, const plan_frame *frame, const view_planes *planes,
                       const plan_instance *instance, const plan_parts *parts) {
  for (uint32_t i = 0; i < parts->count; ++i) {
    plan_placed placed;
    plan_receiver_box box;
    place_before(&placed, &frame->camera, instance, parts->parts[i].center, parts->parts[i].extent);
    if (outside_planes(planes, &placed))
      continue;
    find_box(&box, frame, &placed);
    mark(readers, frame->cascade_count, &box);
  }
}

/* Those who read the maps of a frame. */
typedef struct readers {
  reader readers[CSM_MAX_CASCADES];
  uint32_t count;
} readers;

static void mark_seen(void *user, const plan_receiver_box *box) {
  const readers *all = user;
  mark(all->readers, all->count, box);
}

static void mark_receivers(const readers *all, const plan_frame *frame, const plan_scene *scene,
                           const plan_order *order, double end) {
  view_planes planes;
  plan_placed placed;
  sight of_camera;
  shadow_planes(&planes, &frame->camera, end);
  look(&of_camera, &planes, &frame->camera, scene, order);
  for (uint32_t slot; next_seen(&of_camera, &slot, &placed);) {
    plan_receiver_box box;
    const plan_instance *instance = &scene->instances[slot];
    find_box(&box, frame, &placed);
    const plan_parts parts = plan_parts_of(scene, instance);
    if (parts.count && lies_over_many(all->readers, all->count, &box))
      mark_parts(all->readers, frame, &planes, instance, &parts);
    else
      mark(all->readers, all->count, &box);
  }
}

void plan_read_cells(plan_cells *cells, const plan_frame *frame, const plan_area *areas, const plan_order *order,
                     const plan_frame_info *info) {
  reading of = {.frame = frame,
                .areas = areas,
                .config = info->config,
                .narrowed = info->sample_count || frame->camera.orthographic};
  readers all = {.count = frame->cascade_count};
  for (uint32_t i = 0; i < frame->cascade_count; ++i)
    of.borders[i] = find_border(&of, i);
  for (uint32_t i = 0; i < frame->cascade_count; ++i)
    make_reader(&all.readers[i], &cells[i], &of, i);
  const double end = frame->cascades[frame->cascade_count - 1].info.far_depth;
  if (info->seen)
    plan_seen_walk(info->seen, frame, end + depth_rounding(end), &(plan_box_sink){.take = mark_seen, .user = &all});
  else
    mark_receivers(&all, frame, info->scene, order, end);
}

void plan_seen_cells(plan_cells *cells, const plan_frame *frame, const plan_area *areas, const csm_config *config) {
  const double depths[2] = {frame->camera.near_depth, frame->cascades[frame->cascade_count - 1].info.far_depth};
  for (uint32_t i = 0; i < frame->cascade_count; ++i) {
    plan_hull hull = {0};
    const double room = largest_texel(&frame->cascades[i]) * plan_view_room_texels(config, i);
    plan_cells_lay(&cells[i], &areas[i]);
    if (config->caster_set == CSM_CASTER_SET_VIEW)
      plan_view_hull(&hull, &frame->camera, frame->basis, depths, room);
    for (uint32_t y = 0; y < PLAN_CELLS; ++y)
      for (uint32_t x = 0; x < PLAN_CELLS; ++x) {
        double low[2], high[2];
        cell_box(low, high, &cells[i], (uint32_t[]){x, y});
        cells[i].read[y] |= (uint64_t)!plan_outside_hull(&hull, low, high) << x;
      }
  }
}
