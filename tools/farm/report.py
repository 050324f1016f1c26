"""What came of runs, as rows for JSON and as a Markdown table."""
import search
from ledger import COLUMNS


def row(flight, farm, runs, tried, steps, array=None):
    """Figures of one size of farm: of its median run, with the range over the seeds.

    `array` is the most tasks that one array of the engine may have, if there is a limit.
    """
    run = search.median(runs)
    middle, least, largest = search.spread(runs)
    found = {
        "workers": farm.workers,
        "frames": len(flight),
        "frame_seconds": sum(flight.seconds),
        "chunk_frames": farm.chunk_frames,
        "makespan_s": run.makespan_s,
        "makespan_range_s": [runs[0].makespan_s, runs[-1].makespan_s],
        "efficiency": middle,
        "efficiency_range": [least, largest],
        "lost": shares_lost(run),
        "bytes_read": run.bytes_read,
        "bytes_written": run.bytes_written,
        "manifest_bytes": run.manifest_bytes,
        "storage_busy": run.storage.busy_s / run.makespan_s,
        "engine_busy": run.engine.served * farm.task_s / run.makespan_s,
        "tasks": run.engine.served,
        "arrays": -(-run.engine.served // array) if array else 1,
        "losses": run.losses,
        "wasted_frames": run.wasted_frames,
        "merge_s": run.merge_s,
        "encode_s": farm.encode_s * len(flight),
        "efficiency_by_chunk_frames": {str(frames): value for frames, value in tried.items()},
        "mended": [
            {"by": name, "efficiency": run.efficiency, "chunk_frames": frames, "lost": shares_lost(run)}
            for name, run, frames in steps
        ],
    }
    found["bottleneck"] = bottleneck(found)
    return found


def shares_lost(run):
    """Shares of all time that were not useful, by column."""
    total = run.ledger.total()
    return {name: run.ledger.seconds[name] / total for name in COLUMNS if name != "useful"}


def bottleneck(found):
    """What the farm waits for, in words."""
    if found["storage_busy"] > 0.8:
        return f"storage, busy {100 * found['storage_busy']:.0f} % of the time"
    if found["engine_busy"] > 0.8:
        return f"engine, busy {100 * found['engine_busy']:.0f} % of the time"
    name = max(found["lost"], key=found["lost"].get)
    return f"{name}: {COLUMNS[name]}"


def markdown(rows):
    """The table, and below it what does not reach the goal and what mends it."""
    names = [name for name in COLUMNS if name != "useful"]
    head = ["workers", "frames a chunk", "makespan", "efficiency", *(f"{name} %" for name in names)]
    lines = ["| " + " | ".join([*head, "read", "written", "storage busy"]) + " |"]
    lines.append("|---:" * (7 + len(names)) + "|")
    for found in rows:
        least, largest = found["efficiency_range"]
        shares = " | ".join(f"{100 * found['lost'][name]:.1f}" for name in names)
        lines.append(
            f"| {found['workers']} | {found['chunk_frames']} | {duration(found['makespan_s'])} "
            f"| {100 * found['efficiency']:.1f} % ({100 * least:.1f}–{100 * largest:.1f}) | {shares} "
            f"| {size(found['bytes_read'])} | {size(found['bytes_written'])} | {100 * found['storage_busy']:.0f} % |"
        )
    lines.append("")
    for found in rows:
        lines.append(
            f"{found['workers']} workers: the most is lost to {found['bottleneck']}. {found['tasks']} tasks in "
            f"{found['arrays']} array(s), {found['losses']} losses; manifests merge in {duration(found['merge_s'])} "
            f"and move {size(found['manifest_bytes'])}; the film takes {duration(found['encode_s'])} on one host "
            "afterwards.\n"
        )
        for step in found["mended"][1:]:
            share, frames = 100 * step["efficiency"], step["chunk_frames"]
            left = sorted(step["lost"].items(), key=lambda entry: -entry[1])[:3]
            rest = ", ".join(f"{name} {100 * part:.1f}" for name, part in left)
            lines.append(f"- and with {step['by']}: {share:.1f} % ({frames} frames a chunk; {rest} % are lost)")
    return "\n".join(lines) + "\n"


def duration(seconds):
    """Seconds, minutes or hours."""
    for unit, length in (("h", 3600.0), ("min", 60.0)):
        if seconds >= 3 * length:
            return f"{seconds / length:.1f} {unit}"
    return f"{seconds:.1f} s"


def size(count):
    """Bytes with a decimal suffix."""
    for unit, length in (("TB", 1e12), ("GB", 1e9), ("MB", 1e6)):
        if count >= length:
            return f"{count / length:.3g} {unit}"
    return f"{count:.0f} B"
