"""Reads what hprad writes as OpenEXR: one part, scanlines or tiles of one level, ZIP or no compression. Plain Python.

    picture = exr.read("box.exr")
    picture.width, picture.height, picture.channels  # {"R": array("f", ...), ...}, row 0 at the top
    picture.window, picture.display  # (left, top, right, bottom), ends included
"""
import array
import itertools
import struct
import zlib
from collections import namedtuple

Picture = namedtuple("Picture", "width height channels attributes window display", defaults=(None, None))

_MAGIC, _LONG_NAMES, _TILED = 20000630, 0x400, 0x200  # of the flags, only these may be set
_KINDS = "Ief"  # as array and struct have them: uint, half, float
_LINES = {0: 1, 2: 1, 3: 16}  # per chunk: none, ZIP by line, ZIP by 16 lines


def _text(data, at):
    end = data.index(b"\0", at)
    return data[at:end].decode(), end + 1


def _header(data):
    """({name: bytes of the value}, where the header ends)"""
    magic, version = struct.unpack_from("<II", data)
    if magic != _MAGIC or version & ~(_LONG_NAMES | _TILED) != 2:
        raise ValueError("not a single-part OpenEXR file")
    attributes, at = {}, 8
    while data[at]:
        name, at = _text(data, at)
        _, at = _text(data, at)
        size = struct.unpack_from("<I", data, at)[0]
        attributes[name] = data[at + 4:at + 4 + size]
        at += 4 + size
    return attributes, at + 1


def _channels(value):
    """[(name, kind)] in the order of the file"""
    at, found = 0, []
    while value[at]:
        name, at = _text(value, at)
        kind, _, across, down = struct.unpack_from("<IIII", value, at)
        if (across, down) != (1, 1):
            raise ValueError(f"channel {name} is not at every pixel")
        found.append((name, _KINDS[kind]))
        at += 16
    return found


def _unzip(packed, size):
    """Undoes ZIP, then the differences of neighbours, then the parting of even and odd bytes."""
    if len(packed) == size:
        return packed
    bytes_in = zlib.decompress(packed)
    whole = bytes(itertools.accumulate(bytes_in, lambda before, step: (before + step - 128) & 255))
    half, out = (size + 1) // 2, bytearray(size)
    out[0::2], out[1::2] = whole[:half], whole[half:]
    return bytes(out)


def _chunks(data, at, attributes, width, height):
    """(left, top, width, height, bytes) of every chunk, from the window's corner."""
    lines = _LINES[attributes["compression"][0]]
    if "tiles" in attributes:
        side, _, mode = struct.unpack("<IIB", attributes["tiles"])
        if mode:
            raise ValueError("tiles of several levels")
        count = ((width + side - 1) // side) * ((height + side - 1) // side)
    else:
        count = (height + lines - 1) // lines
    top = struct.unpack_from("<i", attributes["dataWindow"], 4)[0]
    for chunk in range(count):
        start = struct.unpack_from("<Q", data, at + 8 * chunk)[0]
        if "tiles" in attributes:
            column, row, _, _, size = struct.unpack_from("<iiiiI", data, start)
            left, first, start = side * column, side * row, start + 20
            yield left, first, min(side, width - left), min(side, height - first), data[start:start + size]
        else:
            first, size = struct.unpack_from("<iI", data, start)
            yield 0, first - top, width, min(lines, height - first + top), data[start + 8:start + 8 + size]


def read(path):
    with open(path, "rb") as file:
        data = file.read()
    attributes, at = _header(data)
    left, top, right, bottom = window = struct.unpack("<iiii", attributes["dataWindow"])
    width, height = right - left + 1, bottom - top + 1
    found = _channels(attributes["channels"])
    channels = {name: array.array("I" if kind == "I" else "f", bytes(4 * width * height)) for name, kind in found}
    line = sum(struct.calcsize("<" + kind) for _, kind in found)
    for x, y, wide, high, packed in _chunks(data, at, attributes, width, height):
        pixels, offset = _unzip(packed, line * wide * high), 0
        for row in range(y, y + high):
            for name, kind in found:
                values = struct.unpack_from(f"<{wide}{kind}", pixels, offset)
                offset += struct.calcsize(f"<{wide}{kind}")
                channels[name][row * width + x:row * width + x + wide] = array.array(channels[name].typecode, values)
    return Picture(width, height, channels, attributes, window, struct.unpack("<iiii", attributes["displayWindow"]))
