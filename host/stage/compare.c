#include "stage/compare.h"
#include <inttypes.h>
#include <stdlib.h>
#include <math.h>
#include <string.h>

const float compare_mask_tolerance = 1.0f / 255.0f + 1e-6f;
const double compare_mask_share = 1e-4;

static const char *const view_names[STAGE_VIEWS] = {
    [CSM_SHOW_CASCADE - 1] = "cascade", [CSM_SHOW_DENSITY - 1] = "density", [CSM_SHOW_PENUMBRA - 1] = "penumbra",
    [CSM_SHOW_HISTORY - 1] = "history", [CSM_SHOW_RAYS - 1] = "rays",       [CSM_SHOW_PAGES - 1] = "pages",
};

/* Floats in the order of their values as integers, so that neighbours are 1 apart. */
static int64_t float_order(float value) {
  int32_t bits;
  memcpy(&bits, &value, sizeof bits);
  return bits < 0 ? (int64_t)INT32_MIN - bits : bits;
}

depth_difference compare_depths(const float *a, const float *b, size_t count) {
  depth_difference difference = {0};
  if (memcmp(a, b, count * sizeof *a) == 0)
    return difference;
  for (size_t i = 0; i < count; i++) {
    const int64_t apart = llabs(float_order(a[i]) - float_order(b[i]));
    difference.differing += memcmp(&a[i], &b[i], sizeof *a) != 0;
    if (apart > difference.max_ulp)
      difference.max_ulp = (uint32_t)(apart > UINT32_MAX ? UINT32_MAX : apart);
  }
  return difference;
}

static bool blocks_equal(const void *a, uint32_t size_a, const void *b, uint32_t size_b) {
  return size_a == size_b && (size_a == 0 || memcmp(a, b, size_a) == 0);
}

static bool bindings_equal(const csm_binding *a, const csm_binding *b) {
  return a->cascade_count == b->cascade_count && memcmp(a->resolutions, b->resolutions, sizeof a->resolutions) == 0 &&
         memcmp(a->origin, b->origin, sizeof a->origin) == 0 &&
         memcmp(a->cascades, b->cascades, a->cascade_count * sizeof a->cascades[0]) == 0 &&
         blocks_equal(a->cascade_constants, a->cascade_constants_size, b->cascade_constants,
                      b->cascade_constants_size) &&
         blocks_equal(a->setting_constants, a->setting_constants_size, b->setting_constants, b->setting_constants_size);
}

static bool within(const depth_difference *difference, uint32_t allowed_ulp) {
  return allowed_ulp == 0 ? difference->differing == 0 : difference->max_ulp <= allowed_ulp;
}

static void compare_masks(agreement *out, const float *a, const float *b, size_t count) {
  out->mask_pixels = count;
  for (size_t i = 0; i < count; i++) {
    const float apart = fabsf(a[i] - b[i]);
    out->mask_beyond += !(apart <= compare_mask_tolerance);
    out->mask_largest = fmaxf(out->mask_largest, apart);
  }
  out->mask_agrees = (double)out->mask_beyond <= compare_mask_share * (double)count;
}

/* One device gives the same bits; of two, rounding may decide otherwise at a few pixels. */
static void compare_views(agreement *out, const stage_frame *a, const stage_frame *b, size_t pixels, size_t instances) {
  out->has_views = a->casters && b->casters;
  out->views_agree = out->casters_equal = true;
  if (!out->has_views)
    return;
  for (uint32_t i = 0; i < STAGE_VIEWS; i++) {
    out->has_view[i] = a->views[i] && b->views[i];
    for (size_t at = 0; at < pixels && out->has_view[i]; at++)
      out->views[i] += a->views[i][at] != b->views[i][at];
    const double allowed = out->allowed_ulp == 0 ? 0.0 : compare_mask_share * (double)pixels;
    out->views_agree = out->views_agree && (double)out->views[i] <= allowed;
  }
  out->casters_equal = memcmp(a->casters, b->casters, instances) == 0;
  out->views_agree = out->views_agree && out->casters_equal;
}

