// csm_sample.glsl: visibility of the light at a point, from the cascades' maps, for an engine's GLSL (4.50). Any stage.
//
//   layout(binding = 0) uniform shadows { vec4 csm_c[CSM_C_COUNT]; };  // csm_binding.constants; std140
//   layout(binding = 1) uniform sampler2DArrayShadow csm_maps;         // the maps with the sampler
//   #include "csm_sample.glsl"
//   ... csm_visibility(position - origin, normal, view_depth)
//   ... csm_visibility_point(position - origin, view_depth)            // fog, particles, volumes: there is no normal
//
// csm_constants.h, which this includes, may be included before them. Names are the includer's choice; define, before:
//   CSM_CONSTANTS    what is indexed for a float4 of the blocks (csm_c)
//   CSM_CONSTANT(i)  or how one is had, where they are no array: a function, a texture, two blocks (CSM_CONSTANTS[i])
//   CSM_PREFIX       what the functions' and structs' names begin with, in place of csm_; this may be included again then,
//                    for another light, and forgets all defines but those of the shared headers. Where there are several
//                    inclusions, all but the last have one
//   CSM_MAPS         the maps (csm_maps)
//   CSM_SAMPLER      a samplerShadow, where CSM_MAPS is a texture2DArray without one
//   CSM_DEPTHS       a sampler2DArray of the same maps, point and clamped, or with map_layout pages repeated: faster, and
//                    needed for filter linear_depth, which through comparisons alone gives the bilinear comparison
//   CSM_DEPTH_ONLY   1: there is no sampler that compares, and no CSM_MAPS: all is read through CSM_DEPTHS
//   CSM_MOMENTS      a sampler2DArray, the moments with a sampler that is linear, also between levels, and clamped, for
//                    filters that read them (csm_moments, where a define fixes such a filter); without it those are
//                    pcf_3x3
//   CSM_SOFT         1: filters pcss, vssm and backprojection are there too where no define fixes the filter; they make such
//                    a shader large, and are pcf_3x3 there without this
//   CSM_RAYS         1: filters exact and exact_soft send rays where the maps do not decide, from the position itself. Without
//                    this they are pcf_3x3 and pcss. exact_soft takes CSM_SOFT, too, where no define fixes the filter, and
//                    CSM_DEPTHS: through comparisons alone no map tells where penumbras are, and all is for rays
//   CSM_MESHES(row)  for CSM_RAYS: a row, a uvec4, of csm_binding.native_ray_meshes (csm_meshes.rows[row], by default:
//                    layout(std430, binding = 2) readonly buffer meshes { uvec4 rows[]; } csm_meshes;)
//   CSM_INSTANCES(row)   and of native_ray_instances (csm_instances.rows[row])
//   CSM_TRACE(position, direction, apart)   for CSM_RAYS: a tracer of the includer's own in place of those two buffers: whether
//                    anything lies between a vec3 position, relative to csm_binding.origin, and the light, in a direction
//                    of length 1; what is no farther than `apart` metres from the plane of a triangle is on it
//   CSM_COMPARE(uv, layer, reference)   a bilinear comparison of the includer's own, to read through instead
//   CSM_TEXEL_LIT(texel, layer, reference)   the comparison with one texel, by its index: 1 or 0, likewise
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
#undef CSM_SAMPLE_GLSL
#endif
#ifndef CSM_SAMPLE_GLSL
#define CSM_SAMPLE_GLSL

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
#ifndef CSM_DEPTH_ONLY
#define CSM_DEPTH_ONLY 0
#endif
#if CSM_DEPTH_ONLY == 1
#ifndef CSM_DEPTHS
#define CSM_DEPTHS csm_depths
#endif
#ifndef CSM_TEXEL_LIT
#define CSM_TEXEL_LIT(texel, layer, reference)                                                                         \
    float((reference) * CSM_SIDE <= texelFetch(CSM_DEPTHS, ivec3(ivec2(csm_texel_at(texel)), int(layer)), 0).x * CSM_SIDE)
#define CSM_DEPTHS_4(texel, layer) textureGather(CSM_DEPTHS, vec3(((texel) + 1.0) * CSM_CONSTANT(CSM_C_PARAMS).zw, layer)).wzxy
#endif
#else
#ifndef CSM_MAPS
#define CSM_MAPS csm_maps
#endif
#ifdef CSM_SAMPLER
#define CSM_SHADOWS sampler2DArrayShadow(CSM_MAPS, CSM_SAMPLER)
#else
#define CSM_SHADOWS CSM_MAPS
#endif
#ifndef CSM_COMPARE
#ifndef CSM_TEXEL_LIT
#define CSM_CENTRE(texel) (((texel) + 1.0) * CSM_CONSTANT(CSM_C_PARAMS).zw)
#ifdef CSM_DEPTHS
#define CSM_DEPTHS_4(texel, layer) textureGather(CSM_DEPTHS, vec3(CSM_CENTRE(texel), layer)).wzxy
#else
#define CSM_GATHER_LIT(texel, layer, reference)                                                                        \
    textureGather(CSM_SHADOWS, vec3(CSM_CENTRE(texel), layer), reference).wzxy
#endif
#endif
#endif
// Core GLSL has no textureLod of an array with comparison; without gradients this is level 0, in branches too.
#ifndef CSM_COMPARE
#define CSM_COMPARE(uv, layer, reference) textureGrad(CSM_SHADOWS, vec4(uv, layer, reference), vec2(0.0), vec2(0.0))
#endif
// At a texel's centre the bilinear comparison is that texel's own; GLSL cannot fetch from a sampler that compares.
#ifndef CSM_TEXEL_LIT
#define CSM_TEXEL_LIT(texel, layer, reference)                                                                         \
    CSM_COMPARE((texel + 0.5) * CSM_CONSTANT(CSM_C_PARAMS).zw, layer, reference)
#endif
#endif
#if defined(CSM_FILTER) && !defined(CSM_MOMENTS)
#if (CSM_FILTER >= CSM_FILTER_VSM && CSM_FILTER <= CSM_FILTER_MSM4) || CSM_FILTER == CSM_FILTER_VSSM
#define CSM_MOMENTS csm_moments
#endif
#endif
#ifdef CSM_MOMENTS
#define CSM_MOMENTS_AT(uv, layer, level) textureLod(CSM_MOMENTS, vec3(uv, layer), level)
#endif
#ifndef CSM_MESHES
#define CSM_MESHES(row) csm_meshes.rows[row]
#endif
#ifndef CSM_INSTANCES
#define CSM_INSTANCES(row) csm_instances.rows[row]
#endif
#define CSM_ROW_FLOATS(row) uintBitsToFloat(row)
#define CSM_BITS(value) floatBitsToInt(value)
#define csm_float2 vec2
#define csm_float3 vec3
#define csm_float4 vec4
#define csm_uint4 uvec4
#define csm_mad fma
#define CSM_UNROLL
#define CSM_LOOP
#define CSM_STATIC const
#define CSM_GLOBAL

#include "csm_sample.inc"

#ifdef CSM_PREFIX
#include "csm_forget.inc"
#endif

#endif
