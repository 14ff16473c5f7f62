// The forward pass: positions relative to csm_binding.origin, then clip space.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "include/bones.glsl"
#include "include/frame.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 0) out vec3 out_position;
layout(location = 1) out vec3 out_normal;

void main()
{
    vec3 p = bent_position(position);
    out_position = p;
    out_normal = bent_normal(normal, position);
    gl_Position = vec4(row(to_clip[0], p), row(to_clip[1], p), row(to_clip[2], p), row(to_clip[3], p));
}
