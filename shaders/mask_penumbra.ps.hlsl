// The debug view of penumbrae, as csm.h defines it. The spot is the one that the mask's filter gets, but for the engine's
// normals; where two cascades blend, that of the nearer one.
#define MASK_GENERAL 1
#include "csm_enums.h"
#if CSM_FILTER == CSM_FILTER_VSSM
#define MASK_SEARCH(spot) csm_search_moments(spot, csm_receiver_deviation(spot))
#else
#define MASK_SEARCH(spot) csm_search(spot)
#endif
#define CSM_FILTER_BODY(spot)                                                                                          \
    csm_blockers found = MASK_SEARCH(spot);                                                                            \
    return found.dark > 0.0 ? csm_penumbra(spot, found.heights / max(found.weights, 1e-6)) : 0.0;
#include "private/mask.hlsl"

float main(mask_inputs pixel) : SV_Target
{
    inputs = pixel;
    float2 place = pixel.position.xy;
    float depth = camera_depth.Load(int3(int2(place), 0));
    float3 at = light_position(place, depth), normal = unit(plane_normal(place, depth, depth_steps(place, depth)));
    csm_receiver receiver = csm_receiver_of(at, normal, light_view_depth(at));
    csm_choice choice = csm_choose(receiver);
    float radius = csm_look_up(choice.first, receiver, csm_tilt_of(normal, CSM_BIAS_ROW.z));
    // Rounded here, so that no format has a say in it
    float level = floor(mad(log2(clamp(radius, 1e-30, 1e30)), 16.0, 128.5));
    bool none = depth == mask_c[CSM_M_CLEAR].x || !choice.first.held || radius <= 0.0;
    return none ? 0.0 : clamp(level, 1.0, 255.0) * (1.0 / 255.0);
}
