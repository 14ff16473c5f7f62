#!/usr/bin/env python3
"""install.py BUILD PREFIX CC: what is installed, and that a program finds it through csm.pc."""
import os
import pathlib
import shlex
import subprocess
import sys
import tempfile

build, prefix, cc = sys.argv[1], pathlib.PurePath(sys.argv[2]), shlex.split(sys.argv[3])
program = """#include <csm/csm.h>
int main(void) { return csm_version() == CSM_VERSION ? 0 : 1; }
"""
with tempfile.TemporaryDirectory() as folder:
    root = pathlib.Path(folder)
    subprocess.run(["meson", "install", "-C", build, "--no-rebuild", "--quiet", "--destdir", folder], check=True)
    installed = {str(p.relative_to(root / prefix.relative_to("/"))) for p in root.rglob("*") if not p.is_dir()}
    libraries = next(p for p in root.rglob("libcsm.so")).parent
    names = {p.name for p in libraries.iterdir() if p.is_file()}
    assert names == {"libcsm.so", "libcsm.so.1", "libcsm.so.1.0.0"}, names
    plugins = {p.name for p in (libraries / "csm").iterdir()}
    assert plugins and plugins <= {"libcsm-vulkan.so", "libcsm-d3d12.so"}, plugins
    for name in ("csm.h", "csm_base.h", "csm_vulkan.h", "csm_d3d12.h", "shaders/include/csm_constants.h",
                 "shaders/include/csm_sample.hlsl"):
        assert f"include/csm/{name}" in installed, f"{name} is not installed"
    for path in installed:
        assert path.startswith(("include/csm/", "lib")), f"{path} is none of csm's places"

    environment = dict(os.environ, PKG_CONFIG_LIBDIR=str(libraries / "pkgconfig"), PKG_CONFIG_SYSROOT_DIR=folder,
                       LD_LIBRARY_PATH=str(libraries))
    flags = subprocess.run(["pkg-config", "--cflags", "--libs", "csm"], env=environment, check=True, text=True,
                           stdout=subprocess.PIPE).stdout.split()
    subprocess.run([*cc, "-x", "c", "-", "-x", "none", *flags, "-o", root / "program"], input=program, text=True, check=True)
    subprocess.run([root / "program"], env=environment, check=True)
print(f"{len(installed)} files are in their places, and csm.pc leads to them")
