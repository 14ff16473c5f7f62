#!/usr/bin/env python3
"""readme.py CC SOURCE_ROOT: the README's C compiles as it stands."""
import pathlib
import re
import shlex
import subprocess
import sys

cc, root = shlex.split(sys.argv[1]), pathlib.Path(sys.argv[2])
body = re.search(r"```c\n(.*?)```", (root / "README.md").read_text(), re.DOTALL)[1]
source = f"""#include "csm/csm.h"
#define PARAMETERS csm_context *context, csm_cascades *cascades, csm_view *view, csm_scene *scene, \\
  csm_mesh_info mesh_info, csm_mesh mesh, csm_scene_batch batch, csm_scene_batch moved, csm_frame frame
void example(PARAMETERS);
void example(PARAMETERS) {{
{body}}}
"""
command = [*cc, "-fsyntax-only", "-x", "c", "-std=c11", "-Wall", "-Wextra", "-Werror", f"-I{root}/api/include", "-"]
sys.exit(subprocess.run(command, input=source, text=True).returncode)
