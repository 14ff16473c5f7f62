/*
 * What the documents get wrong in their shaders: each formula stands here as they have it and fails what it is for;
 * csm_sample.inc, compiled for the CPU, does not.
 */
#include "maps.h"

#include <math.h>
#include <stdlib.h>

static const double sun[3] = {0.3, -1.0, 0.2}, up[3] = {0.0, 1.0, 0.0};
static const double floor_point[3] = {0.5, -2.0, -8.0};

static test_maps *maps;

static int make_maps(void **state) {
  (void)state;
  maps = malloc(sizeof *maps);
  return maps == NULL;
}

static int free_maps(void **state) {
  (void)state;
  free(maps);
  return 0;
}

static double dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* How the depth of a plane changes for a texel to the right and for one down, by the plan's own matrix. */
static void slopes_of(double out[2], const plan_cascade *cascade, const double normal[3]) {
  double back[16], origin[3], steps[3][3];
  assert_true(plan_invert(back, cascade->info.world_to_shadow));
  transform_point(back, (double[3]){0}, origin);
  for (int axis = 0; axis < 3; ++axis) {
    double at[3] = {0};
    at[axis] = axis == 2 ? 1.0 : 1.0 / cascade->resolution;
    transform_point(back, at, steps[axis]);
    for (int k = 0; k < 3; ++k)
      steps[axis][k] -= origin[k];
  }
  for (int axis = 0; axis < 2; ++axis)
    out[axis] = -dot(normal, steps[axis]) / dot(normal, steps[2]);
}

static float slope_bias(int cascade, const double normal[3]) {
  return sampler_bias(cascade, (float[]){(float)normal[0], (float)normal[1], (float)normal[2]});
}

/* A unit normal at an angle to the light whose cosine is given. */
static void tilted(double out[3], const plan_frame *frame, double cosine) {
  const double sine = sqrt(1.0 - cosine * cosine);
  for (int k = 0; k < 3; ++k)
    out[k] = sine * frame->basis[k] - cosine * frame->basis[6 + k];
}

/* ---- OGLDev 49 ---- */

static bool ogldev_shadows(float depth, float z) {
  return depth < z + 0.00001f;
}

static void ogldevs_bias_shadows_what_is_lit(void **state) {
  (void)state;
  assert_true(ogldev_shadows(0.5f, 0.5f));
  assert_false(ogldev_shadows(0.5f, 0.5f - 0.00002f));
  const csm_config config = default_config();
  maps_make(maps, &config, sun);
  double facing[3];
  tilted(facing, &maps->frame, 1.0);
  maps_draw_plane(maps, facing, floor_point, 0.0); /* exactly the receiver's depth */
  assert_near(maps_visibility(floor_point, facing), 1.0, 1e-6);
  maps_draw_plane(maps, facing, floor_point, 1.0);
  assert_true(maps_visibility(floor_point, facing) == 0.0f);
}

static float ogldev_factor(const double *ends, int count, double depth) {
  float factor = 0.0f;
  for (int i = 0; i < count; ++i)
    if (depth <= ends[i]) {
      factor = 1.0f;
      break;
    }
  return factor;
}

static void ogldev_leaves_all_beyond_in_the_dark(void **state) {
  (void)state;
  assert_true(ogldev_factor((double[]){25.0, 90.0, 150.0}, 3, 151.0) == 0.0f);
  const csm_config config = default_config();
  maps_make(maps, &config, sun);
  maps_draw_plane(maps, up, (double[]){0.0, 5.0, 0.0}, 0.0); /* a ceiling, over all maps */
  assert_true(maps_visibility((double[]){0.0, -2.0, -100.0}, up) == 0.0f);
  assert_true(maps_visibility((double[]){0.0, -2.0, -151.0}, up) == 1.0f);
}

/* ---- which cascade ---- */

static int nvidia_index(double depth, const double far_depths[4]) {
  int index = 3;
  if (depth < far_depths[0])
    index = 0;
  else if (depth < far_depths[1])
    index = 1;
  else if (depth < far_depths[2])
    index = 2;
  return index;
}

static int microsoft_index(double depth, const double *far_depths, int count) {
  double index = 0.0;
  for (int i = 0; i < count; ++i)
    index += depth > far_depths[i];
  return (int)fmin(index, count);
}

