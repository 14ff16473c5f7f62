#!/usr/bin/env python3
"""prefix.py INCLUDE_FOLDER: csm_prefix.inc names every function and struct of the shader includes, and csm_forget.inc
forgets these and every macro, so that they may be included twice with two prefixes.
"""
import pathlib
import re
import sys

folder = pathlib.Path(sys.argv[1])
TEXTS = ["csm_sample.inc", "csm_moments.inc", "csm_soft.inc", "csm_rays.inc"]
LANGUAGES = ["csm_sample.hlsl", "csm_sample.glsl"]
TYPES = {"csm_float2", "csm_float3", "csm_float4", "csm_uint4", "csm_mad"}  # of a language


def names_of(text):
    functions = re.findall(r"^(?:float|int|uint|bool|csm_\w+) (csm_\w+)\(", text, re.M)
    structs = re.findall(r"^struct (csm_\w+)", text, re.M)
    tables = re.findall(r"^CSM_(?:STATIC|GLOBAL) \w+ (csm_\w+)", text, re.M)
    made = re.findall(r"^CSM_(?:BOX|EARLY)\((csm_\w+)", text, re.M)
    return {*functions, *structs, *tables, *made}


def say(what, names):
    if names:
        print(f"{what}: {' '.join(sorted(names))}")
    return bool(names)


names = set().union(*(names_of((folder / file).read_text()) for file in TEXTS))
macros = set().union(*(re.findall(r"^#define (CSM_\w+)", (folder / file).read_text(), re.M) for file in TEXTS + LANGUAGES))
prefixed = set(re.findall(r"^#define (csm_\w+) CSM_NAMED", (folder / "csm_prefix.inc").read_text(), re.M))
forgotten = set(re.findall(r"^#undef (\w+)", (folder / "csm_forget.inc").read_text(), re.M))
assert "csm_visibility" in names and "CSM_FILTER_IS" in macros

wrong = [
    say("without a prefix", names - prefixed),
    say("with a prefix, and not there", prefixed - names),
    say("not forgotten", (names | TYPES | macros) - forgotten),
    say("forgotten, and not there", {name for name in forgotten if name.startswith("csm_")} - names - TYPES),
]
sys.exit(any(wrong))
