// Draws a skinned thing into a shadow map: its bones lead straight to the map's clip space.
#include "include/bones.hlsl"

float4 main(float3 position : POSITION) : SV_Position
{
    return float4(bent_position(position), 1.0); // a sun's projection is affine: w is 1
}
