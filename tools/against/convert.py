#!/usr/bin/env python3
"""Turn a raw heightfield scene into inputs of `hedgehop build` and a path file.

    convert.py --heights H.f32 --rgb C.raw --size N --poses P.txt --out DIR

Inputs: N*N float32 heights and N*N RGB bytes, sample (i, j) at x = i, y = j, row j = 0 first; poses as
lines `x y z roll pitch yaw` in degrees with yaw 0 along +x and +90 along +y.

Outputs: DIR/elevation.f32 and DIR/imagery.png with the northernmost row first, DIR/imagery.pgw, and
DIR/NAME.csv with one pose a second. Hedgehop's x is i + 0.5, its y is j + 0.5 (a sample is the centre
of a voxel), and its yaw is clockwise from north.

Build with:  hedgehop build --elevation DIR/elevation.f32 --imagery DIR/imagery.png --local --spacing 1 -o DIR/scene.hop
and, from 8192 on, --memory 8G: a PNG is decoded whole.
"""
import argparse
import pathlib
import struct
import zlib


def png_chunk(kind, body):
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def path_csv(poses):
    """A path file of hedgehop with one pose a second, from lines `x y z roll pitch yaw`; # begins a comment."""
    lines = ["t_s,x_m,y_m,alt_msl_m,yaw_deg,pitch_deg,roll_deg"]
    for second, line in enumerate(pose_lines(poses)):
        x, y, z, roll, pitch, yaw = map(float, line.split())
        lines.append(f"{second},{x + 0.5},{y + 0.5},{z},{(90 - yaw) % 360},{pitch},{roll}")
    return "\n".join(lines) + "\n"


def pose_lines(poses):
    """The lines of `poses` that hold a pose."""
    return [line for line in poses.splitlines() if line.strip() and not line.startswith("#")]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--heights", required=True, type=pathlib.Path)
    parser.add_argument("--rgb", required=True, type=pathlib.Path)
    parser.add_argument("--size", required=True, type=int)
    parser.add_argument("--poses", required=True, type=pathlib.Path, action="append")
    parser.add_argument("--out", required=True, type=pathlib.Path)
    args = parser.parse_args()
    size, out = args.size, args.out
    out.mkdir(parents=True, exist_ok=True)

    with open(args.heights, "rb") as source, open(out / "elevation.f32", "wb") as target:
        for row in reversed(range(size)):
            source.seek(row * size * 4)
            target.write(source.read(size * 4))

    pack = zlib.compressobj(1)
    body = bytearray()
    with open(args.rgb, "rb") as source:
        for row in reversed(range(size)):
            source.seek(row * size * 3)
            body += pack.compress(b"\0" + source.read(size * 3))
    body += pack.flush()
    header = struct.pack(">IIBBBBB", size, size, 8, 2, 0, 0, 0)
    (out / "imagery.png").write_bytes(
        b"\x89PNG\r\n\x1a\n" + png_chunk(b"IHDR", header) + png_chunk(b"IDAT", bytes(body)) + png_chunk(b"IEND", b"")
    )
    # World file: pixel size, rotation, centre of the north-west pixel.
    (out / "imagery.pgw").write_text(f"1\n0\n0\n-1\n0.5\n{size - 0.5}\n")

    for poses in args.poses:
        (out / f"{poses.stem}.csv").write_text(path_csv(poses.read_text()))


if __name__ == "__main__":
    main()
