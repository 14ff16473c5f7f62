// What the history's vertex shader hands to its pixel shader, the same for every pixel: see mask_inputs.hlsl.
struct history_inputs
{
    nointerpolation float4 place_0 : PLACE0; // HISTORY_PLACE
    nointerpolation float4 place_1 : PLACE1;
    nointerpolation float4 place_2 : PLACE2;
    nointerpolation float4 place_3 : PLACE3;
    nointerpolation float4 plane_0 : PLANE0; // HISTORY_PLANE
    nointerpolation float4 plane_1 : PLANE1;
    nointerpolation float4 plane_2 : PLANE2;
    nointerpolation float4 normal_0 : NORMAL0; // HISTORY_NORMAL
    nointerpolation float4 normal_1 : NORMAL1;
    nointerpolation float4 normal_2 : NORMAL2;
    nointerpolation float4 own : OWN0;       // HISTORY_OWN
    nointerpolation float4 size : SIZE0;     // HISTORY_SIZE
    nointerpolation float4 limits : LIMITS0; // HISTORY_LIMITS
    nointerpolation float4 clear : CLEAR0;   // HISTORY_CLEAR
    float4 position : SV_Position;
};
