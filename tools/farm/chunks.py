"""Cuts a flight into chunks, and puts them in the order in which they are handed out."""
import bisect
import dataclasses
import itertools
import json
import math
import random

import flight as flights


@dataclasses.dataclass(frozen=True)
class Chunk:
    """Frames from `first` to before `last`, counted from 0, and what they are thought to cost."""

    first: int
    last: int
    predicted_s: float


def predicted(flight, farm, seed):
    """Predicted seconds of each frame: the true ones with an error that neighbours share."""
    line = flights.smooth(random.Random(seed + 77), len(flight), farm.error_frames)
    return [cost * math.exp(farm.prediction_error * error) for cost, error in zip(flight.seconds, line)]


def cut(flight, farm, seed):
    """The chunks of a policy.

    count: so many frames each; cost: so many predicted seconds each; longest: the same, the longest first;
    shrinking: each a share of what is left, 1 / (2 processes), and not shorter than a quarter of the mean one.
    """
    costs, frames = predicted(flight, farm, seed), len(flight)
    sums = [0.0, *itertools.accumulate(costs)]
    number = max(1, round(frames / farm.chunk_frames))
    if farm.policy == "count":
        edges = [round(frames * i / number) for i in range(number + 1)]
    elif farm.policy in ("cost", "longest"):
        edges = [bisect.bisect_left(sums, sums[-1] * i / number) for i in range(number)] + [frames]
    elif farm.policy == "shrinking":
        edges = shrinking(sums, farm.processes, sums[-1] / number)
    else:
        raise ValueError(f"no policy `{farm.policy}`; there are count, cost, longest and shrinking")
    pairs = zip(edges, edges[1:])
    chunks = [Chunk(a, b, sums[b] - sums[a]) for a, b in pairs if b > a]
    if farm.policy == "longest":
        chunks.sort(key=lambda chunk: -chunk.predicted_s)
    return chunks


def shrinking(sums, processes, mean):
    """Edges of chunks whose predicted cost shrinks with what is left."""
    edges = [0]
    while edges[-1] < len(sums) - 1:
        done = sums[edges[-1]]
        size = max((sums[-1] - done) / (2.0 * processes), mean / 4.0)
        edge = bisect.bisect_left(sums, done + min(size, 4.0 * mean))
        edges.append(min(len(sums) - 1, max(edges[-1] + 1, edge)))
    return edges


def read(path):
    """Chunks of a file: a JSON list of {"frames": "1-40", "predicted_s": 12.3}, or an object with it as "chunks"."""
    value = json.loads(path.read_text(encoding="utf-8"))
    entries = value["chunks"] if isinstance(value, dict) else value
    chunks = []
    for entry in entries:
        first, _, last = str(entry["frames"]).partition("-")
        if not first.isdigit() or not (last or first).isdigit():
            raise ValueError(f"{path}: `{entry['frames']}` is not FIRST-LAST")
        chunks.append(Chunk(int(first) - 1, int(last or first), float(entry["predicted_s"])))
    covered = sorted((chunk.first, chunk.last) for chunk in chunks)
    edges = [0] + [last for _, last in covered]
    if any(first != edge for (first, _), edge in zip(covered, edges)):
        raise ValueError(f"{path}: the chunks do not cover the frames from 1 on, each once")
    return chunks
