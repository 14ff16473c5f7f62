#version 450
layout(location = 0) in vec3 position;
layout(push_constant) uniform block { mat4 object_to_clip; };

void main() { gl_Position = object_to_clip * vec4(position, 1); }
