#!/usr/bin/env python3
"""Write every scene of this folder as NAME.gltf + NAME.bin, beside this script.

    python3 make_scenes.py            write the files, print a line for each scene
    python3 make_scenes.py --check    write nothing; exit 1 if a file differs from what would be written

Python 3 standard library only; the output is the same byte for byte on every run.

Conventions
  quad      4 vertices, counter-clockwise seen from the front; triangles (0,1,2) and (0,2,3)
  vertices  float32, as glTF demands; numbers that float32 cannot hold go through a node's TRS, which is JSON double
  emission  radiance in W/m2/sr (emissiveFactor x emissiveStrength); exitance M = pi * radiance
"""
import argparse
import json
import math
import pathlib
import re
import struct
import sys

HERE = pathlib.Path(__file__).resolve().parent
MM = 0.001
ONE_OVER_PI = 1 / math.pi  # radiance of a diffuse emitter of exitance 1 W/m2
Y, Z = (0, 1, 0), (0, 0, 1)  # what "up" may be

# ---------------------------------------------------------------- vectors


def sub(a, b):
    return tuple(p - q for p, q in zip(a, b))


def dot(a, b):
    return sum(p * q for p, q in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    length = math.sqrt(dot(a, a))
    return tuple(p / length for p in a)


def tidy(x):
    """Rounds away what differs between C libraries, and -0."""
    return round(x, 12) + 0.0


def f32(x):
    """The double with the value that float32 stores for x."""
    return struct.unpack("<f", struct.pack("<f", x))[0]


def turn_y(degrees):
    """Quaternion of a counter-clockwise turn about the vertical, seen from above; unit to the last digit."""
    half = math.radians(degrees) / 2
    return list(unit((0.0, tidy(math.sin(half)), 0.0, tidy(math.cos(half)))))


def look(eye, target, up):
    """TRS of a glTF camera (it looks along its -z, its +y is up) at eye, aimed at target."""
    z = unit(sub(eye, target))
    x = unit(cross(up, z))
    y = cross(z, x)
    return {"translation": list(eye), "rotation": quaternion(x, y, z)}


def quaternion(x, y, z):
    """Rotation whose matrix has the columns x, y, z; the largest component is found first, for stability."""
    squares = [1 + x[0] - y[1] - z[2], 1 - x[0] + y[1] - z[2], 1 - x[0] - y[1] + z[2], 1 + x[0] + y[1] + z[2]]
    largest = max(range(4), key=lambda i: squares[i])
    products = [
        [squares[0], x[1] + y[0], x[2] + z[0], y[2] - z[1]],
        [x[1] + y[0], squares[1], y[2] + z[1], z[0] - x[2]],
        [x[2] + z[0], y[2] + z[1], squares[2], x[1] - y[0]],
        [y[2] - z[1], z[0] - x[2], x[1] - y[0], squares[3]],
    ]
    scale = 2 * math.sqrt(squares[largest])
    return [tidy(p / scale) for p in products[largest]]


# ---------------------------------------------------------------- quads


def corner_normals(quad):
    """Unnormalised normals of the quad's two triangles."""
    a, b, c, d = quad
    return cross(sub(b, a), sub(c, a)), cross(sub(c, a), sub(d, a))


def facing(quad, point):
    """The quad, once it is certain that its front looks at the point."""
    assert all(dot(n, sub(point, quad[0])) > 0 for n in corner_normals(quad)), f"wrong side: {quad}"
    return quad


def facing_away(quad, point):
    assert all(dot(n, sub(point, quad[0])) < 0 for n in corner_normals(quad)), f"wrong side: {quad}"
    return quad


def is_parallelogram(quad):
    a, b, c, d = quad
    size = max(abs(p) for v in quad for p in v)
    return max(abs(p) for p in sub(sub(a, b), sub(d, c))) <= 1e-6 * size


def box(lo, hi, omit=()):
    """Outward faces of an axis-aligned box, by name: x0 is the face at the low x, and so on."""
    (x0, y0, z0), (x1, y1, z1) = lo, hi
    faces = {
        "x0": ((x0, y0, z0), (x0, y0, z1), (x0, y1, z1), (x0, y1, z0)),
        "x1": ((x1, y0, z0), (x1, y1, z0), (x1, y1, z1), (x1, y0, z1)),
        "y0": ((x0, y0, z0), (x1, y0, z0), (x1, y0, z1), (x0, y0, z1)),
        "y1": ((x0, y1, z0), (x0, y1, z1), (x1, y1, z1), (x1, y1, z0)),
        "z0": ((x0, y0, z0), (x0, y1, z0), (x1, y1, z0), (x1, y0, z0)),
        "z1": ((x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1)),
    }
    centre = tuple((p + q) / 2 for p, q in zip(lo, hi))
    return {name: facing_away(quad, centre) for name, quad in faces.items() if name not in omit}


def room(lo, hi):
    """Inward faces of a closed axis-aligned box, by name."""
    return {name: (a, d, c, b) for name, (a, b, c, d) in box(lo, hi).items()}


def boxes(*parts):
    """Faces of several boxes, each given as (lo, hi) or (lo, hi, omitted faces), as one list."""
    return [quad for part in parts for quad in box(*part).values()]


def mirrored(lo, hi, omit=()):
    """The box and its mirror image in x = 0 (omit must not name x0 or x1)."""
    return (lo, hi, omit), ((-hi[0], lo[1], lo[2]), (-lo[0], hi[1], hi[2]), omit)


def four_legs(x, z, width, height):
    """Legs from the floor to a plate that rests on them, their outer corners at (+-x, +-z); open at both ends."""
    ends = ("y0", "y1")
    back = mirrored((x - width, 0, -z), (x, height, width - z), ends)
    front = mirrored((x - width, 0, z - width), (x, height, z), ends)
    return boxes(*back, *front)


# ---------------------------------------------------------------- glTF


class Gltf:
    """One scene under construction. Every method that adds something returns its index."""

    def __init__(self, **extras):
        self.positions = bytearray()
        self.indices = bytearray()
        self.primitives = {}  # quads -> (POSITION accessor, indices accessor), so equal geometry is stored once
        self.quads = []  # per mesh
        self.doc = {
            "asset": {
                "version": "2.0",
                "generator": "hprad scenes/make_scenes.py",
                "copyright": "Copyright (c) 2026 The hprad authors",
                "extras": {"licence": "MIT", **extras},
            },
            "scene": 0,
            "scenes": [{"nodes": []}],
            "nodes": [],
            "cameras": [],
            "meshes": [],
            "materials": [],
            "accessors": [],
        }

    def material(self, name, rho, radiance=None, double_sided=False):
        """rho and radiance are one number or three (R, G, B)."""
        rgb = lambda v: list(v) if isinstance(v, tuple) else [v] * 3
        material = {
            "name": name,
            "pbrMetallicRoughness": {"baseColorFactor": rgb(rho) + [1], "metallicFactor": 0, "roughnessFactor": 1},
        }
        if radiance is not None:
            material.update(self.emission(rgb(radiance)))
        if double_sided:
            material["doubleSided"] = True
        self.doc["materials"].append(material)
        return len(self.doc["materials"]) - 1

    def emission(self, radiance):
        """emissiveFactor must not exceed 1; a power of two as strength keeps the product exact."""
        if max(radiance) <= 1:
            return {"emissiveFactor": radiance}
        strength = 2 ** math.ceil(math.log2(max(radiance)))
        self.doc["extensionsUsed"] = ["KHR_materials_emissive_strength"]
        return {
            "emissiveFactor": [v / strength for v in radiance],
            "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": strength}},
        }

    def accessor(self, view, offset, component_type, count, **more):
        self.doc["accessors"].append(
            {"bufferView": view, "byteOffset": offset, "componentType": component_type, "count": count, **more})
        return len(self.doc["accessors"]) - 1

    def geometry(self, quads):
        """Accessors (POSITION, indices) of the quads, four vertices and two triangles each."""
        key = tuple(quads)
        if key not in self.primitives:
            vertices = [tuple(f32(c) for c in v) for quad in quads for v in quad]
            bounds = {"min": [min(c) for c in zip(*vertices)], "max": [max(c) for c in zip(*vertices)]}
            position = self.accessor(0, len(self.positions), 5126, len(vertices), type="VEC3", **bounds)
            self.positions += b"".join(struct.pack("<3f", *v) for v in vertices)
            triangles = [4 * q + k for q in range(len(quads)) for k in (0, 1, 2, 0, 2, 3)]
            index = self.accessor(1, len(self.indices), 5123, len(triangles), type="SCALAR")
            self.indices += struct.pack(f"<{len(triangles)}H", *triangles)
            self.primitives[key] = position, index
        return self.primitives[key]

    def mesh(self, name, *parts):
        """parts: (material, list of quads), a primitive each."""
        primitives = []
        for material, quads in parts:
            position, index = self.geometry(quads)
            primitives.append({"attributes": {"POSITION": position}, "indices": index, "material": material})
        self.doc["meshes"].append({"name": name, "primitives": primitives})
        self.quads.append([quad for _, quads in parts for quad in quads])
        return len(self.doc["meshes"]) - 1

    def node(self, name, parent=None, **members):
        """members: mesh, camera, translation, rotation, scale as glTF has them."""
        self.doc["nodes"].append({"name": name, **members})
        index = len(self.doc["nodes"]) - 1
        siblings = self.doc["scenes"][0]["nodes"] if parent is None else self.doc["nodes"][parent].setdefault(
            "children", [])
        siblings.append(index)
        return index

    def camera(self, name, yfov, aspect, **trs):
        self.doc["cameras"].append({
            "name": name,
            "type": "perspective",
            "perspective": {"yfov": tidy(yfov), "aspectRatio": aspect, "znear": 0.01},
        })
        return self.node(name, camera=len(self.doc["cameras"]) - 1, **trs)

    def patch_count(self):
        """Patches in the scene: 1 for a parallelogram, 2 (triangles) for any other quad."""
        meshes = [node["mesh"] for node in self.doc["nodes"] if "mesh" in node]
        return sum(1 if is_parallelogram(quad) else 2 for mesh in meshes for quad in self.quads[mesh])

    def files(self, name):
        """{file name: bytes}"""
        start = len(self.positions)
        doc = dict(self.doc)
        doc["bufferViews"] = [
            {"buffer": 0, "byteOffset": 0, "byteLength": start, "byteStride": 12, "target": 34962},
            {"buffer": 0, "byteOffset": start, "byteLength": len(self.indices), "target": 34963},
        ]
        doc["buffers"] = [{"uri": f"{name}.bin", "byteLength": start + len(self.indices)}]
        text = json.dumps(doc, indent=1)
        flat = re.sub(r"\[\s+([^][{}]*?)\s+\]", lambda m: "[" + re.sub(r",\s+", ", ", m[1]) + "]", text)
        return {f"{name}.gltf": (flat + "\n").encode(), f"{name}.bin": bytes(self.positions + self.indices)}


