#!/usr/bin/env python3
"""Compiles the shaders: one HLSL source each, SPIR-V for Vulkan and DXBC for Direct3D 12.

  compile.py embed OUT_C OUT_H GLSLANG SPIRV_VAL SHADER...   build: SPIR-V made now, DXBC as committed, both as C
  compile.py words OUT_H FILE.dxbc...                        C arrays of DXBC alone, for a program without gpu.h
  compile.py spirv OUT_H GLSLANG SPIRV_VAL SHADER...         C arrays of SPIR-V alone, for who draws with Vulkan alone
  compile.py dxbc VKD3D_COMPILER FOLDER...                   makes FOLDER/dxbc and its MANIFEST anew, for ./dev shaders
  compile.py check FOLDER...                                 fails where HLSL, dxbc/ and MANIFEST do not belong together

A shader is NAME.STAGE.hlsl, STAGE being vs, ps or cs, with `main` as its entry. Includes are pasted in here, looked up
beside the including file, in the shader's folder, in its include/ and in the one beside this script, so that both
compilers get the same text, whatever their own rules.
MANIFEST has a line for each shader: its name, the SHA-256 of that text, and the SHA-256 of its DXBC.
"""
import hashlib
import os
import pathlib
import re
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
STAGES = {"vs": ("vert", "vs_5_0"), "ps": ("frag", "ps_5_0"), "cs": ("comp", "cs_5_0")}
SPIRV_OPTIONS = (
    "-D -V -e main --quiet --target-env vulkan1.1 --hlsl-iomap --shift-cbuffer-binding 0 --shift-texture-binding 16 "
    "--shift-uav-binding 32 --shift-sampler-binding 48").split()
INCLUDE = re.compile(r'\s*#\s*include\s*"([^"]+)"')


def flatten(path, root, marked=False, open_files=()):
    """The text of a shader with its includes pasted in; `marked` with #line, which vkd3d's compiler does not take."""
    if path in open_files:
        sys.exit(f"{path}: includes itself")
    mark = (lambda number: [f'#line {number} "{os.path.relpath(path, root)}"']) if marked else (lambda number: [])
    lines = mark(1)
    for number, line in enumerate(path.read_text().splitlines(), 1):
        include = INCLUDE.match(line)
        if not include:
            lines.append(line)
            continue
        found = next((f / include[1] for f in (path.parent, root, root / "include", HERE / "include") if (f / include[1]).is_file()), None)
        if not found:
            sys.exit(f"{path}:{number}: there is no {include[1]}")
        lines.append(flatten(found.resolve(), root, marked, open_files + (path,)))
        lines += mark(number + 1)
    return "\n".join(lines) + "\n"


def shaders(root):
    """Name ("mask_3x3.ps") and path of every shader in a folder."""
    paths = sorted(p for p in root.glob("*.hlsl"))
    for path in paths:
        if path.suffixes[0][1:] not in STAGES or len(path.suffixes) != 2:
            sys.exit(f"{path}: a shader's name ends in .vs.hlsl, .ps.hlsl or .cs.hlsl")
    return {path.name.removesuffix(".hlsl"): path for path in paths}


def digest(data):
    return hashlib.sha256(data).hexdigest()


