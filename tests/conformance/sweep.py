#!/usr/bin/env python3
"""sweep.py HOST [--libraries FOLDER] [--scene NAME]...: both backends draw the same, whatever the scene and camera.

HOST is csm-host. FOLDER has another vkd3d to run on. Every depth map must be equal bit for bit, and every mask as the
contract says. Takes minutes, so it is not one of the tests: `./dev sweep` runs it.
"""
import argparse
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile

# eye, target, and how far shadows matter
VIEWS = {
    "valley": [((0, 60, 0), (200, 20, -700), 2000), ((30, 12, 5), (31, 0, 4), 300), ((-400, 300, -900), (0, 0, -900), 3000)],
    "town": [((-1.5, 7, 56), (60, 4, -60), 300), ((20, 60, 20), (20.1, 0, 20), 200), ((0, 1.7, 0), (0, 1.8, -1), 120)],
    "oaks": [((0.12, 1.14, 2.25), (0.2365, 0.848, 1.301), 48), ((3, 6, 3), (0, 0, 0), 20), ((0.3, 0.2, 0.9), (0, 1, 0), 9)],
}
LIGHTS = {"low": (1, -0.02, 0.3), "grazing": (-0.7, -0.001, 0.7), "down": (0, -1, 0), "up": (0.1, 1, 0), "right": (1, 0, 0),
          "left": (-1, 0, 0), "away": (0, 0, -1), "high": (0.2, -3, 0.1)}
SIZES = [(640, 360), (333, 517), (1280, 96), (64, 64)]
COUNTS = [1, 3, 4, 8]


# ---- cameras, column-major ----


def unit(v):
    length = math.sqrt(sum(x * x for x in v))
    return [x / length for x in v]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def view_matrix(eye, target, right_sign=1, forward_sign=-1):
    """forward_sign is the sign of view z ahead: -1 for a right-handed view, 1 for a left-handed one."""
    forward = unit([t - e for t, e in zip(target, eye)])
    right = unit(cross(forward, (0, 1, 0)))
    up = cross(right, forward)
    rows = [[right_sign * x for x in right], up, [forward_sign * x for x in forward]]
    rows = [row + [-sum(a * b for a, b in zip(row, eye))] for row in rows] + [[0, 0, 0, 1]]
    return [rows[r][c] for c in range(4) for r in range(4)]


def perspective(aspect, near, far, reversed_z=True, forward_sign=-1, shift=(0, 0)):
    focal = 1.2
    p = [0.0] * 16
    p[0], p[5], p[11] = focal / aspect, focal, forward_sign
    p[8], p[9] = shift[0] * forward_sign, shift[1] * forward_sign
    # depth = a + b / distance
    near_depth, far_depth = (1, 0) if reversed_z else (0, 1)
    b = (near_depth - far_depth) * (near if far is None else near * far / (far - near))
    a = near_depth - b / near
    p[10], p[14] = a * forward_sign, b
    return p


def orthographic(aspect, half_height, near, far, reversed_z):
    p = [0.0] * 16
    p[0], p[5], p[15] = 1 / (half_height * aspect), 1 / half_height, 1
    a, b = (1, -1) if reversed_z else (0, 1) # depth = a + b * (distance - near) / (far - near)
    p[10], p[14] = -b / (far - near), a - b * near / (far - near)
    return p


def cameras(scene, aspect):
    """Name, view and projection of cameras of every kind, where the scene's first view is."""
    eye, target, distance = VIEWS[scene][0]
    near, far = distance / 500, distance * 1.5
    right_handed, left_handed = view_matrix(eye, target), view_matrix(eye, target, forward_sign=1)
    yield "left-handed", left_handed, perspective(aspect, near, None, forward_sign=1)
    yield "left-handed, not reversed", left_handed, perspective(aspect, near, far, reversed_z=False, forward_sign=1)
    yield "not reversed", right_handed, perspective(aspect, near, far, reversed_z=False)
    yield "not reversed, infinite", right_handed, perspective(aspect, near, None, reversed_z=False)
    yield "off-centre", right_handed, perspective(aspect, near, far, shift=(0.4, -0.7))
    yield "mirrored", view_matrix(eye, target, right_sign=-1), perspective(aspect, near, far)
    yield "orthographic", right_handed, orthographic(aspect, distance / 12, near, distance, False)
    yield "orthographic, reversed", right_handed, orthographic(aspect, distance / 12, near, distance, True)


