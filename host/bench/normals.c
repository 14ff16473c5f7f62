#include "bench/normals.h"
#include "base/host.h"
#include "hard/engine.h"
#include "truth/truth.h"
#include <stdlib.h>

enum { warm_up = 2 };
enum { BASE, EXACT, SIDES };

/* The same scene twice, each with a device and a configuration of its own. */
typedef struct normals_bench {
  host_setup setups[SIDES];
  hard_engine *engines[SIDES];
  float (*normals)[4]; /* what the camera sees: geometric, unit, in the world */
  float *mask;
  double *ms[SIDES];
  uint32_t pixels;
} normals_bench;

static int see_normals(normals_bench *b) {
  const host_setup *setup = &b->setups[BASE];
  const size_t pixels = (size_t)setup->width * setup->height;
  uint32_t *triangles = host_allocate(pixels, sizeof *triangles);
  truth *caster = truth_create(&setup->scene, true);
  const hard_truth seen = {.view = {.camera = &setup->camera,
                                    .width = setup->width,
                                    .height = setup->height,
                                    .surfaces = host_allocate(pixels, sizeof *seen.view.surfaces)}};
  int code = truth_find(caster, &setup->camera, setup->width, setup->height, triangles);
  if (code == 0)
    code = truth_view_fill(caster, &seen.view, triangles);
  if (code == 0)
    b->normals = hard_true_normals(&seen);
  free(seen.view.surfaces);
  truth_destroy(caster);
  free(triangles);
  return code;
}

static int draw(normals_bench *b, int side, double *ms) {
  const host_setup *setup = &b->setups[side];
  const hard_inputs inputs = {.normals = (const float(*)[4])b->normals};
  csm_view_stats stats = {.struct_size = sizeof stats};
  const int code = hard_engine_draw(b->engines[side], &inputs, &setup->camera, &setup->light, b->mask);
  if (code)
    return code;
  const stage *s = hard_engine_stage(b->engines[side]);
  if (csm_get_view_stats(s->view, &stats))
    return host_fail(HOST_NO_DEVICE, "%s: %s", s->backend, csm_last_error(s->context));
  *ms = stats.mask_gpu_ms + (side == EXACT ? stats.rays_gpu_ms : 0.0);
  b->pixels = side == EXACT ? stats.ray_pixels : b->pixels;
  return 0;
}

static int draw_in_turn(normals_bench *b, uint32_t pairs) {
  int code = 0;
  for (uint32_t round = 0; round < warm_up + pairs && code == 0; round++) {
    const uint32_t i = round < warm_up ? 0 : round - warm_up;
    host_progress("masks with the engine's normals");
    for (int side = 0; side < SIDES && code == 0; side++)
      code = draw(b, side, &b->ms[side][i]);
  }
  host_progress("");
  return code;
}

static int open_sides(normals_bench *b, const host_setup *setup, const host_options *options, uint32_t pairs) {
  const size_t pixels = (size_t)setup->width * setup->height;
  int code = 0;
  b->mask = host_allocate(pixels, sizeof *b->mask);
  for (int side = 0; side < SIDES; side++) {
    b->ms[side] = host_allocate(pairs, sizeof(double));
    b->setups[side] = *setup; /* which stays its owner */
    b->setups[side].config.filter = CSM_FILTER_PCF_3X3;
  }
  bench_exact(&b->setups[EXACT].config);
  for (int side = 0; side < SIDES && code == 0; side++) {
    code = hard_engine_open(&b->engines[side], &b->setups[side], options, false);
    if (code == 0)
      hard_engine_stage(b->engines[side])->frame.flags |= CSM_FRAME_TIMESTAMPS;
  }
  return code ? code : see_normals(b);
}

int bench_normals_run(bench_normals *out, const host_setup *setup, const host_options *options, uint32_t pairs) {
  normals_bench b = {0};
  if (!hard_engine_there(options))
    return 0;
  int code = open_sides(&b, setup, options, pairs);
  if (code == 0)
    code = draw_in_turn(&b, pairs);
  if (code == 0)
    *out = (bench_normals){.pairs = pairs,
                           .pixels = b.pixels,
                           .base_ms = estimate_median(b.ms[BASE], pairs),
                           .exact_ms = estimate_median(b.ms[EXACT], pairs),
                           .to_base = estimate_ratio(b.ms[EXACT], b.ms[BASE], pairs),
                           .most_bases = bench_most_with_normals(setup->scene.name)};
  for (int side = 0; side < SIDES; side++) {
    hard_engine_close(b.engines[side]);
    free(b.ms[side]);
  }
  free(b.mask);
  free(b.normals);
  return code;
}

void bench_normals_print(FILE *to, const bench_normals *n) {
  if (!n->pairs)
    return;
  fprintf(to, "\nmasks with the engine's normals, on an engine's Vulkan device; GPU time, %u rounds in turn\n\n",
          n->pairs);
  bench_print_line(to, "pcf_3x3, ms", &n->base_ms);
  bench_print_line(to, "exact, ms", &n->exact_ms);
  bench_print_line(to, "exact / pcf_3x3", &n->to_base);
  if (n->most_bases > 0.0)
    fprintf(to, "  at most %.1f: %s\n", n->most_bases, n->to_base.median <= n->most_bases ? "yes" : "NO");
  fprintf(to, "  %u rays a mask\n", n->pixels);
}

json_t *bench_normals_to_json(const bench_normals *n) {
  json_t *object = json_object();
  json_object_set_new(object, "pcf_3x3_ms", estimate_to_json(&n->base_ms));
  json_object_set_new(object, "exact_ms", estimate_to_json(&n->exact_ms));
  json_object_set_new(object, "to_pcf_3x3", estimate_to_json(&n->to_base));
  json_object_set_new(object, "ray_pixels", json_integer(n->pixels));
  if (n->most_bases > 0.0)
    json_object_set_new(object, "at_most", json_real(n->most_bases));
  return object;
}
