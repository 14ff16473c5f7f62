#!/usr/bin/env python3
"""presets.py HOST BACKEND...: every preset draws the town on every backend, and these agree; measure compares presets."""
import json
import pathlib
import subprocess
import sys
import tempfile

host, backends = sys.argv[1], sys.argv[2:]


def run(*arguments):
    command = [host, *map(str, arguments), "--backend", "both" if len(backends) == 2 else backends[0]]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=300)
    if done.returncode:
        sys.exit(f"presets.py: {' '.join(command)}: exit {done.returncode}\n{done.stderr}")
    return done


def check_drawing(name, folder):
    """With small maps: a CPU draws them, and their pictures are written."""
    told = json.loads(run("config", "--preset", name).stdout)
    told["resolution"] = min(told["resolution"], 256)
    smaller = pathlib.Path(folder, "smaller.json")
    smaller.write_text(json.dumps({"resolution": told["resolution"]}))
    drawn = json.loads(run("run", "--preset", name, "--config", smaller, "--scene", "town", "--size", "160x90", "--out",
                           folder, "--json", "-").stdout)
    assert dict(told, shadow_distance=drawn["config"]["shadow_distance"]) == drawn["config"], name
    assert len(backends) < 2 or drawn["agreement"]["agrees"] and drawn["agreement"]["plans_equal"], name


def check_measuring(folder):
    done = run("measure", "--presets", "low,default", "--scene", "town", "--size", "160x90", "--sun-samples", "4", "--quick",
               "--minutes", "0.01", "--cache", folder, "--json", "-")
    scene, = json.loads(done.stdout)
    assert scene["scene"] == "town" and [p["preset"] for p in scene["presets"]] == ["default", "low"]
    for preset in scene["presets"]:
        assert list(preset["backends"]) == backends
        for result in preset["backends"].values():
            assert result["gpu_ms"]["median"] > 0 and 0 < result["metrics"]["false_lit"] < 0.1
    assert scene["presets"][0]["backends"][backends[0]]["ratio"]["median"] == 1
    assert sum(line.startswith("| low |") for line in done.stderr.splitlines()) == len(backends)


names = list(json.loads(run("presets").stdout))
with tempfile.TemporaryDirectory() as folder:
    for name in names:
        check_drawing(name, folder)
    check_measuring(folder)
print(f"{len(names)} presets")
