// The debug views of the mask, as csm.h defines them: which cascade a pixel takes, and how densely its map lies there. The
// normal comes from the depth, whether or not the engine has one: it decides nothing but by the configured normal offset.
#define MASK_VIEW
#define CSM_FILTER 2
#include "private/mask.hlsl"

// The square of the texels of a cascade's map that a step in the world passes.
float texels_square(int cascade, float3 step)
{
    float side = csm_c[CSM_C_RECTS + cascade].z;
    float u = csm_dot(csm_c[CSM_C_MATRICES + cascade * 3].xyz, step) * side;
    float v = csm_dot(csm_c[CSM_C_MATRICES + cascade * 3 + 1].xyz, step) * side;
    return mad(u, u, v * v);
}

float main(float4 screen : SV_Position) : SV_Target
{
    int2 pixel = int2(screen.xy);
    float depth = load_depth(pixel);
    if (depth == mask_c[CSM_M_CLEAR].x)
        return 0.0;
    float3 position = pixel_position(float2(pixel), depth);
    float3 right = tangent(pixel, int2(1, 0), position, depth);
    float3 down = tangent(pixel, int2(0, 1), position, depth);
    float3 normal = unit_cross(down, right) * mask_c[CSM_M_CLEAR].y;
    int cascade = csm_cascade(position, normal, csm_view_depth(position));
    float count = csm_c[CSM_C_PARAMS].x;
    if (float(cascade) >= count)
        return 0.0;
    if (mask_c[CSM_M_VIEW].x < 1.5)
        return float(cascade + 1) * (1.0 / 255.0);
    // Half the logarithm of the square; rounded here, so that no format has a say in it
    float square = max(texels_square(cascade, right), texels_square(cascade, down));
    float level = floor(mad(log2(clamp(square, 1e-30, 1e30)), 8.0, 128.5));
    return clamp(level, 1.0, 255.0) * (1.0 / 255.0);
}
