#!/usr/bin/env python3
"""Writes a large float32 elevation GeoTIFF (EPSG:32633, 10 m) with nothing but the standard library.

    make_large_tiff.py OUT.tif [--size 16384] [--layout strips|tiles] [--deflate]

Every row is a stretch of one long profile of summed sines, so that 1 GiB is written in seconds; the height of
pixel (column, row) is profile[column + shift(row)].
"""

import argparse
import array
import math
import struct
import sys
import zlib

STRIP_ROWS = 16
TILE = 256


def profile(length):
    """Heights between about 200 and 1800 m, smooth from one to the next."""
    waves = [(600.0, 0.0011), (150.0, 0.0073), (40.0, 0.041), (6.0, 0.37)]
    return array.array("f", (1000.0 + sum(a * math.sin(k * i) for a, k in waves) for i in range(length)))


def shift(row, size):
    """Where a row's stretch begins: a slow wave, so that rows resemble their neighbours."""
    return int(size / 8 * (1.0 + math.sin(row * 0.003)))


def blocks(size, layout):
    """The file's blocks as bytes, in order."""
    line = profile(size + size // 4 + TILE + 1)
    if sys.byteorder == "big":
        line.byteswap()
    data, item = memoryview(line.tobytes()), line.itemsize
    row = lambda r, start, count: data[(shift(r, size) + start) * item : (shift(r, size) + start + count) * item]
    if layout == "strips":
        for top in range(0, size, STRIP_ROWS):
            yield b"".join(row(r, 0, size) for r in range(top, min(top + STRIP_ROWS, size)))
    else:
        for top in range(0, size, TILE):
            for left in range(0, size, TILE):
                yield b"".join(row(min(r, size - 1), left, TILE) for r in range(top, top + TILE))


def entry(tag, kind, values):
    """One field of the directory: its head, and the bytes that do not fit into it."""
    code = {"H": 3, "I": 4, "d": 12}[kind]
    body = struct.pack(f"<{len(values)}{kind}", *values)
    return (tag, code, len(values), body)


def directory(size, layout, deflate, offsets, counts, at):
    """The image file directory as it lies at byte `at`."""
    fields = [
        entry(256, "I", [size]),
        entry(257, "I", [size]),
        entry(258, "H", [32]),
        entry(259, "H", [8 if deflate else 1]),
        entry(262, "H", [1]),
        entry(277, "H", [1]),
        entry(339, "H", [3]),
        entry(33550, "d", [10.0, 10.0, 0.0]),
        entry(33922, "d", [0.0, 0.0, 0.0, 400000.0, 5500000.0, 0.0]),
        entry(34735, "H", [1, 1, 0, 3, 1024, 0, 1, 1, 1025, 0, 1, 1, 3072, 0, 1, 32633]),
    ]
    if layout == "strips":
        fields += [entry(273, "I", offsets), entry(278, "H", [STRIP_ROWS]), entry(279, "I", counts)]
    else:
        fields += [entry(322, "H", [TILE]), entry(323, "H", [TILE]), entry(324, "I", offsets), entry(325, "I", counts)]
    fields.sort()
    head, tail = struct.pack("<H", len(fields)), b""
    after = at + 2 + 12 * len(fields) + 4
    for tag, code, count, body in fields:
        if len(body) <= 4:
            value = body.ljust(4, b"\0")
        else:
            value = struct.pack("<I", after + len(tail))
            tail += body
        head += struct.pack("<HHI", tag, code, count) + value
    return head + struct.pack("<I", 0) + tail


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out")
    parser.add_argument("--size", type=int, default=16384, help="pixels along a side, a multiple of 256")
    parser.add_argument("--layout", choices=["strips", "tiles"], default="strips")
    parser.add_argument("--deflate", action="store_true")
    options = parser.parse_args()
    if options.size <= 0 or options.size % TILE:
        parser.error(f"--size must be a positive multiple of {TILE}")
    offsets, counts = [], []
    with open(options.out, "wb") as out:
        out.write(struct.pack("<2sHI", b"II", 42, 0))
        for block in blocks(options.size, options.layout):
            block = zlib.compress(block, 1) if options.deflate else block
            offsets.append(out.tell())
            counts.append(out.write(block))
        out.write(b"\0" * (out.tell() % 2))
        at = out.tell()
        out.write(directory(options.size, options.layout, options.deflate, offsets, counts, at))
        out.seek(4)
        out.write(struct.pack("<I", at))


if __name__ == "__main__":
    main()
