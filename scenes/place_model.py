#!/usr/bin/env python3
"""Stand a glTF model on the floor of a lit room: one .glb that needs no other file.

    python3 place_model.py MODEL.glb -o ROOM.glb [--size 1.2] [--turn 30]

The room is closed, 4 x 2.7 x 4 m, with a red wall on the left, a green one on the right, a lamp of 1 x 1 m in the
ceiling (10 W/m2/sr) and the camera `room`. The model is scaled until its longest side is --size metres long, turned by
--turn degrees about the vertical, and stands in the middle. Its own cameras are left out, all else of it is kept.
Python 3 standard library only.
"""
import argparse
import base64
import json
import math
import pathlib
import struct
import sys
import urllib.parse

HALF, HEIGHT, LAMP_HALF, LAMP_RADIANCE = 2.0, 2.7, 0.5, 10.0
EYE, TARGET, FIELD = (0.0, 1.35, 1.95), (0.0, 0.6, 0.0), 50.0
COLOURS = {"white": (0.75, 0.75, 0.75), "red": (0.65, 0.15, 0.12), "green": (0.15, 0.5, 0.15)}


def load(path):
    """The JSON of a .gltf or .glb and its binary chunk, b"" if it has none."""
    data = path.read_bytes()
    if data[:4] != b"glTF":
        return json.loads(data), b""
    length = struct.unpack_from("<I", data, 12)[0]
    rest = data[20 + length:]
    return json.loads(data[20:20 + length]), rest[8:8 + struct.unpack_from("<I", rest)[0]] if rest else b""


def fetch(uri, folder):
    if uri.startswith("data:"):
        return base64.b64decode(uri.split(",", 1)[1])
    return (folder / urllib.parse.unquote(uri)).read_bytes()


def gather(gltf, chunk, folder):
    """All buffers and pictures of a model in one buffer, at places that are multiples of 4; returns its bytes."""
    data, start = bytearray(), []
    for buffer in gltf.get("buffers", []):
        start.append(len(data))
        data += fetch(buffer["uri"], folder) if "uri" in buffer else chunk
        data += bytes(-len(data) % 4)
    for view in gltf.get("bufferViews", []):
        view["byteOffset"] = start[view["buffer"]] + view.get("byteOffset", 0)
        view["buffer"] = 0
    for image in gltf.get("images", []):
        uri = image.pop("uri", None)
        if uri is None:
            continue
        picture = fetch(uri, folder)
        image["mimeType"] = "image/png" if picture[:4] == b"\x89PNG" else "image/jpeg"
        image["bufferView"] = append(gltf, data, picture)
    return data


def append(gltf, data, content):
    """A new buffer view that holds the content; returns its index."""
    gltf.setdefault("bufferViews", []).append(
        {"buffer": 0, "byteOffset": len(data), "byteLength": len(content)})
    data += content + bytes(-len(content) % 4)
    return len(gltf["bufferViews"]) - 1


def matrix_of(node):
    """Rows of the node's 3 x 4 matrix."""
    if "matrix" in node:
        m = node["matrix"]
        return [[m[row + 4 * column] for column in range(4)] for row in range(3)]
    x, y, z, w = node.get("rotation", (0, 0, 0, 1))
    turn = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    scale, shift = node.get("scale", (1, 1, 1)), node.get("translation", (0, 0, 0))
    return [[turn[row][k] * scale[k] for k in range(3)] + [shift[row]] for row in range(3)]


def combine(a, b):
    return [[sum(a[row][k] * b[k][column] for k in range(3)) + (a[row][3] if column == 3 else 0)
             for column in range(4)] for row in range(3)]


def measure(gltf, roots, turn):
    """Lowest and highest corner of the boxes of the meshes, turned."""
    low, high = [math.inf] * 3, [-math.inf] * 3

    def visit(index, outer):
        node = gltf["nodes"][index]
        matrix = combine(outer, matrix_of(node))
        for primitive in gltf["meshes"][node["mesh"]]["primitives"] if "mesh" in node else ():
            box = gltf["accessors"][primitive["attributes"]["POSITION"]]
            for corner in range(8):
                point = [box["max" if corner >> k & 1 else "min"][k] for k in range(3)] + [1]
                for k in range(3):
                    value = sum(matrix[k][j] * point[j] for j in range(4))
                    low[k], high[k] = min(low[k], value), max(high[k], value)
        for child in node.get("children", []):
            visit(child, matrix)

    for root in roots:
        visit(root, matrix_of({"rotation": turn}))
    if not all(h >= l for l, h in zip(low, high)):
        sys.exit("the model has no mesh to place")
    return low, high


