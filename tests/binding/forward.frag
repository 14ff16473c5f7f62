// forward.ps.hlsl in GLSL, with names of its own and a sampler apart; FORWARD_DEPTHS: reading depths.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "csm_constants.h"

layout(set = 0, binding = 0) uniform shadows_block
{
    vec4 constants[CSM_C_COUNT];
} sun;
layout(set = 0, binding = 1) uniform plane_block
{
    vec4 plane[4]; // homogeneous position at (0, 0), its change for each pixel right and down; normal
};
layout(set = 0, binding = 16) uniform texture2DArray sun_maps;
layout(set = 0, binding = 48) uniform samplerShadow sun_sampler;

#ifdef FORWARD_DEPTHS
layout(set = 0, binding = 49) uniform sampler sun_point;
#define CSM_DEPTHS sampler2DArray(sun_maps, sun_point)
#endif

#define CSM_CONSTANTS sun.constants
#define CSM_MAPS sun_maps
#define CSM_SAMPLER sun_sampler
#include "csm_sample.glsl"

layout(location = 0) out float lit;

void main()
{
    vec4 p = plane[0] + gl_FragCoord.x * plane[1] + gl_FragCoord.y * plane[2];
    vec3 position = p.xyz / p.w;
    lit = csm_visibility(position, plane[3].xyz, csm_view_depth(position));
}
