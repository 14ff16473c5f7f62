#!/usr/bin/env python3
"""files.py PRESETS FOLDER: what the library says of every preset is what its file in FOLDER says, over the defaults."""
import json
import pathlib
import subprocess
import sys

program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
files = {path.stem: json.loads(path.read_text()) for path in folder.glob("*.json")}
told = {}
for line in subprocess.run([program, "tell"], check=True, stdout=subprocess.PIPE, text=True).stdout.splitlines():
    name, key, *rest = line.split(" ", 2)
    told.setdefault(name, {}).setdefault(key, []).append(rest[0] if rest else "")
defaults = {key: values[0].split() for key, values in told.pop("(defaults)").items()}


def words(key, value):
    """As the library's fields are told: a list of numbers, or of one name."""
    if isinstance(value, str):
        return [value]
    values = value if isinstance(value, list) else [value]
    return [float(element) for element in values] + [0.0] * (len(defaults[key]) - len(values))


def numbers(values):
    return [value if value[0].isalpha() else float(value) for value in values]


assert len(defaults) > 40 and set(told) == set(files), set(told) ^ set(files)
for name, document in files.items():
    lines = told[name]
    unknown = set(document["config"]) - set(defaults)
    assert not unknown, f"{name}: {unknown}"
    assert lines["(about)"] == [document["about"]] and lines["(read_in)"] == [document["read_in"]], name
    assert lines.get("(note)", []) == document["notes"], name
    assert ("(own_distance)" in lines) == ("shadow_distance" in document["config"]), name
    for key, default in defaults.items():
        expected = words(key, document["config"][key]) if key in document["config"] else numbers(default)
        assert numbers(lines[key][0].split()) == expected, f"{name}: {key} is {lines[key][0]}, not {expected}"
print(f"{len(files)} presets, {sum(len(document['config']) for document in files.values())} settings")
