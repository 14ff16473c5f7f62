#!/usr/bin/env python3
"""
exports.py HEADERS LIBCSM BACKEND...: what the libraries export is what exports.txt lists, and what the headers in the
folder HEADERS declare; what they take from other libraries is no more than they should.
"""
import pathlib
import re
import subprocess
import sys

headers, libcsm, *backends = sys.argv[1:]
listed = {"libcsm": set(), "backend": set()}
for line in (pathlib.Path(__file__).parent / "exports.txt").read_text().splitlines():
    kind, name = line.split()
    listed[kind].add(name)
problems = []


def symbols(library, *options):
    """Name and kind of each symbol, without its version."""
    lines = subprocess.run(["nm", *options, library], check=True, stdout=subprocess.PIPE, text=True).stdout.splitlines()
    return {(line.split()[-1].split("@")[0], line.split()[-2]) for line in lines}


def compare(what, expected, found):
    problems.extend(f"{what}: {name} is missing" for name in sorted(expected - found))
    problems.extend(f"{what}: {name} is not in the list" for name in sorted(found - expected))


def exported(library):
    return {name for name, kind in symbols(library, "-D", "--defined-only") if kind != "A"}


def needed(library):
    text = subprocess.run(["objdump", "-p", library], check=True, stdout=subprocess.PIPE, text=True).stdout
    return {name for name in re.findall(r"NEEDED\s+(\S+)", text) if not re.match(r"lib(asan|ubsan|tsan)\.so", name)}


declared = "".join(header.read_text() for header in sorted(pathlib.Path(headers).glob("*.h")))
compare("csm.h", listed["libcsm"], set(re.findall(r"CSM_API [^;]*?CSM_CALL (csm_\w+)\(", declared)))
compare(libcsm, listed["libcsm"], exported(libcsm))
system = {"libc.so.6", "libm.so.6", "libdl.so.2", "libpthread.so.0", "ld-linux-x86-64.so.2", "ld-linux-aarch64.so.1"}
problems += [f"{libcsm}: links {name}" for name in sorted(needed(libcsm) - system)]
for backend in backends:
    compare(backend, listed["backend"], exported(backend))
    problems += [f"{backend}: {name} is a global name of the Vulkan loader's" for name, kind in symbols(backend)
                 if re.match("vk[A-Z]", name) and kind.isupper()]
    problems += [f"{backend}: links {name}" for name in needed(backend) if re.match("libvulkan|libvkd3d|libcsm", name)]
print("\n".join(problems) or f"{1 + len(backends)} libraries export what they should")
sys.exit(1 if problems else 0)