# ---------------------------------------------------------------- Cornell box

# The published measurements, millimetres, y up, x to the left in the picture; the order is the published one,
# which is counter-clockwise seen from inside the box and from outside the blocks.
CORNELL_FLOOR = ((552.8, 0, 0), (0, 0, 0), (0, 0, 559.2), (549.6, 0, 559.2))
CORNELL_LAMP = ((343, 548.8, 227), (343, 548.8, 332), (213, 548.8, 332), (213, 548.8, 227))
CORNELL_BACK = ((549.6, 0, 559.2), (0, 0, 559.2), (0, 548.8, 559.2), (556, 548.8, 559.2))
CORNELL_RIGHT = ((0, 0, 559.2), (0, 0, 0), (0, 548.8, 0), (0, 548.8, 559.2))
CORNELL_LEFT = ((552.8, 0, 0), (549.6, 0, 559.2), (556, 548.8, 559.2), (556, 548.8, 0))
CORNELL_SHORT = ((130, 165, 65), (82, 165, 225), (240, 165, 272), (290, 165, 114))
CORNELL_TALL = ((423, 330, 247), (265, 330, 296), (314, 330, 456), (472, 330, 406))


def cornell_ceiling():
    """The published ceiling (556 x 559.2) as four rectangles around the lamp's hole."""
    y, (x0, x1), (z0, z1) = 548.8, (213, 343), (227, 332)
    rectangle = lambda xa, xb, za, zb: ((xb, y, za), (xb, y, zb), (xa, y, zb), (xa, y, za))
    return [
        rectangle(0, 556, 0, z0),
        rectangle(0, 556, z1, 559.2),
        rectangle(0, x0, z0, z1),
        rectangle(x1, 556, z0, z1),
    ]


