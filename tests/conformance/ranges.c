/*
 * ranges.c: a mask of exact_soft searches no farther than ranges say, a view of its rays all the way. Both must ask rays for
 * the same pixels, whatever the maps are like.
 */
#include "rays_model.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 240, HEIGHT = 160, PIXELS = WIDTH * HEIGHT };

static csm_config soft_config(void) {
  csm_config config = support_config();
  config.filter = CSM_FILTER_EXACT_SOFT;
  config.resolution = 512;
  config.soft_search_taps = 48;
  config.soft_radius_max_texels = 100;
  config.ray_taps = 2;
  config.ray_unsure_cosine = 0;
  config.ray_grazing_cosine = 0;
  config.bias_constant_texels = 0.05;
  return config;
}

static void open_model(rays_model *m, csm_config *config) {
  rays_open(m, 0, NULL);
  m->shot.frame.scene = m->scene;
  *config = soft_config();
}

/* Draws what `show` says, and gives the image, and how many pixels asked a ray. */
static float *draw(rays_model *m, csm_cascades *cascades, uint32_t show, uint32_t *asked) {
  const csm_mask_info info = {
      .struct_size = sizeof info, .frame = shot_frame(&m->shot), .width = WIDTH, .height = HEIGHT, .show = show};
  assert_int_equal(csm_resolve_mask(m->view, cascades, &info), CSM_SUCCESS);
  csm_view_stats stats = {.struct_size = sizeof stats};
  assert_int_equal(csm_get_view_stats(m->view, &stats), CSM_SUCCESS);
  *asked = stats.ray_pixels;
  return support_image(m->context, m->view, CSM_READ_MASK, WIDTH, HEIGHT);
}

/* Where the view asked no ray the map has decided, so that the light is seen, or it is hidden. */
static void compare(rays_model *m, csm_cascades *cascades, const char *what) {
  uint32_t by_mask, by_view, lit = 0, dark = 0, wrong = 0;
  assert_int_equal(csm_render_cascades(cascades, shot_frame(&m->shot)), CSM_SUCCESS);
  float *mask = draw(m, cascades, CSM_SHOW_VISIBILITY, &by_mask);
  float *view = draw(m, cascades, CSM_SHOW_RAYS, &by_view);
  for (uint32_t i = 0; i < PIXELS && rays_draw(); ++i) {
    if (view[i] > 0.0f)
      continue;
    lit += mask[i] == 1.0f;
    dark += mask[i] == 0.0f;
    wrong += mask[i] > 0.0f && mask[i] < 1.0f;
  }
  print_message("%s: %u pixels lit, %u dark, %u asked\n", what, lit, dark, by_mask);
  assert_int_equal(by_mask, by_view);
  assert_int_equal(wrong, 0);
  if (rays_draw())
    assert_true(by_view > PIXELS / 500 && lit > PIXELS / 10 && dark > PIXELS / 500);
  free(mask);
  free(view);
}

/* Under lights of every size: penumbras of less than a texel, and ones that fill all that is searched. */
static void check(rays_model *m, const csm_config *config, const char *what) {
  static const double diameters[] = {0.01, 0.05, 0.2};
  csm_cascades *cascades = rays_cascades(m, config);
  for (int i = 0; i < 3; ++i) {
    m->shot.light.angular_diameter = diameters[i];
    compare(m, cascades, what);
  }
  assert_int_equal(csm_cascades_destroy(cascades), CSM_SUCCESS);
}

static void maps_of_every_kind(void **state) {
  (void)state;
  rays_model m = {0};
  csm_config config;
  open_model(&m, &config);
  check(&m, &config, "as it is");
  config.map_format = CSM_MAP_D16;
  check(&m, &config, "16 bits");
  config.map_reversed = 1;
  check(&m, &config, "16 bits, reversed");
  config.map_layout = CSM_LAYOUT_ATLAS;
  check(&m, &config, "the same in an atlas");
  rays_close(&m);
}

/* Sides that blocks do not divide, and maps that are smaller than the largest. */
static void maps_of_every_size(void **state) {
  static const uint32_t sides[] = {612, 333, 250};
  (void)state;
  rays_model m = {0};
  csm_config config;
  open_model(&m, &config);
  memcpy(config.resolutions, sides, sizeof sides);
  check(&m, &config, "three sizes");
  config.map_layout = CSM_LAYOUT_ATLAS;
  check(&m, &config, "three sizes in an atlas");
  rays_close(&m);
}

/* A search that goes farther than ranges do, and one of a texel. */
static void searches_of_every_radius(void **state) {
  static const double radii[] = {1, 15, 143, 200};
  (void)state;
  rays_model m = {0};
  csm_config config;
  open_model(&m, &config);
  for (size_t i = 0; i < sizeof radii / sizeof *radii; ++i) {
    char what[32];
    snprintf(what, sizeof what, "%g texels", radii[i]);
    config.soft_radius_max_texels = radii[i];
    check(&m, &config, what);
  }
  rays_close(&m);
}

/* Ranges are of the maps that were drawn last: what moves comes into them. */
static void what_moves_is_in_them(void **state) {
  (void)state;
  rays_model m = {0};
  csm_config config;
  open_model(&m, &config);
  m.shot.light.angular_diameter = 0.05;
  csm_cascades *cascades = rays_cascades(&m, &config);
  for (int step = 0; step < 4; ++step) {
    compare(&m, cascades, "a step");
    compare(&m, cascades, "and nothing moves");
    m.instances[1 + step].transform[13] += 2;
    rays_move(&m, 1 + (uint32_t)step);
  }
  rays_close(&m);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(maps_of_every_kind),
      cmocka_unit_test(maps_of_every_size),
      cmocka_unit_test(searches_of_every_radius),
      cmocka_unit_test(what_moves_is_in_them),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
