#include "bench/pages.h"
#include "base/host.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { WHOLE, PAGES, SIDES };

/* From one frame to the next. */
typedef struct movement {
  const char *name;
  bool all;                              /* every instance changes */
  double forward_m, turn_deg, light_deg; /* by which camera and light go on */
  double moved;                          /* the share of the instances that move up and down */
} movement;

static const movement movements[PAGES_CASES] = {
    {.name = "all changes", .all = true},
    {.name = "nothing moves"},
    {.name = "2 m ahead", .forward_m = 2.0},
    {.name = "10 m ahead", .forward_m = 10.0},
    {.name = "turning 2 deg", .turn_deg = 2.0},
    {.name = "turning 10 deg", .turn_deg = 10.0},
    {.name = "5 % of the casters move", .moved = 0.05},
    {.name = "the sun moves 0.01 deg", .light_deg = 0.01},
};

typedef struct side {
  host_setup setup; /* as the stage's, but for its configuration */
  stage stage;
  double *frame_ms, *plan_ms;
  double pages, valid, triangles; /* of the case's frames so far */
} side;

/* ---- what moves ---- */

/* Whether an instance may move: no ground. */
static bool moves(const scene *scene, size_t instance) {
  const scene_mesh *mesh = &scene->meshes[scene->instances[instance].mesh];
  double most = 0.0;
  for (uint32_t i = 0; i < 3 * mesh->vertex_count; ++i)
    most = fmax(most, fabs((double)mesh->positions[i]));
  return most < 20.0;
}

/* So many of the instances, spread over all, are half a metre higher in every second frame. */
static csm_result move_some(stage *s, double share, uint32_t frame) {
  const scene *scene = &s->setup->scene;
  const size_t count = (size_t)((double)scene->instance_count * share);
  csm_instance_id *ids = host_allocate(count, sizeof *ids);
  double(*places)[16] = host_allocate(count, sizeof *places);
  for (size_t i = 0; i < count; ++i) {
    size_t from = i * scene->instance_count / count;
    while (!moves(scene, from))
      from = (from + 1) % scene->instance_count;
    ids[i] = s->instances[from];
    memcpy(places[i], scene->instances[from].transform, sizeof places[i]);
    places[i][13] += 0.5 * (frame % 2);
  }
  const csm_scene_batch batch = {
      .struct_size = sizeof batch, .count = (uint32_t)count, .ids = ids, .matrices = places[0]};
  const csm_result result = csm_scene_move(s->scene, &batch);
  free(places);
  free(ids);
  return result;
}

/* ---- frames ---- */

static void count(side *o, const csm_stats *stats) {
  o->pages += stats->pages_drawn;
  o->valid += stats->pages_valid;
  for (uint32_t i = 0; i < stats->cascade_count; ++i)
    o->triangles += (double)stats->cascades[i].triangles_drawn;
}

static int draw(side *o, const movement *m, uint32_t frame) {
  stage *s = &o->stage;
  const camera eye = camera_moved(&o->setup.camera, m->forward_m * frame, 0.0, m->turn_deg * frame);
  const scene_light light = scene_light_turned(&o->setup.light, m->light_deg * frame);
  if ((m->all && stage_stir(s)) || (m->moved > 0.0 && move_some(s, m->moved, frame)))
    return host_fail(HOST_NO_DEVICE, "%s: %s", s->backend, csm_last_error(s->context));
  stage_look(s, &eye);
  s->light = stage_light(&light);
  csm_stats stats = {.struct_size = sizeof stats};
  const double start_ms = host_now_ms();
  const int code = stage_render(s);
  o->frame_ms[frame] = host_now_ms() - start_ms;
  csm_get_stats(s->cascades, &stats);
  o->plan_ms[frame] = stats.plan_ms;
  if (frame > 0)
    count(o, &stats);
  return code;
}

