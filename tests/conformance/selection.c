/*
 * selection.c: which cascade a point takes and how cascades go over into each other, which faces cast, what biases of
 * the rasteriser do, and what maps keep from one frame to the next.
 */
#include "telling.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { width = 192, height = 108, pixels = width * height };

typedef struct fixture {
  record record;
  csm_context *context;
  telling scene;
  shot shot;
  csm_cascades *cascades;
  csm_view *view;
} fixture;

static void open_fixture(fixture *f) {
  memset(f, 0, sizeof *f);
  f->context = support_open(&f->record);
  telling_make(&f->scene, f->context);
  f->view = support_view(f->context);
  f->shot = telling_shot(&f->scene, 0, 0, (double)width / height);
}

static void close_fixture(fixture *f) {
  support_close(f->context, &f->record);
}

static csm_config base_config(void) {
  csm_config config = support_config();
  config.shadow_distance = 24;
  return config;
}

static void render(fixture *f) {
  assert_int_equal(csm_render_cascades(f->cascades, shot_frame(&f->shot)), CSM_SUCCESS);
  assert_int_equal(shot_resolve(&f->shot, f->view, f->cascades, width, height), CSM_SUCCESS);
}

static void begin(fixture *f, const csm_config *config) {
  assert_int_equal(csm_cascades_create(f->context, config, &f->cascades), CSM_SUCCESS);
  render(f);
}

static void end(fixture *f) {
  assert_int_equal(csm_cascades_destroy(f->cascades), CSM_SUCCESS);
}

static float *mask_of(fixture *f, const csm_config *config) {
  begin(f, config);
  float *mask = support_image(f->context, f->view, CSM_READ_MASK, width, height);
  end(f);
  return mask;
}

/* The view depth of every pixel, and the depths where cascades begin and end; 0 where nothing is. */
static float *depths_of(fixture *f, const csm_config *config, csm_binding *binding) {
  begin(f, config);
  float *depths = support_image(f->context, f->view, CSM_READ_CAMERA_DEPTH, width, height);
  *binding = (csm_binding){.struct_size = sizeof *binding};
  assert_int_equal(csm_bind(f->cascades, binding), CSM_SUCCESS);
  end(f);
  for (int i = 0; i < pixels; ++i)
    depths[i] = depths[i] > 0 ? (float)f->shot.camera.projection[14] / depths[i] : 0;
  return depths;
}

/* ---- beyond the last cascade ---- */

static void beyond_is_lit_dark_or_faded(void **state) {
  (void)state;
  fixture f;
  open_fixture(&f);
  csm_config config = base_config();
  csm_binding binding;
  float *depths = depths_of(&f, &config, &binding), *masks[3];
  for (uint32_t beyond = 0; beyond < 3; ++beyond) {
    config.out_of_range = beyond;
    masks[beyond] = mask_of(&f, &config);
  }
  const double finish = binding.cascades[2].far_depth, length = config.fade_share * finish;
  uint32_t far = 0, faded = 0;
  for (int i = 0; i < pixels; ++i) {
    const double depth = depths[i], lit = masks[0][i], fade = fmin(fmax((depth - finish + length) / length, 0), 1);
    if (depth == 0 || fabs(depth - finish) < 1e-3)
      continue;
    far += depth > finish;
    faded += fade > 0 && fade < 1 && lit < 1;
    if (depth > finish)
      assert_true(masks[0][i] == 1 && masks[1][i] == 0 && masks[2][i] == 1);
    else
      assert_true(masks[0][i] == masks[1][i]);
    assert_true(fabs(masks[2][i] - (lit + fade * (1 - lit))) < 1.01 / 255);
  }
  assert_true(far > pixels / 50 && faded > 20);
  free(depths);
  for (int i = 0; i < 3; ++i)
    free(masks[i]);
  close_fixture(&f);
}

/* ---- blending ---- */

