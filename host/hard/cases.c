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
    &hard_casters,
    &hard_huge_ground,
    &hard_far_orthographic,
    NULL,
};
/* clang-format on */

const hard_case *hard_case_find(const char *name) {
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
