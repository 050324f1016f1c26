#!/usr/bin/env python3
"""Hedgehop against other renderers: the same terrain, poses and size, one worker, in one run on one machine.

    run.py --peers DIR --data DIR --terrain 4096=scene.hop [--terrain 16384=...] [--path open,climb] [--json FILE]

docs/peers.md says what belongs into the two folders, what is compared, and how to read the table. Peers that
are not installed are listed with what they need.

    for each terrain and path:
        repeat ROUNDS times: for each peer: run the peer, run hedgehop
        each pose: the least CPU time of the peer, and the least disturbed frame of hedgehop beside that peer
        ratio = CPU time of the peer / CPU time of hedgehop, over all poses
"""
import argparse
import json
import pathlib
import platform
import re
import shlex
import shutil
import sys
import tempfile

import agreement
import convert
import peers
import tables

ROOT = pathlib.Path(__file__).resolve().parents[2]

#: Stages of `hedgehop bench` that find the surface and colour it.
MARCH_SHADE = ("march_ms", "shade_ms")

#: What bench says of itself, by the names that the rows have for it after `hedgehop_`.
IDENTITY = {"version": "hedgehop", "engine": "engine", "simd": "simd", "frames_by_reference": "frames_by_reference"}


class BenchError(Exception):
    """Hedgehop's figures cannot be had."""


def say(text):
    print(text, file=sys.stderr, flush=True)


def bench(program, area, csv, screen, options, poses, dump=None):
    """What `hedgehop bench --json` says: (what was measured, one frame of figures for each pose)."""
    command = [program, "bench", area, "--path", csv, "--fps", 1, "--frames", f"1-{poses}"]
    command += ["--size", f"{screen.width}x{screen.height}", "--hfov", screen.hfov]
    command += ["--workers", 1, "--repeats", options.runs, "--json", "-", "--progress", "none"]
    command += ["--engine", options.engine]
    command += ["--dump-ranges", dump] if dump else []
    text = peers.output([str(word) for word in [*command, *options.hedgehop_args]])
    return bench_figures(text, poses)


def bench_figures(text, poses):
    """Reads the JSON of bench."""
    try:
        report = json.loads(text)
        frames = report["results"][0]["fastest_passes"]
        figures = [hedgehop_frame(frame) for frame in frames]
        identity = {f"hedgehop_{key}": report[name] for key, name in IDENTITY.items()}
    except (ValueError, LookupError, TypeError, AttributeError) as error:
        raise BenchError(f"the JSON of `hedgehop bench` is not as expected: {error!r}") from error
    if len(figures) != poses:
        raise BenchError(f"`hedgehop bench` measured {len(figures)} frames of {poses} poses")
    return identity, figures


def hedgehop_frame(frame):
    """One frame of one worker in CPU milliseconds.

    Bench states its stages in wall time. What else the machine did meanwhile is taken off in proportion:
    by CPU time over wall time of the whole frame, which is 1 on a quiet machine.
    """
    wall = frame["wall_ms"]
    cpu = frame["cpu_ms"] if frame.get("cpu_ms") is not None else wall
    share = min(1.0, cpu / wall)
    stages = sum(frame[stage] for stage in MARCH_SHADE)
    return {"wall_ms": wall, "frame_ms": cpu, "march_shade_ms": stages * share, "cpu_share": share}


class Duel:
    """One peer beside hedgehop on one scene: the best of every pose so far."""

    def __init__(self, peer, scene):
        self.peer, self.scene = peer, scene
        self.theirs, self.ours, self.agreement = [], [], {}
        self.version = self.failed = ""

    def add(self, theirs, ours):
        """Takes in one round: lists over the poses."""
        if len(theirs) != len(ours):
            raise peers.PeerError(f"{self.peer.name} rendered {len(theirs)} of {len(ours)} poses")
        self.theirs = [min(pair) for pair in zip(self.theirs or theirs, theirs)]
        self.ours = [min(pair, key=lambda frame: frame["wall_ms"]) for pair in zip(self.ours or ours, ours)]

    def row(self, screen, versions):
        """The figures, as docs/peers.md names them."""
        count = len(self.theirs)
        mean = lambda key: sum(frame[key] for frame in self.ours) / count
        theirs, march_shade, frame = sum(self.theirs) / count, mean("march_shade_ms"), mean("frame_ms")
        per_second = lambda milliseconds: screen.width * screen.height * 1000.0 / milliseconds
        return {
            "peer": self.peer.name,
            "terrain": str(self.scene.size),
            "path": self.scene.path,
            "ratio_march_shade": theirs / march_shade,
            "ratio_frame": theirs / frame,
            **self.agreement,
            "peer_ms": theirs,
            "hedgehop_march_shade_ms": march_shade,
            "hedgehop_frame_ms": frame,
            "peer_pixels_per_cpu_s": per_second(theirs),
            "hedgehop_march_shade_pixels_per_cpu_s": per_second(march_shade),
            "hedgehop_frame_pixels_per_cpu_s": per_second(frame),
            "hedgehop_cpu_share": mean("cpu_share"),
            "ratio_march_shade_of_poses": [a / b["march_shade_ms"] for a, b in zip(self.theirs, self.ours)],
            "ratio_frame_of_poses": [a / b["frame_ms"] for a, b in zip(self.theirs, self.ours)],
            "size": [screen.width, screen.height],
            "family": self.peer.family,
            "remark": self.peer.remark,
            "ranges_comparable": self.peer.ranges_comparable,
            "peer_version": self.version,
            **versions,
        }


