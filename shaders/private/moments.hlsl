// What the passes that make moments share: whose texels a thread makes, and what a moment is.
#include "csm_constants.h"
#include "csm_enums.h"
#include "private/moments.h"

cbuffer settings_block : register(b0)
{
    float4 csm_c[CSM_C_COUNT];
    float4 moments_c[MOMENTS_COUNT];
};
cbuffer dispatch_block : register(b1)
{
    float4 dispatch_c[MOMENTS_D_COUNT];
};
StructuredBuffer<uint> tiles : register(t8);

#if defined(MOMENTS_WIDTH) && MOMENTS_WIDTH == 0
#define MOMENTS_CHANNELS 1
#elif defined(MOMENTS_WIDTH) && MOMENTS_WIDTH == 1
#define MOMENTS_CHANNELS 2
#elif defined(MOMENTS_WIDTH)
#define MOMENTS_CHANNELS 4
#elif CSM_FILTER == CSM_FILTER_ESM
#define MOMENTS_CHANNELS 1
#elif CSM_FILTER == CSM_FILTER_EVSM4 || CSM_FILTER == CSM_FILTER_MSM4
#define MOMENTS_CHANNELS 4
#else
#define MOMENTS_CHANNELS 2
#endif

// glslang takes an image's format from its type, which is of 32 bits, unless it is told.
#if MOMENTS_CHANNELS == 1
#define MOMENTS float
#define MOMENTS_OF(m) (m).x
#if defined(VULKAN) && MOMENTS_HALF
[[spv::format_r16f]]
#endif
#elif MOMENTS_CHANNELS == 2
#define MOMENTS float2
#define MOMENTS_OF(m) (m).xy
#if defined(VULKAN) && MOMENTS_HALF
[[spv::format_rg16f]]
#endif
#else
#define MOMENTS float4
#define MOMENTS_OF(m) (m)
#if defined(VULKAN) && MOMENTS_HALF
[[spv::format_rgba16f]]
#endif
#endif
RWTexture2DArray<MOMENTS> to : register(u0);

// To the nearest float of 16 bits, for a device may round what it stores either way. None comes near the largest one.
MOMENTS stored(MOMENTS m)
{
#if MOMENTS_HALF
    return asfloat((asuint(m) + 0x1000u) & 0xffffe000u);
#else
    return m;
#endif
}

struct tile
{
    int2 begin;
    int cascade, side;
};

// Where a group's tile begins in its cascade. `size` is a tile's side in texels of the level that is made.
tile tile_of(uint3 group, int size)
{
    float4 list = dispatch_c[MOMENTS_D_TILES];
    uint packed = tiles[uint(list.x) + group.y * uint(list.y) + group.x];
    uint mask = (1u << MOMENTS_TILE_BITS) - 1u;
    tile t;
    t.begin = int2(int(packed & mask), int((packed >> MOMENTS_TILE_BITS) & mask)) * size;
    t.cascade = int(packed >> (2 * MOMENTS_TILE_BITS));
    t.side = int(moments_c[MOMENTS_SIDES + t.cascade].x);
    return t;
}

#ifdef MOMENTS_FROM_DEPTH
Texture2DArray<float> maps : register(t0);

static float4 moments_row;
static int2 map_begin;
static int map_layer;
static float2 towards_light;
static float slice;
#define CSM_MOMENTS_ROW moments_row
#define CSM_MOMENTS_WARP_ONLY
#define csm_float2 float2
#define csm_float4 float4
#define csm_mad mad
#include "csm_moments.inc"

void begin_depths(tile t, float layer)
{
    float4 rect = csm_c[CSM_C_RECTS + t.cascade];
    moments_row = csm_c[CSM_S_MOMENTS];
    map_begin = int2(rect.xy);
    map_layer = int(rect.w);
    towards_light = float2(csm_c[CSM_S_OPTIONS].z, 1.0 - csm_c[CSM_S_OPTIONS].w);
    slice = layer;
}

MOMENTS moments_of_texel(int x, int y)
{
    float depth = maps.Load(int4(map_begin.x + x, map_begin.y + y, map_layer, 0));
    return MOMENTS_OF(csm_moments_of(mad(depth, towards_light.x, towards_light.y), slice));
}

// At a texel of the moments.
MOMENTS moments_at(int x, int y)
{
#if MOMENTS_HALVED
    MOMENTS above = moments_of_texel(2 * x, 2 * y) + moments_of_texel(2 * x + 1, 2 * y);
    return (above + (moments_of_texel(2 * x, 2 * y + 1) + moments_of_texel(2 * x + 1, 2 * y + 1))) * 0.25;
#else
    return moments_of_texel(x, y);
#endif
}
#endif
