// The depths of the pixels on either side, and of those behind them.
struct neighbours
{
    float back;
    float far_back;
    float on;
    float far_on;
};

// How the depth changes from one pixel to the next along an axis. Across a plane depth is linear on screen, so the side is
// taken on which three pixels lie on one line. Where both do, their difference is rounding, which must not choose.
//
// It is told, too, by how much the better side bends more than a hundredth of the step: above 0 the plane is unsure.
struct depth_slope
{
    float step;
    float bend;
};

depth_slope depth_slope_of(float depth, neighbours n, float at, float pixel)
{
    float bend_back = abs(mad(2.0, n.back, -n.far_back) - depth), bend_on = abs(mad(2.0, n.on, -n.far_on) - depth);
    // Pixels beyond the border say nothing; `at` goes from 0 to 1 across the screen
    bend_back = at > 2.0 * pixel ? bend_back : at > pixel ? 1e20 : 1e30;
    bend_on = at < mad(-2.0, pixel, 1.0) ? bend_on : at < 1.0 - pixel ? 1e20 : 1e30;
    bool back = mad(depth, 4.0 / 8388608.0, bend_back) < bend_on;
    depth_slope slope;
    slope.step = back ? depth - n.back : n.on - depth;
    slope.bend = mad(depth, -4.0 / 8388608.0, mad(abs(slope.step), -0.01, back ? bend_back : bend_on));
    return slope;
}

// The depth's steps right and down, and the greater of the two bends.
float3 depth_plane(float2 place, float depth)
{
    float4 size = mask_c[CSM_M_SIZE];
    float2 uv = place * size.zw;
    // Each gather reads two pixels to one side: its corner lies between them, and half a pixel off the axis
    float4 left = camera_depth.Gather(csm_point, float2(mad(size.z, -1.5, uv.x), mad(size.w, 0.5, uv.y)));
    float4 right = camera_depth.Gather(csm_point, float2(mad(size.z, 1.5, uv.x), mad(size.w, 0.5, uv.y)));
    float4 above = camera_depth.Gather(csm_point, float2(mad(size.z, 0.5, uv.x), mad(size.w, -1.5, uv.y)));
    float4 below = camera_depth.Gather(csm_point, float2(mad(size.z, 0.5, uv.x), mad(size.w, 1.5, uv.y)));
    neighbours across, down;
    across.back = left.z;
    across.far_back = left.w;
    across.on = right.w;
    across.far_on = right.z;
    down.back = above.x;
    down.far_back = above.w;
    down.on = below.w;
    down.far_on = below.x;
    depth_slope x = depth_slope_of(depth, across, uv.x, size.z), y = depth_slope_of(depth, down, uv.y, size.w);
    return float3(x.step, y.step, max(x.bend, y.bend));
}

float2 depth_steps(float2 place, float depth)
{
    float3 plane = depth_plane(place, depth);
    return plane.xy;
}
