/*
 * limits.c: nothing to do, and as little as there can be: no instance, no caster, no receiver in sight, masks of one
 * pixel to 16384 x 1, maps of 16 x 16. What is drawn is right, and nothing is drawn that nothing needs.
 */
#include "base/host.h"
#include "base/linear.h"
#include "hard/hard.h"
#include <math.h>

/* ---- nothing to do ---- */

/* Casters that the last frame drew, in all cascades. */
static int count_drawn(const hard_run *run, double *drawn) {
  csm_stats stats = {.struct_size = sizeof stats};
  const csm_result result = csm_get_stats(run->stages[0].cascades, &stats);
  *drawn = 0.0;
  for (uint32_t k = 0; k < stats.cascade_count; k++)
    *drawn += stats.cascades[k].casters_drawn + (double)stats.cascades[k].triangles_drawn;
  return result ? HOST_NO_DEVICE : 0;
}

/* Without a caster all is lit, to the last bit; and whatever there may be, none is drawn. */
static int expect_nothing(hard_run *run, const csm_config *config, const char *what) {
  const host_setup *setup = run->setup;
  hard_picture picture = {0};
  uint64_t dark = 0;
  double drawn;
  int code = hard_restart(run, config);
  if (code == 0)
    code = hard_draw(run, &setup->camera, &setup->light, 0, &picture);
  if (code == 0)
    code = count_drawn(run, &drawn);
  for (size_t i = 0; code == 0 && i < (size_t)setup->width * setup->height; i++)
    dark += picture.mask[i] != 1.0f;
  if (code == 0) {
    hard_figure_add(run, (double)dark, 0.0, "px", "not lit: %s", what);
    hard_figure_add(run, drawn, 0.0, "1", "casters drawn: %s", what);
  }
  hard_picture_free(&picture);
  return code;
}

static int draw_empty(hard_run *run) {
  host_setup setup;
  hard_setup_begin(&setup, 64, 36);
  hard_look(&setup, (const double[3]){0.0, 2.0, 0.0}, (const double[3]){0.0, 0.0, -10.0}, 60.0);
  int code = hard_load(run, &setup);
  if (code == 0)
    code = expect_nothing(run, &setup.config, "no instances");
  hard_unload(run);
  setup_free(&setup);
  return code;
}

static int draw_flagged(hard_run *run) {
  host_setup setup;
  hard_setup_begin(&setup, 64, 36);
  hard_yard(&setup, false);
  csm_config view = setup.config;
  view.caster_set = CSM_CASTER_SET_VIEW;
  int code = hard_load(run, &setup);
  if (code == 0)
    code = hard_flag(run, 0, setup.scene.instance_count, CSM_INSTANCE_RECEIVE_ONLY);
  if (code == 0)
    code = expect_nothing(run, &setup.config, "no casters");
  if (code == 0)
    code = hard_flag(run, 0, setup.scene.instance_count, CSM_INSTANCE_HIDDEN);
  if (code == 0)
    code = expect_nothing(run, &setup.config, "all hidden");
  if (code == 0)
    code = hard_flag(run, 0, setup.scene.instance_count, CSM_INSTANCE_CAST_ONLY);
  if (code == 0)
    code = expect_nothing(run, &view, "no receivers, caster_set view");
  hard_unload(run);
  setup_free(&setup);
  return code;
}

/* The camera sees sky; what stands behind it casts where nobody looks. */
static int draw_sky(hard_run *run) {
  host_setup setup;
  hard_setup_begin(&setup, 64, 36);
  hard_yard(&setup, false);
  hard_look(&setup, (const double[3]){0.0, 20.0, 2.0}, (const double[3]){0.0, 60.0, 30.0}, 40.0);
  setup.config.caster_set = CSM_CASTER_SET_VIEW;
  int code = hard_load(run, &setup);
  if (code == 0)
    code = expect_nothing(run, &setup.config, "no receivers in sight, caster_set view");
  hard_unload(run);
  setup_free(&setup);
  return code;
}

/* Shadows end before the view begins. */
static int draw_beyond(hard_run *run) {
  host_setup setup;
  hard_setup_begin(&setup, 64, 36);
  hard_yard(&setup, false);
  camera_pose pose = setup.scene.camera;
  pose.near_depth = 70.0;
  camera_from_pose(&setup.camera, &pose, 64.0 / 36.0);
  int code = hard_load(run, &setup);
  if (code == 0)
    code = expect_nothing(run, &setup.config, "shadows end before the near plane");
  hard_unload(run);
  setup_free(&setup);
  return code;
}

/* ---- masks of any size ---- */

/* As many pixels as are asked for, each from 0 to 1; whether they are right is another case's (thin_masks). */
static int draw_size(hard_run *run, uint32_t width, uint32_t height) {
  host_setup setup;
  hard_picture picture = {0};
  uint64_t outside = 0;
  hard_setup_begin(&setup, width, height);
  hard_yard(&setup, false);
  setup.config.resolution = 256;
  int code = hard_load(run, &setup);
  if (code == 0)
    code = hard_draw(run, &setup.camera, &setup.light, 0, &picture);
  for (size_t i = 0; code == 0 && i < (size_t)width * height; i++)
    outside += !(picture.mask[i] >= 0.0f && picture.mask[i] <= 1.0f);
  if (code == 0)
    hard_figure_add(run, (double)outside, 0.0, "px", "no visibility in a mask of any size");
  hard_picture_free(&picture);
  hard_unload(run);
  setup_free(&setup);
  return code;
}

