#include "bench/bare.h"
#include "csm_constants.h"
#include "base/host.h"
#include <stdlib.h>
#include <string.h>

enum { warm_up = 2 };

static const char *const pass_names[BARE_PASSES] = {"floor", "set_up", "loop_49", "pcf_7x7"};

/* At most of the loop's time that the filter may take. */
static const double loop_limit = 0.4;

static int open_with(bare_mask **out, const stage_frame *frame, const host_setup *setup, const bench_plan *plan,
                     const char *device) {
  const csm_binding *binding = &frame->binding;
  char error[512] = "";
  float camera[CSM_M_COUNT * 4], blocks[CSM_C_COUNT * 4] = {0};
  memcpy(blocks, binding->cascade_constants, binding->cascade_constants_size);
  memcpy(blocks + 4 * CSM_S_BEGIN, binding->setting_constants, binding->setting_constants_size);
  const plan_picture picture = {.camera = &plan->frame.camera, .width = setup->width, .height = setup->height};
  plan_write_mask_constants(camera, &plan->frame, &picture, &setup->config);
  const bare_mask_info info = {.width = setup->width,
                               .height = setup->height,
                               .resolution = binding->resolutions[0],
                               .cascade_count = binding->cascade_count,
                               .camera_depth = frame->camera_depth,
                               .maps = frame->maps,
                               .cascades = blocks,
                               .camera = camera,
                               .device = device};
  return bare_mask_open(out, &info, error, sizeof error) ? host_fail(HOST_NO_DEVICE, "%s", error) : 0;
}

int bench_bare_open(bare_mask **out, stage *s, const csm_config *config, const bench_plan *plan, const char *device) {
  stage_frame frame = {0};
  stage_stats stats;
  *out = NULL;
  csm_config plain = *config;
  plain.map_layout = CSM_LAYOUT_ARRAY;
  plain.map_format = CSM_MAP_D32;
  memset(plain.resolutions, 0, sizeof plain.resolutions);
  int code = stage_configure(s, &plain);
  if (code == 0)
    code = stage_draw(s, &stats);
  if (code == 0)
    code = stage_read(s, true, &frame);
  if (code == 0)
    code = open_with(out, &frame, s->setup, plan, device);
  stage_frame_free(&frame);
  return code;
}

static int draw_in_turn(bare_mask *mask, double *const samples[BARE_PASSES], uint32_t pairs) {
  for (uint32_t round = 0; round < warm_up + pairs; round++) {
    host_progress("bare masks");
    for (int pass = 0; pass < BARE_PASSES; pass++) {
      const double ms = bare_mask_draw(mask, (bare_pass)pass);
      if (!(ms > 0.0))
        return host_fail(HOST_NO_DEVICE, "the bare mask: a frame failed, or was not timed");
      if (round >= warm_up)
        samples[pass][round - warm_up] = ms;
    }
  }
  host_progress("");
  return 0;
}

static int compare_masks(bench_bare *out, bare_mask *mask) {
  uint8_t *loop = host_allocate(out->pixels, 1);
  int code = bare_mask_draw(mask, BARE_LOOP_49) < 0.0 ? HOST_NO_DEVICE : 0;
  memcpy(loop, bare_mask_pixels(mask), out->pixels);
  if (code == 0 && bare_mask_draw(mask, BARE_PCF_7X7) < 0.0)
    code = HOST_NO_DEVICE;
  const uint8_t *own = bare_mask_pixels(mask);
  for (uint32_t i = 0; i < out->pixels && code == 0; i++) {
    out->differing += loop[i] != own[i];
    out->partial += own[i] != 0 && own[i] != 255;
  }
  free(loop);
  return code ? host_fail(code, "the bare mask: a frame failed") : 0;
}

int bench_bare_run(bench_bare *out, stage *s, const csm_config *config, const bench_plan *plan, const char *device,
                   uint32_t pairs) {
  csm_config seven = *config;
  seven.filter = CSM_FILTER_PCF_7X7;
  seven.filter_weights = CSM_WEIGHTS_UNIFORM;
  seven.filter_early_out = 0;
  seven.bias_mode = CSM_BIAS_SLOPE; /* the sampler has one depth to compare with for its four texels */
  seven.map_reversed = 0;
  *out = (bench_bare){.pixels = s->setup->width * s->setup->height};
  double *samples[BARE_PASSES];
  for (int i = 0; i < BARE_PASSES; i++)
    samples[i] = host_allocate(pairs, sizeof *samples[i]);
  bare_mask *mask = NULL;
  int code = bench_bare_open(&mask, s, &seven, plan, device);
  if (code == 0)
    code = draw_in_turn(mask, samples, pairs);
  if (code == 0)
    code = compare_masks(out, mask);
  if (code == 0) {
    out->pairs = pairs;
    out->set_up_to_floor = estimate_ratio(samples[BARE_SET_UP], samples[BARE_FLOOR], pairs);
    out->pcf_to_loop = estimate_ratio(samples[BARE_PCF_7X7], samples[BARE_LOOP_49], pairs);
    for (int i = 0; i < BARE_PASSES; i++)
      out->ms[i] = estimate_median(samples[i], pairs);
  }
  for (int i = 0; i < BARE_PASSES; i++)
    free(samples[i]);
  bare_mask_close(mask);
  return code;
}

static void print_ratio(FILE *to, const char *name, const estimate *value, const char *end) {
  fprintf(to, "  %-24s %9.3f   %8.3f .. %-8.3f%s\n", name, value->median, value->low, value->high, end);
}

void bench_bare_print(FILE *to, const bench_bare *bare) {
  fprintf(to, "\nbare: masks in bare Vulkan on csm's maps, one depth for all taps; GPU time, %u rounds in turn\n\n",
          bare->pairs);
  for (int i = 0; i < BARE_PASSES; i++)
    fprintf(to, "  %-24s %9.2f ms %7.2f .. %-8.2f\n", pass_names[i], bare->ms[i].median, bare->ms[i].low,
            bare->ms[i].high);
  print_ratio(to, "set_up / floor", &bare->set_up_to_floor, "");
  print_ratio(to, "pcf_7x7 / loop_49", &bare->pcf_to_loop,
              bare->pcf_to_loop.median <= loop_limit ? "  at most 0.4: yes" : "  at most 0.4: NO");
  fprintf(to, "  %u of %u pixels differ between the two, %u of them neither lit nor dark\n", bare->differing,
          bare->pixels, bare->partial);
}

json_t *bench_bare_to_json(const bench_bare *bare) {
  json_t *object = json_object(), *times = json_object();
  for (int i = 0; i < BARE_PASSES; i++)
    json_object_set_new(times, pass_names[i], estimate_to_json(&bare->ms[i]));
  json_object_set_new(object, "pairs", json_integer(bare->pairs));
  json_object_set_new(object, "gpu_ms", times);
  json_object_set_new(object, "set_up/floor", estimate_to_json(&bare->set_up_to_floor));
  json_object_set_new(object, "pcf_7x7/loop_49", estimate_to_json(&bare->pcf_to_loop));
  json_object_set_new(object, "at_most", json_real(loop_limit));
  json_object_set_new(object, "pixels", json_integer(bare->pixels));
  json_object_set_new(object, "partial_pixels", json_integer(bare->partial));
  json_object_set_new(object, "differing_pixels", json_integer(bare->differing));
  return object;
}
