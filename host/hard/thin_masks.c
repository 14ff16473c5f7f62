/* thin_masks.c: masks of one row or one column, which tell no plane of what they show: what is lit is lit. */
#include "hard/hard.h"

/* A picture of a plane that fills it, under a sun 30 degrees high. No normals are given. */
static int draw_plane(hard_run *run, uint32_t width, uint32_t height) {
  host_setup setup;
  mesh_builder b = {0};
  hard_picture drawn = {0};
  hard_truth truth = {0};
  hard_setup_begin(&setup, width, height);
  hard_ground(&b, (const double[3]){0.0, 0.0, 0.0}, 400.0, 2);
  hard_add(&setup, &b, "ground", NULL);
  /* A picture that is wide, or high, looks down, so that all of it lies on the plane, within the shadows' reach */
  hard_look(&setup, (const double[3]){0.0, 2.0, 0.0}, (const double[3]){0.3, 0.0, -0.5}, width > height ? 0.01 : 60.0);
  const scene_light sun = hard_sun(30.0, 20.0);
  int code = hard_load(run, &setup);
  if (code == 0)
    code = hard_draw(run, &setup.camera, &sun, 0, &drawn);
  if (code == 0)
    code = hard_cast(run, &setup.camera, &sun, &truth);
  if (code == 0) {
    const hard_count count = hard_judge(run, &truth, drawn.mask, (hard_margin){.silhouette_px = 0.0});
    hard_figure_add(run, (double)count.false_dark, 0.0, "px", "dark pixels of a lit plane, %u x %u", width, height);
    hard_figure_add(run, count.judged > 0 ? 0.0 : 1.0, 0.0, "1", "pictures without a plane");
  }
  hard_truth_free(&truth);
  hard_picture_free(&drawn);
  hard_unload(run);
  setup_free(&setup);
  return code;
}

static int run_case(hard_run *run) {
  static const uint32_t sizes[][2] = {{1, 1}, {16384, 1}, {1, 16384}, {2, 1},  {1, 2},
                                      {2, 2}, {16384, 2}, {3, 1},     {1, 720}};
  int code = 0;
  for (size_t i = 0; code == 0 && i < (run->sweep ? sizeof sizes / sizeof sizes[0] : 6); i++)
    code = draw_plane(run, sizes[i][0], sizes[i][1]);
  return code;
}

const hard_case hard_thin_masks = {
    .name = "thin_masks", .about = "masks of one row or column, 1 x 1 to 16384 x 1", .run = run_case};
