#!/usr/bin/env python3
"""interrupts.py HOST LIBRARY BACKEND [--all]: SIGINT at any moment of any command of csm-host.

LIBRARY is interrupt_at.c, which counts the calls that write files, and sends the signal at one of them. Each command
runs over files of an earlier run, and over none. Afterwards every file is the old one or the new one, whole; those that
belong together are of one run; and nothing else lies there. Without --all a few of the moments are tried.
"""
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile

from tiny_gltf import box, quad, write_gltf

host, library, backend, every = *sys.argv[1:4], "--all" in sys.argv
MOMENTS = 5  # of each command and beginning, unless all are tried
top = pathlib.Path(tempfile.mkdtemp())
place, stand = top / "place", {}
tried = 0

# What each command writes is told apart by the light, which is in none of the paths.
LIGHTS = {"old": "0.3,-1,0.2", "new": "-0.5,-1,0.1"}


def commands(light):
    drawn = ("--scene", top / "scene.gltf", "--config", top / "small.json", "--size", "40x24", "--backend", backend,
             "--light", LIGHTS[light])
    files = ("--out", place / "out", "--json", place / "numbers.json")
    quick = ("--quick", "--minutes", "0.001")
    return {
        "run": ("run", *drawn, *files, "--dump", place / "dump"),
        "measure": ("measure", *drawn, *files, "--dump", place / "dump", "--cache", place / "cache"),
        "presets": ("measure", *drawn, *files, *quick, "--presets", "low", "--cache", place / "cache"),
        "report": ("report", *drawn, *files, *quick, "--cascades", "1", "--resolutions", "32", "--case", "bare_plane",
                   "--cache", place / "cache"),
        "hard": ("hard", "--case", "bare_plane", "--backend", backend, *files),
        "bench": ("bench", *drawn, *files, "--quick", "--only", "depth"),
        "config": ("config", "--preset", {"old": "low", "new": "high"}[light]),
    }


def run(arguments, at=0):
    """Its exit code, and how many moments there were if it came to its end. What is printed is a file, too."""
    place.mkdir(exist_ok=True)
    count = top / "count"
    count.unlink(missing_ok=True)
    settings = dict(os.environ, LD_PRELOAD=library, CSM_INTERRUPT_AT=str(at), CSM_INTERRUPT_UNDER=str(place),
                    CSM_INTERRUPT_COUNT=str(count))
    with open(place / "printed", "wb") as printed:
        done = subprocess.run([host, *map(str, arguments)], env=settings, stdout=printed, stderr=subprocess.PIPE,
                              timeout=300)
    return done.returncode, int(count.read_text()) if count.exists() else 0


def contents():
    return {str(path.relative_to(place)): path.read_bytes() for path in place.rglob("*") if path.is_file()}


def whole(name, text):
    """What a file must be a whole one of, where times in it differ from run to run."""
    if name.endswith(".json"):
        json.loads(text)
    elif name.endswith(".html"):
        assert text.rstrip().endswith(b"</html>"), name
    elif name == "printed":
        assert not text or text.endswith(b"\n"), "half a line was printed"
    else:
        return False
    return True


def light_of(text):
    return json.loads(text)["light"]["direction"]


def check(what, found, before, old, new):
    stray = [name for name in found if name not in old and name not in new]
    assert not stray, (what, "left behind", stray)
    lost = [name for name in before if name not in found]
    assert not lost, (what, "lost", lost)
    for name, text in found.items():
        assert whole(name, text) or text in (old.get(name), new.get(name)), (what, name, "is neither old nor new")
    dump = [name for name in found if name.startswith("dump/")]
    for reference in old, new:
        if dump and light_of(found[frame_of(dump)]) == light_of(reference[frame_of(dump)]):
            mixed = [name for name in dump if not name.endswith(".json") and found[name] != reference[name]]
            assert not mixed and len(dump) == sum(name.startswith("dump/") for name in reference), (what, mixed)


def frame_of(dump):
    return next(name for name in dump if name.endswith("frame.json"))


def outcome(arguments):
    shutil.rmtree(place, ignore_errors=True)
    code, moments = run(arguments)
    assert code == 0, (arguments, code)
    return contents(), moments


def begin(before):
    shutil.rmtree(place, ignore_errors=True)
    for name, text in before.items():
        (place / name).parent.mkdir(parents=True, exist_ok=True)
        (place / name).write_bytes(text)


def interrupt(name, arguments, old, new, moments):
    global tried
    chosen = range(1, moments + 1)
    if not every and moments > MOMENTS:  # the first and the last, and what lies between in even steps
        chosen = sorted({1 + i * (moments - 1) // (MOMENTS - 1) for i in range(MOMENTS)})
    for i, at in enumerate(chosen):
        for before in ({}, old) if every else ({}, old)[i % 2:][:1]:
            begin({file: text for file, text in before.items() if file != "printed"})
            code, ended = run(arguments, at)
            # What an earlier run left in the cache needs no writing, so there may be fewer moments.
            assert code == -signal.SIGINT or (code == 0 and 0 < ended < at), (name, at, "exit", code)
            check((name, at), contents(), {file for file in before if file != "printed"}, old, new)
            tried += 1


write_gltf(str(top / "scene.gltf"), quad((-8, 0, 8), (8, 0, 8), (8, 0, -8), (-8, 0, -8)) + box((0, 1, 0), (1, 2, 1)))
(top / "small.json").write_text('{"resolution": 32, "cascade_count": 2}')
for name, arguments in commands("new").items():
    old, _ = outcome(commands("old")[name])
    new, moments = outcome(arguments)
    assert moments > 0 and new.keys() >= {"printed"}, name
    interrupt(name, arguments, old, new, moments)
    print(f"{name}: {moments} moments", flush=True)
shutil.rmtree(top)
print(f"{tried} interruptions; every file is there whole, or as it was")
