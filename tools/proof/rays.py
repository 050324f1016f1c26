"""A table of rays as an OpenEXR file, for screens that have no name: a dome seen from beside its centre."""

import math
import struct


def write_table(path, width, height):
    """Writes uncompressed scan lines with the channels X, Y and Z, 32-bit floats (OpenEXR file layout, version 2)."""
    header = attribute("channels", "chlist", b"".join(channel(name) for name in "XYZ") + b"\0")
    header += attribute("compression", "compression", b"\0")
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    header += attribute("dataWindow", "box2i", window) + attribute("displayWindow", "box2i", window)
    header += attribute("lineOrder", "lineOrder", b"\0")
    header += attribute("pixelAspectRatio", "float", struct.pack("<f", 1.0))
    header += attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0.0, 0.0))
    header += attribute("screenWindowWidth", "float", struct.pack("<f", 1.0))
    head = struct.pack("<II", 20000630, 2) + header + b"\0"

    line_bytes = 8 + 12 * width
    first = len(head) + 8 * height
    offsets = struct.pack(f"<{height}Q", *(first + row * line_bytes for row in range(height)))
    lines = b"".join(line(row, width, height) for row in range(height))
    path.write_bytes(head + offsets + lines)


def attribute(name, kind, value):
    return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<I", len(value)) + value


def channel(name):
    return name.encode() + b"\0" + struct.pack("<iB3xii", 2, 0, 1, 1)


def line(row, width, height):
    rays = [dome(column, row, width, height) for column in range(width)]
    samples = b"".join(struct.pack(f"<{width}f", *(ray[axis] for ray in rays)) for axis in range(3))
    return struct.pack("<iI", row, len(samples)) + samples


def dome(column, row, width, height):
    """The direction to a point of an equidistant dome of 180 degrees, from an eye below and behind its centre."""
    x, y = (2 * column + 1 - width) / height, (height - 2 * row - 1) / height
    radius = math.hypot(x, y)
    if radius > 1:
        return (0.0, 0.0, 0.0)
    angle = radius * math.pi / 2
    share = math.sin(angle) / max(radius, 1e-9)
    return (x * share, y * share + 0.3, math.cos(angle) + 0.2)
