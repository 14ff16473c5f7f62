#!/usr/bin/env python3
"""drift.py COMPILE FOLDER...: HLSL and DXBC belong together, and the check that says so sees every kind of drift.

COMPILE is shaders/compile.py. The kinds are tried in a copy of the first folder.
"""
import pathlib
import shutil
import subprocess
import sys
import tempfile

compiler, shaders, *others = map(pathlib.Path, sys.argv[1:])


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

first = sorted(shaders.glob("*.hlsl"))[0].name.removesuffix(".hlsl")
included = next(p for p in sorted(shaders.glob("*.hlsl")) if "#include" in p.read_text()).name.removesuffix(".hlsl")
drifts = {
    "a changed shader": (first, lambda f: append(f / f"{first}.hlsl", "// changed\n")),
    "a changed include": (included, lambda f: append(f / "include/csm_constants.h", "// changed\n")),
    "another blob": (first, lambda f: (f / f"dxbc/{first}.dxbc").write_bytes(b"DXBC")),
    "a lost blob": (first, lambda f: (f / f"dxbc/{first}.dxbc").unlink()),
    "a new shader": ("new.vs", lambda f: shutil.copy(f / f"{first}.hlsl", f / "new.vs.hlsl")),
    "a removed shader": (first, lambda f: (f / f"{first}.hlsl").unlink()),
}
for what, (name, drift) in drifts.items():
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch) / "shaders"
        shutil.copytree(shaders, folder)
        drift(folder)
        status, output = check(folder)
        if not status or f"{name}: " not in output or "./dev shaders" not in output:
            sys.exit(f"{what} goes unseen: {output}")
print(f"{len(drifts)} kinds of drift are seen")