def room():
    """Quads of each material, fronts inward."""
    h, top, lamp = HALF, HEIGHT, LAMP_HALF

    def ceiling(x0, z0, x1, z1):
        return ((x0, top, z0), (x1, top, z0), (x1, top, z1), (x0, top, z1))

    return {
        "white": [((-h, 0, h), (h, 0, h), (h, 0, -h), (-h, 0, -h)), ((-h, 0, -h), (h, 0, -h), (h, top, -h), (-h, top, -h)),
                  ((h, 0, h), (-h, 0, h), (-h, top, h), (h, top, h)), ceiling(-h, -h, h, -lamp), ceiling(-h, lamp, h, h),
                  ceiling(-h, -lamp, -lamp, lamp), ceiling(lamp, -lamp, h, lamp)],
        "red": [((-h, 0, h), (-h, 0, -h), (-h, top, -h), (-h, top, h))],
        "green": [((h, 0, -h), (h, 0, h), (h, top, h), (h, top, -h))],
        "lamp": [ceiling(-lamp, -lamp, lamp, lamp)],
    }


def add_accessor(gltf, data, content, **keys):
    keys["bufferView"] = append(gltf, data, content)
    gltf.setdefault("accessors", []).append(keys)
    return len(gltf["accessors"]) - 1


def add_room(gltf, data):
    """Materials, mesh and camera of the room; returns the indices of their nodes."""
    primitives = []
    for name, quads in room().items():
        corners = [corner for quad in quads for corner in quad]
        indices = [4 * i + k for i in range(len(quads)) for k in (0, 1, 2, 0, 2, 3)]
        position = add_accessor(
            gltf, data, b"".join(struct.pack("<3f", *c) for c in corners), componentType=5126, type="VEC3",
            count=len(corners), min=[min(c[k] for c in corners) for k in range(3)],
            max=[max(c[k] for c in corners) for k in range(3)])
        index = add_accessor(gltf, data, struct.pack(f"<{len(indices)}H", *indices), componentType=5123,
                             type="SCALAR", count=len(indices))
        material = {"name": f"room {name}", "pbrMetallicRoughness": {
            "baseColorFactor": [*COLOURS.get(name, (0, 0, 0)), 1], "metallicFactor": 0, "roughnessFactor": 1}}
        if name == "lamp":
            material["emissiveFactor"] = [1, 1, 1]
            material["extensions"] = {"KHR_materials_emissive_strength": {"emissiveStrength": LAMP_RADIANCE}}
        gltf.setdefault("materials", []).append(material)
        primitives.append({"attributes": {"POSITION": position}, "indices": index,
                           "material": len(gltf["materials"]) - 1})
    used = gltf.setdefault("extensionsUsed", [])
    if "KHR_materials_emissive_strength" not in used:
        used.append("KHR_materials_emissive_strength")
    gltf.setdefault("meshes", []).append({"name": "room", "primitives": primitives})
    gltf["cameras"] = [{"name": "room", "type": "perspective", "perspective": {
        "yfov": math.radians(FIELD), "aspectRatio": 4 / 3, "znear": 0.01}}]
    down = math.atan2(EYE[1] - TARGET[1], EYE[2] - TARGET[2])
    gltf["nodes"] += [{"name": "room", "mesh": len(gltf["meshes"]) - 1},
                      {"name": "room", "camera": 0, "translation": list(EYE),
                       "rotation": [-math.sin(down / 2), 0, 0, math.cos(down / 2)]}]
    return [len(gltf["nodes"]) - 2, len(gltf["nodes"]) - 1]


def place(gltf, data, size, degrees):
    """The model's roots under one node that scales, turns and moves them; the room beside it."""
    scene = gltf.setdefault("scenes", [{"nodes": list(range(len(gltf["nodes"])))}])[gltf.get("scene", 0)]
    for node in gltf["nodes"]:
        node.pop("camera", None)
    turn = [0, math.sin(math.radians(degrees) / 2), 0, math.cos(math.radians(degrees) / 2)]
    low, high = measure(gltf, scene["nodes"], turn)
    scale = size / max(h - l for l, h in zip(low, high))
    shift = [-scale * (low[0] + high[0]) / 2, -scale * low[1], -scale * (low[2] + high[2]) / 2]
    gltf["nodes"].append({"name": "model", "children": scene["nodes"], "rotation": turn, "scale": [scale] * 3,
                          "translation": shift})
    scene["nodes"] = [len(gltf["nodes"]) - 1]
    scene["nodes"] += add_room(gltf, data)


def write(path, gltf, data):
    gltf["buffers"] = [{"byteLength": len(data)}]
    text = json.dumps(gltf, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    total = 12 + 8 + len(text) + 8 + len(data)
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, total) + struct.pack("<I4s", len(text), b"JSON") + text
                     + struct.pack("<I4s", len(data), b"BIN\0") + bytes(data))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("model", type=pathlib.Path)
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True)
    parser.add_argument("--size", type=float, default=1.2, help="longest side of the model, metres")
    parser.add_argument("--turn", type=float, default=30, help="degrees, counter-clockwise seen from above")
    arguments = parser.parse_args()
    try:
        gltf, chunk = load(arguments.model)
        data = gather(gltf, chunk, arguments.model.parent)
        place(gltf, data, arguments.size, arguments.turn)
    except OSError as error:
        sys.exit(f"place_model.py: {error.filename}: {error.strerror}")
    except (ValueError, KeyError, IndexError, TypeError, RecursionError, struct.error) as error:
        sys.exit(f"place_model.py: {arguments.model}: not a glTF model that can be placed ({error!r})")
    write(arguments.output, gltf, data)


if __name__ == "__main__":
    main()
