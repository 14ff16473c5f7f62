// The debug views of the mask, as csm.h defines them: which cascade a pixel takes, how densely its map lies there, and which page
// of it the pixel reads. The normal comes from the depth, whether or not the engine has one: it decides nothing but by the configured normal offset.
#define MASK_GENERAL 1
#define CSM_FILTER CSM_FILTER_NEAREST
#include "private/mask.hlsl"

// The square of the texels of a map that a step in light space passes.
float texels_square(float4 scale, float side, float3 step)
{
    float u = scale.x * step.x * side, v = scale.y * step.y * side;
    return mad(u, u, v * v) * 0.25;
}

// The place of a page in its layer, in 16 steps that tell it from its neighbours.
float page_of(csm_found found)
{
    float4 rect = csm_rect(found);
    float half_side = 0.5 * rect.z, pages = 64.0 / rect.z;
    float right = floor(mad(found.at.x, half_side, half_side + rect.x) * pages);
    float down = floor(mad(-found.at.y, half_side, half_side + rect.y) * pages);
    return mad(mad(floor(right * 0.25), -4.0, right), 4.0, mad(floor(down * 0.25), -4.0, down));
}

float main(mask_inputs pixel) : SV_Target
{
    inputs = pixel;
    float2 place = pixel.position.xy;
    float depth = camera_depth.Load(int3(int2(place), 0));
    float2 steps = depth_steps(place, depth);
    float3 at = light_position(place, depth), normal = unit(plane_normal(place, depth, steps));
    csm_choice choice = csm_choose(csm_receiver_of(at, normal, light_view_depth(at)));
    // Half the logarithm of the square; rounded here, so that no format has a say in it
    float4 scale = csm_c[CSM_C_SCALES + choice.first.cascade];
    float side = csm_rect(choice.first).z;
    float right = texels_square(scale, side, light_position(float2(place.x + 1.0, place.y), depth + steps.x) - at);
    float down = texels_square(scale, side, light_position(float2(place.x, place.y + 1.0), depth + steps.y) - at);
    float level = floor(mad(log2(clamp(max(right, down), 1e-30, 1e30)), 8.0, 128.5));
    float cascade = float(choice.first.cascade + 1);
    float show = mask_c[CSM_M_CLEAR].y;
    float page = mad(cascade, 16.0, page_of(choice.first) - 15.0);
    float view = show < 1.5 ? cascade : show < 2.5 ? clamp(level, 1.0, 255.0) : page;
    return depth == mask_c[CSM_M_CLEAR].x || !choice.first.held ? 0.0 : view * (1.0 / 255.0);
}
