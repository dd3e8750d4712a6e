#!/usr/bin/env python3
"""Writes a glTF scene that is the same problem in another guise, or with other lamps.

    vary_scene.py IN.gltf OUT.gltf [--turn DEGREES] [--scale FACTOR] [--shift N] [--reflectance R]

--turn: everything turned about the axis (1, 2, 3), so that no edge lies along an axis; --scale: all emission times
FACTOR; --shift: the emission of each material goes to the N-th after it; --reflectance: of all surfaces that reflect.
Buffers stay where they are. Python 3 standard library only."""
import argparse
import json
import math
import os


def turn(gltf, degrees):
    length, half = math.sqrt(14), math.radians(degrees) / 2
    rotation = [math.sin(half) * x / length for x in (1, 2, 3)] + [math.cos(half)]
    for scene in gltf["scenes"]:
        gltf["nodes"].append({"name": "turned", "rotation": rotation, "children": scene["nodes"]})
        scene["nodes"] = [len(gltf["nodes"]) - 1]


def emission(material):
    strength = material.get("extensions", {}).get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1)
    return [strength * x for x in material.get("emissiveFactor", [0, 0, 0])]


def emit(gltf, material, radiance):
    material.pop("emissiveFactor", None)
    material.get("extensions", {}).pop("KHR_materials_emissive_strength", None)
    strength = max(radiance)
    if strength > 0:
        material["emissiveFactor"] = [x / strength for x in radiance]
        material.setdefault("extensions", {})["KHR_materials_emissive_strength"] = {"emissiveStrength": strength}
        used = gltf.setdefault("extensionsUsed", [])
        if "KHR_materials_emissive_strength" not in used:
            used.append("KHR_materials_emissive_strength")
    if not material.get("extensions", True):
        del material["extensions"]


def reflect(material, reflectance):
    pbr = material.setdefault("pbrMetallicRoughness", {})
    colour = pbr.get("baseColorFactor", [1, 1, 1, 1])
    if max(colour[:3]) > 0:
        pbr["baseColorFactor"] = [*[reflectance] * 3, colour[3]]


def vary(source, target, degrees=0, scale=1, shift=0, reflectance=0):
    with open(source, encoding="utf-8") as file:
        gltf = json.load(file)
    folder = os.path.dirname(os.path.abspath(source))
    for buffer in gltf["buffers"]:
        if not buffer["uri"].startswith("data:"):
            buffer["uri"] = os.path.relpath(os.path.join(folder, buffer["uri"]), os.path.dirname(os.path.abspath(target)))
    radiance = [emission(m) for m in gltf["materials"]]
    for i, material in enumerate(gltf["materials"]):
        emit(gltf, material, [scale * x for x in radiance[(i - shift) % len(radiance)]])
    for material in gltf["materials"] if reflectance else ():
        reflect(material, reflectance)
    if degrees:
        turn(gltf, degrees)
    with open(target, "w", encoding="utf-8") as file:
        json.dump(gltf, file, indent=1)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("source")
    parser.add_argument("target")
    parser.add_argument("--turn", type=float, default=0)
    parser.add_argument("--scale", type=float, default=1)
    parser.add_argument("--shift", type=int, default=0)
    parser.add_argument("--reflectance", type=float, default=0)
    a = parser.parse_args()
    vary(a.source, a.target, a.turn, a.scale, a.shift, a.reflectance)


if __name__ == "__main__":
    main()
