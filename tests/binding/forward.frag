// forward.ps.hlsl in GLSL, with names of its own and a sampler apart. FORWARD_WAY: 0 compares, 1 reads depths, 2 is fixed to
// a configuration, 3 has two lights, one of them with depths alone, 4 asks for points, 5 is fixed to
// FORWARD_FILTER, has moments, and tells how the position changes; 6 sends rays, too, and is fixed to FORWARD_FILTER, or,
// without it, follows the configuration; 7 has no depths beside; 8 traces by itself, and binds none of csm's trees.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "csm_constants.h"
#include "forward_boxes.h"

layout(set = 0, binding = 0) uniform shadows_block
{
    vec4 constants[CSM_C_COUNT];
} sun;
layout(set = 0, binding = 1) uniform plane_block
{
    vec4 plane[4]; // homogeneous position at (0, 0), its change for each pixel right and down; normal
#if FORWARD_WAY == 8
    vec4 boxes[2 * FORWARD_BOXES]; // least and largest corners
#endif
};
layout(set = 0, binding = 16) uniform texture2DArray sun_maps;
#if FORWARD_WAY >= 5
layout(set = 0, binding = 17) uniform texture2DArray sun_moments;
layout(set = 0, binding = 48) uniform sampler sun_point;
layout(set = 0, binding = 49) uniform sampler sun_linear;
layout(set = 0, binding = 50) uniform samplerShadow sun_sampler;
#else
layout(set = 0, binding = 48) uniform samplerShadow sun_sampler;
layout(set = 0, binding = 49) uniform sampler sun_point;
#endif
#if FORWARD_WAY == 8
bool is_hidden(vec3 position, vec3 direction, float apart)
{
    bool hidden = false;
    for (int i = 0; i < FORWARD_BOXES; ++i)
    {
        vec3 a = (boxes[2 * i].xyz - position) / direction, b = (boxes[2 * i + 1].xyz - position) / direction;
        vec3 enters = min(a, b), leaves = max(a, b);
        float last = min(min(leaves.x, leaves.y), leaves.z);
        hidden = hidden || (last > apart && max(max(enters.x, enters.y), enters.z) <= last);
    }
    return hidden;
}
#define CSM_RAYS 1
#define CSM_TRACE is_hidden
#elif FORWARD_WAY >= 6
layout(std430, set = 0, binding = 24) readonly buffer mesh_block
{
    uvec4 rows[];
} csm_meshes;
layout(std430, set = 0, binding = 25) readonly buffer instance_block
{
    uvec4 rows[];
} scene;
#define CSM_RAYS 1
#define CSM_INSTANCES(row) scene.rows[row]
#endif

#if FORWARD_WAY == 3
vec4 constant(int i)
{
    return sun.constants[i];
}
#define CSM_PREFIX sun_
#define CSM_CONSTANT(i) constant(i)
#define CSM_DEPTH_ONLY 1
#define CSM_DEPTHS sampler2DArray(sun_maps, sun_point)
#include "csm_sample.glsl"
#define CSM_PREFIX moon_
#define CSM_CONSTANTS sun.constants
#define CSM_MAPS sun_maps
#define CSM_SAMPLER sun_sampler
#define CSM_DEPTHS sampler2DArray(sun_maps, sun_point)
#include "csm_sample.glsl"

float visibility(vec3 position)
{
    vec3 normal = plane[3].xyz;
    float lit = sun_visibility(position, normal, sun_view_depth(position));
    return 0.5 * (lit + moon_visibility(position, normal, moon_view_depth(position)));
}
#else
#if FORWARD_WAY == 1
#define CSM_DEPTHS sampler2DArray(sun_maps, sun_point)
#elif FORWARD_WAY == 2
#include "forward_defines.h"
#elif FORWARD_WAY >= 5
#if FORWARD_WAY != 7
#define CSM_DEPTHS sampler2DArray(sun_maps, sun_point)
#endif
#define CSM_MOMENTS sampler2DArray(sun_moments, sun_linear)
#ifdef FORWARD_FILTER
#define CSM_FILTER FORWARD_FILTER
#else
#define CSM_SOFT 1
#endif
#include "forward_plain.h"
#endif
#define CSM_CONSTANTS sun.constants
#define CSM_MAPS sun_maps
#define CSM_SAMPLER sun_sampler
#include "csm_sample.glsl"

float visibility(vec3 position)
{
#if FORWARD_WAY == 4
    return csm_visibility_point(position, csm_view_depth(position));
#else
    return csm_visibility(position, plane[3].xyz, csm_view_depth(position));
#endif
}
#endif

layout(location = 0) out float lit;

vec3 position_at(vec2 screen)
{
    vec4 p = plane[0] + screen.x * plane[1] + screen.y * plane[2];
    return p.xyz / p.w;
}

void main()
{
    vec3 position = position_at(gl_FragCoord.xy);
#if FORWARD_WAY >= 5
    vec3 across = position_at(gl_FragCoord.xy + vec2(1.0, 0.0)) - position;
    vec3 down = position_at(gl_FragCoord.xy + vec2(0.0, 1.0)) - position;
    lit = csm_visibility_grad(position, plane[3].xyz, csm_view_depth(position), across, down);
#else
    lit = visibility(position);
#endif
}
