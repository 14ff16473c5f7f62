// The forward pass: positions relative to csm_binding.origin, then clip space.
#include "include/bones.hlsl"
#include "include/frame.hlsl"

struct outputs
{
    float4 clip : SV_Position;
    float3 position : POSITION;
    float3 normal : NORMAL;
};

outputs main(float3 position : POSITION, float3 normal : NORMAL)
{
    float3 p = bent_position(position);
    outputs o;
    o.clip = float4(row(to_clip[0], p), row(to_clip[1], p), row(to_clip[2], p), row(to_clip[3], p));
    o.position = p;
    o.normal = bent_normal(normal, position);
    return o;
}
