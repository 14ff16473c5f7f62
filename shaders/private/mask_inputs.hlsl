// What the mask's vertex shader hands to its pixel shaders, the same for every pixel. They could read all of it from
// constants, but rasterisers on a CPU fetch a constant anew for each pixel, which cost more than all else that a mask does.
// 15 float4 and the position are as much as every Vulkan device takes.
struct mask_inputs
{
    nointerpolation float4 light_0 : LIGHT0; // CSM_M_LIGHT
    nointerpolation float4 light_1 : LIGHT1;
    nointerpolation float4 light_2 : LIGHT2;
    nointerpolation float4 light_3 : LIGHT3;
    nointerpolation float4 normal_0 : NORMAL0; // CSM_M_PLANES or CSM_M_NORMALS
    nointerpolation float4 normal_1 : NORMAL1;
    nointerpolation float4 normal_2 : NORMAL2;
    nointerpolation float4 scale_0 : SCALE0; // CSM_C_SCALES; w: CSM_M_BIAS
    nointerpolation float4 scale_1 : SCALE1;
    nointerpolation float4 scale_2 : SCALE2;
    nointerpolation float4 scale_3 : SCALE3;
    nointerpolation float4 offset_0 : OFFSET0; // CSM_C_OFFSETS; w: of CSM_M_DEPTH x, y, z, and y of CSM_C_PARAMS
    nointerpolation float4 offset_1 : OFFSET1;
    nointerpolation float4 offset_2 : OFFSET2;
    nointerpolation float4 offset_3 : OFFSET3;
    float4 position : SV_Position;
};
