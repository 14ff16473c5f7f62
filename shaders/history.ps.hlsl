// The history of a mask: this frame's visibility, and the mean of the frames before it where they saw the same surface.
// Out come visibility, how many frames it is the mean of and how flat (private/history_frames.hlsl), span and normal.
#include "csm_history.h"
#include "private/history_inputs.hlsl"

cbuffer history_block : register(b0)
{
    float4 mask_c[CSM_H_COUNT]; // CSM_M_SIZE is what depth_steps reads of it
};
Texture2D<float2> mask : register(t0);
Texture2D<float> camera_depth : register(t1);
Texture2D<float4> history : register(t2);
#if HISTORY_NORMALS
Texture2D<float4> normals : register(t3);
#endif
#if HISTORY_MOTION
Texture2D<float4> motion : register(t4);
#endif
SamplerState csm_point : register(s0);
#include "private/depth_steps.hlsl"

static history_inputs inputs;

// How far from the mean of what is around it a history may be, in deviations of a pixel's noise, of which the mean has 3 / 8:
// the weights' squares add up to 9 / 64. And how far from what this frame has, in deviations of what is surely noise. And
// what share of its frames it loses for each unit that it was farther off.
#define HISTORY_REACH 0.75
#define HISTORY_AWAY 2.0
#define HISTORY_STALE 4.0

float place_row(float4 row, float2 place, float depth)
{
    return mad(place.x, row.x, mad(place.y, row.y, mad(depth, row.z, row.w)));
}

float plane_row(float4 row, float2 steps, float origin)
{
    return mad(steps.x, row.x, mad(steps.y, row.y, mad(origin, row.w, -row.z)));
}

float product(float3 a, float3 b)
{
    return mad(a.x, b.x, mad(a.y, b.y, a.z * b.z));
}

// ---- normals, as one of 64 x 64 directions: an octahedron laid flat (Cigolle et al. 2014) ----

float encode_normal(float3 n)
{
    float inverse = 1.0 / max(abs(n.x) + abs(n.y) + abs(n.z), 1e-30);
    float u = n.x * inverse, v = n.z * inverse;
    float right = u < 0.0 ? abs(v) - 1.0 : 1.0 - abs(v), up = v < 0.0 ? abs(u) - 1.0 : 1.0 - abs(u);
    u = n.y < 0.0 ? right : u;
    v = n.y < 0.0 ? up : v;
    float column = clamp(floor(mad(u, 32.0, 32.0)), 0.0, 63.0), row = clamp(floor(mad(v, 32.0, 32.0)), 0.0, 63.0);
    return mad(column, 64.0, row - 2048.0);
}

// Of no length in particular.
float3 decode_normal(float code)
{
    float column = floor(mad(code, 1.0 / 64.0, 32.0));
    float row = mad(column, -64.0, code + 2048.0);
    float u = mad(column, 1.0 / 32.0, -31.5 / 32.0), v = mad(row, 1.0 / 32.0, -31.5 / 32.0);
    float y = 1.0 - abs(u) - abs(v);
    float x = y < 0.0 ? (u < 0.0 ? abs(v) - 1.0 : 1.0 - abs(v)) : u;
    float z = y < 0.0 ? (v < 0.0 ? abs(u) - 1.0 : 1.0 - abs(u)) : v;
    return float3(x, y, z);
}

#include "private/history_frames.hlsl"

// ---- a pixel's surface, now and in the earlier picture ----

struct surface
{
    float3 normal;
    float square;  // of the normal's length
    float2 place;  // in the earlier picture, in pixels; far outside where there is none
    float span;    // there
    float2 slope;  // of the span, right and down
    bool rests;    // it and its shadows are as they were
};

surface surface_at(float2 place, float depth)
{
    surface s;
    float2 steps = depth_steps(place, depth);
    float origin = mad(-steps.x, place.x, mad(-steps.y, place.y, depth));
#if HISTORY_NORMALS
    float3 n = normals.Load(int3(int2(place), 0)).xyz;
    s.normal.x = mad(n.x, inputs.normal_0.x, inputs.normal_0.w);
    s.normal.y = mad(n.y, inputs.normal_1.y, inputs.normal_1.w);
    s.normal.z = mad(n.z, inputs.normal_2.z, inputs.normal_2.w);
#else
    s.normal.x = plane_row(inputs.normal_0, steps, origin);
    s.normal.y = plane_row(inputs.normal_1, steps, origin);
    s.normal.z = plane_row(inputs.normal_2, steps, origin);
#endif
    s.square = product(s.normal, s.normal);
    float w = place_row(inputs.place_3, place, depth);
    float scale = 1.0 / w;
    s.place.x = place_row(inputs.place_0, place, depth) * scale;
    s.place.y = place_row(inputs.place_1, place, depth) * scale;
    s.span = place_row(inputs.place_2, place, depth) * scale;
    s.rests = inputs.clear.z > 0.5;
#if HISTORY_MOTION
    float2 moved = motion.Load(int3(int2(place), 0)).xy;
    s.place.x = mad(moved.x, inputs.size.x, place.x);
    s.place.y = mad(moved.y, inputs.size.y, place.y);
    s.rests = s.rests && moved.x == 0.0 && moved.y == 0.0;
#endif
    bool inside = w > 0.0 && abs(s.place.x) < 65536.0 && abs(s.place.y) < 65536.0;
    s.place.x = inside ? s.place.x : -65536.0;
    s.place.y = inside ? s.place.y : -65536.0;
    float across = -plane_row(inputs.plane_2, steps, origin);
    float inverse = abs(across) > 1e-30 ? 1.0 / across : 0.0;
    s.slope.x = plane_row(inputs.plane_0, steps, origin) * inverse;
    s.slope.y = plane_row(inputs.plane_1, steps, origin) * inverse;
    return s;
}

