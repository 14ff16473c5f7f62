#!/usr/bin/env python3
"""run.py CSM_HOST dummy|XVFB: `csm-host view` flies by itself, swaps its backend and changes its settings, and shows it.

On SDL's dummy display, which shows nothing anywhere, or on one of Xvfb's."""
import base64
import json
import math
import os
import pathlib
import struct
import subprocess
import sys
import tempfile
import zlib

WIDTH, HEIGHT = 192, 108  # the window is twice as large
CAMERA, TARGET, FIELD_DEG = (18, 12, 26), (0, 3, 0), 50
LIGHT = (-1, -1.2, 0.3)


def box(low, high):
    """Corners and triangles, counter-clockwise from outside."""
    corners = [(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners, [i for a, b, c, d in sides for i in (a, b, c, a, c, d)]


def write_scene(path):
    """A tower on a plain."""
    positions, indices = [], []
    for low, high in (((-40, -1, -40), (40, 0, 40)), ((-2, 0, -2), (2, 9, 2))):
        corners, triangles = box(low, high)
        indices += [i + len(positions) for i in triangles]
        positions += corners
    data = struct.pack(f"<{3 * len(positions)}f", *(v for p in positions for v in p))
    index_offset = len(data)
    data += struct.pack(f"<{len(indices)}H", *indices)
    path.write_text(json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(positions), "type": "VEC3",
             "min": [min(p[i] for p in positions) for i in range(3)], "max": [max(p[i] for p in positions) for i in range(3)]},
            {"bufferView": 1, "componentType": 5123, "count": len(indices), "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": index_offset},
                        {"buffer": 0, "byteOffset": index_offset, "byteLength": len(data) - index_offset}],
        "buffers": [{"byteLength": len(data), "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}],
    }))


def read_png(path):
    """Width, height and rows of an RGB picture of 8 bits."""
    data, at, packed = path.read_bytes(), 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        if kind == b"IHDR":
            width, height, depth, color = struct.unpack(">IIBB", data[at + 8:at + 18])
            assert (depth, color) == (8, 2), (depth, color)
        if kind == b"IDAT":
            packed += data[at + 8:at + 8 + length]
        at += 12 + length
    raw, stride, rows, above = zlib.decompress(packed), 3 * width, [], bytes(3 * width)
    for y in range(height):
        line = bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        kind = raw[y * (stride + 1)]
        for x in range(stride):
            a, b, c = (line[x - 3] if x >= 3 else 0), above[x], (above[x - 3] if x >= 3 else 0)
            near = min((abs(b - c), 0, a), (abs(a - c), 1, b), (abs(a + b - 2 * c), 2, c))[2] # Paeth's predictor
            line[x] = (line[x] + (0, a, b, (a + b) // 2, near)[kind]) & 255
        rows.append(line)
        above = line
    return width, height, rows


def view(*arguments, **extra):
    command = [sys.argv[1], "view", *(str(a) for a in arguments)]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env={**os.environ, **extra})
    print(done.stdout, end="", flush=True)
    return done


def fly(folder, keys, *expected, **display):
    """One frame for each key; `expected` holds a text that each frame's line has in it. Gives the window's picture."""
    done = view("--scene", folder / "tower.gltf", "--camera", f"{numbers(CAMERA)}:{numbers(TARGET)}:{FIELD_DEG}",
                "--light", numbers(LIGHT), "--size", f"{WIDTH}x{HEIGHT}", "--out", folder, "--frames", len(keys), "--keys", keys, **display)
    frames = [line for line in done.stdout.splitlines() if line.startswith("frame ")]
    assert done.returncode == 0, done.returncode
    assert len(frames) == len(keys) == len(expected), frames
    for line, text in zip(frames, expected):
        assert text in line, (line, text)
    swaps = [line for line in done.stdout.splitlines() if " -> " in line]
    assert len(swaps) == keys.count("B") and all("the mask is the same (0 of" in line for line in swaps), swaps
    width, height, rows = read_png(folder / "view.png")
    assert (width, height) == (2 * WIDTH, 2 * HEIGHT), (width, height)
    return rows


def numbers(values):
    return ",".join(str(v) for v in values)


def unit(v):
    return [x / math.hypot(*v) for x in v]


def cross(a, b):
    return [a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3] for i in range(3)]


