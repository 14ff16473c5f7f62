#!/usr/bin/env python3
"""
layers.py SOURCE_ROOT: every #include of the project points down, or sideways within its own layer.

The breaches are printed as FILE:LINE. Then the check is checked: breaches that are planted in a copy must all be found.
"""
import pathlib
import re
import shutil
import sys
import tempfile

PUBLIC, SHADER_INCLUDES, GPU = "api/include", "shaders/include", "backends"

# A layer is a folder, and has all that is below it but for the layers named here themselves. What each one may see
# besides itself:
MAY_SEE = {
    PUBLIC: (),
    "api/plan": (PUBLIC, SHADER_INCLUDES),
    "api/device": (PUBLIC, GPU, "shaders"),  # for bindings of alpha masks
    "api/scene": (PUBLIC, GPU, "api/plan", "api/device"),
    "api/techniques": (PUBLIC, GPU, SHADER_INCLUDES, "shaders", "api/plan", "api/device", "api/scene"),
    "api/abi": (PUBLIC, GPU, SHADER_INCLUDES, "api/plan", "api/device", "api/scene", "api/techniques"),
    GPU: (PUBLIC,),
    "backends/vulkan": (PUBLIC, GPU),
    "backends/d3d12": (PUBLIC, GPU),
    "backends/null": (PUBLIC, GPU),
    SHADER_INCLUDES: (),
    "shaders": (SHADER_INCLUDES,),
    "examples": (PUBLIC, SHADER_INCLUDES),
}
# csm-host's own, from the lowest up: each may see those before it.
HOST = ("base", "native", "scene", "truth", "picture", "setup", "stage", "metrics", "measure", "hard", "report", "bench", "view", "app")
MAY_SEE |= {f"host/{name}": (PUBLIC, *(f"host/{lower}" for lower in HOST[:i])) for i, name in enumerate(HOST)}
MAY_SEE["host/report"] += ("api/plan",)
MAY_SEE["host/hard"] += (SHADER_INCLUDES,)  # it reads the constants that an engine's shaders would
MAY_SEE["host/bench"] += ("api/plan", SHADER_INCLUDES, "shaders")  # it draws a plan without csm
# What of a layer the others may see, where that is not all of it: its own doors.
ONLY = {
    ("backends", PUBLIC): {"csm_base.h"},
    ("backends/vulkan", PUBLIC): {"csm_base.h", "csm_vulkan.h"},
    ("backends/d3d12", PUBLIC): {"csm_base.h", "csm_d3d12.h"},
    ("backends/null", PUBLIC): {"csm_base.h", "csm_vulkan.h", "csm_d3d12.h"},
    **{(f"api/{layer}", GPU): {"gpu.h", "gpu_calls.h", "structs.h"} for layer in ("device", "scene", "techniques", "abi")},
    **{(f"backends/{name}", GPU): {"gpu.h", "choose.h", "lent.h", "physical.h", "structs.h"} for name in ("vulkan", "d3d12")},
    ("backends/null", GPU): {"gpu.h"},
}
# Headers from outside: the API knows no GPU's, but where it hands one over, and the plan does no input and output.
GPU_HEADERS = re.compile(r"vulkan/|vkd3d|d3d12|dxgi|windows\.h|SDL")
PURE_HEADERS = re.compile(r"(float|limits|math|stdbool|stddef|stdint|string)\.h")
HANDED_OVER = {("api/include/csm/csm_vulkan.h", "vulkan/vulkan_core.h"), ("api/include/csm/csm_loader.h", "windows.h")}

FOLDERS = ("api", "backends", "shaders", "host", "examples")
SEARCHED = (PUBLIC, SHADER_INCLUDES, "api", "backends", "shaders", "host", "api/plan", "examples/shaders")
# Made by the build, so not to be found in the sources.
GENERATED = {"shader_code.h": "shaders"}
SUFFIXES = {".c", ".h", ".cpp", ".hlsl", ".glsl", ".inc", ".vert", ".frag", ".comp"}
INCLUDE = re.compile(r'\s*#\s*include\s*([<"])([^>"]+)[>"]')


def layer_of(path):
    """The innermost layer that holds a path."""
    inside = [layer for layer in MAY_SEE if path.startswith(f"{layer}/")]
    return max(inside, key=len, default=None)


def resolve(root, source, name):
    """
    The project's file that an include means, from the project's root, or None for one from outside. Names that two
    folders have mean the one of the same part of the project, as for the compiler.
    """
    own = source.relative_to(root).parts[0]
    for folder in (source.parent, *(root / folder for folder in (own, *SEARCHED))):
        found = (folder / name).resolve()
        if found.is_file() and found.is_relative_to(root):
            return found.relative_to(root).as_posix()
    return None


def breach_outside(path, layer, name):
    if layer.startswith("api/") and GPU_HEADERS.search(name) and (path, name) not in HANDED_OVER:
        return f"{layer} may not see a GPU's headers: {name}"
    if layer == "api/plan" and not PURE_HEADERS.fullmatch(name):
        return f"{layer} is pure, and may not see {name}"
    return None