/* ---- maps of 16 x 16 ---- */

/* A level ground, and over all of it, or over none, a lid that is thicker than any bias. */
static void make_ground(host_setup *out, bool lid) {
  mesh_builder b = {0};
  hard_setup_begin(out, 192, 108);
  hard_ground(&b, (const double[3]){0.0, 0.0, 0.0}, 200.0, 4);
  hard_add(out, &b, "ground", NULL);
  if (lid) {
    builder_box(&b, (const double[3]){-2000.0, 200.0, -2000.0}, (const double[3]){2000.0, 400.0, 2000.0});
    hard_add(out, &b, "lid", NULL);
  }
  hard_look(out, (const double[3]){0.0, 1.7, 0.0}, (const double[3]){10.0, 1.0, 3.0}, 60.0);
  hard_reach(out, 100.0);
}

/* 65536 bytes for an image is what Direct3D 12 rounds up to; a map takes 1024. */
static void count_bytes(hard_run *run) {
  csm_stats stats = {.struct_size = sizeof stats};
  for (uint32_t i = 0; i < run->stage_count; i++)
    if (csm_get_stats(run->stages[i].cascades, &stats) == CSM_SUCCESS)
      hard_figure_add(run, (double)stats.map_bytes, 65536.0, "bytes", "maps of 16 x 16, all together");
}

/* Under a lid, or on a lit plane; with one of hard_filters, or NULL. */
typedef struct small_maps {
  const host_setup *setup;
  const hard_truth *truth;
  bool lid;
} small_maps;

static int draw_small(hard_run *run, const small_maps *of, uint32_t layout, uint32_t cascades,
                      const hard_filter *filter) {
  csm_config config = of->setup->config;
  hard_picture picture = {0};
  config.cascade_count = cascades;
  config.resolution = 16;
  config.map_layout = layout;
  if (filter)
    hard_filter_set(&config, filter);
  config.soft_radius_max_texels = 2.0; /* there is no room for more */
  int code = hard_restart(run, &config);
  if (code == 0)
    code = hard_draw(run, &of->setup->camera, &of->setup->light, 0, &picture);
  if (code == 0) {
    const hard_count found = hard_judge(run, of->truth, picture.mask, (hard_margin){.edge_px = 0.0});
    hard_figure_add(run, (double)(found.false_dark + found.false_lit), 0.0, "px", "wrong with maps of 16 x 16, %s%s%s",
                    of->lid ? "under a lid" : "a lit plane", filter ? ", " : "", filter ? filter->name : "");
    hard_figure_add(run, found.judged > 1000 ? 0.0 : 1.0, 0.0, "1", "pictures that show nothing");
    count_bytes(run);
  }
  hard_picture_free(&picture);
  return code;
}

static int draw_small_maps(hard_run *run, bool lid) {
  host_setup setup;
  hard_truth truth = {0};
  const small_maps of = {.setup = &setup, .truth = &truth, .lid = lid};
  make_ground(&setup, lid);
  int code = hard_load(run, &setup);
  if (code == 0)
    code = hard_cast(run, &setup.camera, &setup.light, &truth);
  for (uint32_t layout = 0; code == 0 && layout <= CSM_LAYOUT_ATLAS; layout++)
    for (uint32_t count = 1; code == 0 && count <= CSM_MAX_CASCADES; count += run->sweep ? 1 : 7)
      code = draw_small(run, &of, layout, count, NULL);
  for (uint32_t i = 0; code == 0 && i < HARD_ALL_FILTERS; i++)
    code = draw_small(run, &of, i % 2, run->sweep ? CSM_MAX_CASCADES : 1 + i % 2, &hard_filters[i]);
  hard_truth_free(&truth);
  hard_unload(run);
  setup_free(&setup);
  return code;
}

static int run_case(hard_run *run) {
  static const uint32_t sizes[][2] = {{1, 1}, {16384, 1}, {1, 16384}, {3, 2}, {1, 7}, {16384, 3}, {17, 16384}};
  const uint32_t count = run->sweep ? sizeof sizes / sizeof sizes[0] : 4;
  int code = draw_empty(run);
  if (code == 0)
    code = draw_flagged(run);
  if (code == 0)
    code = draw_sky(run);
  if (code == 0)
    code = draw_beyond(run);
  for (uint32_t i = 0; code == 0 && i < count; i++)
    code = draw_size(run, sizes[i][0], sizes[i][1]);
  for (int lid = 0; code == 0 && lid < 2; lid++)
    code = draw_small_maps(run, lid);
  return code;
}

const hard_case hard_limits = {
    .name = "limits", .about = "nothing to do, masks of one pixel to 16384, maps of 16 x 16", .run = run_case};