/* What is blended from `own` to `linear` by a share is one value of the next cascade; dithering takes it or `own`. */
static void blends_go_over_at_both_ends(void **state) {
  (void)state;
  fixture f;
  open_fixture(&f);
  csm_config config = base_config();
  config.selection = CSM_SELECT_INTERVAL;
  config.blend_share = 0.5;
  config.split_mode = CSM_SPLIT_UNIFORM;
  config.resolution = 64;
  config.fit_mode = CSM_FIT_CENTROID_SPHERE;
  csm_binding binding;
  float *depths = depths_of(&f, &config, &binding), *masks[3];
  for (uint32_t blend = 0; blend < 3; ++blend) {
    config.blend_mode = blend;
    masks[blend] = mask_of(&f, &config);
  }
  uint32_t inside = 0, taken[2] = {0}, differing[2] = {0};
  for (int i = 0; i < pixels; ++i) {
    int cascade = 0;
    while (cascade < 2 && depths[i] > binding.cascades[cascade].far_depth)
      ++cascade;
    const double begin = binding.cascades[cascade].near_depth, end = binding.cascades[cascade].far_depth;
    const double share = (depths[i] - end) / ((end - begin) * config.blend_share) + 1;
    const double own = masks[0][i], linear = masks[1][i], dithered = masks[2][i];
    if (share <= 0 || cascade == 2) { /* the last one has nothing to blend into */
      assert_true(depths[i] == 0 || cascade == 2 || (own == linear && own == dithered));
      continue;
    }
    if (share < 0.1)
      continue;
    const double next = (linear - (1 - share) * own) / share, tolerance = 1.01 / 255 / share;
    assert_true(next > -tolerance && next < 1 + tolerance);
    assert_true(dithered == own || fabs(dithered - next) < tolerance);
    ++inside;
    if (fabs(next - own) > 2 * tolerance) {
      ++differing[share > 0.5];
      taken[share > 0.5] += dithered != own;
    }
  }
  printf("%u pixels in bands; of %u and %u that differ in the nearer and farther half, dithering takes %u and %u from "
         "the next cascade\n",
         inside, differing[0], differing[1], taken[0], taken[1]);
  assert_true(inside > pixels / 10 && differing[0] > 20 && differing[1] > 20);
  assert_true(taken[0] * 2 < differing[0] && taken[1] * 2 > differing[1]);
  free(depths);
  for (int i = 0; i < 3; ++i)
    free(masks[i]);
  close_fixture(&f);
}

/* ---- faces, clipping, the rasteriser's bias ---- */

/* How many texels of one map seen from straight above are not empty, and the last of their depths. */
static uint32_t covered(fixture *f, const csm_config *config, const csm_instance *instance, float *depth) {
  const shot before = f->shot;
  f->shot.frame.instances = instance;
  f->shot.frame.instance_count = 1;
  f->shot.light.direction[0] = f->shot.light.direction[2] = 0;
  begin(f, config);
  float *map = support_map(f->context, f->cascades, 0, config->resolution);
  const float clear = config->map_reversed ? 0.0f : 1.0f;
  uint32_t count = 0;
  for (uint32_t i = 0; i < config->resolution * config->resolution; ++i)
    if (map[i] != clear) {
      ++count;
      *depth = map[i];
    }
  free(map);
  end(f);
  f->shot = before;
  return count;
}

