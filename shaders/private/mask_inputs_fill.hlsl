// Fills mask_inputs from the blocks of constants, which the includer declares before this: for a vertex shader that hands them
// on, and for what has none.
#if MASK_NORMALS
#define NORMAL_ROWS CSM_M_NORMALS
#else
#define NORMAL_ROWS CSM_M_PLANES
#endif

mask_inputs mask_inputs_of(float4 position)
{
    mask_inputs o;
    o.position = position;
    o.light_0 = mask_c[CSM_M_LIGHT];
    o.light_1 = mask_c[CSM_M_LIGHT + 1];
    o.light_2 = mask_c[CSM_M_LIGHT + 2];
    o.light_3 = mask_c[CSM_M_LIGHT + 3];
    o.normal_0 = mask_c[NORMAL_ROWS];
    o.normal_1 = mask_c[NORMAL_ROWS + 1];
    o.normal_2 = mask_c[NORMAL_ROWS + 2];
    o.scale_0 = float4(csm_c[CSM_C_SCALES].xyz, mask_c[CSM_M_BIAS].x);
    o.scale_1 = float4(csm_c[CSM_C_SCALES + 1].xyz, mask_c[CSM_M_BIAS].y);
    o.scale_2 = float4(csm_c[CSM_C_SCALES + 2].xyz, mask_c[CSM_M_BIAS].z);
    o.scale_3 = float4(csm_c[CSM_C_SCALES + 3].xyz, mask_c[CSM_M_BIAS].w);
    o.offset_0 = float4(csm_c[CSM_C_OFFSETS].xyz, mask_c[CSM_M_DEPTH].x);
    o.offset_1 = float4(csm_c[CSM_C_OFFSETS + 1].xyz, mask_c[CSM_M_DEPTH].y);
    o.offset_2 = float4(csm_c[CSM_C_OFFSETS + 2].xyz, mask_c[CSM_M_DEPTH].z);
    o.offset_3 = float4(csm_c[CSM_C_OFFSETS + 3].xyz, csm_c[CSM_C_PARAMS].y);
    return o;
}
