// How far a mask's search for blockers need look, by ranges: csm_soft.inc's CSM_REACH.
//
// The nearest depth around a place bounds how wide a penumbra is there. That bounds how far away a blocker matters, and the
// nearest depth of a smaller square bounds it again.
#include "private/ranges.h"

Texture2DArray<float4> ranges : register(t2);

// `reach`, or less if a square that reaches `most` texels holds all of it, with this nearest depth. `plane`: of a csm_spot, its
// depth, how much that may change from texel to texel, its last one, and the light's size. Depths are rounded by less than is
// added.
float reach_within(float4 plane, float reach, float nearest, float most)
{
    float deepest = min(mad(reach + 1.0, plane.y, plane.x), plane.z) + 2.5e-7;
    float radius = max(deepest - nearest, 0.0) * plane.w;
    // Farther away nothing hides light, and nothing open tells that not all of it is hidden: see csm_block, csm_partly_hidden
    return reach <= most ? min(reach, mad(radius, 1.33334, 2.01)) : reach;
}

float reach_of(float4 plane, float reach, float2 place, float side, int cascade)
{
    float2 block = clamp(place, 0.0, side - 1.0) * (1.0 / float(RANGES_BLOCK));
    float4 nearest = ranges.Load(int4(int2(block), cascade, 0));
    reach = reach_within(plane, reach, nearest.w, RANGES_REACH(RANGES_WIDTH_3));
    reach = reach_within(plane, reach, nearest.z, RANGES_REACH(RANGES_WIDTH_2));
    reach = reach_within(plane, reach, nearest.y, RANGES_REACH(RANGES_WIDTH_1));
    reach = reach_within(plane, reach, nearest.x, RANGES_REACH(RANGES_WIDTH_0));
    return reach_within(plane, reach, nearest.x, RANGES_REACH(RANGES_WIDTH_0));
}
