// Cuts out what an alpha mask says is not there: bilinear, at full resolution, alpha >= cutoff. The four texels are
// loaded and mixed here, because samplers round their weights, and a rounded edge is a different leaf.
#include "private/alpha_mask.h"

cbuffer alpha_mask_block : register(b0)
{
    float4 alpha_mask_c[ALPHA_MASK_COUNT];
};
Texture2D<float> alpha_mask : register(t0);

// A texel's index brought into the texture: repeated, clamped or mirrored.
float wrap(float index, float size, float mode)
{
    float period = mode == ALPHA_MASK_MIRROR ? 2.0 * size : size;
    float inside = mad(-floor(index / period), period, index);
    float mirrored = min(inside, 2.0 * size - 1.0 - inside);
    float clamped = min(max(index, 0.0), size - 1.0);
    return mode == ALPHA_MASK_CLAMP ? clamped : mode == ALPHA_MASK_MIRROR ? mirrored : inside;
}

float texel(float x, float y)
{
    return alpha_mask.Load(int3((int)x, (int)y, 0));
}

void cut_out(float2 uv)
{
    float2 size = alpha_mask_c[ALPHA_MASK_SIZE].xy;
    float2 mode = alpha_mask_c[ALPHA_MASK_WRAP].xy;
    float2 place = float2(mad(uv.x, size.x, -0.5), mad(uv.y, size.y, -0.5));
    float2 first = floor(place);
    float2 share = place - first;
    float x0 = wrap(first.x, size.x, mode.x), x1 = wrap(first.x + 1.0, size.x, mode.x);
    float y0 = wrap(first.y, size.y, mode.y), y1 = wrap(first.y + 1.0, size.y, mode.y);
    float top = texel(x0, y0), bottom = texel(x0, y1);
    top = mad(share.x, texel(x1, y0) - top, top);
    bottom = mad(share.x, texel(x1, y1) - bottom, bottom);
    if (mad(share.y, bottom - top, top) < alpha_mask_c[ALPHA_MASK_SIZE].z)
        discard;
}
