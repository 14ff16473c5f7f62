/* bare_plane.c: a plane with nothing on it, under the whole field of view. It is lit, everywhere. */
#include "hard/hard.h"

static void add_figures(hard_run *run, const hard_truth *truth, const hard_picture *drawn, const char *how) {
  const hard_count count = hard_judge(run, truth, drawn->mask, (hard_margin){.silhouette_px = 0.0});
  /* Nothing stands on it, so that no pixel may be dark. */
  hard_figure_add(run, (double)count.false_dark, 0.0, "px", "dark pixels, %s", how);
  /* It fills more than a third of the picture: something was judged. */
  hard_figure_add(run, count.judged * 3 > (uint64_t)drawn->width * drawn->height ? 0.0 : 1.0, 0.0, "1",
                  "pictures without a plane");
}

static int draw_plane(hard_run *run, const host_setup *setup, hard_picture *drawn, hard_truth *truth) {
  static const double heights[] = {90.0, 60.0, 45.0, 30.0, 20.0, 10.0};
  const uint32_t step = run->sweep ? 1 : 2;
  int code = hard_load(run, setup);
  for (uint32_t i = 0; code == 0 && i < sizeof heights / sizeof heights[0]; i += step) {
    const scene_light sun = hard_sun(heights[i], 20.0);
    code = hard_draw(run, &setup->camera, &sun, 0, drawn);
    if (code == 0)
      code = hard_cast(run, &setup->camera, &sun, truth);
    if (code == 0)
      add_figures(run, truth, drawn, "normals from the depth");
    if (code == 0 && hard_has_engine(run)) {
      code = hard_draw_normals(run, truth, drawn);
      if (code == 0)
        add_figures(run, truth, drawn, "the engine's normals");
    }
  }
  return code;
}

static int run_case(hard_run *run) {
  host_setup setup;
  mesh_builder builder = {0};
  hard_picture drawn = {0};
  hard_truth truth = {0};
  hard_setup_begin(&setup, 256, 144);
  hard_ground(&builder, (const double[3]){0.0, 0.0, 0.0}, 200.0, 8);
  hard_add(&setup, &builder, "ground", NULL);
  hard_look(&setup, (const double[3]){0.0, 1.7, 0.0}, (const double[3]){10.0, 1.0, 3.0}, 60.0);
  const int code = draw_plane(run, &setup, &drawn, &truth);
  hard_truth_free(&truth);
  hard_picture_free(&drawn);
  hard_unload(run);
  setup_free(&setup);
  return code;
}

const hard_case hard_bare_plane = {
    .name = "bare_plane", .about = "a plane with nothing on it, suns from 90 to 10 degrees", .run = run_case};
