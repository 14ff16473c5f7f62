/* hard/cases.h: the hard cases there are, one file each. */
#ifndef HOST_HARD_CASES_H
#define HOST_HARD_CASES_H

#include "hard/hard.h"

extern const hard_case hard_bare_plane;
extern const hard_case hard_offsets;
extern const hard_case hard_far_vertices;
extern const hard_case hard_turned;
extern const hard_case hard_formats;
extern const hard_case hard_borders;
extern const hard_case hard_casters;
extern const hard_case hard_huge_ground;
extern const hard_case hard_far_orthographic;

/* In the order of the table; NULL ends it. */
extern const hard_case *const hard_cases[];

/* NULL after a message that lists the names there are. */
const hard_case *hard_case_find(const char *name);

#endif