def cornell_block(top):
    """The top and the four sides down to the floor, all looking outward."""
    centre = tuple(sum(c) / 4 for c in zip(*top))
    inside = (centre[0], centre[1] / 2, centre[2])
    foot = lambda v: (v[0], 0, v[2])
    sides = [(foot(b), b, a, foot(a)) for a, b in zip(top, top[1:] + top[:1])]
    return [facing_away(quad, inside) for quad in [top] + sides]


def cornell_box():
    g = Gltf(units="metre (vertices in millimetre under a node scale of 0.001)",
             source="Cornell University Program of Computer Graphics, Cornell Box Data (published measurements)")
    white = g.material("white", (0.725, 0.71, 0.68))
    red = g.material("red", (0.63, 0.065, 0.05))
    green = g.material("green", (0.14, 0.45, 0.091))
    lamp = g.material("lamp", 0.78, radiance=(17, 12, 4))
    parts = [
        ("floor", white, [CORNELL_FLOOR]),
        ("ceiling", white, cornell_ceiling()),
        ("lamp", lamp, [CORNELL_LAMP]),
        ("back wall", white, [CORNELL_BACK]),
        ("right wall", green, [CORNELL_RIGHT]),
        ("left wall", red, [CORNELL_LEFT]),
    ]
    root = g.node("Cornell box", scale=[MM] * 3)
    for name, material, quads in parts:
        inward = [facing(quad, (278, 273, 280)) for quad in quads]
        g.node(name, root, mesh=g.mesh(name, (material, inward)))
    g.node("short block", root, mesh=g.mesh("short block", (white, cornell_block(CORNELL_SHORT))))
    g.node("tall block", root, mesh=g.mesh("tall block", (white, cornell_block(CORNELL_TALL))))
    # Published camera: focal length 0.035, film 0.025 x 0.025, looking along +z.
    g.camera("camera", 2 * math.atan(0.0125 / 0.035), 1, **look((0.278, 0.273, -0.8), (0.278, 0.273, 0), Y))
    return g


