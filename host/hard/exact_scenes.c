/*
 * exact_scenes.c: the host's scenes under nine lights down to a degree: how much is wrong where maps decide what they do
 * not know.
 */
#include "base/host.h"
#include "hard/exact.h"
#include <math.h>

enum { WIDTH = 320, HEIGHT = 180, LIGHTS = 9 };

/* What decides, and with which normals. */
enum { ENGINE_NORMALS = EXACT_WAYS, WAYS };

static const char *name_of(int way) {
  return way == ENGINE_NORMALS ? "maps and rays, the engine's normals" : exact_ways[way];
}

typedef struct known_scene {
  const char *name;
  double wrong, wrong_normals; /* share of 1280 x 720 pixels: with normals from the depth, and with the engine's */
} known_scene;

static const known_scene scenes[] = {{"town", 0.0002, 0.0002}, {"valley", 0.0010, 0.0012}};

static int load_scene(hard_run *run, host_setup *out, const char *name) {
  hard_setup_begin(out, WIDTH, HEIGHT);
  const int code = scene_load(&out->scene, name);
  if (code)
    return code;
  camera_from_pose(&out->camera, &out->scene.camera, (double)WIDTH / HEIGHT);
  hard_reach(out, out->scene.shadow_distance);
  exact_set(&out->config, EXACT_MAPS); /* an engine's device keeps it */
  return hard_load(run, out);
}

/*
 * Pixels at edges are as many times more of a picture as it is less wide, so that the shares of wrong pixels are
 * times four here. What is far from all edges does not change with the size.
 */
static void add_figures(hard_run *run, const known_scene *of, int way, const metrics *m) {
  const double larger = 1280.0 / WIDTH;
  const double most = (way == ENGINE_NORMALS ? of->wrong_normals : of->wrong) * larger;
  hard_figure_add(run, (m->false_lit + m->false_shadow) / most, 1.0, "1", "wrong pixels of %s, of what they may be, %s",
                  of->name, name_of(way));
  hard_figure_add(run, m->acne, INFINITY, "1", "acne of %s, %s", of->name, name_of(way));
  hard_figure_add(run, m->leak, INFINITY, "1", "leaks of %s, %s", of->name, name_of(way));
}

/* `drawn`: the same picture, of which the view depths serve again. */
static int measure_normals(hard_run *run, const hard_truth *truth, const hard_picture *drawn, metrics *out) {
  hard_picture picture = {0};
  int code = hard_draw_normals(run, truth, &picture);
  if (code == 0) {
    hard_picture seen = *drawn;
    seen.mask = picture.mask;
    code = hard_measure(out, truth, &seen);
  }
  hard_picture_free(&picture);
  return code;
}

static int draw_light(hard_run *run, const scene_light *sun, hard_truth *truth, metrics out[WAYS]) {
  const host_setup *setup = run->setup;
  hard_picture drawn = {0};
  int code = hard_cast(run, &setup->camera, sun, truth);
  for (int way = 0; code == 0 && way < EXACT_WAYS; way++) {
    csm_config config = setup->config;
    exact_set(&config, way);
    code = hard_configure(run, &config);
    if (code == 0)
      code = hard_draw(run, &setup->camera, sun, HARD_DEPTH, &drawn);
    if (code == 0)
      code = hard_measure(&out[way], truth, &drawn);
  }
  if (code == 0 && hard_has_engine(run))
    code = measure_normals(run, truth, &drawn, &out[ENGINE_NORMALS]);
  hard_picture_free(&drawn);
  return code;
}

static int draw_scene(hard_run *run, const known_scene *of) {
  static const double heights[LIGHTS] = {60.0, 5.0, 20.0, 45.0, 1.0, 30.0, 10.0, 2.0, 75.0};
  const int step = run->sweep ? 1 : 4;
  host_setup setup;
  hard_truth truth = {0};
  const int way_count = hard_has_engine(run) ? WAYS : ENGINE_NORMALS;
  metrics measured[WAYS][LIGHTS];
  uint32_t count = 0;
  int code = load_scene(run, &setup, of->name);
  for (int i = 0; code == 0 && i < LIGHTS; i += step, count++) {
    const scene_light sun = hard_sun(heights[i], 40.0 * i + 15.0);
    metrics all[WAYS];
    code = draw_light(run, &sun, &truth, all);
    for (int way = 0; code == 0 && way < way_count; way++)
      measured[way][count] = all[way];
  }
  for (int way = 0; code == 0 && way < way_count; way++) {
    metrics all;
    metrics_pool(&all, measured[way], count);
    add_figures(run, of, way, &all);
  }
  hard_truth_free(&truth);
  hard_unload(run);
  setup_free(&setup);
  return code;
}

static int run_case(hard_run *run) {
  int code = 0;
  for (int i = 0; code == 0 && i < (run->sweep ? 2 : 1); i++)
    code = draw_scene(run, &scenes[i]);
  return code;
}

const hard_case hard_exact_scenes = {
    .name = "exact_scenes", .about = "exact: the host's scenes under nine lights, down to a degree", .run = run_case};