def breach_inside(layer, target):
    seen = GENERATED.get(target) or layer_of(target)
    if seen == layer:
        return None
    if seen not in MAY_SEE[layer]:
        return f"{layer} may not see {seen}: {target}"
    doors = ONLY.get((layer, seen))
    return f"{layer} may not see this of {seen}: {target}" if doors and pathlib.Path(target).name not in doors else None


def breaches(root):
    """(path, line, what) of every include that points up."""
    found, count = [], 0
    files = [p for folder in FOLDERS for p in sorted((root / folder).rglob("*")) if p.suffix in SUFFIXES]
    for source in files:
        path = source.relative_to(root).as_posix()
        layer = layer_of(path)
        if not layer:
            found.append((path, 1, "it lies in no layer"))
            continue
        for number, line in enumerate(source.read_text().splitlines(), 1):
            match = INCLUDE.match(line)
            if not match:
                continue
            count += 1
            name = match[2]
            target = name if name in GENERATED else resolve(root, source, name)
            what = breach_inside(layer, target) if target else breach_outside(path, layer, name)
            if what:
                found.append((path, number, what))
    assert len(files) > 150 and count > 400, f"only {count} includes of {len(files)} files were seen"
    return found


# ---- the check of the check ----

PLANTED = [  # a folder, what is included there, and a word of what must be said
    ("api/plan", '"gpu.h"', "backends/gpu.h"),
    ("api/plan", '"device/device.h"', "api/device"),
    ("api/plan", "<stdio.h>", "pure"),
    ("api/device", '"plan/plan.h"', "api/plan"),
    ("api/device", '"../scene/handles.h"', "api/scene"),
    ("api/scene", '"shader_code.h"', "shaders"),
    ("api/scene", '"abi/context.h"', "api/abi"),
    ("api/scene", '"vulkan/internal.h"', "backends/vulkan"),
    ("api/techniques", '"abi/context.h"', "api/abi"),
    ("api/techniques/mask", '"../../abi/context.h"', "api/abi"),
    ("api/abi", "<vulkan/vulkan.h>", "a GPU's headers"),
    ("api/abi", '"choose.h"', "this of backends"),
    ("api/include/csm", '"../../plan/plan.h"', "api/plan"),
    ("backends/vulkan", '"csm/csm.h"', "csm.h"),
    ("backends/vulkan", '"csm/csm_d3d12.h"', "csm_d3d12.h"),
    ("backends/d3d12", '"../vulkan/internal.h"', "backends/vulkan"),
    ("backends/d3d12", '"gpu_calls.h"', "gpu_calls.h"),
    ("backends/null", '"device/device.h"', "api/device"),
    ("shaders/include", '"../private/mask.hlsl"', "shaders/private"),
    ("host/stage", '"plan/plan.h"', "api/plan"),
    ("host/bench", '"abi/context.h"', "api/abi"),
    ("host/truth", '"gpu.h"', "backends"),
    ("host/scene", '"stage/stage.h"', "host/stage"),
    ("host/measure", '"hard/hard.h"', "host/hard"),
    ("examples", '"plan/plan.h"', "api/plan"),
    ("examples", '"../host/base/host.h"', "host/base/host.h"),
]


def stub(root, name):
    """What a planted include names has to be there to be found."""
    (root / name).parent.mkdir(parents=True, exist_ok=True)
    (root / name).touch()


def check_the_check(source_root, root):
    for folder in FOLDERS:
        shutil.copytree(source_root / folder, root / folder,
                        ignore=lambda _, names: [n for n in names if "." in n and pathlib.Path(n).suffix not in SUFFIXES])
    for name in ("api/abi/context.h", "api/device/device.h", "api/scene/handles.h", "backends/choose.h",
                 "backends/gpu_calls.h", "backends/vulkan/internal.h", "host/base/host.h"):
        stub(root, name)
    before = set(breaches(root))
    for number, (folder, include, word) in enumerate(PLANTED):
        planted = root / folder / f"planted_{number}.h"
        planted.parent.mkdir(parents=True, exist_ok=True)
        planted.write_text(f"/* The second line is the breach. */\n#include {include}\n")
    for name in ("shaders/stray.txt", "api/stray.c"):
        stub(root, name)
    found = set(breaches(root)) - before
    for number, (folder, include, word) in enumerate(PLANTED):
        mine = [entry for entry in found if entry[0] == f"{folder}/planted_{number}.h"]
        assert len(mine) == 1 and mine[0][1] == 2 and word in mine[0][2], (folder, include, mine)
    strays = {entry[0] for entry in found} - {f"{folder}/planted_{i}.h" for i, (folder, *_) in enumerate(PLANTED)}
    assert strays == {"api/stray.c"}, strays


root = pathlib.Path(sys.argv[1]).resolve()
real = breaches(root)
for path, line, what in real:
    print(f"{path}:{line}: {what}")
with tempfile.TemporaryDirectory() as folder:
    check_the_check(root, pathlib.Path(folder).resolve())
print(f"{len(real)} includes point up; {len(PLANTED)} planted ones were found")
sys.exit(1 if real else 0)