static void faces_are_culled_as_they_say(void **state) {
  (void)state;
  fixture f;
  open_fixture(&f);
  const struct {
    csm_instance instance;
    bool casts[3]; /* by face_culling: none, front, back */
  } cases[] = {
      {support_instance(f.scene.square, 0, 1, 0, 2, 1, 2), {true, false, true}},
      {support_instance(f.scene.square, 0, 1, 0, -2, 1, 2), {true, false, true}},
      {support_instance(f.scene.square, 0, 1, 0, 2, -1, 2), {true, true, false}},
      {support_instance(f.scene.square, 0, 1, 0, 2, -1, -3), {true, true, false}},
      {support_instance(f.scene.box, 0, 1, 0, 1, 2, 1), {true, true, true}},
      {support_instance(f.scene.box, 0, 1, 0, -1, 2, 0.5), {true, true, true}},
      {support_instance(f.scene.wedge, 0, 1, 0, -1, 2, 0.5), {true, true, true}},
  };
  csm_config config = base_config();
  config.cascade_count = 1;
  for (uint32_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
    uint32_t counts[3];
    float depth[3] = {0};
    for (uint32_t cull = 0; cull < 3; ++cull) {
      config.face_culling = cull;
      counts[cull] = covered(&f, &config, &cases[i].instance, &depth[cull]);
      if ((counts[cull] > 0) != cases[i].casts[cull])
        fail_msg("case %u, cull %u: %u texels", i, cull, counts[cull]);
      if (counts[cull]) /* the silhouette stays */
        assert_int_equal(counts[cull], counts[0]);
    }
    assert_true(i < 4 || (depth[1] > depth[0] && depth[2] == depth[0])); /* a closed mesh keeps its far side */
  }
  csm_instance leaf = support_instance(f.scene.leaf, 0, 1, 0, 2, 2, 2);
  memcpy(leaf.transform, (const double[]){2, 0, 0, 0, 0, 0, 2, 0, 0, -2, 0, 0}, 12 * sizeof(double));
  uint32_t counts[3];
  for (uint32_t cull = 0; cull < 3; ++cull) {
    config.face_culling = cull;
    float depth;
    counts[cull] = covered(&f, &config, &leaf, &depth);
  }
  assert_true(counts[0] > 50 && counts[0] == counts[1] && counts[0] == counts[2]);
  close_fixture(&f);
}

static void casters_before_the_near_plane_are_clamped_or_clipped(void **state) {
  (void)state;
  fixture f;
  open_fixture(&f);
  const csm_instance high = support_instance(f.scene.box, 0, 60, 0, 4, 1, 4);
  csm_config config = base_config();
  config.caster_distance = 5;
  for (uint32_t reversed = 0; reversed < 2; ++reversed)
    for (uint32_t mode = CSM_DEPTH_CASTERS; mode <= CSM_DEPTH_SLICE; ++mode) {
      float depth = -1;
      config.cascade_count = 1;
      config.depth_mode = mode;
      config.map_reversed = reversed;
      config.pancaking = CSM_PANCAKING_CLAMP;
      assert_true(covered(&f, &config, &high, &depth) > 100);
      assert_true(depth == (reversed ? 1.0f : 0.0f));
      config.pancaking = CSM_PANCAKING_CLIP;
      assert_int_equal(covered(&f, &config, &high, &depth), 0);
      config.depth_mode = CSM_DEPTH_SCENE; /* reaches as far as all casters do */
      assert_true(covered(&f, &config, &high, &depth) > 100);
    }
  close_fixture(&f);
}

/*
 * The bias pushes casters away from the light, whichever way depth runs. What a unit of 16 bits is, the driver says:
 * 2^-16 by D3D12, up to twice that by Vulkan, which is what lavapipe takes, for vkd3d too.
 */
static void the_rasterisers_bias_moves_depth(void **state) {
  (void)state;
  fixture f;
  open_fixture(&f);
  const csm_instance ground = f.scene.instances[0];
  csm_config config = base_config();
  config.cascade_count = 1;
  config.map_format = CSM_MAP_D16;
  for (uint32_t reversed = 0; reversed < 2; ++reversed) {
    float plain, moved;
    config.map_reversed = reversed;
    config.polygon_offset_constant = 0;
    covered(&f, &config, &ground, &plain);
    for (int units = -200; units <= 200; units += 100) {
      config.polygon_offset_constant = units;
      covered(&f, &config, &ground, &moved);
      const double away = (reversed ? plain - moved : moved - plain) * 65536;
      if (fabs(away - units) > 1.1 && fabs(away - 2 * units) > 1.1)
        fail_msg("reversed %u: %d units move depth by %g", reversed, units, away);
    }
    config.polygon_offset_constant = 200;
    config.polygon_offset_clamp = 0.001;
    covered(&f, &config, &ground, &moved);
    assert_true(fabs(fabs((double)moved - plain) - 0.001) < 1.1 / 65536);
    config.polygon_offset_clamp = 0;
  }
  close_fixture(&f);
}

