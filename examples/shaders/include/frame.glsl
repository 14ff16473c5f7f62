// frame.glsl: the block frame_constants of world.h.
layout(set = 0, binding = 1, std140) uniform frame_block
{
    vec4 to_clip[4]; // rows; from positions relative to csm_binding.origin
    vec4 to_sun;     // unit
    vec4 sun_light;  // colours
    vec4 sky_light;
};