/* Maps of so many cascades, all dark: whatever is asked of them, nothing else is read. */
static void check_indices(uint32_t count) {
  csm_config config = default_config();
  config.cascade_count = count;
  config.selection = CSM_SELECT_INTERVAL;
  maps_make(maps, &config, sun);
  maps_draw_plane(maps, up, (double[]){0.0, 5.0, 0.0}, 0.0);
  const float normal[3] = {0.0f, 1.0f, 0.0f};
  for (double depth = 0.05; depth < 400.0; depth *= 1.01) {
    const int selected = sampler_select((float)depth);
    const float position[3] = {0.0f, 0.0f, (float)-depth};
    const int cascade = sampler_cascade(position, normal, (float)depth);
    assert_true(depth > config.shadow_distance ? selected == (int)count : selected < (int)count);
    assert_true(cascade >= selected && cascade <= (int)count);
    assert_true(sampler_visibility(position, normal, (float)depth) == (depth > config.shadow_distance ? 1.0f : 0.0f));
  }
  assert_false(sampler_read_outside());
}

static void nvidias_index_is_3_with_fewer_maps(void **state) {
  (void)state;
  const double two[4] = {25.0, 90.0, 0.0, 0.0};
  assert_int_equal(nvidia_index(24.0, two), 0);
  assert_true(nvidia_index(91.0, two) >= 2);
  for (uint32_t count = 1; count <= 3; ++count)
    check_indices(count);
}

static void microsofts_index_may_be_the_count(void **state) {
  (void)state;
  const double four[4] = {10.0, 25.0, 60.0, 150.0};
  assert_int_equal(microsoft_index(149.0, four, 4), 3);
  assert_false(microsoft_index(151.0, four, 4) < 4);
  for (uint32_t count = 4; count <= CSM_MAX_CASCADES; ++count)
    check_indices(count);
}

/* ---- the receiver's plane ---- */

/* The depths that Microsoft's loop compares with, and those of the plane, at the taps of a 3 x 3 filter. */
static void microsoft_references(double out[3][3], double depth, double right, double above) {
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y) {
      depth += right * x + above * y;
      out[x + 1][y + 1] = depth;
    }
}

static void microsofts_reference_runs_on(void **state) {
  (void)state;
  double references[3][3];
  microsoft_references(references, 0.0, 1.0, 1.0);
  assert_true(references[1][1] == -4.0); /* at the sample itself */

  /* On a plane every tap is lit, just so; a hundredth of a texel's slope before it, none is. */
  csm_config config = default_config();
  config.bias_constant_texels = 0.01;
  config.bias_slope_texels = 0.0;
  maps_make(maps, &config, sun);
  double slant[3]; /* on which depth falls to the right and down, so that the references lie behind the plane */
  for (int k = 0; k < 3; ++k)
    slant[k] = 0.6 * maps->frame.basis[3 + k] - 0.48 * maps->frame.basis[k] - 0.64 * maps->frame.basis[6 + k];
  const double texel = maps->frame.cascades[0].info.texel_size;
  double slopes[2];
  slopes_of(slopes, &maps->frame.cascades[0], slant);
  microsoft_references(references, 0.0, slopes[0], slopes[1]);
  int shadowed = 0;
  for (int x = 0; x < 3; ++x)
    for (int y = 0; y < 3; ++y)
      shadowed += references[x][y] - 0.01 * texel / maps->frame.cascades[0].info.depth_range >
                  slopes[0] * (x - 1) + slopes[1] * (y - 1);
  assert_in_range(shadowed, 5, 9);
  const double on_it[3] = {0.1, -0.2, -1.5};
  maps_draw_plane(maps, slant, on_it, 0.0);
  assert_near(maps_visibility(on_it, slant), 1.0, 1e-6);
  maps_draw_plane(maps, slant, on_it, 0.02 * texel);
  assert_true(maps_visibility(on_it, slant) == 0.0f);
}

/* Of the inverse of Microsoft's matrix, from screen to shadow. */
static double microsoft_inverse_determinant(const double ddx[2], const double ddy[2]) {
  return 1.0 / (ddx[0] * ddy[1] - ddx[1] * ddy[0]);
}