/* ---- filters that turn ---- */

/* Whether a pixel and all that its normal is taken from lie on one level. */
static bool level(const float *depths, int x, int y) {
  const float *at = &depths[y * width + x];
  for (int i = -2; i <= 2; ++i)
    if (fabsf(at[i] - *at) > 1e-6f || fabsf(at[i * width] - *at) > 1e-6f)
      return false;
  return true;
}

/* A camera that moves by just a pixel sees the same points again: what a disc's points are turned by belongs to them.
 */
static void patterns_do_not_swim(void **state) {
  (void)state;
  fixture f;
  open_fixture(&f);
  shot *shot = &f.shot;
  memset(shot->camera.view, 0, sizeof shot->camera.view);
  memset(shot->camera.projection, 0, sizeof shot->camera.projection);
  shot->camera.view[0] = shot->camera.view[6] = shot->camera.view[15] = 1; /* straight down */
  shot->camera.view[9] = -1;
  shot->camera.projection[0] = 2.0 / (width / 8.0);
  shot->camera.projection[5] = 2.0 / (height / 8.0);
  shot->camera.projection[10] = -1.0 / 64;
  shot->camera.projection[15] = 1;
  for (uint32_t filter = CSM_FILTER_POISSON; filter <= CSM_FILTER_VOGEL; ++filter) {
    csm_config config = base_config();
    config.cascade_count = 1;
    config.filter = filter;
    config.shadow_distance = 64;
    config.filter_taps = 12;
    config.filter_radius_texels = 4;
    float *masks[2], *depths[2];
    for (int step = 0; step < 2; ++step) {
      shot->camera.view[12] = -step * 0.125;
      shot->camera.view[14] = -40; /* from 40 m above, so that nothing but the mast is cut */
      begin(&f, &config);
      masks[step] = support_image(f.context, f.view, CSM_READ_MASK, width, height);
      depths[step] = support_image(f.context, f.view, CSM_READ_CAMERA_DEPTH, width, height);
      end(&f);
    }
    uint32_t differ = 0, between = 0;
    for (int y = 2; y < height - 2; ++y)
      for (int x = 3; x < width - 3; ++x) {
        if (!level(depths[0], x, y) || !level(depths[1], x - 1, y))
          continue;
        const float a = masks[0][y * width + x], b = masks[1][y * width + x - 1];
        differ += fabsf(a - b) > 1.0f / 255 + 1e-6f;
        between += a > 0 && a < 1;
      }
    printf("filter %u: %u of %d pixels swim, %u are between light and shadow\n", filter, differ, pixels, between);
    assert_true(between > pixels / 50);
    assert_true(differ <= pixels / 10000);
    for (int step = 0; step < 2; ++step) {
      free(masks[step]);
      free(depths[step]);
    }
  }
  close_fixture(&f);
}

/* ---- from frame to frame ---- */

static void samples_settle_and_cost_nothing(void **state) {
  (void)state;
  fixture f;
  open_fixture(&f);
  for (uint32_t mode = CSM_DEPTH_SAMPLES_SPLITS; mode <= CSM_DEPTH_SAMPLES_BOUNDS; ++mode) {
    csm_config config = base_config();
    config.shadow_distance = 1000;
    config.depth_samples = mode;
    begin(&f, &config);
    csm_binding first = {.struct_size = sizeof first}, last = {.struct_size = sizeof last};
    assert_int_equal(csm_bind(f.cascades, &first), CSM_SUCCESS);
    float *before = NULL;
    for (int i = 0; i < 8; ++i) {
      const uint64_t allocations = f.record.allocations;
      render(&f);
      assert_true(i < 4 || f.record.allocations == allocations);
      float *mask = support_image(f.context, f.view, CSM_READ_MASK, width, height);
      if (i > 4)
        assert_memory_equal(mask, before, pixels * sizeof *mask);
      free(before);
      before = mask;
    }
    free(before);
    assert_int_equal(csm_bind(f.cascades, &last), CSM_SUCCESS);
    assert_true(last.cascades[2].far_depth < first.cascades[2].far_depth / 2);
    assert_true(last.cascades[2].texel_size < first.cascades[2].texel_size / 2);
    end(&f);
  }
  close_fixture(&f);
}

