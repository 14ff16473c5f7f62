// Draws a skinned thing into a shadow map: its bones lead straight to the map's clip space.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "include/bones.glsl"

layout(location = 0) in vec3 position;

void main()
{
    gl_Position = vec4(bent_position(position), 1.0); // a sun's projection is affine: w is 1
}
