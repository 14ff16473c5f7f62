#!/usr/bin/env python3
"""Compiles the shaders: one HLSL source each, SPIR-V for Vulkan and DXBC for Direct3D 12.

  compile.py embed OUT_C OUT_H GLSLANG SPIRV_VAL SHADER...   build: SPIR-V made now, DXBC as committed, both as C
  compile.py words OUT_H FILE.dxbc...                        C arrays of DXBC alone, for a program without gpu.h
  compile.py spirv OUT_H GLSLANG SPIRV_VAL SHADER...         C arrays of SPIR-V alone, for who draws with Vulkan alone
  compile.py dxbc VKD3D_COMPILER FOLDER...                   makes each folder's DXBC and its MANIFEST anew, for ./dev shaders
  compile.py check FOLDER...                                 fails where HLSL, DXBC and MANIFEST do not belong together

A shader is NAME.STAGE.hlsl, STAGE being vs, ps or cs, with `main` as its entry. Includes are pasted in here, looked up
beside the including file, in the shader's folder, in its include/, in this folder and its include/, so that both
compilers get the same text, whatever their own rules.

A folder with a variants.toml, which says what it means, makes many programs of a source. Their DXBC lies in one file,
dxbc/archive, in the order of dxbc/MANIFEST; a folder without one has a file each. MANIFEST has a line for each program: its
name, the SHA-256 of what its text comes to by its defines, the SHA-256 of its DXBC, and in an archive its bytes.
"""
import concurrent.futures
import hashlib
import itertools
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import tomllib
from dataclasses import dataclass, field

HERE = pathlib.Path(__file__).resolve().parent
STAGES = {"vs": ("vert", "vs_5_0"), "ps": ("frag", "ps_5_0"), "cs": ("comp", "cs_5_0")}
SPIRV_OPTIONS = (
    "-D -V -g0 -e main --quiet --target-env vulkan1.1 --hlsl-iomap --shift-cbuffer-binding 0 --shift-texture-binding 16 "
    "--shift-uav-binding 32 --shift-sampler-binding 48").split()
MISREAD = re.compile(r"^\s*mov (r\d+)\.yzw, (?!\1\b)r\d+\.xyzw$", re.MULTILINE)
UNCAST = re.compile(r"^\s*(?:add|mul|mad|div|min|max|lt|ge|eq|ne|ftoi|ftou) .*\bvThread\w*.*$", re.MULTILINE)
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
        found = next((f / include[1] for f in (path.parent, root, root / "include", HERE, HERE / "include") if (f / include[1]).is_file()), None)
        if not found:
            sys.exit(f"{path}:{number}: there is no {include[1]}")
        lines.append(flatten(found.resolve(), root, marked, open_files + (path,)))
        lines += mark(number + 1)
    return "\n".join(lines) + "\n"


@dataclass
class Program:
    """One program: a source with what is defined before it."""
    name: str  # "mask_pcf_3x3_plane.ps"
    path: pathlib.Path
    defines: dict = field(default_factory=dict)
    values: tuple = ()  # of each axis, where it has some

    @property
    def stage(self):
        return self.name.rsplit(".", 1)[1]

    @property
    def symbol(self):
        return "shader_" + self.name.replace(".", "_")

    def text(self, marked=False):
        before = "".join(f"#define {name} {value}\n" for name, value in self.defines.items())
        return before + flatten(self.path, self.path.parent, marked)

    def essence(self):
        """The hash of what a compiler gets to see: without comments, what #if leaves out, and spaces."""
        text = "#undef __STDC_VERSION__\n" + self.text()
        done = subprocess.run(["cpp", "-P", "-undef", "-w"], input=text, stdout=subprocess.PIPE, text=True, check=True)
        return digest("".join(done.stdout.split()).encode())


def stem(path):
    """"mask.ps" of mask.ps.hlsl."""
    if path.suffix != ".hlsl" or len(path.suffixes) != 2 or path.suffixes[0][1:] not in STAGES:
        sys.exit(f"{path}: a shader's name ends in .vs.hlsl, .ps.hlsl or .cs.hlsl")
    return path.name.removesuffix(".hlsl")


def table_of(root):
    file = root / "variants.toml"
    return tomllib.loads(file.read_text())["source"] if file.is_file() else []