def run(*command):
    done = subprocess.run([str(part) for part in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode:
        sys.exit(f"{done.stdout}\nfailed: {' '.join(str(part) for part in command)}")


def make_spirv(glslang, spirv_val, name, path, folder):
    source, output = folder / f"{name}.hlsl", folder / f"{name}.spv"
    source.write_text(flatten(path, path.parent, marked=True))
    run(glslang, *SPIRV_OPTIONS, "-S", STAGES[name.split(".")[1]][0], "-o", output, source)
    run(spirv_val, "--target-env", "vulkan1.1", output)
    return output.read_bytes()


def words(name, code):
    """A C array of a shader's code: both forms are made of little-endian words of 32 bits."""
    if not code or len(code) % 4:
        sys.exit(f"{name}: {len(code)} bytes of code are not whole words")
    values = [f"0x{int.from_bytes(code[i:i + 4], 'little'):08x}" for i in range(0, len(code), 4)]
    rows = [", ".join(values[i:i + 10]) for i in range(0, len(values), 10)]
    return f"static const uint32_t {name}[] = {{\n    " + ",\n    ".join(rows) + "};\n"


def embed(out_c, out_h, glslang, spirv_val, *paths):
    header_name = pathlib.Path(out_h).name
    guard = header_name.upper().replace(".", "_")
    header = ["/* Made by shaders/compile.py. */", f"#ifndef {guard}", f"#define {guard}", "", '#include "gpu.h"', ""]
    source = ["/* Made by shaders/compile.py. */", f'#include "{header_name}"', ""]
    with tempfile.TemporaryDirectory() as folder:
        for path in (pathlib.Path(p).resolve() for p in paths):
            name = path.name.removesuffix(".hlsl")
            blob = path.parent / "dxbc" / f"{name}.dxbc"
            if not blob.is_file():
                sys.exit(f"{blob} is missing: run ./dev shaders")
            c_name = "shader_" + name.replace(".", "_")
            code = {"spirv": make_spirv(glslang, spirv_val, name, path, pathlib.Path(folder)), "dxbc": blob.read_bytes()}
            header.append(f"extern const gpu_code {c_name};")
            source += [words(f"{c_name}_{kind}", data) for kind, data in code.items()]
            fields = ", ".join(f".{kind} = {c_name}_{kind}, .{kind}_size = sizeof {c_name}_{kind}" for kind in code)
            source.append(f"const gpu_code {c_name} = {{{fields}}};\n")
    pathlib.Path(out_h).write_text("\n".join(header + ["", "#endif", ""]))
    pathlib.Path(out_c).write_text("\n".join(source))


def make_dxbc(compiler, root):
    folder = root / "dxbc"
    folder.mkdir(exist_ok=True)
    manifest = []
    with tempfile.TemporaryDirectory() as scratch:
        for name, path in shaders(root).items():
            text = flatten(path, root)
            source = pathlib.Path(scratch) / f"{name}.hlsl"
            source.write_text(text)
            blob = folder / f"{name}.dxbc"
            run(compiler, "-x", "hlsl", "-b", "dxbc-tpf", "-p", STAGES[name.split(".")[1]][1], "-e", "main", "-o", blob,
                source)
            manifest.append(f"{name} {digest(text.encode())} {digest(blob.read_bytes())}\n")
            print(f"{root.name}/dxbc/{blob.name}: {blob.stat().st_size} bytes")
    for blob in folder.glob("*.dxbc"):
        if blob.stem not in shaders(root):
            blob.unlink()
    (folder / "MANIFEST").write_text("".join(manifest))


def words_header(out_h, *paths):
    blobs = [pathlib.Path(path) for path in paths]
    arrays = [words(blob.stem.replace(".", "_"), blob.read_bytes()) for blob in blobs]
    pathlib.Path(out_h).write_text("\n".join(["/* Made by shaders/compile.py. */", "#include <stdint.h>", "", *arrays]))


def spirv_header(out_h, glslang, spirv_val, *paths):
    arrays = []
    with tempfile.TemporaryDirectory() as folder:
        for path in (pathlib.Path(p).resolve() for p in paths):
            name = path.name.removesuffix(".hlsl")
            code = make_spirv(glslang, spirv_val, name, path, pathlib.Path(folder))
            arrays.append(words(name.replace(".", "_"), code))
    pathlib.Path(out_h).write_text("\n".join(["/* Made by shaders/compile.py. */", "#include <stdint.h>", "", *arrays]))


def dxbc(compiler, *folders):
    for folder in folders:
        make_dxbc(compiler, pathlib.Path(folder).resolve())


def drift(root):
    """What has drifted apart in a folder, a line each, and how many shaders it has."""
    recorded = {}
    for line in (root / "dxbc/MANIFEST").read_text().splitlines():
        name, source_hash, blob_hash = line.split()
        recorded[name] = (source_hash, blob_hash)
    present = shaders(root)
    wrong = [f"{name}: in dxbc/MANIFEST, but there is no {name}.hlsl" for name in recorded.keys() - present.keys()]
    for name, path in present.items():
        blob = root / "dxbc" / f"{name}.dxbc"
        if name not in recorded or not blob.is_file():
            wrong.append(f"{name}: has no DXBC")
        elif digest(flatten(path, root).encode()) != recorded[name][0]:
            wrong.append(f"{name}: the HLSL has changed since its DXBC was made")
        elif digest(blob.read_bytes()) != recorded[name][1]:
            wrong.append(f"{name}: the DXBC is not the one in MANIFEST")
    return wrong, len(present)


def check(*folders):
    """Says what has drifted apart, and how to mend it."""
    total = 0
    for folder in folders:
        wrong, count = drift(pathlib.Path(folder).resolve())
        if wrong:
            sys.exit("\n".join(sorted(wrong)) + f"\nRun ./dev shaders and commit {folder}/dxbc.")
        total += count
    print(f"{total} shaders: HLSL, DXBC and MANIFEST belong together")


if __name__ == "__main__":
    commands = {"embed": embed, "words": words_header, "spirv": spirv_header, "dxbc": dxbc, "check": check}
    if len(sys.argv) < 2 or sys.argv[1] not in commands:
        sys.exit(__doc__)
    commands[sys.argv[1]](*sys.argv[2:])
