#!/usr/bin/env python3
"""
includes.py GLSLANG SPIRV_VAL SPIRV_DIS SOURCE_ROOT [--long]: shaders/include compiles as engines include it, by the compiler's own
#include, in either language, with names of the includer's choice and each filter; and both languages lay the constants
out as csm_constants.h says. Without --long defines are fixed several at a time, and each filter with some of the ways
to read.
"""
import concurrent.futures
import pathlib
import re
import subprocess
import sys
import tempfile

glslang, spirv_val, spirv_dis, root = sys.argv[1:5]
every = "--long" in sys.argv
include = pathlib.Path(root) / "shaders/include"
count = int(re.search(r"#define CSM_C_COUNT (\d+)", (include / "csm_constants.h").read_text())[1])

hlsl = """#include "csm_constants.h"
cbuffer shadows : register(b0) { float4 CONSTANTS[CSM_C_COUNT]; };
Texture2DArray<float> MAPS : register(t0);
#ifdef MOMENTS
Texture2DArray<float4> MOMENTS : register(t1);
SamplerState csm_linear : register(s2);
#endif
#ifdef CSM_POINT
SamplerState CSM_POINT : register(s0);
#endif
#ifdef ROWS
StructuredBuffer<uint4> csm_meshes : register(t8);
StructuredBuffer<uint4> csm_instances : register(t9);
#endif
#ifdef OWN_ROWS
Buffer<uint4> trees : register(t8);
#define CSM_MESHES(row) trees[int(row)]
#define CSM_INSTANCES(row) trees[int(row) + 4096]
#endif
#ifdef OWN_TRACER
bool is_hidden(float3 position, float3 direction, float apart) { return position.y + direction.y > apart; }
#define CSM_TRACE(position, direction, apart) is_hidden(position, direction, apart)
#endif
#ifdef OWN_COMPARISON
SamplerComparisonState compare : register(s1);
#define CSM_COMPARE(uv, layer, reference) MAPS.SampleCmpLevelZero(compare, float3(uv, layer), reference)
#endif
#ifdef OWN_TEXEL
#define CSM_TEXEL_LIT(texel, layer, reference) float(reference <= MAPS.Load(int4(int2(texel), int(layer), 0)))
#endif
#include "csm_sample.hlsl"
float main(float4 p : SV_Position) : SV_Target { return ASKED; }
"""
glsl = """#version 450
#extension GL_GOOGLE_include_directive : require
#include "csm_constants.h"
layout(set = 0, binding = 0) uniform shadows { vec4 CONSTANTS[CSM_C_COUNT]; };
#ifdef CSM_DEPTH_ONLY
#elif defined(CSM_SAMPLER)
layout(set = 0, binding = 1) uniform texture2DArray MAPS;
layout(set = 0, binding = 2) uniform samplerShadow CSM_SAMPLER;
#else
layout(set = 0, binding = 1) uniform sampler2DArrayShadow MAPS;
#endif
#ifdef CSM_DEPTHS
layout(set = 0, binding = 3) uniform sampler2DArray CSM_DEPTHS;
#endif
#ifdef MOMENTS
layout(set = 0, binding = 6) uniform sampler2DArray MOMENTS;
#endif
#ifdef ROWS
layout(std430, set = 0, binding = 7) readonly buffer meshes { uvec4 rows[]; } csm_meshes;
layout(std430, set = 0, binding = 8) readonly buffer instances { uvec4 rows[]; } csm_instances;
#endif
#ifdef OWN_ROWS
layout(set = 0, binding = 7) uniform utextureBuffer trees;
#define CSM_MESHES(row) texelFetch(trees, int(row))
#define CSM_INSTANCES(row) texelFetch(trees, int(row) + 4096)
#endif
#ifdef OWN_TRACER
bool is_hidden(vec3 position, vec3 direction, float apart) { return position.y + direction.y > apart; }
#define CSM_TRACE is_hidden
#endif
#ifdef OWN_COMPARISON
#define CSM_COMPARE(uv, layer, reference) textureGrad(MAPS, vec4(uv, layer, reference), vec2(0.0), vec2(0.0))
#endif
#ifdef OWN_TEXEL
layout(set = 0, binding = 4) uniform texture2DArray texels;
layout(set = 0, binding = 5) uniform sampler any;
#define CSM_TEXEL_LIT(texel, layer, reference) \\
    float(reference <= texelFetch(sampler2DArray(texels, any), ivec3(texel, layer), 0).x)
#endif
#include "csm_sample.glsl"
layout(location = 0) out float lit;
void main() { vec4 p = gl_FragCoord; lit = ASKED; }
"""
# Two suns by one include: what the macros name may depend on a variable.
compute = """#version 450
#extension GL_GOOGLE_include_directive : require
#include "csm_constants.h"
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform shadows { vec4 suns[2][CSM_C_COUNT]; };
layout(set = 0, binding = 1) uniform sampler2DArrayShadow maps[2];
layout(set = 0, binding = 2, r32f) uniform image2D lit;
int sun;
#define CSM_CONSTANTS suns[sun]
#define AT(i, uv, layer, reference) textureGrad(maps[i], vec4(uv, layer, reference), vec2(0.0), vec2(0.0))
#define CSM_COMPARE(uv, layer, reference) (sun == 0 ? AT(0, uv, layer, reference) : AT(1, uv, layer, reference))
#include "csm_sample.glsl"
void main()
{
    vec3 p = vec3(gl_GlobalInvocationID);
    sun = 0;
    float both = csm_visibility(p, p, csm_view_depth(p));
    sun = 1;
    imageStore(lit, ivec2(p.xy), vec4(both * csm_visibility(p, p, csm_view_depth(p))));
}
"""
hlsl_suns = """#include "csm_constants.h"
cbuffer shadows : register(b0) { float4 suns[2][CSM_C_COUNT]; };
Texture2DArray<float> first : register(t0);
Texture2DArray<float> second : register(t1);
static int sun;
float depth(float2 texel, float layer)
{
    int4 at = int4(int2(texel), int(layer), 0);
    return sun == 0 ? first.Load(at) : second.Load(at);
}
#define CSM_TEXEL_LIT(texel, layer, reference) float(reference <= depth(texel, layer))
#define CSM_CONSTANTS suns[sun]
#include "csm_sample.hlsl"
float main(float4 p : SV_Position) : SV_Target
{
    sun = 0;
    float both = csm_visibility(p.xyz, p.xyz, csm_view_depth(p.xyz));
    sun = 1;
    return both * csm_visibility(p.xyz, p.xyz, csm_view_depth(p.xyz));
}
"""
# Rays to two suns through the same meshes, by two prefixes; or to one of them by a tracer that the other does not have.
hlsl_prefixes = """#include "csm_constants.h"
cbuffer shadows : register(b0) { float4 suns[2][CSM_C_COUNT]; };
Texture2DArray<float> maps : register(t0);
StructuredBuffer<uint4> csm_meshes : register(t8);
StructuredBuffer<uint4> csm_instances : register(t9);
StructuredBuffer<uint4> moon_instances : register(t10);
#define CSM_PREFIX moon_
#define CSM_RAYS 1
#define CSM_FILTER CSM_FILTER_EXACT_SOFT
#ifdef MOON_TRACER
#define CSM_TRACE(position, direction, apart) (position.y + direction.y > apart)
#else
#define CSM_INSTANCES(row) moon_instances[row]
#endif
#define CSM_CONSTANTS suns[1]
#define CSM_MAPS maps
#include "csm_sample.hlsl"
#define CSM_RAYS 1
#define CSM_CONSTANTS suns[0]
#define CSM_MAPS maps
#include "csm_sample.hlsl"
float main(float4 p : SV_Position) : SV_Target
{
    return csm_visibility(p.xyz, p.xyz, p.w) * moon_visibility(p.xyz, p.xyz, p.w);
}
"""
asked = {"ASKED": "csm_visibility(p.xyz,p.xyz,csm_view_depth(p.xyz))"}
usual = {"CONSTANTS": "csm_c", "MAPS": "csm_maps", **asked}
named = {"CSM_CONSTANTS": "c", "CSM_MAPS": "maps", "CONSTANTS": "c", "MAPS": "maps", **asked}
LOAD, GATHER, GATHER_LIT, LIT = READS = "OpImageFetch", "OpImageGather", "OpImageDrefGather", "OpImageSampleDref"
# How the maps are read in each language: four texels with what, single ones with what
ways = {
    "HLSL, loads": (hlsl, usual, {LOAD}, {LOAD}),
    "HLSL, own names, gathers": (hlsl, {**named, "CSM_POINT": "point_sampler"}, {GATHER}, {LOAD}),
    "HLSL, own comparison": (hlsl, {**usual, "OWN_COMPARISON": "1"}, {LIT}, {LIT}),
    "HLSL, own comparison with a texel": (hlsl, {**usual, "OWN_TEXEL": "1"}, {LOAD}, {LOAD}),
    "GLSL, gathers with comparison": (glsl, usual, {GATHER_LIT, LIT}, {LIT}),
    "GLSL, own names, sampler apart": (glsl, {**named, "CSM_SAMPLER": "compare"}, {GATHER_LIT, LIT}, {LIT}),
    "GLSL, own names, depths": (glsl, {**named, "CSM_DEPTHS": "depths"}, {GATHER}, {LIT}),
    "GLSL, depths alone": (glsl, {**usual, "CSM_DEPTH_ONLY": "1", "CSM_DEPTHS": "depths"}, {GATHER}, {LOAD}),
    "GLSL, own comparison": (glsl, {**usual, "OWN_COMPARISON": "1"}, {LIT}, {LIT}),
    "GLSL, own comparison with a texel": (glsl, {**usual, "OWN_TEXEL": "1"}, {LOAD}, {LOAD}),
}
NEAREST, FIRST_OF_MOMENTS, FIRST_SOFT, FIRST_OF_RAYS, FILTERS = 2, 10, 15, 18, 20
cases = {}  # source, stage, macros, the instructions that read (None: any), whether one is all
for way, (source, defines, reads, texel_reads) in ways.items():
    cases[f"{way}, as configured"] = source, "frag", defines, reads | texel_reads, False
    usual_way = way in ("HLSL, loads", "GLSL, gathers with comparison")
    some = (NEAREST, FIRST_OF_MOMENTS - 1) if "own comparison" in way else (1, NEAREST, 4, 6, FIRST_OF_MOMENTS - 1)
    for kind in range(FIRST_OF_MOMENTS) if usual_way or (every and "own comparison" not in way) else some:
        fixed, nearest = {**defines, "CSM_FILTER": str(kind)}, kind == NEAREST
        cases[f"{way}, filter {kind}"] = source, "frag", fixed, texel_reads if nearest else reads, nearest
