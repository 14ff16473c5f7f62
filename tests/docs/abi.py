#!/usr/bin/env python3
"""
abi.py CC SOURCE_ROOT [--write]: the structs of the public headers keep the rules of docs/abi.md: struct_size first, no
holes, no type whose size is the compiler's to choose, and every field of 1.0 (abi_1.0.txt) where it was, with new ones
after them.

--write makes abi_1.0.txt anew, which is for the time before 1.0 is released only.
"""
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile

cc, root = shlex.split(sys.argv[1]), pathlib.Path(sys.argv[2])
recorded = pathlib.Path(__file__).parent / "abi_1.0.txt"
HEADERS = ("csm.h", "csm_config.h", "csm_vulkan.h", "csm_d3d12.h")
# They stand in arrays of other structs, or are small answers of the engine's, and never grow.
INNER = {"csm_cascade_info", "csm_cascade_stats", "csm_vulkan_memory", "csm_d3d12_memory"}
LOOSE = re.compile(r"\b(bool|_Bool|enum|long|short|int|unsigned|size_t|wchar_t)\b|:\s*\d")
include = "".join(f'#include "csm/{name}"\n' for name in HEADERS)
problems = []


def compiler(*options, source):
    command = [*cc, "-std=c11", f"-I{root}/api/include", "-x", "c", *options, "-"]
    return subprocess.run(command, input=source, text=True, check=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)


def fields(body):
    """Names of a struct's fields, in order."""
    names = []
    for declaration in filter(None, (part.strip() for part in body.split(";"))):
        if LOOSE.search(declaration):
            problems.append(f"a type that compilers size as they like: {declaration}")
        names += [re.search(r"(\w+)(?:\[[^]]*\])*$", part.strip())[1] for part in declaration.split(",")]
    return names


def layout():
    """Lines "struct.field offset size" of all structs, by the compiler."""
    structs = {}
    for name in HEADERS:
        text = re.sub(r"/\*.*?\*/", "", (root / "api/include/csm" / name).read_text(), flags=re.DOTALL)
        for struct, body in re.findall(r"struct (csm_\w+) \{(.*?)\n\}", text, re.DOTALL):
            structs[struct] = fields(body)
            if structs[struct][0] != "struct_size" and struct not in INNER:
                problems.append(f"{struct} does not begin with struct_size")
    entries = [(struct, field) for struct, names in structs.items() for field in names]
    assert len(structs) > 15, "the headers are not understood"
    rows = "".join(f'{{"{s}.{f}", offsetof({s}, {f}), sizeof((({s} *)0)->{f})}},\n' for s, f in entries)
    program = f"""{include}#include <stdio.h>
static const struct {{ const char *name; size_t offset, size; }} rows[] = {{
{rows}}};
int main(void) {{
  for (size_t i = 0; i < sizeof rows / sizeof *rows; ++i)
    printf("%s %zu %zu\\n", rows[i].name, rows[i].offset, rows[i].size);
}}
"""
    with tempfile.TemporaryDirectory() as folder:
        compiler("-o", f"{folder}/layout", source=program)
        return subprocess.run([f"{folder}/layout"], check=True, stdout=subprocess.PIPE, text=True).stdout.splitlines()


def ends(lines):
    """Where each struct's last field ends."""
    result = {}
    for line in lines:
        name, offset, size = line.split()
        struct = name.split(".")[0]
        result[struct] = max(result.get(struct, 0), int(offset) + int(size))
    return result


holes = compiler("-Wpadded", "-fsyntax-only", source=include).stderr
problems += re.findall(r"csm\w*\.h:\d+:\d+: warning: .*Wpadded.*", holes)
now = layout()
if "--write" in sys.argv:
    recorded.write_text("\n".join(now) + "\n")
before = recorded.read_text().splitlines()
end = ends(before)
problems += [f"was, and is not any more: {line}" for line in before if line not in now]
for line in set(now) - set(before):
    name, offset, _ = line.split()
    struct = name.split(".")[0]
    if int(offset) < end.get(struct, 0):
        problems.append(f"new, and not at the end: {line}")
    if struct in INNER and struct in end:
        problems.append(f"new in a struct that cannot grow: {line}")
print("\n".join(problems) or f"{len(ends(now))} structs, {len(now)} fields, {len(before)} of them recorded")
sys.exit(1 if problems else 0)
