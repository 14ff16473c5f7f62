#!/usr/bin/env python3
"""host_program.py HOST BUILD BACKEND...: csm-host as a program: exit codes, words, JSON, pictures, and the dump's contract.

HOST is csm-host, BUILD the folder with the libraries, BACKENDs those that were built.
"""
import base64
import json
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile

import dump

host, build, backends = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), sys.argv[3:]
all_of_them = ("--backend", "both" if len(backends) == 2 else backends[0])
checks = 0


def expect(condition, what):
    global checks
    checks += 1
    if not condition:
        sys.exit(f"host_program.py: {what}")


def run(*arguments, program=host, **environment):
    return subprocess.run([program, *map(str, arguments)], env=dict(os.environ, **environment), stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True, timeout=300)


def expect_exit(code, word, *arguments, **settings):
    done = run(*arguments, **settings)
    expect(done.returncode == code and word in done.stderr,
           f"{' '.join(map(str, arguments))}: exit {done.returncode}, not {code} with '{word}':\n{done.stderr}")
    return done


# ---- a small scene: a ground, and two tilted boxes above it, under a node that is moved and turned ----


def box(size):
    points = [(x * size[0], y * size[1], z * size[2]) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return points, [i for a, b, c, d in quads for i in (a, b, c, a, c, d)]


def write_scene(path):
    data, views, accessors, meshes = b"", [], [], []
    for points, indices in (box((9, 0.1, 7)), box((1, 0.5, 1.5))):
        positions, corners = b"".join(struct.pack("<3f", *p) for p in points), struct.pack(f"<{len(indices)}H", *indices)
        low, high = ([f(p[i] for p in points) for i in range(3)] for f in (min, max))
        meshes.append({"primitives": [{"attributes": {"POSITION": len(accessors)}, "indices": len(accessors) + 1}]})
        accessors.append({"bufferView": len(views), "componentType": 5126, "count": len(points), "type": "VEC3",
                          "min": low, "max": high})
        accessors.append({"bufferView": len(views) + 1, "componentType": 5123, "count": len(indices), "type": "SCALAR"})
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(positions)})
        views.append({"buffer": 0, "byteOffset": len(data) + len(positions), "byteLength": len(corners)})
        data += positions + corners
    nodes = [{"translation": [3, 0, -2], "rotation": [0, 0.2588190451, 0, 0.9659258263], "children": [1, 2, 3]},
             {"mesh": 0},
             {"mesh": 1, "translation": [-2, 2, 1], "rotation": [0.3826834324, 0, 0, 0.9238795325]},
             {"mesh": 1, "translation": [3, 1, -2], "rotation": [0, 0, 0.1736481777, 0.984807753], "scale": [1, 2, 1]}]
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    path.write_text(json.dumps({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": nodes,
                                "meshes": meshes, "accessors": accessors, "bufferViews": views,
                                "buffers": [{"byteLength": len(data), "uri": uri}]}))


# ---- what is refused ----


def write(path, text):
    path.write_text(text)
    return path


