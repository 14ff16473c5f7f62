// frame.hlsl: the block frame_constants of world.h.
cbuffer frame_block : register(b1)
{
    float4 to_clip[4]; // rows; from positions relative to csm_binding.origin
    float4 to_sun;     // unit
    float4 sun_light;  // colours
    float4 sky_light;
};
