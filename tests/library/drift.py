#!/usr/bin/env python3
"""drift.py COMPILE FOLDER...: HLSL and DXBC belong together, and the check that says so sees every kind of drift.

COMPILE is shaders/compile.py. The kinds are tried in a copy of the first folder, without the sources that have many
variants.
"""
import pathlib
import shutil
import subprocess
import sys
import tempfile

compiler, shaders, *others = map(pathlib.Path, sys.argv[1:])
sys.path.insert(0, str(compiler.parent))
sys.dont_write_bytecode = True
import compile as compiling  # noqa: E402


def check(*folders):
    done = subprocess.run([sys.executable, compiler, "check", *folders], stderr=subprocess.STDOUT, stdout=subprocess.PIPE,
                          text=True)
    return done.returncode, done.stdout


def append(path, text):
    path.write_text(path.read_text() + text)


status, output = check(shaders, *others)
print(output, end="")
if status:
    sys.exit(1)



def copy_small(folder):
    """A copy of the first folder, of which programs are kept whose source has a few variants."""
    shutil.copytree(shaders, folder)
    counts = {}
    for program in compiling.shaders(shaders).values():
        counts[program.path.name] = counts.get(program.path.name, 0) + 1
    head, *blocks = (folder / "variants.toml").read_text().split("[[source]]")
    kept = [block for block in blocks if counts[block.split('"')[1]] <= MOST_VARIANTS]
    (folder / "variants.toml").write_text("[[source]]".join([head, *kept]))
    for name in counts.keys() - {block.split('"')[1] for block in kept}:
        (folder / name).unlink()
    names, blobs = compiling.shaders(folder), compiling.read_dxbc(folder)
    lines = (folder / "dxbc/MANIFEST").read_text().splitlines(True)
    (folder / "dxbc/MANIFEST").write_text("".join(line for line in lines if line.split()[0] in names))
    (folder / "dxbc/archive").write_bytes(b"".join(blob for name, blob in blobs.items() if name in names))


MOST_VARIANTS = 4
first = sorted(shaders.glob("*.hlsl"))[0]
name = first.name.removesuffix(".hlsl")
included = next(p for p in sorted(shaders.glob("*.hlsl")) if "csm_constants.h" in p.read_text()).name.removesuffix(".hlsl")


def change_blob(folder):
    archive = folder / "dxbc/archive"
    content = bytearray(archive.read_bytes())
    content[-1] ^= 1  # of the last program
    archive.write_bytes(content)


def lose_blob(folder):
    archive = folder / "dxbc/archive"
    archive.write_bytes(archive.read_bytes()[:-4])


def lose_row(folder):
    table = folder / "variants.toml"
    table.write_text(table.read_text().replace(f'file = "{first.name}"', f'file = "{included}.hlsl"', 1))


def change_axis(folder):
    table = folder / "variants.toml"
    table.write_text(table.read_text().replace('"pcss"', '"new_filter"'))


with tempfile.TemporaryDirectory() as scratch:
    copy_small(pathlib.Path(scratch) / "shaders")
    status, output = check(pathlib.Path(scratch) / "shaders")
    if status:
        sys.exit(f"the copy has drifted: {output}")
    last = (pathlib.Path(scratch) / "shaders/dxbc/MANIFEST").read_text().split("\n")[-2].split()[0]
drifts = {
    "a changed shader": (name, lambda f: append(f / first.name, "static const float changed = 1.0;\n")),
    "a changed include": (included, lambda f: append(f / "include/csm_constants.h", "static const float changed = 1.0;\n")),
    "another blob": (last, change_blob),
    "a lost blob": (last, lose_blob),
    "a new shader": ("new.vs.hlsl", lambda f: shutil.copy(first, f / "new.vs.hlsl")),
    "a shader without a row": (first.name, lose_row),
    "a new value of an axis": ("mask_penumbra_new_filter", change_axis),
}
for what, (name, drift) in drifts.items():
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch) / "shaders"
        copy_small(folder)
        drift(folder)
        status, output = check(folder)
        if not status or name not in output or "./dev shaders" not in output:
            sys.exit(f"{what} goes unseen: {output}")
print(f"{len(drifts)} kinds of drift are seen")
