/*
 * history.c: masks that are accumulated. A still picture gets better, a moving one shows nothing of before: what a frame
 * alone has around a pixel bounds what its history may say, so a shadow that went leaves nothing behind.
 */
#include "base/host.h"
#include "hard/hard.h"
#include "metrics/ghosts.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A step of the mask's own 8 bits, and of the halves that a history lies in. */
static const double rounding = 1.5 / 255.0;
/* Pixels to either side that bound a pixel's history. */
enum { AROUND = 1 };

/* Masks with and without a history, of one frame; and how many the view has had, which says how its patterns lie. */
typedef struct pair {
  hard_picture mask, alone;
  uint32_t frames;
  bool pattern; /* the filter has one, so that frames differ */
  scene *built; /* whose caster moves */
} pair;

static void pair_free(pair *p) {
  hard_picture_free(&p->mask);
  hard_picture_free(&p->alone);
}

static size_t pixels_of(const hard_run *run) {
  return (size_t)run->setup->width * run->setup->height;
}

/* Draws a frame, whose history goes on. */
static int draw(hard_run *run, const camera *from, const scene_light *light, pair *out) {
  out->frames++;
  return hard_draw(run, from, light, HARD_DEPTH, &out->mask);
}

/* And the same without. */
static int draw_both(hard_run *run, const camera *from, const scene_light *light, pair *out) {
  const int code = draw(run, from, light, out);
  if (!out->alone.mask)
    out->alone = (hard_picture){
        .width = run->setup->width, .height = run->setup->height, .mask = host_allocate(pixels_of(run), sizeof(float))};
  return code ? code
              : stage_mask_alone(&run->stages[0], from, out->pattern ? (out->frames - 1) % 64 : 0, out->alone.mask);
}

static double rms(const float *a, const float *b, size_t count) {
  double sum = 0.0;
  for (size_t i = 0; i < count; i++)
    sum += ((double)a[i] - b[i]) * ((double)a[i] - b[i]);
  return sqrt(sum / (double)count);
}

/* Pixels that are brighter or darker than all that the frame alone has around them. */
static uint64_t count_unbounded(const pair *p) {
  const int width = (int)p->mask.width, height = (int)p->mask.height;
  uint64_t count = 0;
  for (int y = 0; y < height; y++)
    for (int x = 0; x < width; x++) {
      double least = 1.0, most = 0.0;
      for (int v = y - AROUND; v <= y + AROUND; v++)
        for (int u = x - AROUND; u <= x + AROUND; u++) {
          const int row = v < 0 ? 0 : v < height ? v : height - 1, column = u < 0 ? 0 : u < width ? u : width - 1;
          const double at = p->alone.mask[row * width + column];
          least = fmin(least, at);
          most = fmax(most, at);
        }
      const double drawn = p->mask.mask[y * width + x];
      count += drawn < least - rounding || drawn > most + rounding;
    }
  return count;
}

static uint64_t count_other(const pair *p) {
  uint64_t count = 0;
  for (size_t i = 0; i < (size_t)p->mask.width * p->mask.height; i++)
    count += fabs((double)p->mask.mask[i] - p->alone.mask[i]) > rounding;
  return count;
}

static csm_config configured(const hard_run *run, uint32_t filter, uint32_t frames) {
  csm_config config = run->setup->config;
  config.filter = filter;
  config.filter_taps = 8;
  config.filter_radius_texels = 4.0;
  config.history = CSM_HISTORY_ON;
  config.history_frames = frames;
  return config;
}

/* ---- a camera that stands ---- */

/*
 * A pattern of few taps that turns from frame to frame. Eight frames are as many taps as a pattern of eight times as many
 * has; the deviation of n independent samples falls by sqrt(n), of eight to 0.36: half of the first one's leaves room for
 * taps that are not.
 */
static int stand(hard_run *run, pair *frame) {
  const size_t count = pixels_of(run);
  const csm_config config = configured(run, CSM_FILTER_VOGEL, 64);
  float *first = host_allocate(count, sizeof *first), *eighth = host_allocate(count, sizeof *eighth);
  int code = hard_restart(run, &config);
  for (uint32_t i = 0; code == 0 && i < 64; i++) {
    code = draw(run, &run->setup->camera, &run->setup->light, frame);
    if (i == 0)
      memcpy(first, frame->mask.mask, count * sizeof *first);
    if (i == 7)
      memcpy(eighth, frame->mask.mask, count * sizeof *eighth);
  }
  if (code == 0) {
    const double alone = rms(first, frame->mask.mask, count);
    hard_figure_add(run, alone, INFINITY, "1", "deviation of one frame of 8 taps from 64");
    hard_figure_add(run, rms(eighth, frame->mask.mask, count) / alone, 0.5, "1", "of eight frames, to that of one");
  }
  free(first);
  free(eighth);
  return code;
}

/* ---- a soft sun ---- */