def check_bad_input(folder, scene):
    whole = scene.read_text()
    small = ("run", *all_of_them, "--size", "16x16", "--out", folder / "out")
    ours = (*small, "--scene", scene)
    expect_exit(2, "unknown command", "frobnicate")
    expect_exit(2, "unknown option", "run", "--nope", "1")
    expect_exit(2, "truncated", *small, "--scene", write(folder / "cut.gltf", whole[:len(whole) // 2]))
    expect_exit(2, "cannot open", *small, "--scene", folder / "absent.gltf")
    expect_exit(2, "no scene is called", *small, "--scene", "absent")
    expect_exit(2, "--light", *ours, "--light", "0,0,0")
    expect_exit(2, "--camera", *ours, "--camera", "0,0,0:0,0,0:45")
    expect_exit(2, "far must be beyond near", *ours, "--camera", "0,1,0:0,0,0:45:2:1")
    expect_exit(2, "--camera: cannot open", *ours, "--camera", folder / "absent.json")
    expect_exit(2, "--config: cannot open", *ours, "--config", folder / "absent.json")
    expect_exit(2, "cannot make the folder", *ours, "--out", "/proc/no/such/folder")
    expect_exit(2, "cannot make the folder", *ours, "--dump", "/proc/no/such/folder")
    expect_exit(2, "cannot write", *ours, "--json", "/proc/no/such/file")
    full = str(folder)
    full += "/deep" * ((4090 - len(full)) // 5)  # a folder that there may be, without room for a file's name
    expect_exit(2, "too long", *ours, "--out", full)
    expect_exit(2, "too long", "measure", *ours[1:], "--cache", folder / "cache", "--out", full)
    for config, word in (('{"filter": 77}', "filter"), ('{"filter": -1}', "filter"), ('{"resolution": 3}', "resolution"),
                         ('{"split_mode": "manual", "split_distances": [2, 1]}', "contradict")):
        expect_exit(2, word, "config", "--config", write(folder / "bad.json", config))
    for config, word in (('{"nope": 1}', "nope"), ('{"cascade_count": 0}', "cascade_count"),
                         ('{"cascade_count": 9}', "cascade_count"), ('{"resolution": 32768}', "resolution"),
                         ('{"resolution": 16384, "cascade_count": 8}', "bytes"), ('{"filter": "box"}', "box"),
                         ('{"split_mode": "manual", "split_distances": [2, 1], "cascade_count": 2}', "split_distances"),
                         ('{"shadow_distance": 0}', "shadow_distance"), ('{"split_lambda": ', "line 1")):
        expect_exit(2, word, *ours, "--config", write(folder / "bad.json", config))


# ---- presets ----


def answer(*arguments):
    return json.loads(expect_exit(0, "", *arguments).stdout)


def check_presets(folder, scene):
    ours = ("run", *all_of_them, "--size", "16x16", "--out", folder / "out", "--scene", scene)
    presets = answer("presets")
    expect({"default", "bevy", "ogldev49-fixed"} < set(presets), presets.keys())
    expect(all(p["about"] and p["read_in"] and "config" not in p for p in presets.values()), "what a preset is")
    for command in ours, ("measure", "--scene", scene), ("config",), ("bench",), ("report",), ("view",):
        done = expect_exit(2, "no preset is called 'nobody'", *command, "--preset", "nobody")
        expect(all(name in done.stderr for name in presets), done.stderr)
    expect_exit(2, "nobody", "measure", "--presets", "low,nobody")
    expect_exit(2, "--camera-path", "measure", "--presets", "low", "--camera-path", "absent")
    bevy = answer("config", "--preset", "bevy")
    expect(bevy["shadow_distance"] == 150 and bevy["map_reversed"] == "on", bevy)
    expect("shadow_distance" not in answer("config", "--preset", "low"), "the scene's distance is the scene's")
    over = write(folder / "over.json", '{"resolution": 256}')
    both = answer("config", "--config", over, "--preset", "bevy")
    expect(both == dict(bevy, resolution=256), "a file goes over the preset, in either order")
    expect(answer(*ours, "--preset", "bevy", "--config", over, "--json", "-")["config"] == both, "run's configuration")
    again = write(folder / "again.json", json.dumps(bevy))
    expect(answer("config", "--config", again) == bevy, "a preset that is told can be read again")


# ---- hard cases ----


def check_hard(folder):
    ours = ("hard", *all_of_them, "--case", "bare_plane")
    done = expect_exit(0, "", *ours, "--out", folder / "hard", "--json", folder / "hard.json")
    (case,) = json.loads((folder / "hard.json").read_text())
    expect(case["case"] == "bare_plane" and case["figures"] and all(f["holds"] for f in case["figures"]), case)
    lines = done.stdout.splitlines()
    expect([line.split()[0] for line in lines] == ["bare_plane"] * len(case["figures"]), done.stdout)
    expect(all(line.endswith(" ok") for line in lines), done.stdout)
    expect((folder / "hard" / "bare_plane.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n", "a picture of the worst pixel")
    table = expect_exit(0, "", *ours, "--table").stdout.splitlines()
    expect(table[0] == f"**bare_plane**: {case['about']}" and table[1] == table[-1] == "" and table[3].startswith("|---"), table)
    expect(len(table) == 5 + len(case["figures"]) and {line.count("|") for line in table[2:-1]} == {6}, table)
    expect_exit(2, "offsets", "hard", "--case", "bare_plane,nowhere")
    expect_exit(2, "--case", "hard", "--case", ",")
    expect_exit(3, "no-such-device", *ours, "--device", "no-such-device")


# ---- bench ----


def bench_part(part, folder, scene, size="64x36"):
    """One part's numbers; small pictures and maps, for nothing here depends on times."""
    config = write(folder / "bench.json", '{"resolution": 128}')
    done = run("bench", *all_of_them, "--only", part, "--quick", "--scene", scene, "--size", size, "--config", config,
               "--json", "-")
    expect(done.returncode == 0, f"bench --only {part}: exit {done.returncode}:\n{done.stderr}")
    expect(part in done.stderr, f"bench --only {part}: its table is not on stderr beside the JSON")
    numbers = json.loads(done.stdout)
    expect("depth_ms" not in numbers and numbers["pairs"] == 5, f"bench --only {part}: other parts ran, too")
    return numbers[part]


def check_bench(folder, scene):
    expect_exit(2, "--only", "bench", "--only", "everything")
    rows = {"filters": ("nearest", ("linear_depth", "pcf_2x2", "pcf_3x3", "pcf_5x5", "pcf_7x7", "pcf_n 9", "pcf_5x5 early",
                                    "pcf_7x7 early", "poisson", "vogel 16", "grid_17", "pcf_3x3 gaussian",
                                    "pcf_5x5 castano")),
            "modes": ("base", ("samples splits", "samples bounds", "selection map", "selection best", "blend linear",
                               "blend dithered")),
            "maps": ("base", ("atlas", "d16", "reversed", "cull back", "cull front", "raster bias", "resolutions halved",
                              "pancaking clip", "fit cascade", "fit scene_square", "depth slice", "depth scene"))}
    for part, (base, names) in rows.items():
        table = bench_part(part, folder, scene)
        expect(table["base"] == base, f"bench --only {part}: compared with {table['base']}")
        for backend in backends:
            by_name = {row["name"]: row for row in table["rows"] if row["backend"] == backend}
            missing = [name for name in (base, *names) if name not in by_name]
            expect(not missing, f"bench --only {part}: {backend} has no row {missing}")
            expect(by_name[base]["to_base"]["median"] == 1, f"bench --only {part}: the base is not 1 of itself")
            for row in by_name.values():
                for key in ("gpu_ms", "to_base", *(("to_floor",) if "vulkan" in backends else ())):
                    expect(0 < row[key]["low"] <= row[key]["median"] <= row[key]["high"],
                           f"bench --only {part}: {row['name']}: {key}: {row[key]}")
    if "vulkan" in backends:
        for name, drawn in bench_part("drawn", folder, scene).items():
            expect(all(0 < drawn[key]["low"] <= drawn[key]["median"] for key in ("drawn_ms", "made_ms", "drawn/made")),
                   f"bench --only drawn: {name}: {drawn}")
        bare = bench_part("bare", folder, scene, "640x360")
        expect(bare["differing_pixels"] == 0, f"the 7 x 7 filter is not the loop of 49 taps: {bare}")
        expect(bare["partial_pixels"] > 0, f"there is no edge that could tell them apart: {bare}")
        expect({"floor", "set_up", "loop_49", "pcf_7x7"} == bare["gpu_ms"].keys(), f"bare passes: {bare}")


def in_order(estimate):
    return 0 < estimate["low"] <= estimate["median"] <= estimate["high"]


def check_bench_pages(folder, scene):
    sides = bench_part("pages", folder, scene)
    expect(sorted(side["backend"] for side in sides) == sorted(backends), f"bench --only pages: {sides}")
    for side in sides:
        still, cold = side["nothing moves"], side["all changes"]
        expect(still["pages"] == 0 and still["triangles"] == 0, f"bench --only pages: a still frame draws: {still}")
        expect(0 < cold["pages"] <= cold["valid"] and cold["triangles"] > 0, f"bench --only pages: all changed: {cold}")
        expect(all(in_order(case["pages/whole"]) for case in side.values() if isinstance(case, dict)),
               f"bench --only pages: {side}")


def check_bench_rays(folder, scene):
    rays = bench_part("rays", folder, scene)
    costs = rays["costs"]
    expect(sorted(c["backend"] for c in costs) == sorted(backends), f"bench --only rays: {[c['backend'] for c in costs]}")
    for c in costs:
        expect(c["triangles"] == 24 and c["instances"] == 3, f"two boxes, one of them twice: {c}")
        expect(c["mesh_tree_bytes"] > 24 * 48 and c["instance_tree_bytes"] > 3 * 128, f"a tree's bytes: {c}")
        expect(all(in_order(c[key]) for key in ("mesh_trees_ms", "ns_a_triangle", "instance_tree_ms", "ns_a_ray")), c)
        expect(c["ray_pixels"] > 0 and c["nodes_a_ray"] > 1 and c["triangles_a_ray"] > 0, f"rays that meet nothing: {c}")
        expect(c["ray_map_pixels"] == 0, f"a mesh without a tree: {c}")
        moved = c["moved"]
        expect(moved["instances"] == 10000 and moved["moved"] == 100, moved)
        expect(all(in_order(moved[key]) for key in ("frame/plain", "call/plain", "tree_ms")), moved)
    same = ("ray_pixels", "nodes_a_ray", "triangles_a_ray", "mesh_tree_bytes", "instance_tree_bytes")
    expect(len({tuple(c[key] for key in same) for c in costs}) == 1, f"bench --only rays: the backends differ: {costs}")
    for table in rays["masks"], rays["frames"]:
        names = {(row["name"], row["backend"]) for row in table["rows"]}
        expect(names == {(n, b) for n in ("pcf_3x3", "exact", "exact, maps of 1024") for b in backends}, names)
        expect(all(in_order(row["to_base"]) for row in table["rows"]), f"bench --only rays: {table}")


# ---- machines and installations that lack something ----


def copy_program(folder):
    (folder / "host").mkdir(parents=True)
    shutil.copy(host, folder / "host")
    for library in build.glob("libcsm*.so*"):
        if library.is_file():
            shutil.copy(library, folder)
    return folder / "host" / host.name


def check_lacks(folder, scene):
    arguments = ("run", "--size", "16x16", "--out", folder / "out", "--scene", scene)
    for name in (*backends, "both") if len(backends) == 2 else backends:
        expect_exit(3, "Vulkan driver", *arguments, "--backend", name, VK_DRIVER_FILES="/nonexistent",
                    VK_ICD_FILENAMES="/nonexistent")
    expect_exit(3, "no such device", *arguments, *all_of_them, "--device", "no such device")
    expect_exit(3, "Vulkan driver", "bench", *all_of_them, "--quick", "--scene", scene, VK_DRIVER_FILES="/nonexistent",
                VK_ICD_FILENAMES="/nonexistent")

    copy = folder / "copy"
    program = copy_program(copy)
    settings = {"program": program, "LD_LIBRARY_PATH": str(copy)}
    for name in backends:
        library = copy / f"libcsm-{name}.so"
        alone = (*arguments, "--backend", name)
        library.unlink()
        expect_exit(3, f"no libcsm-{name}.so", *alone, **settings)
        library.write_text("not a library")
        expect_exit(3, "does not load", *alone, **settings)
        library.write_bytes((build / library.name).read_bytes()[:20000])
        expect_exit(3, "does not load", *alone, **settings)
        shutil.copy(copy / "libcsm.so.1", library)
        expect_exit(3, "is no backend", *alone, **settings)
        shutil.copy(build / library.name, library)
        expect_exit(0, "", *alone, **settings)
    if len(backends) == 2:
        shutil.copy(build / "libcsm-null.so", copy / "libcsm-d3d12.so") # it draws nothing
        done = expect_exit(1, "", *arguments, **settings)
        expect("DIFFER" in done.stdout, done.stdout)
        expect((folder / "out/d3d12-lit.png").is_file(), "the second one's pictures are not there")


# ---- what is written ----

CAMERA = "-3,6,5:2.5,0.5,-1.5:55:0.5:80"
LIGHT = "-0.7,-1,0.5:0.5"
CONFIG = {"cascade_count": 3, "resolution": 128, "split_distances": [0.0] * 8}


def check_frame(frame):
    expect(frame["width"] == 96 and frame["height"] == 54, "width and height")
    camera, light = frame["camera"], frame["light"]
    expect(set(camera) == {"position", "view", "projection", "near", "far", "reversed"}, camera.keys())
    expect(camera["position"] == [-3, 6, 5] and camera["near"] == 0.5 and camera["far"] == 80, camera)
    expect(camera["reversed"] is True and len(camera["view"]) == len(camera["projection"]) == 16, camera)
    expect(max(map(abs, dump.apply(camera["view"], camera["position"])[:3])) < 1e-12, "view does not take position to 0")
    expect(light == {"direction": [-0.7, -1, 0.5], "disc_deg": 0.5}, light)
    expect(frame["shadow_distance"] == 40 and frame["config"]["shadow_distance"] == 40, "shadow_distance")
    expect(all(frame["config"][key] == value for key, value in CONFIG.items()), frame["config"])
    expect("metrics" not in frame, "nothing was measured")
    cascades = frame["cascades"]
    expect(len(cascades) == 3 and cascades[0]["near"] == 0.5 and cascades[2]["far"] == 40, "intervals")
    expect(all(a["far"] == b["near"] for a, b in zip(cascades, cascades[1:])), "intervals do not follow each other")


def check_maps(frame):
    """Every third texel's centre, along the light, against the triangles."""
    direction = dump.unit(frame.frame["light"]["direction"])
    for cascade, (width, height, rows) in zip(frame.frame["cascades"], frame.maps):
        matrix = cascade["world_to_shadow"]
        back = dump.invert(matrix)
        along = dump.dot(matrix[2::4], direction) # depth for each metre along the light
        texel = 1 / dump.dot(matrix[0::4], matrix[0::4][:3] + [0]) ** 0.5 / width
        expect(width == height == 128 and abs(texel - cascade["texel_size"]) < 1e-9 * texel, "texel_size")
        wrong, total = 0, 0
        for row in range(0, height, 3):
            for column in range(0, width, 3):
                start = dump.apply(back, ((column + 0.5) / width, (row + 0.5) / height, 0))[:3]
                hit = dump.cast(frame.triangles, start, direction)
                depth = min(max(hit[0] * along, 0), 1) if hit else 1
                wrong += abs(depth - rows[row][column]) > 1e-5
                total += 1
        expect(wrong <= 0.002 * total, f"{wrong} of {total} texels of a map are not what the light meets")


def check_view(frame):
    """Every third pixel: the depth of the first surface; and, away from edges, whether the light reaches it."""
    camera, light = frame.frame["camera"], dump.unit(frame.frame["light"]["direction"])
    to_clip = dump.multiply(camera["projection"], camera["view"])
    back = dump.invert(to_clip)
    wrong_depth = wrong_mask = total = shadowed = 0
    for row in range(0, frame.height, 3):
        for column in range(0, frame.width, 3):
            x, y = 2 * (column + 0.5) / frame.width - 1, 1 - 2 * (row + 0.5) / frame.height
            middle = dump.apply(back, (x, y, 0.5))
            ray = dump.unit(dump.subtract([v / middle[3] for v in middle[:3]], camera["position"]))
            hit = dump.cast(frame.triangles, camera["position"], ray, nearest=0)
            depth, visibility = frame.camera_depth[2][row][column], frame.mask[2][row][column]
            total += 1
            if not hit:
                wrong_depth += depth != 0
                wrong_mask += visibility != 1
                continue
            point = [p + hit[0] * d for p, d in zip(camera["position"], ray)]
            clip = dump.apply(to_clip, point)
            wrong_depth += abs(depth - clip[2] / clip[3]) > 1e-4 * depth
            a, b, c = frame.triangles[hit[1]]
            normal = dump.unit(dump.cross(dump.subtract(b, a), dump.subtract(c, a)))
            cosine = dump.dot(normal, light) * (1 if dump.dot(normal, ray) > 0 else -1)
            if cosine > 0.1:
                lit = dump.cast(frame.triangles, point, [-v for v in light], skip=hit[1], nearest=0) is None
                wrong_mask += (visibility >= 0.5) != lit
                shadowed += not lit
    expect(shadowed > 0.02 * total, "nothing is in shadow")
    expect(wrong_depth <= 0.005 * total, f"{wrong_depth} of {total} pixels' depths are not those of what is seen")
    expect(wrong_mask <= 0.01 * total, f"{wrong_mask} of {total} pixels are wrongly lit or shadowed")


def check_written(folder, scene):
    config = write(folder / "config.json", json.dumps(CONFIG))
    arguments = ("run", "--scene", scene, "--light", LIGHT, "--shadow-distance", "40", "--config", config,
                 *all_of_them)
    done = expect_exit(0, "", *arguments, "--camera", CAMERA, "--size", "96x54", "--out", folder / "out", "--json", "-",
                       "--dump", folder / "dump")
    numbers = json.loads(done.stdout)
    expect([b["name"] for b in numbers["backends"]] == backends, "backends in the JSON")
    expect(len(backends) < 2 or (numbers["agreement"]["agrees"] and "AGREE" in done.stderr), "agreement")
    names = ("lit", "mask", "cascades", "density", "maps", "frusta", "culled")
    for name in (*names, "difference") if len(backends) == 2 else names:
        data = (folder / f"out/{name}.png").read_bytes()
        size = (3 * 134 - 6, 128) if name == "maps" else (96, 54)
        expect(data[:8] == b"\x89PNG\r\n\x1a\n" and struct.unpack(">II", data[16:24]) == size, f"{name}.png")
        expect(len(data) > 700, f"{name}.png is blank: {len(data)} bytes") # a plain one takes less
    if len(backends) == 2:
        expect(numbers["agreement"]["views"] == {"agree": True, "cascade_differing": 0, "density_differing": 0,
                                                 "casters_equal": True}, numbers["agreement"])
    soft = expect_exit(0, "", "run", "--scene", scene, "--light", "-0.7,-1,0.5:5", "--preset", "soft_low", *all_of_them,
                       "--size", "96x54", "--out", folder / "soft", "--json", "-")
    expect((folder / "soft/penumbra.png").is_file() and not (folder / "out/penumbra.png").exists(), "penumbra.png")
    if len(backends) == 2:
        expect(json.loads(soft.stdout)["agreement"]["views"]["penumbra_differing"] == 0, soft.stdout)
        exact = expect_exit(0, "", "run", "--scene", scene, "--preset", "exact", "--size", "96x54", "--out",
                            folder / "exact", "--json", "-")
        expect(json.loads(exact.stdout)["agreement"]["views"]["rays_differing"] == 0, exact.stdout)
        expect("0 of rays differ" in exact.stderr, exact.stderr)
    frame = dump.Dump(folder / "dump" / backends[0])
    check_frame(frame.frame)
    check_maps(frame)
    check_view(frame)
    # each backend writes the same bytes, and so does a second run from the camera that was dumped
    expect_exit(0, "", *arguments, "--camera", folder / "dump" / backends[0] / "frame.json", "--out", folder / "out",
                "--dump", folder / "again")
    files = sorted(p.name for p in (folder / "dump" / backends[0]).iterdir())
    for other in [folder / "dump" / name for name in backends] + [folder / "again" / backends[0]]:
        for name in files:
            expect((other / name).read_bytes() == (folder / "dump" / backends[0] / name).read_bytes(), f"{other}/{name}")


with tempfile.TemporaryDirectory() as scratch:
    folder = pathlib.Path(scratch)
    write_scene(folder / "scene.gltf")
    check_bad_input(folder, folder / "scene.gltf")
    check_presets(folder, folder / "scene.gltf")


    check_hard(folder)
    check_bench(folder, folder / "scene.gltf")
    check_bench_rays(folder, folder / "scene.gltf")
    check_bench_pages(folder, folder / "scene.gltf")
    check_lacks(folder, folder / "scene.gltf")
    check_written(folder, folder / "scene.gltf")
print(f"{checks} checks")