def compare_ranges(duel, screen, theirs, ours, poses):
    """How the range images agree; frame N of hedgehop is pose N - 1."""
    pixels = screen.width * screen.height
    pairs = (
        (
            agreement.read(theirs / f"range_{pose}.f32", pixels),
            agreement.read(ours / f"range_{pose + 1}.f32", pixels),
        )
        for pose in range(poses)
    )
    duel.agreement = agreement.agreement(pairs)


def duel_round(duel, found, screen, options, job, number):
    """One run of the peer, one of hedgehop; the first of them compares ranges too."""
    name = f"{duel.peer.name}, {duel.scene.path} {duel.scene.size}, round {number + 1} of {options.rounds}"
    with tempfile.TemporaryDirectory(dir=job["folder"]) as out:
        out, first = pathlib.Path(out), number == 0
        always = isinstance(duel.peer, peers.Script)
        command = duel.peer.command(found, duel.scene, screen, options.runs, out if first or always else None)
        text = peers.output(command, duel.peer.environment())
        theirs = duel.peer.cpu_ms(text)
        duel.version = duel.version or duel.peer.version(text)
        if first:
            compare_ranges(duel, screen, out, job["ranges"], job["poses"])
    _, ours = bench(options.hedgehop, job["area"], job["csv"], screen, options, job["poses"])
    duel.add(theirs, ours)
    say(f"{name}: {sum(theirs) / len(theirs):.1f} ms; hedgehop {sum(f['frame_ms'] for f in ours) / len(ours):.1f} ms")


def run_scene(scene, area, found, screen, options, folder):
    """All peers on one scene: (rows, skipped)."""
    skipped, duels = [], []
    for peer in options.only:
        reason = peer.missing(found, scene, peers.free_memory())
        if reason is None:
            duels.append(Duel(peer, scene))
        else:
            skipped.append((peer.name, scene, reason))
    if not duels:
        return [], skipped
    text = scene.poses.read_text(encoding="utf-8")
    poses = len(convert.pose_lines(text))
    ranges, csv = folder / f"ranges_{scene.path}_{scene.size}", folder / f"{scene.path}_{scene.size}.csv"
    csv.write_text(convert.path_csv(text), encoding="utf-8")
    # An untimed run, so that the ranges are there before the first round and the database is in memory.
    identity, _ = bench(options.hedgehop, area, csv, screen, options, poses, dump=ranges)
    job = {"area": area, "csv": csv, "ranges": ranges, "poses": poses, "folder": folder}
    for number in range(options.rounds):
        for duel in duels:
            if duel.failed:
                continue
            try:
                duel_round(duel, found, screen, options, job, number)
            except (peers.PeerError, agreement.RangeError) as error:
                duel.failed = str(error)
                say(f"{duel.peer.name}: {error}")
    shutil.rmtree(ranges)
    skipped += [(duel.peer.name, scene, duel.failed) for duel in duels if duel.failed]
    versions = {**identity, "processor": processor()}
    return [duel.row(screen, versions) for duel in duels if not duel.failed], skipped


def mark_best(rows):
    """Of each family's peers on a scene, marks the one that is fastest."""
    for row in rows:
        rivals = [r for r in rows if all(r[key] == row[key] for key in ("family", "terrain", "path"))]
        row["best_of_family"] = row is min(rivals, key=lambda rival: rival["peer_ms"])


def processor():
    """Name of the processor."""
    try:
        text = pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace")
    except OSError:
        text = ""
    match = re.search(r"^model name\s*: *(.+)$", text, re.MULTILINE)
    return match[1].strip() if match else platform.processor() or platform.machine()


def terrain(text):
    """SIZE=AREA.hop."""
    size, _, area = text.partition("=")
    if not size.isdigit() or not area:
        raise argparse.ArgumentTypeError(f"`{text}` is not SIZE=AREA.hop, such as 4096=scene.hop")
    return int(size), pathlib.Path(area)