/*
 * One sample a frame, of maps that are jittered. The mean of many frames has the error of a mean of kernels, and one of them is
 * nearly all noise: 8 leave at most half of the first one's error.
 */
static int soften(hard_run *run, pair *frame) {
  static const double discs[] = {0.53, 2.0, 5.0};
  const double reach = run->setup->config.shadow_distance;
  csm_config config = {.struct_size = sizeof config};
  int code = csm_config_preset("soft_history", &config) ? HOST_BAD_INPUT : 0;
  hard_truth truth = {0};
  config.shadow_distance = reach;
  config.resolution = run->setup->config.resolution;
  for (size_t i = 0; code == 0 && i < sizeof discs / sizeof discs[0]; i += run->sweep ? 1 : 2) {
    scene_light light = run->setup->light;
    metrics first, eighth;
    light.disc_deg = discs[i];
    code = hard_cast(run, &run->setup->camera, &light, &truth);
    if (code == 0)
      code = hard_restart(run, &config);
    for (uint32_t k = 0; code == 0 && k < 8; k++) {
      code = draw(run, &run->setup->camera, &light, frame);
      if (code == 0 && (k == 0 || k == 7))
        code = hard_measure(k ? &eighth : &first, &truth, &frame->mask);
    }
    if (code == 0)
      hard_figure_add(run, eighth.rmse / first.rmse, 0.5, "1", "rmse of eight frames to that of one, a sun of %g",
                      light.disc_deg);
  }
  hard_truth_free(&truth);
  return code;
}

/* ---- a camera, a sun and a caster that move ---- */

typedef struct motion {
  const char *name;
  double walk, turn, sun, caster; /* metres, degrees, degrees, metres, a frame */
} motion;

/* The short form has the last two. */
static const motion motions[] = {{"a camera that walks", 0.1, 0.3, 0.0, 0.0},
                                 {"a sun that moves", 0.0, 0.0, 0.1, 0.0},
                                 {"a camera and a sun", 0.1, 0.3, 0.1, 0.0},
                                 {"a caster that moves", 0.0, 0.0, 0.0, 0.15}};
enum { MOTIONS = sizeof motions / sizeof motions[0] };

static camera camera_in(const hard_run *run, const motion *how, uint32_t frame) {
  camera_pose pose = run->setup->scene.camera;
  camera at;
  const double angle = how->turn * frame * (3.14159265358979323846 / 180.0);
  const double way[3] = {pose.target[0] - pose.position[0], pose.target[1] - pose.position[1],
                         pose.target[2] - pose.position[2]};
  pose.position[2] -= how->walk * frame;
  pose.target[0] = pose.position[0] + cos(angle) * way[0] - sin(angle) * way[2];
  pose.target[1] = pose.position[1] + way[1];
  pose.target[2] = pose.position[2] + sin(angle) * way[0] + cos(angle) * way[2];
  camera_from_pose(&at, &pose, (double)run->setup->width / run->setup->height);
  return at;
}

static scene_light light_in(const hard_run *run, const motion *how, uint32_t frame) {
  scene_light light = run->setup->light;
  const double angle = how->sun * frame * (3.14159265358979323846 / 180.0);
  const double x = light.direction[0], z = light.direction[2];
  light.direction[0] = cos(angle) * x - sin(angle) * z;
  light.direction[2] = sin(angle) * x + cos(angle) * z;
  return light;
}

/* Moves a box aside, in the truth's scene, too. */
static int move_caster(hard_run *run, const pair *frame, double aside) {
  enum { BOX = 1 };
  double *matrix = frame->built->instances[BOX].transform;
  int code = 0;
  matrix[12] += aside;
  truth_destroy(run->truth); /* it is made anew when it is asked */
  run->truth = NULL;
  for (uint32_t s = 0; code == 0 && s < run->stage_count; s++) {
    const csm_scene_batch batch = {
        .struct_size = sizeof batch, .count = 1, .ids = &run->stages[s].instances[BOX], .matrices = matrix};
    code = csm_scene_move(run->stages[s].scene, &batch) ? HOST_NO_DEVICE : 0;
  }
  return code;
}

