"""model.png: the symbol of a synchronous generator, a circle with one period of a sine in it."""

import struct
import zlib
from math import hypot, pi, sin

SIZE = 96
RADIUS, LINE, AMPLITUDE, WIDTH = 42.0, 2.5, 14.0, 46.0
"""Pixels."""
INK = (31, 78, 121)


def png() -> bytes:
    """8-bit RGBA."""
    rows = []
    for y in range(SIZE):
        row = bytearray([0])  # no filter
        for x in range(SIZE):
            row += bytes((*INK, round(255 * coverage(x - SIZE / 2 + 0.5, y - SIZE / 2 + 0.5))))
        rows.append(bytes(row))
    header = struct.pack(">2I5B", SIZE, SIZE, 8, 6, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        chunk(kind, content)
        for kind, content in ((b"IHDR", header), (b"IDAT", zlib.compress(b"".join(rows), 9)), (b"IEND", b""))
    )


def coverage(x: float, y: float) -> float:
    """Of the pixel by the lines, from 0 to 1."""
    circle = abs(hypot(x, y) - RADIUS)
    steps = [WIDTH * (k / 200 - 0.5) for k in range(201)]
    sine = min(hypot(x - u, y - AMPLITUDE * sin(2 * pi * u / WIDTH)) for u in steps) if hypot(x, y) < RADIUS else 99.0
    return min(1.0, max(0.0, LINE / 2 + 0.5 - min(circle, sine)))


def chunk(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
