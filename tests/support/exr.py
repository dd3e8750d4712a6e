"""Reads what hprad writes as OpenEXR: one part, scanlines, 32-bit floats, ZIP or no compression. Plain Python.

    picture = exr.read("box.exr")
    picture.width, picture.height, picture.channels  # {"R": array("f", ...), ...}, row 0 at the top
"""
import array
import itertools
import struct
import sys
import zlib
from collections import namedtuple

Picture = namedtuple("Picture", "width height channels attributes")

_MAGIC, _SIMPLE_FLAGS, _FLOAT = 20000630, 0x400, 2  # of the flags, only that of long names may be set
_LINES = {0: 1, 2: 1, 3: 16}  # per chunk: none, ZIP by line, ZIP by 16 lines


def _text(data, at):
    end = data.index(b"\0", at)
    return data[at:end].decode(), end + 1


def _header(data):
    """({name: bytes of the value}, where the header ends)"""
    magic, version = struct.unpack_from("<II", data)
    if magic != _MAGIC or version & ~_SIMPLE_FLAGS != 2:
        raise ValueError("not a single-part scanline OpenEXR file")
    attributes, at = {}, 8
    while data[at]:
        name, at = _text(data, at)
        _, at = _text(data, at)
        size = struct.unpack_from("<I", data, at)[0]
        attributes[name] = data[at + 4:at + 4 + size]
        at += 4 + size
    return attributes, at + 1


def _channel_names(value):
    at, names = 0, []
    while value[at]:
        name, at = _text(value, at)
        kind, _, across, down = struct.unpack_from("<IIII", value, at)
        if (kind, across, down) != (_FLOAT, 1, 1):
            raise ValueError(f"channel {name} is not of 32-bit floats at every pixel")
        names.append(name)
        at += 16
    return names


def _unzip(packed, size):
    """Undoes ZIP, then the differences of neighbours, then the parting of even and odd bytes."""
    if len(packed) == size:
        return packed
    bytes_in = zlib.decompress(packed)
    whole = bytes(itertools.accumulate(bytes_in, lambda before, step: (before + step - 128) & 255))
    half, out = (size + 1) // 2, bytearray(size)
    out[0::2], out[1::2] = whole[:half], whole[half:]
    return bytes(out)


def read(path):
    with open(path, "rb") as file:
        data = file.read()
    attributes, at = _header(data)
    left, top, right, bottom = struct.unpack("<iiii", attributes["dataWindow"])
    width, height, lines = right - left + 1, bottom - top + 1, _LINES[attributes["compression"][0]]
    names = _channel_names(attributes["channels"])
    rows = {name: [None] * height for name in names}
    for chunk in range((height + lines - 1) // lines):
        start = struct.unpack_from("<Q", data, at + 8 * chunk)[0]
        first, size = struct.unpack_from("<iI", data, start)
        count = min(lines, bottom - first + 1)
        pixels = _unzip(data[start + 8:start + 8 + size], 4 * width * len(names) * count)
        for i in range(count * len(names)):
            row = array.array("f", pixels[4 * width * i:4 * width * (i + 1)])
            if sys.byteorder != "little":
                row.byteswap()
            rows[names[i % len(names)]][first - top + i // len(names)] = row
    channels = {name: array.array("f", itertools.chain.from_iterable(rows[name])) for name in names}
    return Picture(width, height, channels, attributes)