static int walk(hard_run *run, const motion *how, uint32_t filter, pair *frame) {
  const csm_config config = configured(run, filter, 8);
  ghosts sum = {0};
  hard_truth truth = {0};
  uint8_t *kinds = host_allocate(pixels_of(run), 1);
  const uint32_t count = run->sweep ? 60 : 8;
  frame->pattern = filter == CSM_FILTER_VOGEL;
  int code = hard_restart(run, &config);
  for (uint32_t i = 0; code == 0 && i < count; i++) {
    const camera from = camera_in(run, how, i);
    const scene_light light = light_in(run, how, i);
    metrics measured;
    code = move_caster(run, frame, i ? how->caster : 0.0);
    if (code == 0)
      code = draw_both(run, &from, &light, frame);
    if (code == 0)
      code = hard_cast(run, &from, &light, &truth);
    const metrics_frame drawn = {.view = &truth.view,
                                 .light = &light,
                                 .shadow_distance = run->setup->shadow_distance,
                                 .visibility = truth.visibility,
                                 .mask = frame->mask.mask,
                                 .view_depth = frame->mask.view_depth};
    if (code == 0)
      code = metrics_measure(&measured, &drawn, kinds);
    if (code == 0)
      ghosts_add(&sum, &drawn, kinds, frame->alone.mask);
  }
  /*
   * 0.02 % is what a picture of 720 rows may have. Edges of shadows, where ghosts lie, take up more of a smaller one.
   */
  if (code == 0)
    hard_figure_add(run, 100.0 * (double)sum.wrong / (double)sum.pixels, 0.02, "%", "ghosts, %s, %s", how->name,
                    filter == CSM_FILTER_VOGEL ? "vogel" : "pcf_3x3");
  if (code == 0)
    code = move_caster(run, frame, -how->caster * (count - 1));
  free(kinds);
  hard_truth_free(&truth);
  return code;
}

/* ---- jumps ---- */

/*
 * A filter without a pattern, so that the frame alone is what the history was bounded by: a caster that jumps aside, or
 * that is elsewhere in every frame, leaves nothing of its shadow. So no pixel may be beyond what is around it.
 */
static int jump(hard_run *run, pair *frame) {
  const csm_config config = configured(run, CSM_FILTER_PCF_3X3, 64);
  frame->pattern = false;
  static const double places[] = {0, 0, 0, 0, 0, 0, 0, 0, 6, 6, 0, 1, 2, 3, 4, 5, -5, -3, -1};
  int code = hard_restart(run, &config);
  for (size_t i = 0; code == 0 && i < sizeof places / sizeof places[0]; i++) {
    code = move_caster(run, frame, i ? places[i] - places[i - 1] : 0.0);
    if (code == 0)
      code = draw_both(run, &run->setup->camera, &run->setup->light, frame);
    if (code == 0)
      hard_figure_add(run, (double)count_unbounded(frame), 0.0, "px", "beyond what is around, a caster jumps");
  }
  if (code == 0)
    code = move_caster(run, frame, -places[sizeof places / sizeof places[0] - 1]);
  return code;
}

/* Another place, which shows nothing of what was seen; another size; and other settings: there is no history. */
static int cut(hard_run *run, pair *frame) {
  csm_config config = configured(run, CSM_FILTER_PCF_3X3, 64);
  frame->pattern = false;
  camera_pose pose = run->setup->scene.camera;
  for (int k = 0; k < 3; k += 2)
    pose.target[k] = 2.0 * pose.position[k] - pose.target[k];
  pose.target[1] = -1.0;
  camera there;
  camera_from_pose(&there, &pose, (double)run->setup->width / run->setup->height);
  int code = hard_restart(run, &config);
  for (int i = 0; code == 0 && i < 4; i++)
    code = draw(run, &run->setup->camera, &run->setup->light, frame);
  if (code == 0)
    code = draw_both(run, &there, &run->setup->light, frame);
  if (code == 0)
    hard_figure_add(run, (double)count_other(frame), 0.0, "px", "other than without history, after a cut");
  for (int i = 0; code == 0 && i < 4; i++)
    code = draw(run, &run->setup->camera, &run->setup->light, frame);
  config.history_frames = 32;
  scene_light light = run->setup->light;
  light.direction[0] = -light.direction[0];
  if (code == 0)
    code = hard_configure(run, &config);
  if (code == 0)
    code = draw_both(run, &run->setup->camera, &light, frame);
  if (code == 0)
    hard_figure_add(run, (double)count_other(frame), 0.0, "px", "other than without history, other settings");
  return code;
}

static int run_case(hard_run *run) {
  host_setup setup;
  pair frame = {.built = &setup.scene};
  hard_setup_begin(&setup, 240, 135);
  hard_yard(&setup, true);
  setup.config.resolution = 1024;
  int code = hard_load(run, &setup);
  if (code == 0)
    code = stand(run, &frame);
  if (code == 0)
    code = soften(run, &frame);
  for (size_t i = run->sweep ? 0 : 2 * (MOTIONS - 2); code == 0 && i < 2 * MOTIONS; i++)
    code = walk(run, &motions[i / 2], i % 2 ? CSM_FILTER_VOGEL : CSM_FILTER_PCF_3X3, &frame);
  if (code == 0)
    code = jump(run, &frame);
  if (code == 0)
    code = cut(run, &frame);
  pair_free(&frame);
  hard_unload(run);
  setup_free(&setup);
  return code;
}

const hard_case hard_history = {.name = "history",
                                .about = "accumulated masks: less noise where all stands, and no ghosts where it moves",
                                .run = run_case};