// What earlier pixels add up to.
struct found
{
    float visibility;
    float frames;
    float flatness; // csm_flatness, each times its weight, of those that know
    float knows;
    float weight;
};

found add_tap(found sum, surface s, float2 pixel, float weight)
{
    float2 last = inputs.size.xy - 1.0;
    float4 tap = history.Load(int3(int2(clamp(pixel.x, 0.0, last.x), clamp(pixel.y, 0.0, last.y)), 0));
    float right = pixel.x + 0.5 - s.place.x, down = pixel.y + 0.5 - s.place.y;
    float span = mad(right, s.slope.x, mad(down, s.slope.y, s.span));
    float3 normal = decode_normal(tap.w);
    float flatness = decode_flatness(tap.y), frames = decode_frames(tap.y);
    bool there = pixel.x >= 0.0 && pixel.y >= 0.0 && pixel.x <= last.x && pixel.y <= last.y && frames > 0.0;
    bool as_deep = abs(tap.z - span) <= mad(abs(span), inputs.limits.x, inputs.limits.y);
    bool alike = product(normal, s.normal) >= inputs.limits.z * sqrt(product(normal, normal) * s.square);
    float counts = there && as_deep && alike ? weight : 0.0;
    sum.visibility = mad(counts, tap.x, sum.visibility);
    sum.frames = mad(counts, frames, sum.frames);
    sum.flatness = mad(counts, flatness, sum.flatness);
    sum.knows += flatness > 0.0 ? counts : 0.0;
    sum.weight += counts;
    return sum;
}

// The mean of the pixels around a place that saw the same surface.
found find_history(surface s)
{
    float2 first = floor(s.place - 0.5);
    float2 share = s.place - 0.5 - first;
    found sum;
    sum.visibility = 0.0;
    sum.frames = 0.0;
    sum.flatness = 0.0;
    sum.knows = 0.0;
    sum.weight = 0.0;
    sum = add_tap(sum, s, first, (1.0 - share.x) * (1.0 - share.y));
    sum = add_tap(sum, s, float2(first.x + 1.0, first.y), share.x * (1.0 - share.y));
    sum = add_tap(sum, s, float2(first.x, first.y + 1.0), (1.0 - share.x) * share.y);
    sum = add_tap(sum, s, float2(first.x + 1.0, first.y + 1.0), share.x * share.y);
    return sum;
}

// ---- what this frame says ----

// Between two steps of flatness the pixel's place and the frame choose, so that means are not stuck at one.
float encode_frames(float frames, float flatness, float2 place)
{
    float turn = mad(place.x, 0.06711056, mad(place.y, 0.00583715, inputs.clear.w));
    turn = 52.9829189 * (turn - floor(turn));
    float step = floor(mad(flatness, 62.0, turn - floor(turn)));
    step = flatness > 0.0 ? clamp(step, 1.0, 62.0) : 0.0;
    return mad(step, 65.0, floor(frames + 0.5) + CSM_H_NO_FRAMES);
}

// What a pixel's history may be.
struct range
{
    float least;
    float most;
};

float squares_of(float4 a)
{
    return mad(a.x, a.x, mad(a.y, a.y, mad(a.z, a.z, a.w * a.w)));
}