# ---------------------------------------------------------------- scenes with an answer

FACING_UP = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0))
FACING_DOWN = ((0, 0, 0), (0, 1, 0), (1, 1, 0), (1, 0, 0))
OPEN_JSON = "own; axes (z up) and answer as in the reference set open.json, case "


def plates(gap, bottom_radiance, top_radiance, **extras):
    """Two unit squares, z = 0 facing +z and z = gap facing -z, reflectance 0.5."""
    g = Gltf(units="metre", **extras)
    for name, quad, z, radiance in (("bottom", FACING_UP, 0, bottom_radiance), ("top", FACING_DOWN, gap, top_radiance)):
        mesh = g.mesh(name, (g.material(name, 0.5, radiance), [quad]))
        g.node(name, mesh=mesh, translation=[0, 0, z])
    return g


def parallel_plates(gap, case):
    g = plates(gap, ONE_OVER_PI, None, source=OPEN_JSON + case)
    g.camera("camera", math.pi / 3, 1, **look((0.5, tidy(-1.2 * gap), gap / 2), (0.5, 1, gap / 2), Z))
    return g


def blocked_plates():
    g = plates(1, None, ONE_OVER_PI, source=OPEN_JSON + "occ_square_centre")
    black = g.material("black", 0, double_sided=True)
    square = ((0.25, 0.25, 0), (0.75, 0.25, 0), (0.75, 0.75, 0), (0.25, 0.75, 0))
    g.node("blocker", mesh=g.mesh("blocker", (black, [square])), translation=[0, 0, 0.5])
    g.camera("camera", math.pi / 3, 1, **look((0.5, -1.3, 0.85), (0.5, 0.5, 0.3), Z))
    return g