static void microsofts_determinant_has_no_guard(void **state) {
  (void)state;
  /* A surface seen edge-on by the light: both derivatives run along one line of the map */
  assert_true(isinf(microsoft_inverse_determinant((double[]){0.25, 0.5}, (double[]){0.125, 0.25})));
  const csm_config config = default_config();
  random_state random = {1};
  maps_make(maps, &config, sun);
  for (int i = 0; i < 2000; ++i) {
    const double angle = random_between(&random, 0.0, 2.0 * M_PI);
    const double off = i % 2 ? 0.0 : random_scale(&random, 1e-12, 1e-2) * (i % 4 ? -1.0 : 1.0);
    float normal[3], plane[2];
    for (int k = 0; k < 3; ++k)
      normal[k] = (float)(cos(angle) * maps->frame.basis[k] + sin(angle) * maps->frame.basis[3 + k] +
                          off * maps->frame.basis[6 + k]);
    for (int c = 0; c < 4; ++c) {
      const csm_cascade_info *info = &maps->frame.cascades[c].info;
      sampler_plane(plane, c, normal);
      for (int axis = 0; axis < 2; ++axis)
        assert_true(fabs(plane[axis]) <= 1.0001 * config.bias_slope_max * info->texel_size / info->depth_range);
      assert_true(isfinite(sampler_bias(c, normal)));
    }
  }
}

/* Gradients that were scaled for one cascade are not another's. */
static void microsofts_blend_reuses_gradients(void **state) {
  (void)state;
  csm_config config = default_config();
  config.depth_mode = CSM_DEPTH_SLICE; /* ranges that do not grow as texels do */
  random_state random = {2};
  for (uint32_t fit = 0; fit <= CSM_FIT_SCENE_SQUARE; ++fit)
    for (uint32_t reversed = 0; reversed <= 1; ++reversed) {
      config.fit_mode = fit;
      config.map_reversed = reversed;
      maps_make(maps, &config, sun);
      for (int i = 0; i < 100; ++i) {
        double normal[3], scaled_for_0[2];
        do
          random_unit(&random, normal);
        while (fabs(dot(normal, &maps->frame.basis[6])) < 0.2);
        slopes_of(scaled_for_0, &maps->frame.cascades[0], normal);
        for (int c = 0; c < 4; ++c) {
          double right[2];
          float own[2];
          slopes_of(right, &maps->frame.cascades[c], normal);
          sampler_plane(own, c, (float[]){(float)normal[0], (float)normal[1], (float)normal[2]});
          for (int axis = 0; axis < 2; ++axis) {
            /* The look-up turns it for reversed maps */
            const double turned = reversed ? -(double)own[axis] : (double)own[axis];
            assert_near(turned, right[axis], 1e-5 * (fabs(right[0]) + fabs(right[1])));
          }
          if (c == 3)
            assert_true(fabs(right[0]) > 2.0 * fabs(scaled_for_0[0]));
        }
      }
    }
}

/* Where a pixel's ray meets the plane, in the first cascade's map. */
static void place_of_pixel(double out[3], double x, double y, const double normal[3]) {
  const test_camera camera = plain_camera();
  double p[3];
  camera_point(&camera, 2.0 * x / 1920.0 - 1.0, 1.0 - 2.0 * y / 1080.0, 1.0, p);
  const double depth = dot(normal, floor_point) / dot(normal, p);
  for (int k = 0; k < 3; ++k)
    p[k] *= depth;
  transform_point(maps->frame.cascades[1].info.world_to_shadow, p, out);
}

static void the_surveys_receiver_plane_has_the_wrong_units(void **state) {
  (void)state;
  const csm_config config = default_config();
  maps_make(maps, &config, sun);
  double at[3], ddx[3], ddy[3];
  place_of_pixel(at, 960.0, 900.0, up);
  place_of_pixel(ddx, 961.0, 900.0, up);
  place_of_pixel(ddy, 960.0, 901.0, up);
  for (int k = 0; k < 3; ++k) {
    ddx[k] -= at[k];
    ddy[k] -= at[k];
  }
  const double texel = 1.0 / maps_side, documents = texel * (fabs(ddx[2]) + fabs(ddy[2]));
  /* By the inverse transpose of the Jacobian, the change of depth for a texel */
  const double determinant = ddx[0] * ddy[1] - ddx[1] * ddy[0];
  const double right[2] = {(ddx[2] * ddy[1] - ddy[2] * ddx[1]) / determinant * texel,
                           (ddy[2] * ddx[0] - ddx[2] * ddy[0]) / determinant * texel};
  assert_true(fabs(right[0]) + fabs(right[1]) > 100.0 * documents);
  float own[2];
  sampler_plane(own, 1, (float[]){0.0f, 1.0f, 0.0f});
  for (int axis = 0; axis < 2; ++axis)
    assert_near(own[axis], right[axis], 1e-4 * (fabs(right[0]) + fabs(right[1])));
}