def screen_size(text):
    """WIDTHxHEIGHT."""
    match = re.fullmatch(r"([1-9]\d*)x([1-9]\d*)", text)
    if match is None:
        raise argparse.ArgumentTypeError(f"`{text}` is not WIDTHxHEIGHT, such as 1920x1080")
    return int(match[1]), int(match[2])


def chosen(text):
    """Peers by name or family, separated by commas."""
    wanted = names(text)
    known = {name for peer in peers.ALL for name in (peer.name, peer.family)}
    for name in wanted:
        if name not in known:
            raise argparse.ArgumentTypeError(f"no peer `{name}`; known are {', '.join(sorted(known))}")
    return [peer for peer in peers.ALL if peer.name in wanted or peer.family in wanted]


def names(text):
    """Words separated by commas."""
    return text.split(",")


def positive(text):
    """A whole number from 1."""
    if not text.isdigit() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"`{text}` is not a whole number from 1")
    return int(text)


def arguments(words):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add = parser.add_argument
    folder, whole = pathlib.Path, {"metavar": "N", "type": positive}
    add("--peers", metavar="DIR", type=folder, action="append", default=[], help="folder of the peers; may be repeated")
    add("--data", metavar="DIR", type=folder, required=True, help="height_SIZE.f32, rgb_SIZE.raw, PATH_SIZE.txt")
    area = "hedgehop's database of the terrain of SIZE x SIZE samples; may be repeated"
    add("--terrain", metavar="SIZE=AREA.hop", type=terrain, action="append", required=True, help=area)
    add("--path", metavar="NAME,...", type=names, default=["open", "climb"], help="paths [default: open,climb]")
    add("--size", metavar="WxH", type=screen_size, default=(1920, 1080), help="pixels [default: 1920x1080]")
    add("--hfov", metavar="DEGREES", type=float, default=60.0, help="horizontal field of view [default: 60]")
    add("--rounds", **whole, default=3, help="alternations of peer and hedgehop [default: 3]")
    add("--runs", **whole, default=3, help="frames of each pose in each round [default: 3]")
    add("--only", metavar="PEER,...", type=chosen, default=list(peers.ALL), help="peers or families [default: all]")
    add("--hedgehop", metavar="PROGRAM", help="[default: target/release/hedgehop, else hedgehop on the PATH]")
    engine = "hedgehop's engine [default: planes]"
    add("--engine", choices=["planes", "reference"], default="planes", help=engine)
    add("--hedgehop-args", metavar="'FLAG ...'", type=shlex.split, default=[], help="more flags of `hedgehop bench`")
    add("--python", metavar="PROGRAM", default=sys.executable, help="runs the Python peers [default: this one]")
    add("--json", metavar="FILE", help="write the rows as JSON; - is standard output, instead of the table")
    add("--markdown", action="store_true", help="print the table as Markdown")
    return parser.parse_args(words)


def hedgehop_program(given):
    """Path of the program, or None."""
    built = ROOT / "target" / "release" / "hedgehop"
    return shutil.which(given) if given else (str(built) if built.is_file() else shutil.which("hedgehop"))


def check(options):
    """A sentence about what cannot be, or None."""
    options.hedgehop = hedgehop_program(options.hedgehop)
    if options.hedgehop is None:
        return "no hedgehop program; build it with `cargo build --release`, or name it with --hedgehop"
    for size, area in options.terrain:
        if not area.is_file():
            return f"no {area}; tools/against/convert.py turns height_{size}.f32 into what `hedgehop build` takes"
    for folder in [options.data, *options.peers]:
        if not folder.is_dir():
            return f"{folder} is no folder"
    return None


def main(words=None):
    options = arguments(words)
    wrong = check(options)
    if wrong:
        sys.exit(f"error: {wrong}")
    found = peers.Found(tuple(folder.resolve() for folder in options.peers), options.python)
    screen = peers.Screen(*options.size, options.hfov)
    rows, skipped = [], []
    try:
        with tempfile.TemporaryDirectory() as folder:
            for size, area in options.terrain:
                for path in options.path:
                    scene = peers.Scene(options.data.resolve(), size, path)
                    more, lacking = run_scene(scene, area, found, screen, options, pathlib.Path(folder))
                    rows += more
                    skipped += lacking
    except (BenchError, peers.PeerError) as error:
        sys.exit(f"error: {error}")
    mark_best(rows)
    if options.json:
        text = json.dumps(rows, indent=2) + "\n"
        if options.json == "-":
            sys.stdout.write(text)
        else:
            pathlib.Path(options.json).write_text(text, encoding="utf-8")
    if options.json != "-":
        print(tables.render(rows, skipped, screen, options.markdown), end="")
    sys.exit(0 if rows else 1)


if __name__ == "__main__":
    main()
