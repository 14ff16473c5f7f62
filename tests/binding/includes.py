#!/usr/bin/env python3
"""
includes.py GLSLANG SPIRV_VAL SPIRV_DIS SOURCE_ROOT: shaders/include compiles as engines include it, by the compiler's own
#include, in either language, with names of the includer's choice and each filter; and both languages lay the constants
out as csm_constants.h says.
"""
import pathlib
import re
import subprocess
import sys
import tempfile

glslang, spirv_val, spirv_dis, root = sys.argv[1:]
include = pathlib.Path(root) / "shaders/include"
count = int(re.search(r"#define CSM_C_COUNT (\d+)", (include / "csm_constants.h").read_text())[1])

hlsl = """#include "csm_constants.h"
cbuffer shadows : register(b0) { float4 CONSTANTS[CSM_C_COUNT]; };
Texture2DArray<float> MAPS : register(t0);
SamplerComparisonState SAMPLER : register(s0);
#include "csm_sample.hlsl"
float main(float4 p : SV_Position) : SV_Target { return csm_visibility(p.xyz, p.xyz, csm_view_depth(p.xyz)); }
"""
glsl = """#version 450
#extension GL_GOOGLE_include_directive : require
#include "csm_constants.h"
layout(set = 0, binding = 0) uniform shadows { vec4 CONSTANTS[CSM_C_COUNT]; };
#ifdef CSM_SAMPLER
layout(set = 0, binding = 1) uniform texture2DArray MAPS;
layout(set = 0, binding = 2) uniform samplerShadow CSM_SAMPLER;
#else
layout(set = 0, binding = 1) uniform sampler2DArrayShadow MAPS;
#endif
#include "csm_sample.glsl"
layout(location = 0) out float lit;
void main() { vec3 p = gl_FragCoord.xyz; lit = csm_visibility(p, p, csm_view_depth(p)); }
"""
compute = """#version 450
#extension GL_GOOGLE_include_directive : require
#include "csm_constants.h"
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform shadows { vec4 suns[2][CSM_C_COUNT]; };
layout(set = 0, binding = 1) uniform sampler2DArrayShadow maps[2];
layout(set = 0, binding = 2, r32f) uniform image2D lit;
int sun; // two suns by one include: what the macros name may depend on a variable
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
named = {"CSM_CONSTANTS": "c", "CSM_MAPS": "maps", "CONSTANTS": "c", "MAPS": "maps"}
usual = {"CONSTANTS": "csm_c", "MAPS": "csm_maps"}
cases = {}
for taps in ({}, {"CSM_FILTER_TAPS": "1"}, {"CSM_FILTER_TAPS": "3"}):
    label = f"taps {taps.get('CSM_FILTER_TAPS', 'as configured')}"
    cases[f"HLSL, {label}"] = (hlsl, "frag", {**usual, **taps, "SAMPLER": "csm_compare"})
    cases[f"HLSL, own names, {label}"] = (hlsl, "frag", {**named, **taps, "CSM_SAMPLER": "compare", "SAMPLER": "compare"})
    cases[f"GLSL, {label}"] = (glsl, "frag", {**usual, **taps})
    cases[f"GLSL, own names, sampler apart, {label}"] = (glsl, "frag", {**named, **taps, "CSM_SAMPLER": "compare"})
for mode in ("0", "1"):
    fixed = {**usual, "CSM_BIAS_MODE": mode, "CSM_FILTER_TAPS": "3"}
    cases[f"HLSL, bias mode {mode}"] = (hlsl, "frag", {**fixed, "SAMPLER": "csm_compare"})
    cases[f"GLSL, bias mode {mode}"] = (glsl, "frag", fixed)
cases["GLSL, two suns in a compute shader"] = (compute, "comp", {})


def run(*command):
    done = subprocess.run([str(part) for part in command], text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if done.returncode:
        raise RuntimeError(done.stdout)
    return done.stdout


def compile_case(folder, source, stage, defines):
    path, output = folder / "shader", folder / "shader.spv"
    path.write_text(source)
    language = ["--hlsl-iomap", "--shift-texture-binding", "16", "--shift-sampler-binding", "48", "-D", "-e", "main"] if (
        source is hlsl) else []
    run(glslang, "-V", *language, "-S", stage, "--target-env", "vulkan1.1", f"-I{include}",
        *(f"-D{name}={value}" for name, value in defines.items()), "-o", output, path)
    run(spirv_val, "--target-env", "vulkan1.1", output)
    return run(spirv_dis, "--raw-id", output)


def check_layout(text):
    """The block begins at 0, and is CSM_C_COUNT float4 that lie 16 bytes apart."""
    length = re.search(rf"(%\d+) = OpConstant %\d+ {count}\n", text)[1]
    array = re.search(rf"(%\d+) = OpTypeArray %\d+ {length}\n", text)[1]
    block = re.search(rf"(%\d+) = OpTypeStruct {array}\n", text)[1]
    assert f"OpDecorate {array} ArrayStride 16\n" in text, "another stride"
    assert f"OpMemberDecorate {block} 0 Offset 0\n" in text, "another offset"


def comparisons(is_hlsl, defines):
    """How many bilinear comparisons and fetches the code should have: a fixed filter or bias leaves the others out."""
    slope = 0 if defines.get("CSM_BIAS_MODE") == "1" else 1 if "CSM_FILTER_TAPS" in defines else 2
    plane = 0 if defines.get("CSM_BIAS_MODE") == "0" else 1
    if is_hlsl:  # glslang puts a function of HLSL where it is called
        return slope, plane if "CSM_FILTER_TAPS" in defines else 2 * plane
    return slope + plane, 0


failed = 0
with tempfile.TemporaryDirectory() as scratch:
    for name, (source, stage, defines) in cases.items():
        try:
            text = compile_case(pathlib.Path(scratch), source, stage, defines)
            if stage == "frag":
                check_layout(text)
                found = len(re.findall("OpImageSampleDref", text)), len(re.findall("OpImageFetch", text))
                assert found == comparisons(source is hlsl, defines), f"{found} comparisons and fetches"
        except (RuntimeError, AssertionError) as error:
            failed += 1
            print(f"{name}: {error}")
    try:
        compile_case(pathlib.Path(scratch), hlsl, "frag", {**usual, "SAMPLER": "csm_compare", "CSM_FILTER_TAPS": "2"})
        failed += 1
        print("a filter that is not there goes unseen")
    except RuntimeError as error:
        if "CSM_FILTER_TAPS is 1 or 3" not in str(error):
            raise
print(f"{len(cases)} ways to include, {failed} failures")
sys.exit(1 if failed else 0)