/* ---- the band of a blend ---- */

/* How long Microsoft's band is before the end of a cascade, as the sample's live code has it. */
static double microsoft_band(const double *ends, int cascade, double share) {
  const int base = cascade - 1 < 0 ? cascade - 1 : 0; /* min(0, cascade - 1) */
  return share * (ends[cascade] - ends[base]);
}

static void microsofts_blend_begins_at_the_wrong_split(void **state) {
  (void)state;
  csm_config config = default_config();
  config.blend_mode = CSM_BLEND_LINEAR;
  config.selection = CSM_SELECT_INTERVAL;
  maps_make(maps, &config, sun);
  double ends[4];
  for (int c = 0; c < 4; ++c)
    ends[c] = maps->frame.cascades[c].info.far_depth;
  assert_true((0 - 1 < 0 ? 0 - 1 : 0) < 0); /* the first one's base lies before the array */
  const float normal[3] = {0.0f, 1.0f, 0.0f};
  for (int c = 0; c < 4; ++c) {
    const double near = maps->frame.cascades[c].info.near_depth, band = config.blend_share * (ends[c] - near);
    if (c >= 2)
      assert_true(microsoft_band(ends, c, config.blend_share) > 1.1 * band);
    static const double shares[] = {-0.05, 0.05, 0.5, 0.95, 1.0};
    for (int i = 0; i < 5; ++i) {
      const double depth = ends[c] - band * (1.0 - shares[i]);
      const float position[3] = {0.0f, 0.0f, (float)-depth};
      assert_near(sampler_blend(c, position, normal, (float)depth), fmax(shares[i], 0.0), 1e-3);
    }
  }
}

/* ---- biases ---- */

static double survey_bias(double cosine) {
  return 0.001 + 0.005 * sqrt(1.0 - cosine * cosine) / cosine;
}

static void the_surveys_slope_bias_has_no_bound(void **state) {
  (void)state;
  assert_near(survey_bias(0.01), 0.5, 0.01); /* half the depth range */
  assert_true(survey_bias(0.001) > 1.0);
  csm_config config = default_config();
  for (uint32_t mode = CSM_BIAS_SLOPE; mode <= CSM_BIAS_RECEIVER_PLANE; ++mode) {
    config.bias_mode = mode;
    config.bias_slope_range = 0.0;
    config.bias_limit_range = 0.0;
    maps_make(maps, &config, sun);
    const double reach = mode == CSM_BIAS_SLOPE ? 2.0 : 0.5;
    for (int c = 0; c < 4; ++c) {
      const csm_cascade_info *info = &maps->frame.cascades[c].info;
      const double texel = info->texel_size / info->depth_range;
      const double most = (config.bias_constant_texels + config.bias_slope_max * reach) * texel;
      double last = 0.0, normal[3];
      for (double cosine = 1.0; cosine > 1e-6; cosine *= 0.8) {
        tilted(normal, &maps->frame, cosine);
        const double bias = slope_bias(c, normal);
        assert_true(bias >= last * (1.0 - 1e-5) && bias <= most * (1.0 + 1e-5));
        last = bias;
      }
      assert_near(last, most, 1e-4 * most);
    }
    /* The survey's own numbers, with a limit */
    config.bias_slope_range = 0.005;
    config.bias_limit_range = 0.01;
    maps_make(maps, &config, sun);
    double normal[3];
    tilted(normal, &maps->frame, 0.01);
    const double level = config.bias_constant_texels * maps->frame.cascades[0].info.texel_size /
                         maps->frame.cascades[0].info.depth_range;
    assert_near(slope_bias(0, normal), level + 0.01, 1e-6);
  }
}

/* What a rasteriser adds to a depth of D32F: so many units of the largest exponent in the primitive. */
static double d32_bias(double units, double depth) {
  int exponent;
  (void)frexp(depth, &exponent);
  return ldexp(units, exponent - 1 - 23);
}