# Each define fixed to each of its values, and all of them; what is fixed away is not read.
axes = {"CSM_BIAS_MODE": 2, "CSM_BIAS_UNITS": 2, "CSM_NORMAL_OFFSET_ON": 2, "CSM_NORMAL_OFFSET_MODE": 3, "CSM_SELECTION": 3, "CSM_OUT_OF_RANGE": 3,
        "CSM_BLENDING": 3, "CSM_MAPS_ALIKE": 3, "CSM_MAPS_REVERSED": 2, "CSM_FILTER_WEIGHTS": 3, "CSM_EARLY_OUT": 2}
for language, source, reads in (("HLSL", hlsl, {LOAD}), ("GLSL", glsl, {GATHER_LIT, LIT})):
    for value in range(3):  # of all of them at once
        fixed = {name: str(value % many) for name, many in axes.items()}
        once = reads - {LIT} if value % 2 == 0 else reads  # one depth for four texels
        cases[f"{language}, values {value}"] = source, "frag", {**usual, "CSM_FILTER": "4", **fixed}, once, False
    for name, many in axes.items() if every else ():
        for value in range(many):
            once = reads - {LIT} if (name, value) == ("CSM_BIAS_MODE", 0) else reads  # one depth for four texels
            cases[f"{language}, {name} {value}"] = source, "frag", {**usual, "CSM_FILTER": "4", name: str(value)}, once, False
    for cascades in range(1, 9) if every else (1, 4, 8):
        cases[f"{language}, {cascades} cascades"] = source, "frag", {
            **usual, "CSM_FILTER": "CSM_FILTER_PCF_3X3", "CSM_CASCADES": str(cascades)}, reads, False
    least = {**usual, **{name: "0" for name in axes}, "CSM_SELECTION": "CSM_SELECT_MAP", "CSM_FILTER": "0"}
    cases[f"{language}, all fixed"] = source, "frag", least, {LOAD} if source == hlsl else {GATHER_LIT}, False
    cases[f"{language}, a point"] = source, "frag", {
        **least, "ASKED": "csm_visibility_point(p.xyz,p.w)"}, {LOAD} if source == hlsl else {GATHER_LIT}, False
