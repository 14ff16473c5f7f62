"""
table.py OUT_C PRESET...: the table of api/plan/presets.h from preset files, in the order given.

A file says what the preset is ("about"), where it was read ("read_in"), what was taken where nothing is said ("notes"),
and what differs from the defaults ("config"). The compiler checks the keys: each one becomes a field of csm_config.
"""
import json
import pathlib
import sys

DOCUMENT = ["about", "read_in", "notes", "config"]
HEAD = "/* Made of api/presets by table.py. */\n#include \"plan/presets.h\"\n#include <stddef.h>\n\n"


def unique(pairs):
    keys = [key for key, _ in pairs]
    if len(keys) != len(set(keys)):
        sys.exit(f"a key is there twice: {keys}")
    return dict(pairs)


def text(words):
    return json.dumps(words, ensure_ascii=True)


def setting(key, value):
    """Rows of plan_setting: one for each element of an array."""
    if isinstance(value, list):
        return [row for i, element in enumerate(value) for row in setting(f"{key}[{i}]", element)]
    told = f".value = {text(value)}" if isinstance(value, str) else f".number = {float(value)!r}"
    return [f"{{.offset = offsetof(csm_config, {key}), {told}}}"]


def rows(kind, name, values):
    """An array in C; an empty one is no array at all, so the last row is one that says nothing."""
    return f"static const {kind} {name}[] = {{{''.join(f'{value}, ' for value in values)}}};\n"


def preset(index, name, document):
    """What a preset needs beside its row, and the row."""
    settings = [row for key, value in document["config"].items() for row in setting(key, value)]
    notes = [text(note) for note in document["notes"]]
    arrays = rows("char *const", f"notes_{index}", [*notes, "NULL"])
    if settings:
        arrays += rows("plan_setting", f"settings_{index}", settings)
    row = [f".name = {text(name)}", f".about = {text(document['about'])}", f".read_in = {text(document['read_in'])}",
           f".notes = notes_{index}"]
    if settings:
        row += [f".settings = settings_{index}", f".setting_count = {len(settings)}"]
    return arrays, f"    {{{', '.join(row)}}},\n"


def main(out, *paths):
    arrays, table = [], []
    for index, path in enumerate(map(pathlib.Path, paths)):
        document = json.loads(path.read_text(), object_pairs_hook=unique)
        if list(document) != DOCUMENT:
            sys.exit(f"{path}: has {list(document)}, not {DOCUMENT}")
        made, row = preset(index, path.stem, document)
        arrays.append(made)
        table.append(row)
    pathlib.Path(out).write_text(f"{HEAD}{''.join(arrays)}\nconst plan_preset plan_presets[] = {{\n{''.join(table)}}};\n"
                                 f"const uint32_t plan_preset_count = {len(table)};\n")


main(*sys.argv[1:])