def excepted(source, names):
    """Whether a rule names all of these: axis by axis, one of its values."""
    return any(all(names[axis] in values for axis, values in rule.items()) for rule in source.get("except", []))


def programs_of(path, source):
    """The programs that a source's row of the table asks for."""
    axes, (name, stage) = source.get("axes", []), stem(path).split(".")
    for values in itertools.product(*(range(len(axis["values"])) for axis in axes)):
        labels = [axis["values"][value] for axis, value in zip(axes, values)]
        if excepted(source, {axis.get("name", axis["define"]): label for axis, label in zip(axes, labels)}):
            continue
        defines = {axis["define"]: value + axis.get("first", 0) for axis, value in zip(axes, values)}
        yield Program("_".join(filter(None, [name, *labels])) + "." + stage, path, defines, values)


def shaders(root):
    """The programs of a folder by name."""
    rows = {row["file"]: row for row in table_of(root)}
    paths = [root / file for file in rows] or sorted(root.glob("*.hlsl"))
    return {program.name: program for path in paths for program in programs_of(path, rows.get(path.name, {}))}


def digest(data):
    return hashlib.sha256(data).hexdigest()


def run(*command):
    done = subprocess.run([str(part) for part in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode:
        sys.exit(f"{done.stdout}\nfailed: {' '.join(str(part) for part in command)}")


def make_spirv(glslang, spirv_val, program, folder, kept):
    """`kept`: a folder of what this compiler made before; or None."""
    about = f"{program.essence()} {program.stage} {SPIRV_OPTIONS} {os.stat(glslang).st_mtime_ns}"
    before = kept and kept / f"{digest(about.encode())}.spv"
    if before and before.is_file():
        return before.read_bytes()
    source, output = folder / f"{program.name}.hlsl", folder / f"{program.name}.spv"
    source.write_text(program.text(marked=True))
    run(glslang, *SPIRV_OPTIONS, "-S", STAGES[program.stage][0], "-o", output, source)
    run(spirv_val, "--target-env", "vulkan1.1", output)
    if before:
        before.with_suffix(".part").write_bytes(output.read_bytes())
        before.with_suffix(".part").rename(before)
    return output.read_bytes()


def make_all_spirv(glslang, spirv_val, programs, kept=None):
    if kept:
        kept.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        make = lambda program: make_spirv(glslang, spirv_val, program, pathlib.Path(folder), kept)
        return list(pool.map(make, programs))


def words(name, code):
    """A C array of a shader's code: both forms are made of little-endian words of 32 bits."""
    if not code or len(code) % 4:
        sys.exit(f"{name}: {len(code)} bytes of code are not whole words")
    values = [f"0x{int.from_bytes(code[i:i + 4], 'little'):08x}" for i in range(0, len(code), 4)]
    rows = [", ".join(values[i:i + 10]) for i in range(0, len(values), 10)]
    return f"static const uint32_t {name}[] = {{\n    " + ",\n    ".join(rows) + "};\n"


def key_of(source, index, values):
    """Five bits for each axis, above them the source."""
    key = index
    for value in values:
        key = key << 5 | value
    return key


def key_function(name, source, index):
    """What makes a key of the defines' values."""
    for axis in source["axes"]:
        assert len(axis["values"]) <= 32, f"{source['file']}: {axis['name']} has more values than five bits tell apart"
    parameters = ", ".join(f"int32_t {axis['name']}" for axis in source["axes"])
    lines = [f"static inline uint64_t shader_key_{name}({parameters}) {{", f"  uint64_t key = {index};"]
    lines += [f"  key = key << 5 | ((uint32_t)({axis['name']} - ({axis.get('first', 0)})) & 31u);" for axis in source["axes"]]
    return "\n".join([*lines, "  return key;", "}"])


FIND = """/* The program of a key, or NULL where the table of variants has none. */
const gpu_code *shader_find(uint64_t key) {
  size_t low = 0, high = sizeof variants / sizeof *variants;
  while (low < high) {
    const size_t middle = low + (high - low) / 2;
    if (variants[middle].key < key)
      low = middle + 1;
    else
      high = middle;
  }
  return low < sizeof variants / sizeof *variants && variants[low].key == key ? &variants[low].code : NULL;
}
"""


def code_of(program):
    kinds = ("spirv", "dxbc")
    fields = ", ".join(f".{kind} = {program.symbol}_{kind}, .{kind}_size = sizeof {program.symbol}_{kind}" for kind in kinds)
    return f"{{{fields}}}"


def keyed_parts(keyed):
    """Header and source of what finds a program by its key; `keyed` is (row of the table, its programs)."""
    header, rows = [], []
    for index, (source, programs) in enumerate(keyed, 1):
        header += [key_function(stem(pathlib.Path(source["file"])).split(".")[0], source, index), ""]
        rows += [(key_of(source, index, program.values), code_of(program)) for program in programs]
    header += ["/* NULL where the table of variants has none. */", "const gpu_code *shader_find(uint64_t key);"]
    table = ",\n".join(f"    {{{key}u, {code}}}" for key, code in sorted(rows))
    source = ["static const struct variant {", "  uint64_t key;", "  gpu_code code;", f"}} variants[] = {{\n{table}}};", "", FIND]
    return header, source


def embed(out_c, out_h, glslang, spirv_val, *paths):
    paths = [pathlib.Path(path).resolve() for path in paths]
    rows = {path.parent / row["file"]: row for path in paths for row in table_of(path.parent)}
    by_path = {path: list(programs_of(path, rows.get(path, {}))) for path in paths}
    programs = [program for made in by_path.values() for program in made]
    header_name = pathlib.Path(out_h).name
    guard = header_name.upper().replace(".", "_")
    header = ["/* Made by shaders/compile.py. */", f"#ifndef {guard}", f"#define {guard}", "", '#include "gpu.h"', ""]
    source = ["/* Made by shaders/compile.py. */", f'#include "{header_name}"', "", "#include <stddef.h>", ""]
    blobs = {root: read_dxbc(root) for root in {path.parent for path in paths}}
    for program, spirv in zip(programs, make_all_spirv(glslang, spirv_val, programs, pathlib.Path(out_c).parent / "spirv")):
        dxbc = blobs[program.path.parent].get(program.name)
        if not dxbc:
            sys.exit(f"{program.name} has no DXBC: run ./dev shaders")
        source += [words(f"{program.symbol}_spirv", spirv), words(f"{program.symbol}_dxbc", dxbc)]
        if not rows.get(program.path, {}).get("keyed"):
            header.append(f"extern const gpu_code {program.symbol};")
            source.append(f"const gpu_code {program.symbol} = {code_of(program)};\n")
    keyed = [(rows[path], made) for path, made in by_path.items() if rows.get(path, {}).get("keyed")]
    if keyed:
        more_header, more_source = keyed_parts(keyed)
        header += ["", *more_header]
        source += more_source
    pathlib.Path(out_h).write_text("\n".join(header + ["", "#endif", ""]))
    pathlib.Path(out_c).write_text("\n".join(source))


# ---- DXBC ----


def read_manifest(root):
    """Of each program: the hashes of its text and its DXBC, and its bytes in an archive."""
    lines = (line.split() for line in (root / "dxbc/MANIFEST").read_text().splitlines())
    return {name: (text, blob, int(*size)) for name, text, blob, *size in lines}


def read_dxbc(root):
    """The DXBC of a folder's programs by name."""
    archive, blobs, at = root / "dxbc/archive", {}, 0
    if not archive.is_file():
        return {blob.name.removesuffix(".dxbc"): blob.read_bytes() for blob in (root / "dxbc").glob("*.dxbc")}
    content = archive.read_bytes()
    for name, (_, _, size) in read_manifest(root).items():
        blobs[name] = content[at:at + size]
        at += size
    return blobs


def compile_dxbc(compiler, program, folder):
    source, output = folder / f"{program.name}.hlsl", folder / f"{program.name}.dxbc"
    source.write_text(program.text())
    run(compiler, "-x", "hlsl", "-b", "dxbc-tpf", "-p", STAGES[program.stage][1], "-e", "main", "-o", output, source)
    listing = folder / f"{program.name}.asm"
    run(compiler, "-x", "dxbc-tpf", "-b", "d3d-asm", "-o", listing, output)
    misread = MISREAD.search(listing.read_text())
    if misread:
        sys.exit(f"{program.name}: vkd3d 1.2 misreads '{misread[0].strip()}'; write the vector so that it begins at x")
    uncast = UNCAST.search(listing.read_text())
    if uncast:
        sys.exit(f"{program.name}: vkd3d's compiler has lost a cast in '{uncast[0].strip()}'; cast to int first")
    return output.read_bytes()


def essences(programs):
    """The hash of each program's text by its name."""
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        return dict(zip(programs, pool.map(Program.essence, programs.values())))


def still_true(root):
    """The DXBC, by name, of programs whose text has not changed since it was made."""
    if not (root / "dxbc/MANIFEST").is_file():
        return {}
    recorded, blobs = read_manifest(root), read_dxbc(root)
    return {name: blobs[name] for name, essence in essences(shaders(root)).items()
            if name in recorded and (essence, digest(blobs.get(name, b""))) == recorded[name][:2]}


def make_dxbc(compiler, root):
    folder = root / "dxbc"
    folder.mkdir(exist_ok=True)
    programs, made = shaders(root), still_true(root)
    with tempfile.TemporaryDirectory() as scratch, concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        make = lambda program: made.get(program.name) or compile_dxbc(compiler, program, pathlib.Path(scratch))
        blobs = list(pool.map(make, programs.values()))
    for old in (*folder.glob("*.dxbc"), *folder.glob("archive")):
        old.unlink()
    archived = bool(table_of(root))
    if archived:
        (folder / "archive").write_bytes(b"".join(blobs))
    else:
        for name, blob in zip(programs, blobs):
            (folder / f"{name}.dxbc").write_bytes(blob)
    lines = (f"{name} {essence} {digest(blob)}{f' {len(blob)}' if archived else ''}\n"
             for (name, essence), blob in zip(essences(programs).items(), blobs))
    (folder / "MANIFEST").write_text("".join(lines))
    print(f"{root.name}/dxbc: {len(blobs)} programs, {len(made)} of them as they were, {sum(map(len, blobs))} bytes")


def words_header(out_h, *paths):
    blobs = [pathlib.Path(path) for path in paths]
    arrays = [words(blob.stem.replace(".", "_"), blob.read_bytes()) for blob in blobs]
    pathlib.Path(out_h).write_text("\n".join(["/* Made by shaders/compile.py. */", "#include <stdint.h>", "", *arrays]))


def spirv_header(out_h, glslang, spirv_val, *paths):
    programs = []
    for path in (pathlib.Path(path).resolve() for path in paths):
        rows = {row["file"]: row for row in table_of(path.parent)}
        programs += programs_of(path, rows.get(path.name, {}))
    codes = make_all_spirv(glslang, spirv_val, programs)
    arrays = [words(program.name.replace(".", "_"), code) for program, code in zip(programs, codes)]
    pathlib.Path(out_h).write_text("\n".join(["/* Made by shaders/compile.py. */", "#include <stdint.h>", "", *arrays]))


def dxbc(compiler, *folders):
    for folder in folders:
        make_dxbc(compiler, pathlib.Path(folder).resolve())


def unlisted(root):
    """Sources that a folder's table of variants does not know."""
    rows = table_of(root)
    return {path.name for path in root.glob("*.hlsl")} - {row["file"] for row in rows} if rows else set()


def drift(root):
    """What has drifted apart in a folder, a line each, and how many programs it has."""
    recorded, blobs, present = read_manifest(root), read_dxbc(root), shaders(root)
    wrong = [f"{name}: in dxbc/MANIFEST, but there is no such program" for name in recorded.keys() - present.keys()]
    wrong += [f"{name}: is not in variants.toml" for name in unlisted(root)]
    for name, essence in essences(present).items():
        if name not in recorded or not blobs.get(name):
            wrong.append(f"{name}: has no DXBC")
        elif essence != recorded[name][0]:
            wrong.append(f"{name}: the HLSL has changed since its DXBC was made")
        elif digest(blobs[name]) != recorded[name][1]:
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
    print(f"{total} programs: HLSL, DXBC and MANIFEST belong together")


if __name__ == "__main__":
    commands = {"embed": embed, "words": words_header, "spirv": spirv_header, "dxbc": dxbc, "check": check}
    if len(sys.argv) < 2 or sys.argv[1] not in commands:
        sys.exit(__doc__)
    commands[sys.argv[1]](*sys.argv[2:])
