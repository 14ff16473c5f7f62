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
extern const hard_case hard_low_sun;
extern const hard_case hard_thin_masks;
extern const hard_case hard_moving_camera;
extern const hard_case hard_moving_sun;
extern const hard_case hard_depth_range;
extern const hard_case hard_projections;
extern const hard_case hard_degenerate;
extern const hard_case hard_many;
extern const hard_case hard_limits;
extern const hard_case hard_settings;
extern const hard_case hard_casters;
extern const hard_case hard_huge_ground;
extern const hard_case hard_far_orthographic;
extern const hard_case hard_moment_limits;
extern const hard_case hard_bleeding;
extern const hard_case hard_moment_gaps;
extern const hard_case hard_half_moments;
extern const hard_case hard_knife_edge;
extern const hard_case hard_moment_borders;
extern const hard_case hard_history;
extern const hard_case hard_exact_closed;
extern const hard_case hard_exact_acne;
extern const hard_case hard_exact_shapes;
extern const hard_case hard_exact_moving;
extern const hard_case hard_exact_scenes;
extern const hard_case hard_pages;

/* In the order of the table; NULL ends it. */
extern const hard_case *const hard_cases[];

/*
 * Those that the options name; all if they name none; none of them if that is what they say. 0, or HOST_BAD_INPUT after
 * a message that lists the names there are.
 */
int hard_cases_choose(const hard_case *chosen[OPTIONS_MAX_CASES], uint32_t *count, const host_options *options);

#endif
