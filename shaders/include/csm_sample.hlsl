// csm_sample.hlsl: visibility of the light at a point, from the cascades' maps, for an engine's HLSL. Any stage.
//
//   cbuffer shadows : register(b0) { float4 csm_c[CSM_C_COUNT]; };   // csm_binding.constants, as csm_constants.h lays out
//   Texture2DArray<float> csm_maps : register(t0);                   // the maps
//   #include "csm_sample.hlsl"
//   ... csm_visibility(position - origin, normal, view_depth)
//   ... csm_visibility_point(position - origin, view_depth)          // fog, particles, volumes: there is no normal
//
// csm_constants.h, which this includes, may be included before them. Names are the includer's choice; define, before:
//   CSM_CONSTANTS    what is indexed for a float4 of the blocks (csm_c)
//   CSM_CONSTANT(i)  or how one is had, where they are no array: a function, a texture, two blocks (CSM_CONSTANTS[i])
//   CSM_PREFIX       what the functions' and structs' names begin with, in place of csm_; this may be included again then,
//                    for another light, and forgets all defines but those of the shared headers. Where there are several
//                    inclusions, all but the last have one
//   CSM_MAPS         the maps (csm_maps)
//   CSM_POINT        a sampler, point and clamped, or with map_layout pages repeated: four texels are gathered at once then,
//                    which is faster
//   CSM_MOMENTS      a Texture2DArray<float4>, the moments, for filters that read them (csm_moments, where a define fixes
//                    such a filter); without it those are pcf_3x3
//   CSM_LINEAR       a sampler for it: linear, also between levels, clamped (csm_linear)
//   CSM_SOFT         1: filters pcss, vssm and backprojection are there too where no define fixes the filter; they make such
//                    a shader large, and are pcf_3x3 there without this
//   CSM_RAYS         1: filters exact and exact_soft send rays where the maps do not decide, from the position itself. Without
//                    this they are pcf_3x3 and pcss. exact_soft takes CSM_SOFT, too, where no define fixes the filter
//   CSM_MESHES(row)  for CSM_RAYS: a row, a uint4, of csm_binding.native_ray_meshes (csm_meshes[row], by default, of a
//                    StructuredBuffer<uint4>)
//   CSM_INSTANCES(row)   and of native_ray_instances (csm_instances[row])
//   CSM_TRACE(position, direction, apart)   for CSM_RAYS: a tracer of the includer's own in place of those two buffers: whether
//                    anything lies between a float3 position, relative to csm_binding.origin, and the light, in a direction
//                    of length 1; what is no farther than `apart` metres from the plane of a triangle is on it
//   CSM_COMPARE(uv, layer, reference)   a bilinear comparison of the includer's own, to read through instead
//   CSM_TEXEL_LIT(texel, layer, reference)   the comparison with one texel, by its index: 1 or 0, likewise
// No sampler that compares is needed, unless CSM_COMPARE has one: filter linear_depth gives the bilinear comparison there.
//
// What csm_shader_defines(config) gives fixes what is else read at run time; each may also be defined alone:
//   CSM_FILTER          CSM_FILTER_*                 CSM_BIAS_MODE      CSM_BIAS_*
//   CSM_FILTER_TAPS     taps, or points              CSM_BIAS_UNITS     0: no bias but in texels, and a constant range
//   CSM_FILTER_WEIGHTS  CSM_WEIGHTS_*                CSM_NORMAL_OFFSET_ON    0: there is none
//   CSM_EARLY_OUT       0 or 1                       CSM_MAPS_ALIKE     1: an array of maps of one size, 2: of pages
//   CSM_SELECTION       CSM_SELECT_*                 CSM_MAPS_REVERSED  0 or 1
//   CSM_OUT_OF_RANGE    CSM_OUT_OF_RANGE_*           CSM_CASCADES       at most so many cascades
//   CSM_BLENDING        CSM_BLEND_*                 CSM_NORMAL_OFFSET_MODE  CSM_NORMAL_OFFSET_*
// CSM_AS_CONFIGURED fixes nothing, and is what each is where it is not defined.
#ifdef CSM_PREFIX
#undef CSM_SAMPLE_HLSL
#endif
#ifndef CSM_SAMPLE_HLSL
#define CSM_SAMPLE_HLSL

#include "csm_constants.h"
#include "csm_enums.h"

#ifdef CSM_PREFIX
#include "csm_prefix.inc"
#endif

#ifndef CSM_CONSTANTS
#define CSM_CONSTANTS csm_c
#endif
#ifndef CSM_CONSTANT
#define CSM_CONSTANT(i) CSM_CONSTANTS[i]
#endif
#ifndef CSM_MAPS
#define CSM_MAPS csm_maps
#endif
// Who compares in a way of their own has maps of their own: at a texel's centre that comparison is the texel's.
#ifdef CSM_COMPARE
#ifndef CSM_TEXEL_LIT
#define CSM_TEXEL_LIT(texel, layer, reference)                                                                         \
    CSM_COMPARE((texel + 0.5) * CSM_CONSTANT(CSM_C_PARAMS).zw, layer, reference)
#endif
#endif
#ifndef CSM_TEXEL_LIT
#define CSM_DEPTH(texel, layer) CSM_MAPS.Load(int4(int2(csm_texel_at(texel)), int(layer), 0))
#define CSM_TEXEL_LIT(texel, layer, reference) float((reference) * CSM_SIDE <= CSM_DEPTH(texel, layer) * CSM_SIDE)
#ifdef CSM_POINT
// Of four components, so that the compiler's place for them begins at a register's first: vkd3d 1.2 misreads
// `mov r.yzw, q.xyzw`.
#define CSM_DEPTHS_4(texel, layer)                                                                                     \
    CSM_MAPS.Gather(CSM_POINT, float4((texel + 1.0) * CSM_CONSTANT(CSM_C_PARAMS).zw, layer, layer).xyz).wzxy
#else
#define CSM_DEPTHS_4(texel, layer)                                                                                     \
    float4(CSM_DEPTH(texel, layer), CSM_DEPTH((texel + float2(1.0, 0.0)), layer),                                      \
           CSM_DEPTH((texel + float2(0.0, 1.0)), layer), CSM_DEPTH((texel + 1.0), layer))
#endif
#endif
#if defined(CSM_FILTER) && !defined(CSM_MOMENTS)
#if (CSM_FILTER >= CSM_FILTER_VSM && CSM_FILTER <= CSM_FILTER_MSM4) || CSM_FILTER == CSM_FILTER_VSSM
#define CSM_MOMENTS csm_moments
#endif
#endif
#ifdef CSM_MOMENTS
#ifndef CSM_LINEAR
#define CSM_LINEAR csm_linear
#endif
#define CSM_MOMENTS_AT(uv, layer, level) CSM_MOMENTS.SampleLevel(CSM_LINEAR, float4(uv, layer, layer).xyz, level)
#endif
#ifndef CSM_MESHES
#define CSM_MESHES(row) csm_meshes[row]
#endif
#ifndef CSM_INSTANCES
#define CSM_INSTANCES(row) csm_instances[row]
#endif
#define CSM_ROW_FLOATS(row) asfloat(row)
#define CSM_BITS(value) asint(value)
#define csm_float2 float2
#define csm_float3 float3
#define csm_float4 float4
#define csm_uint4 uint4
#define csm_mad mad
#define CSM_UNROLL [unroll]
#define CSM_LOOP [loop]
#define CSM_STATIC static const
#define CSM_GLOBAL static

#include "csm_sample.inc"

#ifdef CSM_PREFIX
#include "csm_forget.inc"
#endif

#endif
