#!/usr/bin/env python3
"""
embedding.py CC GLSLANG SOURCE_ROOT LIBCSM BACKEND...: the programs and shaders of docs/embedding.md compile as they stand,
run on each backend, and print what the text says; the parts of programs compile too.

A block that begins with a comment "NAME: ..." is that file; other blocks of C are a part, compiled amid PRELUDE.
"""
import os
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile

cc, glslang, root, libcsm = shlex.split(sys.argv[1]), sys.argv[2], pathlib.Path(sys.argv[3]), pathlib.Path(sys.argv[4])
backends = sys.argv[5:]
text = (root / "docs/embedding.md").read_text()
blocks = re.findall(r"^```(\w+)\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)
FILE = re.compile(r"(?:/\*|//) ([\w.]+\.[a-z]+): ")
files = {FILE.match(body)[1]: body for _, body in blocks if FILE.match(body)}
parts = [body for language, body in blocks if language == "c" and not FILE.match(body)]

packages = {"own_device.c": [], "vulkan.c": ["vulkan"], "d3d12.c": ["libvkd3d-utils"]}
flags = ["-std=c11", "-Wall", "-Wextra", "-Werror", f"-I{root}/api/include", f"-I{root}/shaders/include"]
PRELUDE = """#include "csm/csm_loader.h"
#include "csm/csm_d3d12.h"
#include "csm/csm_vulkan.h"
#include <stdio.h>
#include <vulkan/vulkan.h>
void renderer_set_matrix(void *renderer, void *command_buffer, const double matrix[16]);
void check(csm_context *context, csm_result result);
void renderer_draw_skinned(void *renderer, void *command_buffer, const double planes[5][4]);
"""
ARGUMENTS = ("(csm_create_info create, csm_d3d12_device device, csm_context *context, csm_cascades *cascades, "
             "csm_frame frame, csm_mask_info left_mask, csm_mask_info right_mask, int tile_x, int tile_z, csm_view *view, "
             "csm_mask_info mask, csm_vulkan_image depth, csm_vulkan_image motion)")


def run(*command, **options):
    done = subprocess.run([str(part) for part in command], text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          **options)
    if done.returncode:
        sys.exit(f"{done.stdout}\nfailed, {done.returncode}: {' '.join(str(part) for part in command)}")
    return done.stdout


def package_flags(*names):
    return run("pkg-config", "--cflags", "--libs", *names).split() if names else []


def compile_part(body):
    """A function stands for itself; statements get one around them."""
    inside = body if body.startswith("static ") else f"void part{ARGUMENTS};\nvoid part{ARGUMENTS} {{\n{body}}}\n"
    run(*cc, *flags, "-Wno-unused-function", "-Wno-unused-parameter", "-fsyntax-only", "-x", "c", "-",
        input=PRELUDE + inside)


def compile_shaders(folder):
    run(glslang, "-V", "-x", "--target-env", "vulkan1.1", f"-I{root}/shaders/include", "-o", folder / "points.spv.h",
        folder / "points.comp")
    # Those of moments and of rays are compiled alone; what they give is held by tests/binding.
    for name in "moments", "exact":
        run(glslang, "-V", "--target-env", "vulkan1.1", f"-I{root}/shaders/include", "-o", folder / f"{name}.spv",
            folder / f"{name}.frag")
        run(glslang, "-V", "-D", "-e", "main", "-S", "frag", "--target-env", "vulkan1.1", f"-I{root}/shaders/include",
            "-o", folder / f"{name}_hlsl.spv", folder / f"{name}.ps.hlsl")
    run(glslang, "-V", "--target-env", "vulkan1.2", f"-I{root}/shaders/include", "-o", folder / "traced.spv",
        folder / "traced.frag")
    source = root / "tests/docs/points.cs.hlsl"
    if files["points.cs.hlsl"] != source.read_text():
        sys.exit("points.cs.hlsl of docs/embedding.md is not that of tests/docs: copy it there and run ./dev shaders")
    code = (root / "tests/docs/dxbc/points.cs.dxbc").read_bytes()
    (folder / "points.dxbc.h").write_text(", ".join(str(byte) for byte in code) + "\n")


def run_program(folder, name, source):
    (folder / name).write_text(source)
    program = folder / name.removesuffix(".c")
    run(*cc, *flags, folder / name, "-o", program, f"-L{libcsm.parent}", "-lcsm", *package_flags(*packages[name]))
    environment = dict(os.environ, LD_LIBRARY_PATH=f"{libcsm.parent}:{os.environ.get('LD_LIBRARY_PATH', '')}")
    output = run(program, env=environment, timeout=120)
    print(f"{name}: {output}", end="")
    return output


def said(*lines):
    """What a program must print, which the text must say as well."""
    for line in lines:
        assert f"`{line}`" in text, f"the text does not say {line}"
    return "".join(f"{line}\n" for line in lines)


for part in parts:
    compile_part(part)
assert len(parts) == 11 and set(packages) <= set(files), (len(parts), sorted(files))
with tempfile.TemporaryDirectory() as scratch:
    folder = pathlib.Path(scratch)
    for name, body in files.items():
        (folder / name).write_text(body)
    compile_shaders(folder)
    points = "towards the sun 1.00, behind the tower 0.00"
    shares = []
    for backend in backends:
        source = files["own_device.c"].replace('.backend = "vulkan"', f'.backend = "{backend}"')
        shares.append(run_program(folder, "own_device.c", source))
        assert re.fullmatch(r"[\d.]+ % in shadow\n", shares[-1]) and 0.1 < float(shares[-1].split()[0]) < 10, shares
    assert len(set(shares)) == 1, "the backends' masks differ"
    if "vulkan" in backends:
        assert run_program(folder, "vulkan.c", files["vulkan.c"]) == said(points)
    if "d3d12" in backends:
        assert run_program(folder, "d3d12.c", files["d3d12.c"]) == said(points, "0 references to the device are left")
print(f"{len(files)} files and {len(parts)} parts")