# Filters of moments read those alone, and through a name of the includer's where they are as configured.
MOMENTS = "OpImageSampleExplicitLod"
READS = (*READS, MOMENTS)
for language, source, reads in (("HLSL", hlsl, {LOAD}), ("GLSL", glsl, {GATHER_LIT, LIT})):
    grad = {"ASKED": "csm_visibility_grad(p.xyz,p.xyz,csm_view_depth(p.xyz),p.yzx,p.zxy)"}
    for kind in range(FIRST_OF_MOMENTS, FILTERS):
        fixed, of_moments = {**usual, "CSM_FILTER": str(kind), "MOMENTS": "csm_moments"}, kind < FIRST_SOFT
        expected = {MOMENTS} if of_moments else None
        if every or kind % 2 == (source == hlsl):
            cases[f"{language}, filter {kind}"] = source, "frag", fixed, expected, False
        if every or kind % 2 != (source == hlsl):
            cases[f"{language}, filter {kind}, levels"] = source, "frag", {**fixed, **grad}, expected, False
    cases[f"{language}, moments and soft, as configured"] = source, "frag", {
        **usual, **grad, "MOMENTS": "moments", "CSM_MOMENTS": "moments", "CSM_SOFT": "1"}, None, False
# Filters of rays look up rows; any other filter has none to look up, nor have they where no rays are asked for.
for language, source, rows in ("HLSL", hlsl, {"ROWS": "1"}), ("GLSL", glsl, {"ROWS": "1", "CSM_DEPTHS": "depths"}):
    rays = {**usual, "CSM_RAYS": "1"}
    for kind in range(FIRST_OF_RAYS, FILTERS):
        fixed = {**rays, "CSM_FILTER": str(kind)}
        cases[f"{language}, rays, filter {kind}"] = source, "frag", {**fixed, **rows}, None, False
        cases[f"{language}, rays, filter {kind}, own rows"] = source, "frag", {**fixed, "OWN_ROWS": "1"}, None, False
        cases[f"{language}, rays, filter {kind}, own tracer"] = source, "frag", {**fixed, "OWN_TRACER": "1"}, None, False
    cases[f"{language}, rays, all but maps fixed, a point"] = source, "frag", {
        **rays, **rows, **least, "CSM_FILTER": "18", "ASKED": "csm_visibility_point(p.xyz,p.w)"}, None, False
    cases[f"{language}, rays, as configured"] = source, "frag", {**rays, **rows}, None, False
    cases[f"{language}, rays, as configured, own tracer"] = source, "frag", {**rays, "OWN_TRACER": "1", "CSM_SOFT": "1"}, None, False
    cases[f"{language}, rays, as configured, soft"] = source, "frag", {**rays, **rows, "CSM_SOFT": "1"}, None, False
    cases[f"{language}, no rays for filter 1"] = source, "frag", {**rays, "CSM_FILTER": "1"}, None, False
