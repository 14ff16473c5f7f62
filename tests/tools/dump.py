"""dump.py: reads what `csm-host run --dump` writes, and casts rays through its triangles: slow, simple, and none of csm's code."""
import array
import json
import math
import pathlib
import struct


def read_pfm(path):
    """Width, height, and rows from the top one down."""
    data = path.read_bytes()
    kind, size, scale, body = data.split(b"\n", 3)
    width, height = map(int, size.split())
    assert kind == b"Pf" and float(scale) == -1.0 and len(body) == 4 * width * height, path
    values = array.array("f", body)
    return width, height, [values[row * width:(row + 1) * width] for row in reversed(range(height))]


def read_ply(path):
    """Triangles of three world positions each."""
    data = path.read_bytes()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    header = data[:end].decode().splitlines()
    vertices, faces = (int(next(line for line in header if line.startswith(f"element {name} ")).split()[-1])
                       for name in ("vertex", "face"))
    assert header == ["ply", "format binary_little_endian 1.0", f"element vertex {vertices}", "property double x",
                      "property double y", "property double z", f"element face {faces}",
                      "property list uchar int vertex_indices", "property uchar alpha_tested", "end_header"], header
    assert len(data) == end + vertices * 24 + faces * 14, "not as long as its header says"
    points = list(struct.iter_unpack("<3d", data[end:end + vertices * 24]))
    triangles = []
    for count, a, b, c, alpha in struct.iter_unpack("<B3iB", data[end + vertices * 24:]):
        assert count == 3 and alpha in (0, 1)
        triangles.append((points[a], points[b], points[c]))
    return triangles


class Dump:
    def __init__(self, folder):
        folder = pathlib.Path(folder)
        self.frame = json.loads((folder / "frame.json").read_text())
        self.width, self.height = self.frame["width"], self.frame["height"]
        self.maps = [read_pfm(folder / f"depth_{k}.pfm") for k in range(len(self.frame["cascades"]))]
        self.camera_depth = read_pfm(folder / "camera_depth.pfm")
        self.mask = read_pfm(folder / "mask.pfm")
        self.triangles = read_ply(folder / "scene.ply")
        names = {p.name for p in folder.iterdir()}
        assert names == {"frame.json", "scene.ply", "camera_depth.pfm", "mask.pfm"} | {
            f"depth_{k}.pfm" for k in range(len(self.maps))}, names


def apply(matrix, point, w=1.0):
    """A column-major matrix times a point."""
    return [sum(matrix[4 * c + r] * (*point, w)[c] for c in range(4)) for r in range(4)]


def multiply(a, b):
    return [sum(a[4 * k + r] * b[4 * c + k] for k in range(4)) for c in range(4) for r in range(4)]


def invert(matrix):
    rows = [[matrix[4 * c + r] for c in range(4)] + [float(r == c) for c in range(4)] for r in range(4)]
    for c in range(4):
        pivot = max(range(c, 4), key=lambda r: abs(rows[r][c]))
        rows[c], rows[pivot] = rows[pivot], rows[c]
        rows[c] = [v / rows[c][c] for v in rows[c]]
        for r in range(4):
            if r != c:
                rows[r] = [v - rows[r][c] * u for v, u in zip(rows[r], rows[c])]
    return [rows[r][4 + c] for c in range(4) for r in range(4)]


def subtract(a, b):
    return [a[0] - b[0], a[1] - b[1], a[2] - b[2]]


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def unit(a):
    length = math.sqrt(dot(a, a))
    return [v / length for v in a]


def cast(triangles, origin, direction, skip=None, nearest=-math.inf):
    """The first hit beyond `nearest`: (distance, triangle), or None."""
    found = None
    for index, (a, b, c) in enumerate(triangles):
        if index == skip:
            continue
        edge1, edge2 = subtract(b, a), subtract(c, a)
        p = cross(direction, edge2)
        area = dot(edge1, p)
        if abs(area) < 1e-15:
            continue
        offset = subtract(origin, a)
        u = dot(offset, p) / area
        q = cross(offset, edge1)
        v = dot(direction, q) / area
        distance = dot(edge2, q) / area
        if u >= 0 and v >= 0 and u + v <= 1 and distance > nearest and (found is None or distance < found[0]):
            found = (distance, index)
    return found