def brightness(rows, point):
    """The mean of the window's pixels about a point of the world."""
    forward = unit([t - c for t, c in zip(TARGET, CAMERA)])
    right = unit(cross(forward, (0, 1, 0)))
    to = [p - c for p, c in zip(point, CAMERA)]
    depth, across, up = (sum(a * b for a, b in zip(to, axis)) for axis in (forward, right, cross(right, forward)))
    scale = HEIGHT / math.tan(math.radians(FIELD_DEG / 2)) / depth
    x, y = round(WIDTH + scale * across), round(HEIGHT - scale * up)
    return sum(sum(row[3 * (x - 2):3 * (x + 2)]) for row in rows[y - 2:y + 2]) / (4 * 12)


def colors(rows):
    """The plain hues that a good part of the window has."""
    found = {}
    for row in rows[::3]:
        for x in range(0, len(row), 9):
            r, g, b = row[x:x + 3]
            name = "red" if r > 1.6 * max(g, b, 20) else "green" if g > 1.3 * max(r, b, 20) else "blue" if b > 1.6 * max(r, g, 20) else ""
            found[name] = found.get(name, 0) + 1
    return {name for name, count in found.items() if name and count > 20}


def check(folder, **display):
    write_scene(folder / "tower.gltf")
    rest = fly(folder, ".BB", "vulkan: 4 x 1024", "d3d12: 4 x 1024", "vulkan: 4 x 1024", **display)
    # Where the light through a point within the tower meets the ground, and a place on the sunny side.
    shaded = brightness(rest, [-LIGHT[0] / LIGHT[1] * 6, 0, -LIGHT[2] / LIGHT[1] * 6])
    lit = brightness(rest, [6, 0, 4])
    assert lit > shaded + 30, (lit, shaded)
    moved = fly(folder, "wwB", "vulkan", "vulkan", "d3d12", **display)
    assert moved != rest
    tinted = fly(folder, "BC3FR", "d3d12: 4", "d3d12: 4", "d3d12: 3 x 1024", "d3d12: 3 x 1024", "d3d12: 3 x 2048", **display)
    assert tinted != rest
    views = fly(folder, "CVVVVV", *(f"ms; {name}" for name in ("cascades", "density", "maps", "frusta", "culled", "lit")), **display)
    assert views == rest, "the last view is not the first"
    shown = [fly(folder, "V" * count, *["vulkan"] * count, **display) for count in range(1, 6)]
    assert len({bytes().join(rows) for rows in (rest, *shown)}) == 6, "two views are the same"
    hues = [colors(rows) for rows in shown]
    assert "green" in hues[0] and "red" in hues[1] and hues[3] >= {"red", "green"} and hues[4] >= {"red", "green"}, hues
    maps = fly(folder, "2M", "2 x 1024", "2 x 1024", **display)
    assert maps[0] == bytes(6 * WIDTH) and any(maps[HEIGHT]), "the maps do not lie across the window's middle"


with tempfile.TemporaryDirectory() as name:
    if sys.argv[2] == "dummy":
        check(pathlib.Path(name), SDL_VIDEODRIVER="dummy")
        done = view("--scene", f"{name}/tower.gltf", "--frames", 1, SDL_VIDEODRIVER="x11", DISPLAY=":none")
        assert done.returncode == 2 and "no window can be opened" in done.stdout, done.returncode
    else:
        server = subprocess.Popen([sys.argv[2], "-displayfd", "1", "-screen", "0", "1280x800x24"], stdout=subprocess.PIPE,
                                  stderr=subprocess.DEVNULL, text=True)
        try:
            check(pathlib.Path(name), SDL_VIDEODRIVER="x11", DISPLAY=":" + server.stdout.readline().strip())
        finally:
            server.terminate()
            server.wait()
