#!/usr/bin/env python3
"""
loader.py CC CXX SOURCE_ROOT LIBCSM: csm_loader.h has every function of exports.txt with the type of csm.h, and finds them
in a library opened at run time, in C11 and in C++17; a library that lacks one is told by its name.
"""
import pathlib
import shlex
import subprocess
import sys
import tempfile

cc, cxx, root, libcsm = shlex.split(sys.argv[1]), shlex.split(sys.argv[2]), pathlib.Path(sys.argv[3]), sys.argv[4]
names = [line.split()[1] for line in (root / "tests/library/exports.txt").read_text().splitlines() if line.startswith("libcsm ")]
flags = ["-Wall", "-Wextra", "-pedantic", "-Werror", f"-I{root}/api/include"]
languages = [(cc, "c", "c11"), (cxx, "c++", "c++17")]

types = '#include "csm/csm_loader.h"\nvoid assign(csm_functions *f);\nvoid assign(csm_functions *f) {\n' + "".join(
    f"  f->{name.removeprefix('csm_')} = {name};\n" for name in names) + "}\n" + (
    f"typedef char all[sizeof(csm_functions) == {len(names)} * sizeof(void (*)(void)) ? 1 : -1];\n")

program = """#include "csm/csm_loader.h"
#include <stdio.h>
int main(int argc, char **argv) {
  csm_functions csm;
  void *library = argc == 2 ? dlopen(argv[1], RTLD_NOW | RTLD_LOCAL) : NULL;
  if (!library)
    return 2;
  const char *missing = csm_functions_load(library, &csm);
  if (missing) {
    puts(missing);
    return csm.version ? 3 : 1;
  }
  csm_config config;
  config.struct_size = sizeof config;
  if (csm.config_default(&config) != CSM_SUCCESS || config.cascade_count == 0)
    return 4;
  csm.destroy(NULL);
  return csm.version() == CSM_VERSION ? 0 : 5;
}
"""


def run(*command, **options):
    return subprocess.run([str(part) for part in command], text=True, stdout=subprocess.PIPE, **options)


with tempfile.TemporaryDirectory() as folder:
    partial = pathlib.Path(folder) / "libpartial.so"
    run(*cc, "-shared", "-fPIC", "-x", "c", "-", "-o", partial, input="void csm_version(void) {}\nvoid csm_result_name(void) {}\n",
        check=True)
    for compiler, language, standard in languages:
        command = [*compiler, f"-std={standard}", *flags, "-x", language]
        run(*command, "-fsyntax-only", "-", input=types, check=True)
        binary = pathlib.Path(folder) / standard
        run(*command, "-", "-o", binary, "-ldl", input=program, check=True)
        run(binary, libcsm, check=True)
        done = run(binary, partial)
        assert done.returncode == 1 and done.stdout == "csm_last_error\n", (done.returncode, done.stdout)
print(f"{len(names)} functions, {len(languages)} languages")
