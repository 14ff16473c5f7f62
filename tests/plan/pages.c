/* Pages that a plan says are valid hold what they would if they were drawn, whatever moved since they were. */
#include "world.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { cascades = CSM_MAX_CASCADES, resolution = 256, page_texels = resolution / PLAN_CELLS };

/* ---- what would lie in the maps ---- */

/* A page as it was drawn: where it lies across the light, in metres, and in which revision it got each caster; 0: not. */
typedef struct painted {
  bool any;
  double low[2], high[2], depth[2], basis[9];
  uint64_t casters[2 * WORLD_MOST];
} painted;

typedef painted layers[cascades][PLAN_CELLS][PLAN_CELLS]; /* row, column */

typedef struct maps {
  layers shown, still; /* still: without what keeps moving */
} maps;

/* Where the page of a slot lies, by the map's place on its grid. */
static void lay_page(painted *out, const plan_frame *frame, uint32_t cascade, uint32_t row, uint32_t column) {
  const plan_cascade *of = &frame->cascades[cascade];
  const uint32_t right = (column - of->begin_texels[0] / page_texels) & (PLAN_CELLS - 1);
  const uint32_t down = (row - of->begin_texels[1] / page_texels) & (PLAN_CELLS - 1);
  out->low[0] = (of->origin_texels[0] + right * page_texels) * of->texel[0];
  out->high[0] = out->low[0] + page_texels * of->texel[0];
  out->high[1] = (of->origin_texels[1] + resolution - down * page_texels) * of->texel[1];
  out->low[1] = out->high[1] - page_texels * of->texel[1];
  out->depth[0] = of->to_clip[10];
  out->depth[1] = of->to_clip[11];
  memcpy(out->basis, frame->basis, sizeof out->basis);
}

/* Where a caster lies across the light. */
typedef struct lit_box {
  double low[2], high[2];
} lit_box;

static void lay_boxes(lit_box *out, const plan_frame *frame, const plan_scene *scene) {
  for (uint32_t slot = 0; slot < scene->slot_count; ++slot) {
    out[slot] = (lit_box){{INFINITY, INFINITY}, {-INFINITY, -INFINITY}};
    for (int corner = 0; corner < 8 && plan_casts(&scene->instances[slot]); ++corner) {
      double point[3];
      instance_point(scene, slot, (double[]){corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1}, point);
      for (int axis = 0; axis < 2; ++axis) {
        const double *way = &frame->basis[axis * 3], at = way[0] * point[0] + way[1] * point[1] + way[2] * point[2];
        out[slot].low[axis] = fmin(out[slot].low[axis], at);
        out[slot].high[axis] = fmax(out[slot].high[axis], at);
      }
    }
  }
}

/* By how much a caster reaches over a page, in metres; below 0: it lies beside it. */
static double reach_over(const painted *page, const lit_box *box) {
  double reach = INFINITY;
  for (int axis = 0; axis < 2; ++axis)
    reach = fmin(reach, fmin(box->high[axis] - page->low[axis], page->high[axis] - box->low[axis]));
  return reach;
}

static void clear_page(layers to, const plan_frame *frame, uint32_t cascade, uint32_t row, uint32_t column) {
  painted *page = &to[cascade][row][column];
  *page = (painted){.any = true};
  lay_page(page, frame, cascade, row, column);
}

/* What is there before anything is drawn: what the second layer takes over, and what is cleared. */
static void clear(maps *to, const plan_frame *frame) {
  for (uint32_t c = 0; c < cascades; ++c)
    for (uint32_t row = 0; row < PLAN_CELLS; ++row)
      for (uint32_t column = 0; column < PLAN_CELLS; ++column) {
        const plan_cascade *of = &frame->cascades[c];
        const uint64_t bit = 1ull << column;
        assert_int_equal((of->saved[row] | of->still_due[row]) & ~of->copied[row], 0);
        assert_int_equal((of->saved[row] & of->still_due[row]) | (of->copied[row] & ~of->due[row]), 0);
        if (of->saved[row] & bit)
          to->still[c][row][column] = to->shown[c][row][column];
        if (of->still_due[row] & bit)
          clear_page(to->still, frame, c, row, column);
        if (of->due[row] & ~of->copied[row] & bit)
          clear_page(to->shown, frame, c, row, column);
      }
}

static void copy(maps *to, const plan_frame *frame) {
  for (uint32_t c = 0; c < cascades; ++c)
    for (uint32_t row = 0; row < PLAN_CELLS; ++row)
      for (uint32_t column = 0; column < PLAN_CELLS; ++column)
        if (frame->cascades[c].copied[row] >> column & 1)
          to->shown[c][row][column] = to->still[c][row][column];
}

