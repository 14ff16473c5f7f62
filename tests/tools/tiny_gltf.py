"""Small glTF scenes for tests: triangles as lists of points, three each."""
import base64
import json
import struct


def quad(a, b, c, d):
    return [a, b, c, a, c, d]


def box(low, high):
    corners = [[high[i] if n >> i & 1 else low[i] for i in range(3)] for n in range(8)]
    faces = [(0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)]
    return [p for face in faces for p in quad(*(corners[i] for i in face))]


def write_gltf(path, points):
    data = b''.join(struct.pack('<3f', *p) for p in points)
    uri = 'data:application/octet-stream;base64,' + base64.b64encode(data).decode()
    bounds = [[f(p[i] for p in points) for i in range(3)] for f in (min, max)]
    with open(path, 'w') as file:
        json.dump({'asset': {'version': '2.0'}, 'scene': 0, 'scenes': [{'nodes': [0]}], 'nodes': [{'mesh': 0}],
                   'meshes': [{'primitives': [{'attributes': {'POSITION': 0}}]}],
                   'accessors': [{'bufferView': 0, 'componentType': 5126, 'count': len(points), 'type': 'VEC3',
                                  'min': bounds[0], 'max': bounds[1]}],
                   'bufferViews': [{'buffer': 0, 'byteLength': len(data)}],
                   'buffers': [{'byteLength': len(data), 'uri': uri}]}, file)
    return path