// The variance of noise in 3 x 3 pixels, of which four times 2 x 2 come, as Gather orders them: that of the differences along
// the direction in which they are least, a row, a column or a diagonal. So the step of an edge is no noise.
float noise_along(float4 a, float4 b, float4 c, float4 d)
{
    float across = squares_of(float4(a.z - a.w, b.z - b.w, a.y - a.x, b.y - b.x)) + squares_of(float4(c.y - c.x, d.y - d.x, 0.0, 0.0));
    float down = squares_of(float4(a.x - a.w, c.x - c.w, a.y - a.z, c.y - c.z)) + squares_of(float4(b.y - b.z, d.y - d.z, 0.0, 0.0));
    float falling = squares_of(float4(a.y - a.w, b.y - b.w, c.y - c.w, d.y - d.w));
    float rising = squares_of(float4(a.x - a.z, b.x - b.z, c.x - c.z, d.x - d.z));
    return min(min(across, down) * (1.0 / 12.0), min(falling, rising) * 0.125);
}

// Visibility around a pixel, of 3 x 3 pixels that count 1, 2 and 1 along each axis, is taken for a plane and noise. A
// history that is right lies about that plane's middle, or between it and what this frame has; what is around bounds both.
// An edge that moves is no noise, and leaves no room for what was there before.
range range_at(float2 place, float visibility)
{
    float4 size = inputs.size;
    float2 uv = place * size.zw;
    float2 low = float2(mad(size.z, -0.5, uv.x), mad(size.w, -0.5, uv.y));
    float2 high = float2(mad(size.z, 0.5, uv.x), mad(size.w, 0.5, uv.y));
    float4 a = mask.GatherRed(csm_point, low);
    float4 b = mask.GatherRed(csm_point, float2(high.x, low.y));
    float4 c = mask.GatherRed(csm_point, float2(low.x, high.y));
    float4 d = mask.GatherRed(csm_point, high);
    float4 all = a + b + (c + d), squares = mad(a, a, mad(b, b, mad(c, c, d * d)));
    float mean = (all.x + all.y + (all.z + all.w)) * 0.0625;
    float square = (squares.x + squares.y + (squares.z + squares.w)) * 0.0625;
    // Of the left two of four pixels, a and c have the outer column, and b and d the inner one, of the right two likewise
    float right = ((b.y + b.z + (d.y + d.z)) - (a.x + a.w + (c.x + c.w))) * 0.0625;
    float down = ((c.x + c.y + (d.x + d.y)) - (a.z + a.w + (b.z + b.w))) * 0.0625;
    float noise = mad(-mean, mean, square);
    noise = mad(right * right, -2.0, mad(down * down, -2.0, noise));
    float reach = mad(sqrt(max(noise, 0.0)), HISTORY_REACH, 1.0 / 255.0);
    float4 least = min(min(a, b), min(c, d)), most = max(max(a, b), max(c, d));
    range r;
    r.least = max(min(visibility, mean - reach), min(min(least.x, least.y), min(least.z, least.w)));
    r.most = min(max(visibility, mean + reach), max(max(most.x, most.y), max(most.z, most.w)));
    float away = mad(min(sqrt(noise_along(a, b, c, d)), inputs.noise.x), HISTORY_AWAY, 1.0 / 255.0);
    r.least = max(r.least, visibility - away);
    r.most = min(r.most, visibility + away);
    return r;
}

// As a mask without a history has it, in 8 bits.
float rounded(float lit)
{
    return floor(mad(lit, 255.0, 0.5)) * (1.0 / 255.0);
}

float4 main(history_inputs pixel) : SV_Target
{
    inputs = pixel;
    float2 place = pixel.position.xy;
    float depth = camera_depth.Load(int3(int2(place), 0));
    float visibility = rounded(mask.Load(int3(int2(place), 0)).x);
    surface s = surface_at(place, depth);
    found before = find_history(s);
    range r = range_at(place, visibility);
    float inverse = 1.0 / max(before.weight, 0.01);
    float earlier = before.visibility * inverse;
    float bounded = s.rests ? earlier : clamp(earlier, r.least, r.most);
    // The farther a history was off, the fewer frames it still stands for
    float stale = min(abs(bounded - earlier) * HISTORY_STALE, 1.0);
    float frames = before.frames * inverse;
    frames = before.weight > 0.01 ? mad(frames, -stale, frames) : 0.0;
    frames = min(frames + 1.0, inputs.limits.w);
    float mean = mad(bounded - visibility, 1.0 - 1.0 / frames, visibility);
    float span = clamp(place_row(inputs.own, place, depth), -65504.0, 65504.0);
    bool nothing = depth == inputs.clear.x;
    float flat = mask.Load(int3(int2(place), 0)).y; // apart: of one load vkd3d's compiler makes a move that vkd3d 1.2 misreads
    float flatness = before.knows > 0.01 ? before.flatness / before.knows : flat;
    flatness = flat > 0.0 ? mad(flat - flatness, 1.0 / min(frames, 8.0), flatness) : flatness;
    return float4(nothing ? 1.0 : mean, nothing ? CSM_H_NO_FRAMES : encode_frames(frames, flatness, place), nothing ? 0.0 : span, nothing ? 0.0 : encode_normal(s.normal));
}
