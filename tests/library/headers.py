#!/usr/bin/env python3
"""headers.py CC CXX SOURCE_ROOT: each public header compiles alone, in every language and standard that it is for."""
import pathlib
import shlex
import subprocess
import sys

cc, cxx, root = shlex.split(sys.argv[1]), shlex.split(sys.argv[2]), pathlib.Path(sys.argv[3])
languages = [(cc, "c", "c11"), (cc, "c", "c17"), (cxx, "c++", "c++17")]
headers = sorted(root.glob("api/include/csm/*.h")) + sorted(root.glob("shaders/include/*.h"))
failed = 0
for header in headers:
    for compiler, language, standard in languages:
        command = [*compiler, "-fsyntax-only", "-x", language, f"-std={standard}", "-Wall", "-Wextra", "-Werror", "-pedantic",
                   f"-I{root}/api/include", "-"]
        done = subprocess.run(command, input=f'#include "{header}"\ntypedef int something;\n', stderr=subprocess.PIPE,
                              text=True)
        if done.returncode:
            failed += 1
            print(f"{header.name} as {standard}:\n{done.stderr}")
print(f"{len(headers)} headers, {len(languages)} languages, {failed} failures")
sys.exit(1 if failed or not headers else 0)