def furnace(size):
    """A closed box whose faces all have reflectance 0.5 and emit radiance 1: radiance 2 everywhere."""
    g = Gltf(units="metre", source="own; exact answer: radiance = 1 / (1 - 0.5) = 2 everywhere")
    glow = g.material("glow", 0.5, radiance=1)
    centre = [c / 2 for c in size]
    for name, quad in room((0, 0, 0), size).items():
        g.node(name, mesh=g.mesh(name, (glow, [facing(quad, centre)])))
    g.camera("camera", math.pi / 2, 1, **look([c / 8 for c in size], centre, Y))
    return g


def cube_mixed():
    g = Gltf(units="metre", source=OPEN_JSON + "cube_mixed")
    rho = {"x0": 0.2, "x1": 0.7, "y0": 0.5, "y1": 0.5, "z0": 0.8, "z1": 0.6}
    exitance = {"z1": 1}
    for name, quad in room((0, 0, 0), (1, 1, 1)).items():
        radiance = exitance[name] / math.pi if name in exitance else None
        mesh = g.mesh(name, (g.material(name, rho[name], radiance), [facing(quad, (0.5, 0.5, 0.5))]))
        g.node(name, mesh=mesh)
    g.camera("camera", math.pi / 2, 1, **look((0.5, 0.0625, 0.5), (0.5, 1, 0.5), Z))
    return g


def l_corner():
    """Unit squares in z = 0 (emits) and x = 0, sharing the edge x = z = 0."""
    g = Gltf(units="metre", source=OPEN_JSON + "corner90_rho0.8_E1_0")
    upright = ((0, 0, 0), (0, 1, 0), (0, 1, 1), (0, 0, 1))
    for name, quad, radiance in (("P1", FACING_UP, ONE_OVER_PI), ("P2", upright, None)):
        mesh = g.mesh(name, (g.material(name, 0.8, radiance), [facing(quad, (1, 0.5, 1))]))
        g.node(name, mesh=mesh)
    g.camera("camera", math.radians(40), 1, **look((2.25, -0.75, 1.5), (0.35, 0.5, 0.35), Z))
    return g


# ---------------------------------------------------------------- furnished room

# Furniture stands on y = 0 of its own frame, its back toward -z. A face that lies on another one is left out.
# Where two meshes touch, the height is one that float32 holds exactly.

BOARD_TOPS = (0.125, 0.5, 0.875, 1.25, 1.75)
BOOKS = (  # colour, board, x of the middle, width, height, depth
    (0, 3, -0.49, 0.06, 0.27, 0.19), (1, 3, -0.40, 0.05, 0.30, 0.21), (2, 3, -0.30, 0.08, 0.25, 0.18),
    (1, 3, 0.38, 0.22, 0.12, 0.20), (2, 2, 0.20, 0.07, 0.28, 0.20), (0, 2, 0.31, 0.06, 0.24, 0.17),
    (1, 2, 0.44, 0.10, 0.29, 0.21), (0, 1, -0.35, 0.30, 0.16, 0.22))


def room_shell(g):
    """A unit cube looking inward, scaled by its node, so that the walls stand at exact doubles."""
    plaster = g.material("plaster", (0.76, 0.74, 0.69))
    teal = g.material("teal wall", (0.36, 0.52, 0.53))
    ceiling = g.material("ceiling", 0.85)
    oak = g.material("oak floor", (0.47, 0.33, 0.20))
    faces = room((0, 0, 0), (1, 1, 1))
    walls = [faces["x1"], faces["z0"], faces["z1"]]
    mesh = g.mesh("shell", (plaster, walls), (teal, [faces["x0"]]), (ceiling, [faces["y1"]]), (oak, [faces["y0"]]))
    g.node("shell", mesh=mesh, scale=[5, 2.7, 4])


