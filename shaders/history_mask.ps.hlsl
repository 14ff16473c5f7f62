// The mask that a history comes to: its visibility, as steep as it should be, or how many frames it is the mean of.
#include "csm_history.h"
#include "private/history_frames.hlsl"

// The least that a pixel has which is rather lit: a step of 8 bits above a half.
#define HISTORY_LIT (129.0 / 255.0)

cbuffer history_block : register(b0)
{
    float4 history_c[CSM_H_COUNT];
};
Texture2D<float4> history : register(t0);
Texture2D<float2> mask : register(t1);

float main(float4 screen : SV_Position) : SV_Target
{
    int3 pixel = int3(int2(screen.xy), 0);
    float4 texel = history.Load(pixel);
    float now = mask.Load(pixel).x;
    float4 settings = history_c[CSM_H_CLEAR];
    // Where shadows may have moved, this frame says whether a pixel is rather lit or rather dark, and the history how much
    bool rests = settings.z > 0.5;
    float flatness = decode_flatness(texel.y);
    float steep = 1.0 / (flatness > 0.0 ? flatness : 1.0);
    float lit = clamp(mad(texel.x - 0.5, steep, 0.5), 0.0, 1.0);
    float alone = mad(now - 0.5, steep, 0.5);
    lit = rests ? lit : now > 0.5 ? max(lit, min(alone, HISTORY_LIT)) : min(lit, max(alone, 1.0 - HISTORY_LIT));
    return settings.y > 0.5 ? decode_frames(texel.y) * (1.0 / 255.0) : lit;
}