/* Maps that are turned with the light keep their turn when a setting changes, of whatever shape: the first frame after
   a new bias, and after other maps, has the matrices that it would have had. */
static void settings_keep_the_lights_roll(void **state) {
  (void)state;
  enum { STEPS = 24 };
  fixture f;
  csm_cascades *steady, *changed;
  csm_binding bindings[2];
  open_fixture(&f);
  csm_config config = base_config();
  config.light_roll = CSM_LIGHT_ROLL_CARRIED;
  assert_int_equal(csm_cascades_create(f.context, &config, &steady), CSM_SUCCESS);
  assert_int_equal(csm_cascades_create(f.context, &config, &changed), CSM_SUCCESS);
  csm_cascades *const both[2] = {steady, changed};
  double turned = 0;
  for (int step = 0; step < STEPS; ++step) { /* the sun goes round, so that the carried turn is not the fixed one */
    const double angle = 2 * 3.14159265358979 * step / STEPS;
    memcpy(f.shot.light.direction, (const double[]){cos(angle), -0.4, sin(angle)}, sizeof f.shot.light.direction);
    if (step == STEPS / 2) {
      config.bias_constant_texels += 0.5;
      assert_int_equal(csm_cascades_configure(changed, &config), CSM_SUCCESS);
    }
    if (step == STEPS / 2 + 4) {
      config.map_layout = CSM_LAYOUT_ATLAS; /* other images */
      assert_int_equal(csm_cascades_configure(changed, &config), CSM_SUCCESS);
      config.map_layout = CSM_LAYOUT_ARRAY;
      assert_int_equal(csm_cascades_configure(changed, &config), CSM_SUCCESS);
    }
    for (int i = 0; i < 2; ++i) {
      assert_int_equal(csm_render_cascades(both[i], shot_frame(&f.shot)), CSM_SUCCESS);
      bindings[i] = (csm_binding){.struct_size = sizeof bindings[i]};
      assert_int_equal(csm_bind(both[i], &bindings[i]), CSM_SUCCESS);
    }
    assert_memory_equal(bindings[0].cascades, bindings[1].cascades, sizeof bindings[0].cascades);
  }
  /* A set of cascades that begins here is turned another way: there was something to keep. */
  csm_cascades *fresh;
  assert_int_equal(csm_cascades_create(f.context, &config, &fresh), CSM_SUCCESS);
  assert_int_equal(csm_render_cascades(fresh, shot_frame(&f.shot)), CSM_SUCCESS);
  assert_int_equal(csm_bind(fresh, &bindings[1]), CSM_SUCCESS);
  for (int i = 0; i < 16; ++i)
    turned =
        fmax(turned, fabs(bindings[0].cascades[0].world_to_shadow[i] - bindings[1].cascades[0].world_to_shadow[i]));
  assert_true(turned > 1e-3);
  close_fixture(&f);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(beyond_is_lit_dark_or_faded),
      cmocka_unit_test(blends_go_over_at_both_ends),
      cmocka_unit_test(faces_are_culled_as_they_say),
      cmocka_unit_test(casters_before_the_near_plane_are_clamped_or_clipped),
      cmocka_unit_test(the_rasterisers_bias_moves_depth),
      cmocka_unit_test(patterns_do_not_swim),
      cmocka_unit_test(samples_settle_and_cost_nothing),
      cmocka_unit_test(settings_keep_the_lights_roll),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
