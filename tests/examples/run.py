#!/usr/bin/env python3
"""run.py CHECK FRAMES PROGRAM...: the mini-engines run without a word from the validation layer, and draw what they must."""
import pathlib
import subprocess
import sys
import tempfile

check, frames, programs = sys.argv[1], sys.argv[2], sys.argv[3:]
with tempfile.TemporaryDirectory() as folder:
    pictures = [pathlib.Path(folder) / f"{pathlib.Path(program).name}.png" for program in programs]
    for program, picture in zip(programs, pictures):
        done = subprocess.run([program, "--validate", "--out", picture], stdout=subprocess.PIPE, text=True)
        print(done.stdout, end="", flush=True)
        if done.returncode or "validation messages: 0" not in done.stdout:
            sys.exit(f"{program}: exit status {done.returncode}")
    sys.exit(subprocess.run([check, frames, *pictures]).returncode)
