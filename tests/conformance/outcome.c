#include "outcome.h"

#include <stdlib.h>
#include <string.h>

outcome outcome_draw(csm_context *context, csm_cascades *cascades, csm_view *view, shot *shot) {
  outcome out = {0};
  csm_stats stats = {.struct_size = sizeof stats};
  csm_binding binding = {.struct_size = sizeof binding};
  const csm_result rendered = csm_render_cascades(cascades, shot_frame(shot));
  if (rendered)
    fail_msg("%s: %s", csm_result_name(rendered), csm_last_error(context));
  const csm_result resolved = shot_resolve(shot, view, cascades, OUTCOME_WIDTH, OUTCOME_HEIGHT);
  if (resolved)
    fail_msg("%s: %s", csm_result_name(resolved), csm_last_error(context));
  assert_int_equal(csm_get_stats(cascades, &stats), CSM_SUCCESS);
  assert_int_equal(csm_bind(cascades, &binding), CSM_SUCCESS);
  out.plan_hash = stats.plan_hash;
  out.cascades = binding.cascade_count;
  for (uint32_t i = 0; i < out.cascades; ++i) {
    out.resolutions[i] = binding.resolutions[i];
    out.maps[i] = support_map(context, cascades, i, binding.resolutions[i]);
  }
  out.mask = support_image(context, view, CSM_READ_MASK, OUTCOME_WIDTH, OUTCOME_HEIGHT);
  out.depth = support_image(context, view, CSM_READ_CAMERA_DEPTH, OUTCOME_WIDTH, OUTCOME_HEIGHT);
  return out;
}

void outcome_free(outcome *outcome) {
  for (uint32_t i = 0; i < outcome->cascades; ++i)
    free(outcome->maps[i]);
  free(outcome->mask);
  free(outcome->depth);
  *outcome = (struct outcome){0};
}

bool outcome_same_maps(const outcome *a, const outcome *b) {
  bool same = a->cascades == b->cascades;
  for (uint32_t i = 0; same && i < a->cascades; ++i) {
    const size_t texels = (size_t)a->resolutions[i] * a->resolutions[i];
    same = a->resolutions[i] == b->resolutions[i] && !memcmp(a->maps[i], b->maps[i], texels * sizeof(float));
  }
  return same;
}

bool outcome_same_mask(const outcome *a, const outcome *b) {
  return !memcmp(a->mask, b->mask, OUTCOME_WIDTH * OUTCOME_HEIGHT * sizeof(float));
}

bool outcome_same_depth(const outcome *a, const outcome *b) {
  return !memcmp(a->depth, b->depth, OUTCOME_WIDTH * OUTCOME_HEIGHT * sizeof(float));
}

void outcome_expect_same(const outcome *a, outcome *b, const char *what) {
  if (!outcome_same_maps(a, b) || !outcome_same_mask(a, b) || !outcome_same_depth(a, b))
    fail_msg("%s: maps are %s, masks %s, depths %s", what, outcome_same_maps(a, b) ? "the same" : "others",
             outcome_same_mask(a, b) ? "the same" : "others", outcome_same_depth(a, b) ? "the same" : "others");
  outcome_free(b);
}
