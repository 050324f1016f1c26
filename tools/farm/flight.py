"""A flight as a farm sees it: for each frame its seconds, the part of the database it needs, and its file.

The pages that a flight needs lie one after another on a line, in the order in which they are first needed: frame i
needs the bytes from low[i] to high[i]. A chunk so reads its first view, and then what comes new.
"""
import dataclasses
import itertools
import json
import math
import random


@dataclasses.dataclass(frozen=True)
class Kind:
    """Measured frames of one kind: CPU seconds, more of them for the first, bytes of the file, seconds to check it."""

    frame_s: float
    first_s: float
    frame_bytes: float
    check_s: float
    about: str


#: Frames of the demo's flight; a mean over 3 to 244 of them.
KINDS = {
    "preview": Kind(0.029, 0.026, 1.17e6, 0.0073, "1280x720 PNG"),
    "exr": Kind(1.21, 0.0, 30.3e6, 0.19, "1920x1080 EXR with range, depth and normals"),
    "4k": Kind(1.94, 0.25, 7.3e6, 0.064, "3840x2160 PNG, --antialias 2"),
    "film": Kind(7.1, 0.0, 2.2e6, 0.015, "1920x1080 PNG, --antialias 2 --shutter 180"),
}


@dataclasses.dataclass(frozen=True)
class Flight:
    """Lists of one number a frame; seconds are those of a core that nobody else uses."""

    seconds: list
    low: list
    high: list
    written: list
    first_s: float
    check_s: float

    def __len__(self):
        return len(self.seconds)


def smooth(random_source, count, stretch):
    """A smooth random line of `count` numbers with mean 0 and variance near 1, alike along `stretch`."""
    knots = [random_source.gauss(0.0, 1.0) for _ in range(count // max(1, stretch) + 2)]
    line = []
    for i in range(count):
        knot, part = divmod(i / max(1, stretch), 1.0)
        turn = 0.5 * math.pi * part
        line.append(math.cos(turn) * knots[int(knot)] + math.sin(turn) * knots[int(knot) + 1])
    return line


def extended(values, count):
    """The values over and over, there and back, so that neighbours stay alike."""
    back = itertools.cycle(list(values) + list(reversed(values)))
    return list(itertools.islice(back, count))


def made_up(kind, count, seed=0, relief=0.35, stretch=1500, view_bytes=312e6, fresh_bytes=0.3e6):
    """A long flight with cheap and dear stretches.

    `relief` is the sigma of the logarithm of the cost, and `stretch` how many frames are alike (both assumed).
    The view is that of docs/cli.md, Memory (298 MiB, 1080p at 60 m over voxels of 1 m); what a frame needs anew is
    assumed: 8.3 m of a way 2 km wide at 9.5 bytes a voxel, twice for levels and colours.
    """
    line = smooth(random.Random(seed), count, stretch)
    costs = [math.exp(relief * value) for value in line]
    scale = kind.frame_s * count / sum(costs)
    ends = [view_bytes + fresh_bytes * i for i in range(count)]
    lows = [end - view_bytes for end in ends]
    return Flight([scale * cost for cost in costs], lows, ends, [kind.frame_bytes] * count, kind.first_s, kind.check_s)


def of_files(kind, count=None, plan=None, times=None):
    """A flight from what `hedgehop plan --json` and a table of seconds say, extended to `count` frames."""
    needs = json.loads(plan.read_text(encoding="utf-8"))["by_frame"] if plan else []
    seconds = read_times(times) if times else [kind.frame_s] * len(needs)
    count = count or len(seconds)
    seconds = extended(seconds, count)
    if not needs:
        needs = [{"bytes": 0.0, "first_bytes": 0.0}]
    views = extended([frame["bytes"] for frame in needs], count)
    fresh = extended([frame["first_bytes"] for frame in needs[1:]] or [0.0], count)
    highs = list(itertools.accumulate([views[0]] + fresh[: count - 1]))
    lows = [max(0.0, high - view) for high, view in zip(highs, views)]
    return Flight(seconds, lows, highs, [kind.frame_bytes] * count, kind.first_s, kind.check_s)


def of_chunks(kind, chunks, error, stretch, seed=0):
    """A flight whose chunks take what was predicted, but for an error that neighbouring frames share."""
    count = max(chunk.last for chunk in chunks)
    line = smooth(random.Random(seed), count, stretch)
    seconds = [0.0] * count
    for chunk in chunks:
        for frame in range(chunk.first, chunk.last):
            each = chunk.predicted_s / (chunk.last - chunk.first)
            seconds[frame] = each * math.exp(error * line[frame])
    return dataclasses.replace(made_up(kind, count), seconds=seconds)


def read_times(path):
    """Seconds of each frame: a list of numbers, a manifest.json, or what `plan --times --json` or `bench --json` writes."""
    value = json.loads(path.read_text(encoding="utf-8"))
    if isinstance(value, dict) and "by_frame" in value:
        return [frame["predicted_s"] for frame in value["by_frame"]]
    if isinstance(value, dict) and "settings_digest" in value:
        costs = [frame["cost"] for frame in value["frames"]]
        return [cost.get("cpu_s", cost["wall_s"]) for cost in costs]
    if isinstance(value, dict):
        passes = value["results"][0]["fastest_passes"]
        return [(frame["cpu_ms"] or frame["wall_ms"]) / 1000.0 for frame in passes]
    return [float(number) for number in value]