/* The first frame is no movement. */
static int draw_case(bench_pages_case *out, side sides[SIDES], const movement *m, uint32_t frames) {
  int code = 0;
  host_progress(m->name);
  for (int i = 0; i < SIDES; ++i)
    sides[i].pages = sides[i].valid = sides[i].triangles = 0.0;
  for (uint32_t frame = 0; frame <= frames && code == 0; ++frame)
    for (int i = 0; i < SIDES && code == 0; ++i)
      code = draw(&sides[i], m, frame);
  host_progress("");
  if (code)
    return code;
  const double *whole = sides[WHOLE].frame_ms + 1, *pages = sides[PAGES].frame_ms + 1;
  *out = (bench_pages_case){.name = m->name,
                            .whole_ms = estimate_median(whole, frames),
                            .pages_ms = estimate_median(pages, frames),
                            .ratio = estimate_ratio(pages, whole, frames),
                            .plan_ms = estimate_median(sides[PAGES].plan_ms + 1, frames).median,
                            .pages = sides[PAGES].pages / frames,
                            .valid = sides[PAGES].valid / frames,
                            .triangles = sides[PAGES].triangles / frames,
                            .whole_triangles = sides[WHOLE].triangles / frames};
  for (uint32_t i = 0; i < frames; ++i)
    out->worst = fmax(out->worst, pages[i] / out->whole_ms.median);
  return 0;
}

static int open_side(side *o, int which, const stage *like, const char *device, uint32_t frames) {
  csm_config *config = &o->setup.config;
  o->setup = *like->setup;
  o->frame_ms = host_allocate(frames + 1, sizeof(double));
  o->plan_ms = host_allocate(frames + 1, sizeof(double));
  if (which == PAGES) {
    config->map_layout = CSM_LAYOUT_PAGES;
    config->caster_set = CSM_CASTER_SET_VIEW;
  }
  const int code = stage_open_as(&o->stage, like->backend, device, 0);
  return code ? code : stage_load(&o->stage, &o->setup);
}

int bench_pages_run(bench_pages *out, const stage *s, const char *device, uint32_t frames) {
  side *sides = host_allocate(SIDES, sizeof *sides);
  int code = 0;
  *out = (bench_pages){.backend = s->backend, .frames = frames};
  for (int i = 0; i < SIDES && code == 0; ++i)
    code = open_side(&sides[i], i, s, device, frames);
  for (int i = 0; i < PAGES_CASES && code == 0; ++i)
    code = draw_case(&out->cases[i], sides, &movements[i], frames);
  for (int i = 0; i < SIDES; ++i) {
    stage_close(&sides[i].stage);
    free(sides[i].frame_ms);
    free(sides[i].plan_ms);
  }
  free(sides);
  return code;
}

/* ---- results ---- */

void bench_pages_print(FILE *to, const bench_pages *pages) {
  fprintf(to, "\n  pages, %s: a frame of maps, planned, drawn and waited for, to whole maps; %u frames in turn\n",
          pages->backend, pages->frames);
  fprintf(to, "  %-24s %8s %8s %7s  %-16s %7s %7s %11s %15s\n", "", "whole ms", "pages ms", "ratio", "95 % interval",
          "worst", "plan ms", "pages", "triangles, k");
  for (int i = 0; i < PAGES_CASES; ++i) {
    const bench_pages_case *c = &pages->cases[i];
    fprintf(to, "  %-24s %8.2f %8.2f %7.4f  %.4f .. %.4f %7.4f %7.3f %5.0f /%5.0f %6.0f /%7.0f\n", c->name,
            c->whole_ms.median, c->pages_ms.median, c->ratio.median, c->ratio.low, c->ratio.high, c->worst, c->plan_ms,
            c->pages, c->valid, 1e-3 * c->triangles, 1e-3 * c->whole_triangles);
  }
}

json_t *bench_pages_to_json(const bench_pages *pages) {
  json_t *object = json_object();
  json_object_set_new(object, "backend", json_string(pages->backend));
  json_object_set_new(object, "frames", json_integer(pages->frames));
  for (int i = 0; i < PAGES_CASES; ++i) {
    const bench_pages_case *c = &pages->cases[i];
    json_object_set_new(object, c->name,
                        json_pack("{s:o,s:o,s:o,s:f,s:f,s:f,s:f,s:f,s:f}", "whole_ms", estimate_to_json(&c->whole_ms),
                                  "pages_ms", estimate_to_json(&c->pages_ms), "pages/whole",
                                  estimate_to_json(&c->ratio), "worst", c->worst, "plan_ms", c->plan_ms, "pages",
                                  c->pages, "valid", c->valid, "triangles", c->triangles, "whole_triangles",
                                  c->whole_triangles));
  }
  return object;
}
