"""Reads what hprad writes into numpy arrays: solutions, reports, studies and pictures. Nothing is computed here.

    import hprad_reader as hprad
    box = hprad.solution("box.glb")       # box["solution"]["irradiance"]: [coefficients, channels]
    cost = hprad.report("box.json")       # the report as it is
    rows = hprad.study("box_study.csv")   # rows["error_l2"]: one array per column
    image = hprad.picture("box.exr")      # image["R"]: [height, width], row 0 at the top
"""
import csv
import json
import struct
import zlib

import numpy as np


def solution(path):
    """The extension HPRAD_radiosity of a solution, each array, those of textures too, in the place of its description
    (src/io/solution_format.h says what it holds); numbers that are not finite are floats as the others."""
    with open(path, "rb") as file:
        data = file.read()
    if data[:4] != b"glTF":
        raise ValueError(f"{path} is no .glb")
    length = struct.unpack_from("<I", data, 12)[0]
    gltf = json.loads(data[20:20 + length])
    if "HPRAD_radiosity" not in gltf.get("extensions", {}):
        raise ValueError(f"{path} is no solution of hprad")

    def take(value):
        if isinstance(value, list):
            return [take(inner) for inner in value]
        if value in ("NaN", "Infinity", "-Infinity"):
            return float(value)
        if not isinstance(value, dict):
            return value
        if "componentType" not in value:
            return {key: take(inner) for key, inner in value.items()}
        shape = (value["count"], value["components"])
        if "bufferView" not in value:  # an array that is empty
            return np.zeros(shape, value["componentType"])
        start = 28 + length + gltf["bufferViews"][value["bufferView"]].get("byteOffset", 0)
        return np.frombuffer(data, value["componentType"], shape[0] * shape[1], start).reshape(shape)

    return take(gltf["extensions"]["HPRAD_radiosity"])


def report(path):
    """A report as dictionaries and lists; what is not known is None."""
    with open(path, encoding="utf-8") as file:
        return json.load(file)


def study(path):
    """{column: array} of a study, or of any other table that hprad writes: numbers as float64, NaN where a field is
    empty; a column with other text is an array of text."""
    with open(path, encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))

    def column(values):
        try:
            return np.array([float(value) if value else np.nan for value in values])
        except ValueError:
            return np.array(values)

    return {name: column([row[i] for row in rows[1:]]) for i, name in enumerate(rows[0])}


def _text(data, at):
    end = data.index(b"\0", at)
    return data[at:end].decode(), end + 1


def _header(data):
    attributes, at = {}, 8
    while data[at]:
        name, at = _text(data, at)
        _, at = _text(data, at)
        size = struct.unpack_from("<I", data, at)[0]
        attributes[name] = data[at + 4:at + 4 + size]
        at += 4 + size
    return attributes, at + 1


def _channels(value):
    """[(name, type)] in the order of the file."""
    at, found = 0, []
    while value[at]:
        name, at = _text(value, at)
        kind, _, across, down = struct.unpack_from("<IIII", value, at)
        if (across, down) != (1, 1):
            raise ValueError(f"channel {name} is not at every pixel")
        found.append((name, ("<u4", "<f2", "<f4")[kind]))
        at += 16
    return found


def _unzip(packed, size):
    if len(packed) == size:
        return packed
    steps = np.frombuffer(zlib.decompress(packed), np.uint8).astype(np.int64)
    steps[1:] -= 128
    halves = np.cumsum(steps).astype(np.uint8)
    whole = np.empty(size, np.uint8)
    whole[0::2], whole[1::2] = halves[:(size + 1) // 2], halves[(size + 1) // 2:]
    return whole.tobytes()


def _boxes(data, at, attributes, size):
    """(x, y, width, height, bytes) of every chunk, scanlines or tiles of one level, from the corner of the picture."""
    width, height = size
    lines = {0: 1, 2: 1, 3: 16}[attributes["compression"][0]]
    tiled = "tiles" in attributes
    wide, high = struct.unpack_from("<II", attributes["tiles"]) if tiled else (width, lines)
    top = struct.unpack_from("<i", attributes["dataWindow"], 4)[0]
    for start in struct.unpack_from(f"<{-(-width // wide) * -(-height // high)}Q", data, at):
        if tiled:
            column, row, _, _, count = struct.unpack_from("<iiiiI", data, start)
            x, y, start = wide * column, high * row, start + 20
        else:
            y, count = struct.unpack_from("<iI", data, start)
            x, y, start = 0, y - top, start + 8
        yield x, y, min(wide, width - x), min(high, height - y), data[start:start + count]


def picture(path):
    """{channel: array [height, width]} of a picture of hprad, with whatever layers, --half or --tiled: floats of 32 or 16
    bits, numbers (patchId, elementId) as uint32. A crop has the pixels of its window only."""
    with open(path, "rb") as file:
        data = file.read()
    if struct.unpack_from("<I", data)[0] != 20000630:
        raise ValueError(f"{path} is no OpenEXR file")
    attributes, at = _header(data)
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
    size, channels = (x1 - x0 + 1, y1 - y0 + 1), _channels(attributes["channels"])
    image = {name: np.empty(size[::-1], kind) for name, kind in channels}
    line = sum(np.dtype(kind).itemsize for _, kind in channels)
    for x, y, wide, high, packed in _boxes(data, at, attributes, size):
        pixels, offset = _unzip(packed, line * wide * high), 0
        for row in range(y, y + high):
            for name, kind in channels:
                image[name][row, x:x + wide] = np.frombuffer(pixels, kind, wide, offset)
                offset += wide * image[name].itemsize
    return image
