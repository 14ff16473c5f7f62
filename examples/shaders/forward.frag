// The forward pass: sun and sky on a plain colour, the sun's share by csm.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "csm_constants.h"
#include "include/bones.glsl"
#include "include/frame.glsl"

// What csm_sample.glsl reads: its constants, and its maps with a comparing sampler.
layout(set = 0, binding = 0, std140) uniform shadow_block
{
    vec4 csm_c[CSM_C_COUNT];
};
layout(set = 0, binding = 2) uniform sampler2DArrayShadow csm_maps;
#include "csm_sample.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 0) out vec4 color;

void main()
{
    vec3 n = normal * inversesqrt(dot(normal, normal));
    float visibility = csm_visibility(position, n, csm_view_depth(position));
    vec3 light = sky_light.xyz * (0.75 + 0.25 * n.y) + sun_light.xyz * (visibility * max(dot(n, to_sun.xyz), 0.0));
    color = vec4(surface.xyz * light, 1.0);
}
