// What the history's vertex shader hands to its pixel shader, the same for every pixel: see mask_inputs.hlsl.
struct history_inputs
{
    nointerpolation float4 place_0 : PLACE0; // CSM_H_PLACE
    nointerpolation float4 place_1 : PLACE1;
    nointerpolation float4 place_2 : PLACE2;
    nointerpolation float4 place_3 : PLACE3;
    nointerpolation float4 plane_0 : PLANE0; // CSM_H_PLANE
    nointerpolation float4 plane_1 : PLANE1;
    nointerpolation float4 plane_2 : PLANE2;
    nointerpolation float4 normal_0 : NORMAL0; // CSM_H_NORMAL
    nointerpolation float4 normal_1 : NORMAL1;
    nointerpolation float4 normal_2 : NORMAL2;
    nointerpolation float4 own : OWN0;       // CSM_H_OWN
    nointerpolation float4 size : SIZE0;     // CSM_H_SIZE
    nointerpolation float4 limits : LIMITS0; // CSM_H_LIMITS
    nointerpolation float4 clear : CLEAR0;   // CSM_H_CLEAR
    nointerpolation float4 noise : NOISE0;   // CSM_H_NOISE
    float4 position : SV_Position;
};
