// The mask that a history comes to: its visibility, or how many frames it is the mean of.
#include "csm_history.h"

cbuffer history_block : register(b0)
{
    float4 history_c[CSM_H_COUNT];
};
Texture2D<float4> history : register(t0);

float main(float4 screen : SV_Position) : SV_Target
{
    float4 texel = history.Load(int3(int2(screen.xy), 0));
    return history_c[CSM_H_CLEAR].y > 0.5 ? floor(texel.y + 0.5) * (1.0 / 255.0) : texel.x;
}