void compare_frames(agreement *out, const stage *a, const stage_frame *frame_a, const stage *b,
                    const stage_frame *frame_b) {
  const size_t pixels = (size_t)a->setup->width * a->setup->height;
  *out = (agreement){.cascade_count = frame_a->binding.cascade_count,
                     .allowed_ulp = strcmp(a->device, b->device) == 0 ? 0 : 2,
                     .plans_equal = frame_a->stats.maps.plan_hash == frame_b->stats.maps.plan_hash &&
                                    bindings_equal(&frame_a->binding, &frame_b->binding),
                     .depth_agrees = true};
  for (uint32_t k = 0; k < out->cascade_count; k++) {
    out->maps[k] = compare_depths(frame_a->maps[k], frame_b->maps[k], stage_map_texels(frame_a, k));
    out->depth_agrees = out->depth_agrees && within(&out->maps[k], out->allowed_ulp);
  }
  out->camera_depth = compare_depths(frame_a->camera_depth, frame_b->camera_depth, pixels);
  out->depth_agrees = out->depth_agrees && within(&out->camera_depth, out->allowed_ulp);
  compare_masks(out, frame_a->mask, frame_b->mask, pixels);
  compare_views(out, frame_a, frame_b, pixels, a->setup->scene.instance_count);
  out->agrees = out->plans_equal && out->depth_agrees && out->mask_agrees && out->views_agree;
}

static void print_depth(FILE *to, const char *name, const depth_difference *difference) {
  if (difference->differing)
    fprintf(to, " %s %" PRIu64 " texels, up to %" PRIu32 " ulp;", name, difference->differing, difference->max_ulp);
}

static void print_views(FILE *to, const agreement *result) {
  const char *separator = "", *unit = " pixels";
  fprintf(to, "  views        %s:", result->views_agree ? "agree" : "DIFFER");
  for (uint32_t i = 0; i < STAGE_VIEWS; i++) {
    if (!result->has_view[i])
      continue;
    fprintf(to, "%s %" PRIu64 "%s of %s", separator, result->views[i], unit, view_names[i]);
    separator = ",", unit = "";
  }
  fprintf(to, " differ; casters %s\n", result->casters_equal ? "are the same" : "DIFFER");
}

void agreement_print(FILE *to, const agreement *result, const char *name_a, const char *name_b) {
  bool differs = result->camera_depth.differing != 0;
  for (uint32_t k = 0; k < result->cascade_count; k++)
    differs = differs || result->maps[k].differing != 0;
  fprintf(to, "  plans        %s\n", result->plans_equal ? "equal, byte for byte" : "DIFFER");
  fprintf(to, "  depth maps   %s", differs ? (result->depth_agrees ? "within tolerance:" : "DIFFER:") : "bit-equal");
  for (uint32_t k = 0; k < result->cascade_count; k++) {
    char name[16];
    snprintf(name, sizeof name, "map %u", k);
    print_depth(to, name, &result->maps[k]);
  }
  print_depth(to, "camera depth", &result->camera_depth);
  fprintf(
      to, "\n  masks        %s: %" PRIu64 " of %" PRIu64 " pixels differ by more than 1/255, largest difference %.6g\n",
      result->mask_agrees ? "agree" : "DIFFER", result->mask_beyond, result->mask_pixels, (double)result->mask_largest);
  if (result->has_views)
    print_views(to, result);
  fprintf(to, "  verdict      %s and %s %s\n", name_a, name_b, result->agrees ? "AGREE" : "DIFFER");
}

static json_t *depth_to_json(const depth_difference *difference) {
  json_t *object = json_object();
  json_object_set_new(object, "differing", json_integer((json_int_t)difference->differing));
  json_object_set_new(object, "max_ulp", json_integer(difference->max_ulp));
  return object;
}

static json_t *views_to_json(const agreement *result) {
  json_t *object = json_object();
  json_object_set_new(object, "agree", json_boolean(result->views_agree));
  for (uint32_t i = 0; i < STAGE_VIEWS; i++) {
    char key[32];
    snprintf(key, sizeof key, "%s_differing", view_names[i]);
    if (result->has_view[i])
      json_object_set_new(object, key, json_integer((json_int_t)result->views[i]));
  }
  json_object_set_new(object, "casters_equal", json_boolean(result->casters_equal));
  return object;
}

json_t *agreement_to_json(const agreement *result) {
  json_t *object = json_object(), *maps = json_array();
  for (uint32_t k = 0; k < result->cascade_count; k++)
    json_array_append_new(maps, depth_to_json(&result->maps[k]));
  json_object_set_new(object, "agrees", json_boolean(result->agrees));
  json_object_set_new(object, "plans_equal", json_boolean(result->plans_equal));
  json_object_set_new(object, "allowed_ulp", json_integer(result->allowed_ulp));
  json_object_set_new(object, "maps", maps);
  json_object_set_new(object, "camera_depth", depth_to_json(&result->camera_depth));
  json_object_set_new(object, "mask_pixels", json_integer((json_int_t)result->mask_pixels));
  json_object_set_new(object, "mask_beyond", json_integer((json_int_t)result->mask_beyond));
  json_object_set_new(object, "mask_largest", json_real(result->mask_largest));
  if (result->has_views)
    json_object_set_new(object, "views", views_to_json(result));
  return object;
}