/* By how much nearer than the receiver a map's surface may be before it shadows it. */
static double measured_bias(const double receiver[3], const double normal[3]) {
  double low = 0.0, high = 10.0;
  for (int i = 0; i < 40; ++i) {
    const double tried = (low + high) / 2.0;
    maps_draw_plane(maps, normal, receiver, tried);
    *(maps_visibility(receiver, normal) > 0.5f ? &low : &high) = tried;
  }
  return low;
}

static void the_surveys_raster_bias_goes_with_the_exponent(void **state) {
  (void)state;
  assert_near(d32_bias(100000.0, 0.05), 3.7e-4, 5e-6);
  assert_near(d32_bias(100000.0, 0.6), 6.0e-3, 5e-5);
  csm_config config = default_config();
  assert_true(config.polygon_offset_constant == 0.0);
  config.cascade_count = 1;
  config.shadow_distance = 20.0;
  maps_make(maps, &config, sun);
  double facing[3], biases[2], depths[2];
  tilted(facing, &maps->frame, 1.0);
  for (int i = 0; i < 2; ++i) {
    double receiver[3] = {0.0, 0.0, -14.0};
    for (int k = 0; k < 3; ++k)
      receiver[k] += (i ? 6.0 : -6.0) * maps->frame.basis[6 + k];
    depths[i] = shadow_depth(&maps->frame.cascades[0].info, receiver);
    biases[i] = measured_bias(receiver, facing);
  }
  assert_true(depths[1] > depths[0] + 0.2);
  assert_near(biases[0], config.bias_constant_texels * maps->frame.cascades[0].info.texel_size, 1e-4);
  assert_near(biases[1], biases[0], 1e-4);
}

/* Faces turned to the light are left out, so the map holds the underside of a box that stands on the floor. */
static void the_surveys_front_culling_leaks_with_a_bias(void **state) {
  (void)state;
  const float bias = 0.005f, fragment = 0.5f, underside = 0.5f;
  assert_false(fragment - bias > underside); /* lit, under the box */
  const csm_config config = default_config();
  assert_int_equal(config.face_culling, CSM_FACE_CULLING_NONE);
  maps_make(maps, &config, sun);
  const double top[3] = {floor_point[0], floor_point[1] + 1.0, floor_point[2]};
  maps_draw_plane(maps, up, top, 0.0);
  assert_true(maps_visibility(floor_point, up) == 0.0f);
}

/* ---- points ---- */

static double least_distance(const float points[16][2]) {
  double least = INFINITY;
  for (int a = 0; a < 16; ++a)
    for (int b = 0; b < a; ++b)
      least = fmin(least, hypot(points[a][0] - points[b][0], points[a][1] - points[b][1]));
  return least;
}

static void the_survey_gives_4_of_its_16_points(void **state) {
  (void)state;
  static const float documents[16][2] = {{-0.94201624f, -0.39906216f},
                                         {0.94558609f, -0.76890725f},
                                         {-0.094184101f, -0.92938870f},
                                         {0.34495938f, 0.29387760f}};
  float own[16][2];
  sampler_poisson(own);
  assert_true(least_distance(documents) == 0.0);              /* the other twelve are all at the middle */
  assert_true(hypot(documents[1][0], documents[1][1]) > 1.0); /* and one of the four is outside of the disc */
  assert_true(least_distance((const float(*)[2])own) >= 0.4);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(ogldevs_bias_shadows_what_is_lit),
      cmocka_unit_test(ogldev_leaves_all_beyond_in_the_dark),
      cmocka_unit_test(nvidias_index_is_3_with_fewer_maps),
      cmocka_unit_test(microsofts_index_may_be_the_count),
      cmocka_unit_test(microsofts_reference_runs_on),
      cmocka_unit_test(microsofts_determinant_has_no_guard),
      cmocka_unit_test(microsofts_blend_reuses_gradients),
      cmocka_unit_test(the_surveys_receiver_plane_has_the_wrong_units),
      cmocka_unit_test(microsofts_blend_begins_at_the_wrong_split),
      cmocka_unit_test(the_surveys_slope_bias_has_no_bound),
      cmocka_unit_test(the_surveys_raster_bias_goes_with_the_exponent),
      cmocka_unit_test(the_surveys_front_culling_leaks_with_a_bias),
      cmocka_unit_test(the_survey_gives_4_of_its_16_points),
  };
  return cmocka_run_group_tests_name("plan-document-shaders", tests, make_maps, free_maps);
}