/* A window's list goes into all slots of its rectangle, as a scissor lets it. */
static void draw(maps *to, const plan_frame *frame, plan_window_kind kind, const plan_scene *scene,
                 const lit_box *boxes) {
  for (uint32_t w = 0; w < frame->window_count; ++w) {
    const plan_window *window = &frame->windows[w];
    const uint32_t *slots = window->slots;
    if (window->kind != kind)
      continue;
    for (uint32_t row = slots[1]; row < slots[1] + slots[3]; ++row)
      for (uint32_t column = slots[0]; column < slots[0] + slots[2]; ++column) {
        painted(*layer)[PLAN_CELLS] = (kind == PLAN_WINDOW_STILL ? to->still : to->shown)[window->cascade];
        painted *page = &layer[row][column], now;
        lay_page(&now, frame, window->cascade, row, column);
        for (uint32_t i = 0; i < window->list.instance_count && page->any; ++i) {
          const uint32_t slot = window->list.instances[i];
          if (reach_over(&now, &boxes[slot]) > 0.0 && page->casters[slot] != scene->revisions[slot])
            page->casters[slot] = page->casters[slot] ? UINT64_MAX : scene->revisions[slot];
        }
      }
  }
}

/* ---- what should ---- */

/* `now`: where it should lie. */
static void check_page(const painted *page, const painted *now, double rounding, const plan_scene *scene,
                       const lit_box *boxes) {
  assert_true(page->any);
  assert_memory_equal(page->basis, now->basis, sizeof now->basis);
  assert_memory_equal(page->depth, now->depth, sizeof now->depth);
  for (int axis = 0; axis < 2; ++axis) {
    assert_near(page->low[axis], now->low[axis], rounding);
    assert_near(page->high[axis], now->high[axis], rounding);
  }
  for (uint32_t slot = 0; slot < scene->slot_count; ++slot) {
    const double reach = reach_over(now, &boxes[slot]);
    const uint64_t holds = page->casters[slot];
    if ((reach > rounding && holds != scene->revisions[slot]) || (reach < -rounding && holds))
      fail_msg("caster %u of revision %llu is there as of %llu", slot, (unsigned long long)scene->revisions[slot],
               (unsigned long long)holds);
  }
}

static void check_valid(const maps *of, const plan_frame *frame, const plan_scene *scene, const lit_box *boxes) {
  for (uint32_t c = 0; c < cascades; ++c)
    for (uint32_t row = 0; row < PLAN_CELLS; ++row)
      for (uint32_t column = 0; column < PLAN_CELLS; ++column)
        if (frame->cascades[c].valid[row] >> column & 1) {
          painted now;
          lay_page(&now, frame, c, row, column);
          check_page(&of->shown[c][row][column], &now, 1e-6 * frame->cascades[c].texel[0], scene, boxes);
        }
}

/* ---- frames ---- */

/* A walk with turns and jumps. */
static void walk(test_camera *camera, random_state *random, int frame) {
  static const double scales[] = {0.0, 0.1, 1.0, 10.0};
  const double far = scales[random_below(random, 4)];
  for (int axis = 0; axis < 3; ++axis)
    camera->eye[axis] = fmin(fmax(camera->eye[axis] + far * random_between(random, -1.0, 1.0), -60.0), 60.0);
  if (frame % 5 == 0) {
    double forward[3];
    random_unit(random, forward);
    camera_look(camera, forward, 0.0);
  }
}

static csm_config pages_config(void) {
  csm_config config = default_config();
  config.map_layout = CSM_LAYOUT_PAGES;
  config.cascade_count = cascades;
  config.resolution = resolution;
  config.shadow_distance = 80.0;
  return config;
}

typedef struct walker {
  world world;
  maps maps;
  lit_box boxes[2 * WORLD_MOST];
  plan_cache cache;
  plan_history history;
  test_camera camera;
  double light[3];
  uint32_t drawn, kept, copied, saved, still_drawn, came_to_rest;
} walker;

static uint32_t count(const uint64_t rows[PLAN_CELLS]) {
  uint32_t bits = 0;
  for (uint32_t row = 0; row < PLAN_CELLS; ++row)
    bits += (uint32_t)__builtin_popcountll(rows[row]);
  return bits;
}

static void count_pages(walker *w, const plan_frame *frame) {
  for (uint32_t c = 0; c < cascades; ++c) {
    const plan_cascade *of = &frame->cascades[c];
    w->drawn += count(of->due);
    w->kept += count(of->valid) - count(of->due);
    w->copied += count(of->copied);
    w->saved += count(of->saved);
    w->still_drawn += count(of->still_due);
  }
}

