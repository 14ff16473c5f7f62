// Moments of a map's depths, blurred by a radius of 1 to 3 texels, at once: a thread makes a square of 8 x 8 texels from the
// 14 x 14 depths around it, and keeps all that it needs in registers. Every depth is read and warped three times, which is
// less than it takes to write and read what two passes hand on.
#define MOMENTS_FROM_DEPTH
#include "private/moments.hlsl"

static int4 columns_0, columns_1, columns_2;
static int2 columns_3;
static float3 weights;

// A texel with three on either side: where all are alike, it is none other than they are.
MOMENTS blurred(MOMENTS a, MOMENTS b, MOMENTS c, MOMENTS middle, MOMENTS d, MOMENTS e, MOMENTS f)
{
    MOMENTS outer = mad(weights.z, (a - middle) + (f - middle), middle);
    return mad(weights.x, (c - middle) + (d - middle), mad(weights.y, (b - middle) + (e - middle), outer));
}

struct eight
{
    MOMENTS a, b, c, d, e, f, g, h;
};

eight row_at(int y)
{
    MOMENTS m0 = moments_at(columns_0.x, y), m1 = moments_at(columns_0.y, y), m2 = moments_at(columns_0.z, y);
    MOMENTS m3 = moments_at(columns_0.w, y), m4 = moments_at(columns_1.x, y), m5 = moments_at(columns_1.y, y);
    MOMENTS m6 = moments_at(columns_1.z, y), m7 = moments_at(columns_1.w, y), m8 = moments_at(columns_2.x, y);
    MOMENTS m9 = moments_at(columns_2.y, y), m10 = moments_at(columns_2.z, y), m11 = moments_at(columns_2.w, y);
    MOMENTS m12 = moments_at(columns_3.x, y), m13 = moments_at(columns_3.y, y);
    eight row;
    row.a = blurred(m0, m1, m2, m3, m4, m5, m6);
    row.b = blurred(m1, m2, m3, m4, m5, m6, m7);
    row.c = blurred(m2, m3, m4, m5, m6, m7, m8);
    row.d = blurred(m3, m4, m5, m6, m7, m8, m9);
    row.e = blurred(m4, m5, m6, m7, m8, m9, m10);
    row.f = blurred(m5, m6, m7, m8, m9, m10, m11);
    row.g = blurred(m6, m7, m8, m9, m10, m11, m12);
    row.h = blurred(m7, m8, m9, m10, m11, m12, m13);
    return row;
}

void write(int3 at, eight r0, eight r1, eight r2, eight r3, eight r4, eight r5, eight r6)
{
    to[at] = blurred(r0.a, r1.a, r2.a, r3.a, r4.a, r5.a, r6.a);
    to[int3(at.x + 1, at.yz)] = blurred(r0.b, r1.b, r2.b, r3.b, r4.b, r5.b, r6.b);
    to[int3(at.x + 2, at.yz)] = blurred(r0.c, r1.c, r2.c, r3.c, r4.c, r5.c, r6.c);
    to[int3(at.x + 3, at.yz)] = blurred(r0.d, r1.d, r2.d, r3.d, r4.d, r5.d, r6.d);
    to[int3(at.x + 4, at.yz)] = blurred(r0.e, r1.e, r2.e, r3.e, r4.e, r5.e, r6.e);
    to[int3(at.x + 5, at.yz)] = blurred(r0.f, r1.f, r2.f, r3.f, r4.f, r5.f, r6.f);
    to[int3(at.x + 6, at.yz)] = blurred(r0.g, r1.g, r2.g, r3.g, r4.g, r5.g, r6.g);
    to[int3(at.x + 7, at.yz)] = blurred(r0.h, r1.h, r2.h, r3.h, r4.h, r5.h, r6.h);
}

[numthreads(MOMENTS_THREADS, 1, 1)]
void main(uint3 group : SV_GroupID, uint thread : SV_GroupIndex)
{
    tile t = tile_of(group, MOMENTS_TILE);
    int layer = t.cascade * int(dispatch_c[MOMENTS_D_TILES].w) + int(group.z), last = t.side - 1;
    begin_depths(t, float(group.z));
    // The last ones of a side that they do not divide make some texels twice
    int x = min(t.begin.x + int(thread & 7u) * MOMENTS_RUN, t.side - MOMENTS_RUN);
    int y = min(t.begin.y + int(thread >> 3u) * MOMENTS_RUN, t.side - MOMENTS_RUN);
    columns_0 = int4(max(x - 3, 0), max(x - 2, 0), max(x - 1, 0), x);
    columns_1 = int4(x + 1, x + 2, x + 3, x + 4);
    columns_2 = int4(x + 5, x + 6, x + 7, min(x + 8, last));
    columns_3 = int2(min(x + 9, last), min(x + 10, last));
    int radius = int(dispatch_c[MOMENTS_D_PASS].x);
    weights = float3(moments_c[MOMENTS_WEIGHTS + radius + 1].x, moments_c[MOMENTS_WEIGHTS + radius + 2].x,
                     moments_c[MOMENTS_WEIGHTS + radius + 3].x);
    eight r0 = row_at(max(y - 3, 0)), r1 = row_at(max(y - 2, 0)), r2 = row_at(max(y - 1, 0)), r3 = row_at(y);
    eight r4 = row_at(y + 1), r5 = row_at(y + 2), r6 = row_at(y + 3);
    write(int3(x, y, layer), r0, r1, r2, r3, r4, r5, r6);
    eight r7 = row_at(y + 4);
    write(int3(x, y + 1, layer), r1, r2, r3, r4, r5, r6, r7);
    eight r8 = row_at(y + 5);
    write(int3(x, y + 2, layer), r2, r3, r4, r5, r6, r7, r8);
    eight r9 = row_at(y + 6);
    write(int3(x, y + 3, layer), r3, r4, r5, r6, r7, r8, r9);
    eight r10 = row_at(y + 7);
    write(int3(x, y + 4, layer), r4, r5, r6, r7, r8, r9, r10);
    eight r11 = row_at(min(y + 8, last));
    write(int3(x, y + 5, layer), r5, r6, r7, r8, r9, r10, r11);
    eight r12 = row_at(min(y + 9, last));
    write(int3(x, y + 6, layer), r6, r7, r8, r9, r10, r11, r12);
    eight r13 = row_at(min(y + 10, last));
    write(int3(x, y + 7, layer), r7, r8, r9, r10, r11, r12, r13);
}