# ---- runs ----


def runs(scene):
    """Name, and arguments apart from the scene, of every run; a dictionary is written to a file."""
    for count in COUNTS:
        yield f"{count} cascades", {"--config": {"cascade_count": count}}
    if scene == "oaks":
        yield "4096", {"--config": {"resolution": 4096, "split_lambda": 0.95}}
    for index, (eye, target, distance) in enumerate(VIEWS[scene]):
        text = ",".join(map(str, eye)) + ":" + ",".join(map(str, target)) + ":70"
        yield f"view {index}", {"--camera": text, "--shadow-distance": distance, "--size": SIZES[index],
                                "--config": {"cascade_count": COUNTS[index + 1], "filter": "pcf_2x2"}}
    for index, (name, light) in enumerate(LIGHTS.items()):
        yield f"light {name}", {"--light": ",".join(map(str, light)), "--size": SIZES[index % 4],
                                "--config": {"cascade_count": COUNTS[index % 4], "resolution": 512 + 333 * (index % 3)}}
    for index, (name, view, projection) in enumerate(cameras(scene, 16 / 9)):
        yield name, {"--camera": {"view": view, "projection": projection}, "--size": SIZES[0],
                     "--shadow-distance": VIEWS[scene][0][2], "--config": {"cascade_count": COUNTS[index % 4]}}


def texts(value, folder):
    if isinstance(value, dict):
        path = folder / f"{len(list(folder.iterdir()))}.json"
        path.write_text(json.dumps(value))
        return path
    return "x".join(map(str, value)) if isinstance(value, tuple) else value


def compare(host, scene, arguments, environment):
    """Whether a run agrees, what it says, and the driver of the second backend."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        words = ["run", "--scene", scene, "--json", "-", "--out", folder / "out"]
        for name, value in {"--size": SIZES[0], **arguments}.items():
            words += [name, texts(value, folder)]
        done = subprocess.run([host, *map(str, words)], env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              text=True)
    if done.returncode not in (0, 1):
        return False, f"exit {done.returncode}: {done.stderr.strip()}", "?"
    numbers = json.loads(done.stdout)
    agreement = numbers["agreement"]
    texels = sum(m["differing"] for m in agreement["maps"]) + agreement["camera_depth"]["differing"]
    drawn = sum(c["casters_drawn"] for c in numbers["backends"][0]["cascades"])
    return (done.returncode == 0 and agreement["agrees"] and texels == 0,
            f"{texels} texels and {agreement['mask_beyond']} of {agreement['mask_pixels']} pixels differ, the mask by at most "
            f"{agreement['mask_largest']:.3g}; {drawn} casters drawn", numbers["backends"][1]["driver"])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("host", type=pathlib.Path)
    parser.add_argument("--libraries", help="a folder with another vkd3d")
    parser.add_argument("--scene", action="append", choices=VIEWS, help="only these")
    options = parser.parse_args()
    environment = dict(os.environ)
    if options.libraries:
        environment["LD_LIBRARY_PATH"] = options.libraries
    count = failures = 0
    for scene in options.scene or VIEWS:
        for name, arguments in runs(scene):
            agrees, what, driver = compare(options.host.resolve(), scene, arguments, environment)
            if count == 0:
                print(driver)
            count += 1
            failures += not agrees
            print(f"{'agree ' if agrees else 'DIFFER'} {scene}, {name}: {what}", flush=True)
    print(f"{count - failures} of {count} runs agree")
    sys.exit(failures != 0)


if __name__ == "__main__":
    main()
