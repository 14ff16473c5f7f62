#include "hard/cases.h"
#include "base/host.h"
#include <string.h>

/* clang-format off */
const hard_case *const hard_cases[] = {
    &hard_bare_plane,
    &hard_offsets,
    &hard_far_vertices,
    &hard_turned,
    &hard_formats,
    &hard_borders,
    &hard_low_sun,
    &hard_thin_masks,
    &hard_moving_camera,
    &hard_moving_sun,
    &hard_depth_range,
    &hard_projections,
    &hard_degenerate,
    &hard_many,
    &hard_limits,
    &hard_settings,
    &hard_casters,
    &hard_huge_ground,
    &hard_far_orthographic,
    &hard_moment_limits,
    &hard_bleeding,
    &hard_moment_gaps,
    &hard_half_moments,
    &hard_knife_edge,
    &hard_moment_borders,
    &hard_history,
    &hard_exact_closed,
    &hard_exact_acne,
    &hard_exact_shapes,
    &hard_exact_moving,
    &hard_exact_scenes,
    &hard_pages,
    NULL,
};
/* clang-format on */

/* NULL after a message. */
static const hard_case *find(const char *name) {
  char names[1024] = "";
  for (const hard_case *const *at = hard_cases; *at; at++) {
    if (strcmp((*at)->name, name) == 0)
      return *at;
    const size_t used = strlen(names);
    snprintf(names + used, sizeof names - used, "%s%s", used ? ", " : "", (*at)->name);
  }
  host_fail(HOST_BAD_INPUT, "--case: no case is called '%s' (%s)", name, names);
  return NULL;
}

int hard_cases_choose(const hard_case *chosen[OPTIONS_MAX_CASES], uint32_t *count, const host_options *options) {
  *count = 0;
  if (options->case_count == 1 && strcmp(options->cases[0], "none") == 0)
    return 0;
  for (uint32_t i = 0; i < options->case_count; i++) {
    chosen[i] = find(options->cases[i]);
    if (!chosen[i])
      return HOST_BAD_INPUT;
  }
  for (*count = options->case_count; options->case_count == 0 && hard_cases[*count]; (*count)++)
    chosen[*count] = hard_cases[*count];
  return 0;
}
