"""Looks for the best chunk length, and for what would mend a farm that wastes time."""
import dataclasses
import statistics

import chunks as cutting
import farm as farms

#: Chunks for each process that are tried.
CHUNKS_PER_WORKER = (1, 2, 4, 8, 12, 16, 24, 32, 48, 64)


def one(flight, farm, seed, given=None):
    """One run with a seed; `given` are chunks that were cut elsewhere."""
    return farms.Run(flight, given or cutting.cut(flight, farm, seed), farm, seed)


def lengths(flight, farm):
    """Chunk lengths that are tried, in frames, the longest first."""
    found = {max(1, round(len(flight) / (farm.processes * number))) for number in CHUNKS_PER_WORKER}
    return sorted((frames for frames in found if len(flight) <= 25000 * frames), reverse=True)


def best_length(flight, farm, tried=None):
    """The chunk length that wastes least, and the efficiency at each length.

    Chunks are taken in one step each, which is quicker; where they are few, chance decides, and the mean of five seeds
    counts.
    """
    figures, worse = {}, 0
    for frames in tried or lengths(flight, farm):
        trial = dataclasses.replace(farm, chunk_frames=frames, steps=1)
        seeds = 5 if len(flight) < 3000 * frames else 1
        value = statistics.mean(one(flight, trial, seed).efficiency for seed in range(seeds))
        many = len(flight) > 1000 * frames
        worse = worse + 1 if many and figures and value < max(figures.values()) else 0
        figures[frames] = value
        if worse == 2:
            break
    return max(figures, key=figures.get), figures


def several(flight, farm, seeds, given=None):
    """Runs with seeds from 0 on, by makespan."""
    runs = [one(flight, farm, seed, given) for seed in range(seeds)]
    return sorted(runs, key=lambda run: run.makespan_s)


def median(runs):
    """The run with the median makespan, of runs sorted by it."""
    return runs[(len(runs) - 1) // 2]


def mends(farm):
    """Changes of a farm that could help: the columns that they make less, what they are called, their parameters."""
    quick = {"task_s": min(0.001, farm.task_s), "latency_s": min(0.003, farm.latency_s)}
    yield ("read",), "hosts that keep to stretches of the flight", {"affinity": 1, "policy": "longest"}
    if farm.threads == 1:
        yield ("read",), "processes of four threads", {"threads": 4}
    yield ("read", "write"), "storage four times as fast", {"storage_bytes_per_s": 4 * farm.storage_bytes_per_s}
    yield ("tail",), "costs predicted to 5 %", {"prediction_error": min(0.05, farm.prediction_error)}
    yield ("slow", "tail"), "no slow hosts and tasks", {"slow_hosts": 0.0, "slow_tasks": 0.0}
    yield ("engine",), "an engine that hands out a task in 1 ms", quick
    yield ("manifest",), "a manifest for each chunk", {"manifest": "parts"}
    for policy in ("longest", "shrinking"):
        if policy != farm.policy:
            yield ("tail",), f"chunks `{policy}`", {"policy": policy}


def mended(flight, farm, goal, least_gain=0.003, least_loss=0.01):
    """Mends one after the other, each time the one that helps most, until the goal is met or nothing helps.

    The answer is a list of (name, run, frames of a chunk); the first is the farm as it is.
    """
    run = one(flight, farm, 0)
    steps = [("nothing", run, farm.chunk_frames)]
    while run.efficiency < goal:
        found = []
        for columns, name, change in mends(farm):
            other = dataclasses.replace(farm, **change)
            loss = sum(run.ledger.seconds[column] for column in columns) / run.ledger.total()
            if other != farm and loss > least_loss:
                tried = sorted({max(1, farm.chunk_frames // 2), farm.chunk_frames}, reverse=True)
                frames, figures = best_length(flight, other, tried)
                found.append((figures[frames], name, dataclasses.replace(other, chunk_frames=frames)))
        if not found:
            break
        _, name, other = max(found, key=lambda entry: entry[0])
        run = one(flight, other, 0)
        if run.efficiency < steps[-1][1].efficiency + least_gain:
            break
        farm = other
        steps.append((name, run, farm.chunk_frames))
    return steps


def spread(runs):
    """Median, least and largest efficiency of some runs."""
    values = [run.efficiency for run in runs]
    return statistics.median(values), min(values), max(values)