def ceiling_lamp(g):
    """A panel whose lower face emits, 5 cm under the ceiling; its top lies on the ceiling and is left out."""
    housing = g.material("lamp housing", 0.8)
    light = g.material("lamp", 0.8, radiance=(20, 18, 15))
    faces = box((-0.6, -0.05, -0.3), (0.6, 0, 0.3), ("y1", ))
    emitter = [faces.pop("y0")]
    mesh = g.mesh("ceiling lamp", (housing, list(faces.values())), (light, emitter))
    g.node("ceiling lamp", mesh=mesh, translation=[2.5, 2.7, 2])


def dining_group(g):
    """A table and four instances of a chair, turned together, each chair a little out of line."""
    walnut = g.material("walnut", (0.42, 0.27, 0.16))
    terracotta = g.material("terracotta", (0.66, 0.27, 0.17))
    top = boxes(((-0.7, 0.71, -0.4), (0.7, 0.75, 0.4)))
    table = g.mesh("table", (walnut, top + four_legs(0.65, 0.35, 0.07, 0.71)))
    seat_and_back = boxes(((-0.21, 0.43, -0.21), (0.21, 0.47, 0.21)),
                          ((-0.2, 0.47, -0.2), (0.2, 0.92, -0.165), ("y0", )))
    chair = g.mesh("chair", (terracotta, seat_and_back), (walnut, four_legs(0.2, 0.2, 0.04, 0.43)))
    group = g.node("dining group", translation=[3.45, 0, 2.55], rotation=turn_y(15))
    g.node("table", group, mesh=table)
    for number, (x, z, turn) in enumerate(((-0.33, -0.66, 4), (0.36, -0.63, -9), (-0.35, 0.64, 173), (0.32, 0.7, 188))):
        g.node(f"chair {number + 1}", group, mesh=chair, translation=[x, 0, z], rotation=turn_y(turn))


def sofa(g):
    blue = g.material("blue fabric", (0.20, 0.30, 0.46))
    sand = g.material("sand cushion", (0.70, 0.60, 0.42))
    foot = g.material("sofa foot", 0.15)
    on = ("y0", )
    body = boxes(((-0.95, 0.12, -0.42), (0.95, 0.36, 0.42)),
                 *mirrored((0.74, 0.36, -0.4), (0.93, 0.62, 0.4), on),
                 ((-0.72, 0.36, -0.4), (0.72, 0.86, -0.2), on))
    cushions = boxes(*mirrored((0.01, 0.36, -0.18), (0.71, 0.5, 0.4), on))
    mesh = g.mesh("sofa", (blue, body), (sand, cushions), (foot, four_legs(0.9, 0.38, 0.08, 0.12)))
    g.node("sofa", mesh=mesh, translation=[0.48, 0, 2.4], rotation=turn_y(90))


def bookshelf(g):
    """Two sides and five boards against the wall; the books are instances of a unit box in three colours."""
    birch = g.material("birch", (0.80, 0.73, 0.60))
    sides = boxes(*mirrored((0.57, 0, 0), (0.6, 1.75, 0.3), ("y0", "z0")))
    ends = ("x0", "x1", "z0")
    boards = boxes(*(((-0.57, top - 0.03, 0), (0.57, top, 0.29), ends) for top in BOARD_TOPS))
    shelf = g.node("shelf", mesh=g.mesh("shelf", (birch, sides + boards)), translation=[0.85, 0, 0])
    covers = (("red book", (0.62, 0.12, 0.10)), ("green book", (0.14, 0.36, 0.20)), ("cream book", (0.78, 0.72, 0.55)))
    unit_book = boxes(((-0.5, 0, 0), (0.5, 1, 1), ("y0", )))
    colours = [g.mesh(name, (g.material(name, rho), unit_book)) for name, rho in covers]
    for number, (colour, board, x, width, height, depth) in enumerate(BOOKS):
        g.node(f"book {number + 1}", shelf, mesh=colours[colour], translation=[x, BOARD_TOPS[board], 0.03],
               scale=[width, height, depth])


def cupboard(g):
    sage = g.material("sage", (0.48, 0.56, 0.43))
    body = boxes(((-0.65, 0, 0), (0.65, 0.85, 0.42), ("y0", "z0")))
    doors = boxes(*mirrored((0.02, 0.06, 0.42), (0.62, 0.8, 0.44), ("z0", )))
    g.node("cupboard", mesh=g.mesh("cupboard", (sage, body + doors)), translation=[3.85, 0, 0])


