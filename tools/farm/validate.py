"""Real runs of several processes on this machine, beside what the simulation says of them.

    each round, in turn:
        one process renders one frame, then the whole flight      start-up, first frame, seconds of all frames
        two processes render the whole flight at once             slow-down of a core while the other is busy
        2, 3 and 4 processes render chunks that a dispatcher hands out
    the simulation has the cores that others left: in the run itself, or in the run of two processes before

Processes have one thread each. The calibration is that of the same round, in CPU time, since others disturb wall time.
With cores that others kept busy all along, the first of the two predictions tests no more than start-up, slow-down,
hand-outs and the tail; the second also that the others go on as they did.
"""
import dataclasses
import json
import os
import pathlib
import statistics
import subprocess
import tempfile
import time

import chunks as cutting
import farm as farms
import flight as flights
import parameters

#: Chunks for each of four processes.
CHUNKS = 12


@dataclasses.dataclass
class Measured:
    """Wall and CPU seconds of some processes, and core seconds of everybody else meanwhile."""

    wall_s: float
    cpu_s: float
    others_s: float
    dispatch_s: float = 0.0

    def left(self, cores):
        """Cores that others left."""
        return max(0.1, cores - self.others_s / self.wall_s)


class Machine:
    """The program, its flight and this machine."""

    def __init__(self, program, area, path, more):
        self.program, self.flight_words = program, [str(area), "--path", str(path), *more]
        self.cores = len(os.sched_getaffinity(0))

    def asked(self, command, *words):
        """The JSON that a command prints."""
        line = [self.program, command, *self.flight_words, *words, "--json"]
        line += ["-", "--progress", "none"] if command == "bench" else []
        return json.loads(subprocess.run(line, check=True, capture_output=True, text=True).stdout)

    def start(self, frames, folder):
        """Begins to render frames, such as `1-40`."""
        line = [self.program, "render", *self.flight_words, "--frames", frames, "-j", "1", "--progress", "none"]
        line += ["-o", f"{folder}/######.png"]
        return subprocess.Popen(line, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def run(self, lists, processes):
        """Renders lists of frames, so many at once, each in a folder of its own."""
        with tempfile.TemporaryDirectory() as folder:
            waiting = [(frames, pathlib.Path(folder) / str(i)) for i, frames in enumerate(lists)]
            busy, begin, cpu, handing = core_seconds(), time.perf_counter(), 0.0, 0.0
            running = {}
            while waiting or running:
                while waiting and len(running) < processes:
                    since = time.perf_counter()
                    child = self.start(*waiting.pop(0))
                    running[child.pid] = child
                    handing += time.perf_counter() - since
                pid, status, usage = os.wait4(-1, 0)
                running.pop(pid).returncode = status
                if status:
                    raise ValueError(f"{self.program}: a run ended with status {status}")
                cpu += usage.ru_utime + usage.ru_stime
            wall, busy = time.perf_counter() - begin, core_seconds() - busy
        return Measured(wall, cpu, max(0.0, busy - cpu), handing / len(lists))


def core_seconds():
    """Seconds that all cores were busy with anything, since the machine began."""
    with open("/proc/stat", encoding="ascii") as file:
        ticks = [int(word) for word in file.readline().split()[1:9]]
    return (sum(ticks) - ticks[3] - ticks[4]) / os.sysconf("SC_CLK_TCK")


def ranges(chunks):
    """Chunks as `--frames` takes them."""
    return [f"{chunk.first + 1}-{chunk.last}" for chunk in chunks]


@dataclasses.dataclass
class Calibration:
    """One process, alone and beside another: seconds of frames and of a start, its cores, how much slower two are."""

    seconds: list
    start_s: float
    busy_slowdown: float
    overlap: float
    single: Measured
    pair: Measured


def calibrate(machine, shape):
    """Measures one process that renders single frames and all, and two that render all."""
    count = len(shape)
    picked = [0, count // 2, count - 1] * 2
    alone = [machine.run([f"{frame + 1}"], 1).cpu_s for frame in picked]
    single = machine.run([f"1-{count}"], 1)
    pair = machine.run([f"1-{count}"] * 2, 2)

    scale = single.cpu_s / sum(shape)
    start_s = max(0.0, statistics.median(cpu - scale * shape[frame] for cpu, frame in zip(alone, picked)))
    scale = (single.cpu_s - start_s) / sum(shape)
    slowdown = max(1.0, pair.cpu_s / 2.0 / single.cpu_s)
    overlap = max(1.0, single.cpu_s / single.wall_s)
    return Calibration([scale * cost for cost in shape], start_s, slowdown, overlap, single, pair)


def predict(calibration, processes, cores, dispatch_s):
    """Seconds that the simulation gives for a run on so many cores."""
    count = len(calibration.seconds)
    nothing = [0.0] * count
    flight = flights.Flight(calibration.seconds, nothing, nothing, nothing, 0.0, 0.0)
    farm = dataclasses.replace(
        plain(count), workers=processes, workers_per_host=processes, cores_per_host=cores,
        busy_slowdown=calibration.busy_slowdown, overlap=calibration.overlap, start_s=calibration.start_s,
        task_s=dispatch_s,
    )
    return farms.Run(flight, cutting.cut(flight, farm, 0), farm).makespan_s


def plain(count):
    """A farm without storage, slow parts and losses, and its chunks of equal counts."""
    return parameters.Farm(
        latency_s=0.0, slow_hosts=0.0, slow_tasks=0.0, failure_s=0.0, prediction_error=0.0, policy="count",
        chunk_frames=-(-count // CHUNKS), manifest_entry_s=0.0, steps=1,
    )


def quiet(machine, patience_s=40.0):
    """Waits until others leave the cores alone for two seconds, but not for long."""
    end = time.monotonic() + patience_s
    while time.monotonic() < end:
        before = core_seconds()
        time.sleep(2.0)
        if core_seconds() - before < 0.05 * 2.0 * machine.cores:
            return


def compared(options):
    """Rows of measured and predicted seconds, of each round and number of processes."""
    if not options.area or not options.path:
        raise ValueError("--validate needs --area and --path")
    machine = Machine(options.validate, options.area, options.path, options.render_args)
    bench = machine.asked("bench", "--workers", "1", "--repeats", "1", "--frames", f"1-{frames_of(machine)}")
    shape = [frame["cpu_ms"] for frame in bench["results"][0]["fastest_passes"]]
    shape[0] = shape[1]
    encode = bench["results"][0]["encode_ms"]
    shape = [cost + encode for cost in shape]

    flight = flights.Flight(shape, [], [], [], 0.0, 0.0)
    lists, rows = ranges(cutting.cut(flight, plain(len(shape)), 0)), []
    for number in range(options.rounds):
        quiet(machine)
        calibration = calibrate(machine, shape)
        for processes in (2, 3, 4):
            run = machine.run(lists, processes)
            left, before = run.left(machine.cores), calibration.pair.left(machine.cores)
            rows.append({
                "round": number + 1,
                "processes": processes,
                "measured_s": run.wall_s,
                "predicted_s": predict(calibration, processes, left, run.dispatch_s),
                "predicted_before_s": predict(calibration, processes, before, run.dispatch_s),
                "cores": machine.cores,
                "cpu_s": run.cpu_s,
                "overlap": calibration.overlap,
                "cores_left": left,
                "cores_left_before": before,
                "start_s": calibration.start_s,
                "busy_slowdown": calibration.busy_slowdown,
                "dispatch_s": run.dispatch_s,
                "single_cpu_s": calibration.single.cpu_s,
                "single_wall_s": calibration.single.wall_s,
            })
    return rows


def frames_of(machine):
    """The number of frames of the flight."""
    return machine.asked("plan", "--no-timing")["frames"]


def markdown(rows):
    """The table of --validate, and the medians over the rounds."""
    head = ["round", "processes", "measured", "predicted", "off by", "cores left", "by the cores before", "off by"]
    head += ["cores left", "CPU", "slow-down", "start", "one process: CPU", "wall"]
    lines = ["| " + " | ".join(head) + " |", "|" + "---:|" * len(head)]
    off = lambda row, key: 100.0 * (row[key] / row["measured_s"] - 1.0)
    for row in rows:
        lines.append(
            f"| {row['round']} | {row['processes']} | {row['measured_s']:.2f} s "
            f"| {row['predicted_s']:.2f} s | {off(row, 'predicted_s'):+.1f} % | {row['cores_left']:.2f} "
            f"| {row['predicted_before_s']:.2f} s | {off(row, 'predicted_before_s'):+.1f} % "
            f"| {row['cores_left_before']:.2f} "
            f"| {row['cpu_s']:.2f} s | {row['busy_slowdown']:.3f} | {row['start_s']:.3f} s "
            f"| {row['single_cpu_s']:.2f} s | {row['single_wall_s']:.2f} s |"
        )
    lines.append("")
    for processes in sorted({row["processes"] for row in rows}):
        chosen = [row for row in rows if row["processes"] == processes]
        calm = [row for row in chosen if row["cores_left"] > 0.9 * row["cores"]]
        words = []
        for key, name, some in (
            ("predicted_s", "all runs", chosen),
            ("predicted_s", "undisturbed runs", calm),
            ("predicted_before_s", "all runs by the cores before", chosen),
        ):
            if some:
                offs = [off(row, key) for row in some]
                words.append(
                    f"{name} ({len(some)}) {statistics.median(offs):+.1f} % ({min(offs):+.1f} to {max(offs):+.1f})"
                )
        lines.append(f"{processes} processes, off by: {'; '.join(words)}")
    return "\n".join(lines) + "\n"