cases["HLSL, rays to two suns"] = hlsl_prefixes, "frag", {}, None, False
cases["HLSL, rays to two suns, one by a tracer"] = hlsl_prefixes, "frag", {"MOON_TRACER": "1"}, None, False
cases["GLSL, two suns in a compute shader"] = compute, "comp", {}, {LIT}, False
cases["HLSL, two suns"] = hlsl_suns, "frag", {}, {LOAD}, False


def run(*command):
    done = subprocess.run([str(part) for part in command], text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if done.returncode:
        raise RuntimeError(done.stdout)
    return done.stdout


def check_enumerations():
    """csm_enums.h has csm_config.h's enumerations that shaders share."""
    header = (pathlib.Path(root) / "api/include/csm/csm_config.h").read_text()
    values = dict(re.findall(r"(CSM_[A-Z0-9_]+) = (\d+)", header))
    macros = dict(re.findall(r"#define (CSM_[A-Z0-9_]+) (\d+)\n", (include / "csm_enums.h").read_text()))
    assert len(macros) > 20, "no enumerations"
    wrong = [name for name, value in macros.items() if values.get(name) != value]
    missing = [name for name in values if name.startswith(("CSM_FILTER_", "CSM_WEIGHTS_", "CSM_SELECT_", "CSM_BLEND_",
               "CSM_OUT_OF_RANGE_", "CSM_BIAS_", "CSM_NORMAL_OFFSET_", "CSM_LAYOUT_")) and name not in macros]
    assert not wrong and not missing, f"csm_enums.h and csm_config.h differ: {wrong + missing}"


def compile_case(folder, source, stage, defines):
    path, output = folder / "shader", folder / "shader.spv"
    path.write_text(source)
    language = ["--hlsl-iomap", "--shift-texture-binding", "16", "--shift-sampler-binding", "48", "-D", "-e", "main"] if (
        source in (hlsl, hlsl_suns, hlsl_prefixes)) else []
    run(glslang, "-V", *language, "-S", stage, "--target-env", "vulkan1.1", f"-I{include}",
        *(f"-D{name}={value}" for name, value in defines.items()), "-o", output, path)
    run(spirv_val, "--target-env", "vulkan1.1", output)
    return run(spirv_dis, "--raw-id", output)


def check_layout(text):
    """The block begins at 0, and is CSM_C_COUNT float4 that lie 16 bytes apart."""
    lengths = "|".join(re.findall(rf"(%\d+) = OpConstant %\d+ {count}\n", text))
    array = re.search(rf"(%\d+) = OpTypeArray %\d+ (?:{lengths})\n", text)[1]
    block = re.search(rf"(%\d+) = OpTypeStruct {array}\n", text)[1]
    assert f"OpDecorate {array} ArrayStride 16\n" in text, "another stride"
    assert f"OpMemberDecorate {block} 0 Offset 0\n" in text, "another offset"


def check_case(case):
    name, (source, stage, defines, reads, one) = case
    with tempfile.TemporaryDirectory() as scratch:
        try:
            text = compile_case(pathlib.Path(scratch), source, stage, defines)
            if source in (hlsl, glsl):
                check_layout(text)
            found = {read: len(re.findall(read, text)) for read in READS}
            assert reads is None or {read for read in READS if found[read]} == reads, f"reads by {found}"
            # And again where the receiver is steep: functions are inlined in one language, and not in the other
            assert not one or sum(found.values()) in (1, 2), f"not a single texel: {found}"
            return 0
        except (RuntimeError, AssertionError) as error:
            print(f"{name}: {error}")
            return 1


def refuses(source, value):
    with tempfile.TemporaryDirectory() as scratch:
        try:
            compile_case(pathlib.Path(scratch), source, "frag", {**usual, "CSM_FILTER": value})
        except RuntimeError as error:
            return "CSM_FILTER is 0 to 19" in str(error)
        return False


check_enumerations()
with concurrent.futures.ThreadPoolExecutor(2) as pool:
    failed = sum(pool.map(check_case, cases.items()))
for source in (hlsl, glsl):
    if not refuses(source, str(FILTERS)):
        failed += 1
        print("a filter that is not there goes unseen")
print(f"{len(cases)} ways to include, {failed} failures")
sys.exit(1 if failed else 0)
