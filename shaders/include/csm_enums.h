/*
 * csm_enums.h: the enumerations of csm_config that shaders know, as integers with names, for HLSL and GLSL. C and C++ have
 * them from csm.h, or here where CSM_ENUMS_AS_MACROS is defined and csm.h is not included; a test holds the two together.
 */
#ifndef CSM_ENUMS_H
#define CSM_ENUMS_H

#if defined(CSM_ENUMS_AS_MACROS) || (!defined(__cplusplus) && !defined(__STDC_VERSION__))

/* What a define is that fixes nothing. */
#define CSM_AS_CONFIGURED (-1)

#define CSM_FILTER_PCF_2X2 0
#define CSM_FILTER_PCF_3X3 1
#define CSM_FILTER_NEAREST 2
#define CSM_FILTER_LINEAR_DEPTH 3
#define CSM_FILTER_PCF_5X5 4
#define CSM_FILTER_PCF_7X7 5
#define CSM_FILTER_PCF_N 6
#define CSM_FILTER_POISSON 7
#define CSM_FILTER_VOGEL 8
#define CSM_FILTER_GRID_17 9
#define CSM_FILTER_VSM 10
#define CSM_FILTER_ESM 11
#define CSM_FILTER_EVSM2 12
#define CSM_FILTER_EVSM4 13
#define CSM_FILTER_MSM4 14
#define CSM_FILTER_PCSS 15
#define CSM_FILTER_VSSM 16
#define CSM_FILTER_BACKPROJECTION 17
#define CSM_FILTER_EXACT 18
#define CSM_FILTER_EXACT_SOFT 19

#define CSM_WEIGHTS_UNIFORM 0
#define CSM_WEIGHTS_GAUSSIAN 1
#define CSM_WEIGHTS_CASTANO 2

#define CSM_BIAS_SLOPE 0
#define CSM_BIAS_RECEIVER_PLANE 1

#define CSM_NORMAL_OFFSET_CONSTANT 0
#define CSM_NORMAL_OFFSET_SINE 1
#define CSM_NORMAL_OFFSET_ONE_MINUS_COSINE 2

#define CSM_SELECT_INTERVAL 0
#define CSM_SELECT_MAP 1
#define CSM_SELECT_BEST 2

#define CSM_OUT_OF_RANGE_LIT 0
#define CSM_OUT_OF_RANGE_DARK 1
#define CSM_OUT_OF_RANGE_FADED 2

#define CSM_BLEND_OFF 0
#define CSM_BLEND_LINEAR 1
#define CSM_BLEND_DITHERED 2

#define CSM_LAYOUT_ARRAY 0
#define CSM_LAYOUT_ATLAS 1
#define CSM_LAYOUT_PAGES 2

#define CSM_SAMPLING_BILINEAR 0
#define CSM_SAMPLING_TRILINEAR 1
#define CSM_SAMPLING_ANISOTROPIC 2

#define CSM_BLEEDING_LINEAR 0
#define CSM_BLEEDING_SMOOTHSTEP 1

#define CSM_PENUMBRA_LIGHT 0
#define CSM_PENUMBRA_RATIO 1

#endif
#endif