def wall_hangings(g):
    """The door, three pictures and the window's blind: boxes on the walls, backs left out."""
    cream = g.material("door paint", (0.72, 0.67, 0.57))
    door = g.mesh("door", (cream, boxes(((-0.45, 0, 0), (0.45, 2.05, 0.04), ("y0", "z0")))))
    g.node("door", mesh=door, translation=[2.2, 0, 0])
    border = boxes(((-0.5, -0.5, 0), (0.5, 0.5, 0.03125), ("z0", )))
    panel = boxes(((-0.42, -0.42, 0.03125), (0.42, 0.42, 0.045), ("z0", )))
    dark, canvas = g.material("dark frame", 0.12), g.material("canvas", (0.80, 0.62, 0.28))
    white, blind = g.material("white frame", 0.82), g.material("blind", (0.58, 0.70, 0.78))
    picture = g.mesh("picture", (dark, border), (canvas, panel))
    window = g.mesh("window", (white, border), (blind, panel))
    g.node("picture over the cupboard", mesh=picture, translation=[3.85, 1.55, 0], scale=[0.9, 0.6, 1])
    g.node("picture over the sofa", mesh=picture, translation=[0, 1.6, 2.4], rotation=turn_y(90), scale=[1.2, 0.7, 1])
    g.node("picture by the window", mesh=picture, translation=[1.5, 1.6, 4], rotation=turn_y(180), scale=[0.6, 0.8, 1])
    g.node("window", mesh=window, translation=[3.6, 1.5, 4], rotation=turn_y(180), scale=[1.6, 1.2, 1])


def furnished_room():
    """5 x 2.7 x 4 m, x east, z south."""
    g = Gltf(units="metre", source="own")
    room_shell(g)
    ceiling_lamp(g)
    dining_group(g)
    sofa(g)
    bookshelf(g)
    cupboard(g)
    wall_hangings(g)
    rug = boxes(((-0.5, 0, -0.85), (0.5, 0.015, 0.85), ("y0", )))
    g.node("rug", mesh=g.mesh("rug", (g.material("rug", (0.50, 0.16, 0.15)), rug)), translation=[1.6, 0, 2.4])
    g.camera("door", math.radians(66), 1.5, **look((2.2, 1.6, 0.15), (2.4, 1, 3), Y))
    g.camera("window", math.radians(58), 1.5, **look((4.8, 1.7, 3.7), (1.6, 0.75, 1.2), Y))
    return g


# ---------------------------------------------------------------- command

SCENES = {
    "cornell_box": cornell_box,
    "parallel_plates": lambda: parallel_plates(1, "plates_h1.0_rho0.5"),
    "parallel_plates_0.25": lambda: parallel_plates(0.25, "plates_h0.25_rho0.5"),
    "parallel_plates_0.1": lambda: parallel_plates(0.1, "plates_h0.1_rho0.5"),
    "furnace_cube": lambda: furnace((1, 1, 1)),
    "furnace_box": lambda: furnace((1.5, 0.75, 2)),
    "cube_mixed": cube_mixed,
    "l_corner": l_corner,
    "blocked_plates": blocked_plates,
    "furnished_room": furnished_room,
}


def differs(path, content):
    return not path.is_file() or path.read_bytes() != content


def main():
    parser = argparse.ArgumentParser(description="Write the scenes of this folder as glTF.")
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 if a file on disk differs")
    check = parser.parse_args().check
    stale = []
    for name, scene in SCENES.items():
        g = scene()
        for file_name, content in g.files(name).items():
            if check and differs(HERE / file_name, content):
                stale.append(file_name)
            elif not check:
                (HERE / file_name).write_bytes(content)
        if not check:
            print(f"{name}.gltf: {g.patch_count()} patches")
    for file_name in stale:
        print(f"{file_name} is not what make_scenes.py writes", file=sys.stderr)
    return 1 if stale else 0


if __name__ == "__main__":
    sys.exit(main())
