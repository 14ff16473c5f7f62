#!/usr/bin/env python3
"""
presets.py HOST BACKEND...: what a preset tells is what is drawn; measure compares presets, under soft suns too, and holds
them against others. That every preset draws the same everywhere is presets_agree.c's to tell.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

from tiny_gltf import box, quad, write_gltf

host, backends = sys.argv[1], sys.argv[2:]


def run(*arguments):
    command = [host, *map(str, arguments), "--backend", "both" if len(backends) == 2 else backends[0]]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=300)
    if done.returncode:
        sys.exit(f"presets.py: {' '.join(command)}: exit {done.returncode}\n{done.stderr}")
    return done


def look(folder):
    """At a post and a beam on a ground: a CPU draws them."""
    scene = write_gltf(str(pathlib.Path(folder, "scene.gltf")),
                       quad((-20, 0, -20), (-20, 0, 20), (20, 0, 20), (20, 0, -20)) + box((-1, 0, -1), (1, 3, 1)) +
                       box((-4, 2, -9), (-3.9, 2.1, 9)))
    return ("--scene", scene, "--camera", "6,5,9:0,1,0:50:0.1:100", "--shadow-distance", 40, "--light", "0.5,-0.8,0.3",
            "--size", "160x90")


def check_drawing(name, folder):
    """With small maps; and their pictures are written."""
    told = json.loads(run("config", "--preset", name).stdout)
    told["resolution"] = min(told["resolution"], 256)
    smaller = pathlib.Path(folder, "smaller.json")
    smaller.write_text(json.dumps({"resolution": told["resolution"]}))
    drawn = json.loads(run("run", "--preset", name, "--config", smaller, *look(folder), "--out", folder, "--json", "-").stdout)
    assert dict(told, shadow_distance=drawn["config"]["shadow_distance"]) == drawn["config"], name
    assert len(backends) < 2 or drawn["agreement"]["agrees"] and drawn["agreement"]["plans_equal"], name


def check_measuring(folder):
    done = run("measure", "--presets", "low,default", "--scene", "town", "--size", "160x90", "--sun-samples", "4", "--quick",
               "--minutes", "0.001", "--cache", folder, "--json", "-")
    scene, = json.loads(done.stdout)
    assert scene["scene"] == "town" and [p["preset"] for p in scene["presets"]] == ["default", "low"]
    for preset in scene["presets"]:
        assert list(preset["backends"]) == backends
        for result in preset["backends"].values():
            assert result["gpu_ms"]["median"] > 0 and 0 < result["metrics"]["false_lit"] < 0.1
    assert scene["presets"][0]["backends"][backends[0]]["ratio"]["median"] == 1
    assert sum(line.startswith("| low |") for line in done.stderr.splitlines()) == len(backends)


def expect_refusal(word, *arguments):
    """Before anything is drawn: by the option's name."""
    done = subprocess.run([host, "measure", *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=300)
    assert done.returncode == 2 and word in done.stderr and not done.stdout, (arguments, done.returncode, done.stderr)


def check_soft_suns(folder):
    """A table for each sun; against others, their best is found, and shares of it are those of the figures."""
    small = pathlib.Path(folder, "base.json")
    small.write_text('{"resolution": 256, "cascade_count": 1}')
    done = run("measure", *look(folder), "--config", small, "--presets", "filament_pcss", "--against",
               "filament,filament_vsm", "--suns", "0,5", "--sun-samples", 16, "--quick", "--minutes", 1e-9, "--cache", folder,
               "--json", "-")
    suns, names = json.loads(done.stdout), ["--config", "filament", "filament_vsm", "filament_pcss"]
    assert [s["disc_deg"] for s in suns] == [0, 5] and suns[0]["noise"] == 0 < suns[1]["noise"] < 0.05, suns
    for scene in suns:
        presets = {p["preset"]: p for p in scene["presets"]}
        assert list(presets) == names and presets["filament"]["map_bytes"] == 4 * 1024 ** 2, presets
        assert [name for name in names if presets[name]["moment_bytes"]] == ["filament_vsm"]
        for backend in backends:
            check_shares({name: presets[name]["backends"][backend] for name in names}, scene["disc_deg"] > 0)
    rows = [line.split("|")[1].strip() for line in done.stderr.splitlines() if line.startswith("| ")]
    assert rows == (["preset", *names] * 2) * 2 * len(backends), rows  # a table of figures, and one of shares
    assert done.stderr.count("a sun of 5 degrees, 16 rays") == len(backends) and done.stderr.count("the best of 2") == 2 * len(backends)
    soft = suns[1]["presets"][-1]["backends"][backends[0]]["metrics"]
    assert soft["rmse"] > suns[1]["noise"], "what is drawn is worse than what the truth does not know"
    for word, *bad in (("--suns", "--suns", "x"), ("--suns", "--suns", "0.5,0.5"), ("--suns", "--suns", "180"),
                       ("--suns", "--suns", ""), ("'nobody'", "--against", "nobody"), ("'low' is named twice", "--against", "low,low"),
                       ("--against", "--against", "")):
        expect_refusal(word, "--presets", "low", *bad)
    expect_refusal("--suns", "--suns", "0,5")  # without presets
    expect_refusal("--against", "--against", "low")


def check_shares(results, soft):
    """Of a backend, by name: their error and time in shares of those of the best that was held against."""
    wrong = {name: m["rmse"] if soft else m["false_lit"] + m["false_shadow"] for name, m in
             ((name, result["metrics"]) for name, result in results.items())}
    best = min(("filament", "filament_vsm"), key=wrong.get)
    for name, result in results.items():
        share = result["against"]
        assert share["preset"] == best and "holds" not in share, (name, share)
        assert abs(share["error"] - wrong[name] / wrong[best]) < 1e-9, (name, share)
        assert 0 < share["gpu_ms"]["low"] <= share["gpu_ms"]["median"] <= share["gpu_ms"]["high"], share
    assert results[best]["against"]["gpu_ms"]["median"] == 1


with tempfile.TemporaryDirectory() as folder:
    for name in ("low", "godot", "filament_pcss", "survey12_evsm"):
        check_drawing(name, folder)
    check_measuring(folder)
    check_soft_suns(folder)
print("ok")
