#!/usr/bin/env python3
"""layers.py FOLDER LAYER...: no file of a layer includes one of a layer above it. Layers are folders, the lowest first."""
import pathlib
import re
import sys

root, layers = pathlib.Path(sys.argv[1]), sys.argv[2:]
missing = sorted({p.name for p in root.iterdir() if p.is_dir()} ^ set(layers))
wrong, checked = [], 0
for layer in layers:
    for source in sorted((root / layer).glob("*.[ch]")):
        for name in re.findall(r'^#include "(.+)"', source.read_text(), re.MULTILINE):
            if not (root / name).exists():
                continue  # not one of these layers: csm.h, say, or what the build makes
            checked += 1
            if layers.index(name.split("/")[0]) > layers.index(layer):
                wrong.append(f"{layer}/{source.name} includes {name}, from above it")
for line in [f"{name}: a folder or a layer without the other" for name in missing] + wrong:
    print(line)
print(f"{checked} includes")
sys.exit(1 if wrong or missing or not checked else 0)