/* Some frames are planned, and then come to nothing; some find other images than those that they left. */
static void one_frame(walker *w, int frame) {
  random_state *random = &w->world.random;
  csm_config config = pages_config();
  double view[16], projection[16];
  const char *error = "";
  plan_frame made;
  const plan_scene scene = instances_scene(&w->world.store, &w->world.meshes);
  config.caster_set = (uint32_t)frame / 20 % 2;
  if (random_below(random, 5) == 0) /* its end lies before the near plane */
    config.shadow_distance = 0.05;
  camera_matrices(&w->camera, view, projection);
  const plan_frame_info info = {.config = &config,
                                .view = view,
                                .projection = projection,
                                .light = w->light,
                                .scene = &scene,
                                .cache = &w->cache,
                                .before = &w->history,
                                .all_receivers = frame / 40 % 2,
                                .maps_kept = random_below(random, 30) != 0};
  if (!info.maps_kept)
    memset(&w->maps, 0, sizeof w->maps);
  const uint32_t movers = w->cache.movers;
  if (plan_traced(&made, &info, w->world.memory[0], &error))
    fail_msg("%s", error);
  w->came_to_rest += w->cache.movers < movers;
  if (random_below(random, 4) == 0 && info.maps_kept)
    return;
  clear(&w->maps, &made);
  lay_boxes(w->boxes, &made, &scene);
  draw(&w->maps, &made, PLAN_WINDOW_STILL, &scene, w->boxes);
  draw(&w->maps, &made, PLAN_WINDOW_ALL, &scene, w->boxes);
  copy(&w->maps, &made);
  draw(&w->maps, &made, PLAN_WINDOW_MOVING, &scene, w->boxes);
  check_valid(&w->maps, &made, &scene, w->boxes);
  w->history = made.history;
  count_pages(w, &made);
}

static void stretch(world *w, float away) {
  plan_bounds_make(&w->bounds[0], (float[]){-1, away, -1}, (float[]){1, away + 1.0f, 1});
  instances_mesh_changed(&w->store, &w->meshes, 0);
}

/* `reach`: of the world. */
static void check_walk(uint64_t seed, double reach, int frames) {
  static const double lights[3][3] = {{0.3, -1.0, 0.2}, {0.301, -1.0, 0.2}, {-1.0, -0.5, 0.4}};
  walker *w = calloc(1, sizeof *w);
  world_begin(&w->world, seed);
  w->world.reach = reach;
  w->camera = plain_camera();
  memcpy(w->light, lights[0], sizeof w->light);
  for (int frame = 0; frame < frames; ++frame) {
    random_state *random = &w->world.random;
    for (uint32_t n = frame < 5 ? 3 : random_below(random, 3) / 2; n; --n)
      world_change(&w->world);
    if (random_below(random, 7) == 0) /* there and back, too */
      memcpy(w->light, lights[random_below(random, 3)], sizeof w->light);
    if (frame % 40 == 39) /* the scene's range along the light grows, or shrinks */
      stretch(&w->world, frame % 80 == 39 ? 400.0f : 0.0f);
    walk(&w->camera, random, frame);
    world_reserve_cache(&w->cache, w->world.store.ids.count);
    one_frame(w, frame);
  }
  assert_true(w->drawn > 250 * (uint32_t)frames && w->kept > 250 * (uint32_t)frames);
  assert_true(w->copied > 1000 && w->saved > 1000 && w->still_drawn > 1000 && w->came_to_rest > 3);
  free(w->cache.memory);
  world_end(&w->world);
  free(w);
}

static void valid_pages_hold_what_they_would(void **state) {
  (void)state;
  check_walk(11, 60.0, 400);
}

/* Much lies, moves and comes from beyond all maps, in blocks that no plan has looked at. */
static void valid_pages_hold_what_comes_from_afar(void **state) {
  (void)state;
  check_walk(12, 200.0, 160);
}

/* ---- rectangles ---- */

/* Every slot is in one of them, once. */
static void rectangles_hold_each_slot_once(void **state) {
  (void)state;
  random_state random = {3};
  for (int i = 0; i < 200; ++i) {
    uint64_t rows[PLAN_CELLS], left[PLAN_CELLS], seen[PLAN_CELLS] = {0};
    uint32_t slots[4];
    for (int y = 0; y < PLAN_CELLS; ++y)
      rows[y] = i == 0 ? UINT64_MAX : i % 2 ? random_bits(&random) & random_bits(&random) : random_bits(&random) << 40;
    memcpy(left, rows, sizeof left);
    while (plan_next_slots(slots, left))
      for (uint32_t y = slots[1]; y < slots[1] + slots[3]; ++y)
        for (uint32_t x = slots[0]; x < slots[0] + slots[2]; ++x) {
          assert_false(seen[y] >> x & 1);
          seen[y] |= 1ull << x;
        }
    assert_memory_equal(seen, rows, sizeof rows);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(valid_pages_hold_what_they_would),
      cmocka_unit_test(valid_pages_hold_what_comes_from_afar),
      cmocka_unit_test(rectangles_hold_each_slot_once),
  };
  return cmocka_run_group_tests_name("plan-pages", tests, NULL, NULL);
}
