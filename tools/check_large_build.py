#!/usr/bin/env python3
"""Builds a 1 GiB elevation file within 512 MiB, and kills a build half-way.

    check_large_build.py PATH/TO/hedgehop [--folder DIR] [--size 16384] [--layout strips|tiles] [--deflate]

Needs about 3 GiB of disk. Says the rate and the largest resident set; exits with 1 if the set is too large, if
the database does not verify, or if anything that a killed build leaves opens as a database.
"""

import argparse
import pathlib
import resource
import signal
import subprocess
import sys
import tempfile
import time

MEMORY_MIB = 512


def build(program, raster, output):
    return subprocess.Popen(
        [program, "build", "--elevation", raster, "-o", output, "--overwrite", "--memory", f"{MEMORY_MIB}M"],
        stdout=subprocess.DEVNULL,
    )


def opens(program, file):
    silent = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    return subprocess.run([program, "info", file], **silent).returncode == 0


def build_whole(program, raster, output, size):
    begun = time.monotonic()
    process = build(program, raster, output)
    if process.wait() != 0:
        sys.exit("the build failed")
    seconds = time.monotonic() - begun
    # Kilobytes on Linux; the largest of all children so far, and this is the first that matters.
    resident = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
    print(f"{size * size / seconds / 1e6:.1f} million voxels/s ({seconds:.1f} s), {resident:.0f} MiB resident")
    if resident > MEMORY_MIB:
        sys.exit(f"more than {MEMORY_MIB} MiB were resident")
    if subprocess.run([program, "verify", output], stdout=subprocess.DEVNULL).returncode != 0:
        sys.exit("the database does not verify")


def kill_half_way(program, raster, output, bytes_whole):
    """Kills three builds by how much they have written, since a machine's speed changes under them."""
    before = set(output.parent.iterdir())
    for part in (0.05, 0.5, 0.95):
        process = build(program, raster, output)
        written = 0
        while written < part * bytes_whole and process.poll() is None:
            time.sleep(0.05)
            written = sum(file.stat().st_size for file in set(output.parent.iterdir()) - before)
        if process.poll() is not None:
            sys.exit("the build ended before it could be killed")
        process.send_signal(signal.SIGKILL)
        process.wait()
        for file in set(output.parent.iterdir()) - before:
            if opens(program, file):
                sys.exit(f"killed after {written} bytes, {file.name} opens as a database")
            file.unlink()
    print("killed builds left nothing that opens")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("--folder", help="where to put the files [default: a temporary one]")
    parser.add_argument("--size", type=int, default=16384)
    parser.add_argument("--layout", choices=["strips", "tiles"], default="strips")
    parser.add_argument("--deflate", action="store_true")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=options.folder) as folder:
        folder = pathlib.Path(folder)
        raster, output = folder / "large.tif", folder / "large.hop"
        maker = pathlib.Path(__file__).with_name("make_large_tiff.py")
        flags = ["--size", str(options.size), "--layout", options.layout] + ["--deflate"] * options.deflate
        subprocess.run([sys.executable, maker, raster, *flags], check=True)
        build_whole(options.program, raster, output, options.size)
        bytes_whole = output.stat().st_size
        output.unlink()
        kill_half_way(options.program, raster, output, bytes_whole)


if __name__ == "__main__":
    main()
