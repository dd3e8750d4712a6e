"""Small pictures for the textures of test scenes, and bytes as a URI."""
import base64
import struct
import zlib


def png(rows):
    """A PNG of these rows of (r, g, b)."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    raw = b"".join(b"\0" + bytes(x for pixel in row for x in pixel) for row in rows)
    head = struct.pack(">IIBBBBB", len(rows[0]), len(rows), 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(raw)) + chunk(b"IEND", b"")


def uri(kind, data):
    return f"data:{kind};base64," + base64.b64encode(data).decode()
