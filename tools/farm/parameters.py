"""The parameters of a farm: each with its unit, its default, and where that comes from.

"Measured" is on two cores of a Xeon with AVX-512 (virtual machine) with the demo's database, in CPU time.
"""
import dataclasses


def parameter(default, unit, source):
    """A field with its unit and the origin of its default."""
    return dataclasses.field(default=default, metadata={"unit": unit, "source": source})


@dataclasses.dataclass(frozen=True)
class Farm:
    """What a run is simulated with."""

    workers: int = parameter(1000, "threads of all processes", "the question")
    threads: int = parameter(1, "threads of a process", "`render -j`")
    thread_efficiency: float = parameter(
        0.93, "share of their time in which the threads of one process work",
        "`bench` predicts 0.93 for 4 threads, 0.46 for 16, of 720p frames",
    )
    workers_per_host: int = parameter(16, "threads of all processes of a host", "assumed")
    cores_per_host: float = parameter(16.0, "cores that nobody else uses", "assumed")
    overlap: float = parameter(
        1.0, "cores that a process of one thread uses where they are free",
        "1.4 measured of 720p PNG, whose files a second thread writes",
    )
    busy_slowdown: float = parameter(1.04, "time of a frame with all cores busy / with one", "measured on two cores")

    start_s: float = parameter(
        0.012, "s: program, database and path opened",
        "measured; the same for 245 and 10^5 frames",
    )
    database_bytes: float = parameter(19.3e9, "bytes", "docs/cli.md, Memory: 18 GiB")
    block_bytes: float = parameter(16e6, "bytes of the page cache's blocks", "assumed")
    page_cache_bytes: float = parameter(64e9, "bytes of each host for the database", "assumed")

    storage_bytes_per_s: float = parameter(2e9, "bytes/s of the shared storage, read and written", "assumed")
    host_bytes_per_s: float = parameter(1.25e9, "bytes/s of a host's network", "assumed, 10 Gbit/s")

    task_s: float = parameter(0.001, "s of the engine's controller for each task", "HyperQueue")
    latency_s: float = parameter(0.003, "s from the controller to the process", "HyperQueue: 500 processes in 2.0 s")

    slow_hosts: float = parameter(0.02, "share of hosts", "assumed")
    slow_host_factor: float = parameter(1.5, "times as long there", "assumed")
    slow_tasks: float = parameter(0.01, "share of chunks", "assumed")
    slow_task_factor: float = parameter(2.0, "times as long", "assumed")

    failure_s: float = parameter(1.8e6, "s, mean time between the losses of a worker; 0 is never", "assumed, 500 h")
    detection_s: float = parameter(60.0, "s until a loss is seen and the chunk queued again", "assumed")
    repair_s: float = parameter(120.0, "s until the worker is back after that", "assumed")

    chunk_frames: int = parameter(0, "frames of a chunk on the mean; 0 is the best of several", "searched")
    policy: str = parameter("shrinking", "count, cost, longest or shrinking", "the best of these")
    affinity: int = parameter(
        0, "1: each host keeps to its stretch of the flight while that lasts",
        "no engine here does it",
    )
    prediction_error: float = parameter(0.15, "sigma of the logarithm of predicted / true cost", "assumed")
    error_frames: int = parameter(200, "frames along which that error is alike", "assumed")
    steps: int = parameter(4, "steps of a chunk at most: compute, then write", "model")

    manifest: str = parameter(
        "parts", "parts (one for each chunk) or shared (one folder, locked)",
        "shared is `render` in one folder",
    )
    manifest_entry_s: float = parameter(
        13.4e-6, "s to read, merge and write an entry",
        "measured, 50,000 entries in 0.67 s",
    )
    manifest_entry_bytes: float = parameter(987.0, "bytes", "measured")
    encode_s: float = parameter(
        0.068, "s to encode a frame, on one host after the frames",
        "measured, 1080p of 30.6 Mpixel/s",
    )

    @property
    def processes(self):
        """Processes at once."""
        return max(1, self.workers // self.threads)

    @property
    def hosts(self):
        """Hosts, the last of which may have fewer workers."""
        return -(-self.workers // self.workers_per_host)

    def core_pace(self, processes, factor=1.0):
        """What each of so many busy processes of a host gets, 1 being as many undisturbed cores as it has threads."""
        threads = processes * self.threads
        busy = min(threads * self.overlap, self.cores_per_host)
        crowd = max(0.0, busy - 1.0) / (self.cores_per_host - 1.0) if self.cores_per_host > 1.0 else 0.0
        pace = busy / threads / (1.0 + (self.busy_slowdown - 1.0) * crowd) / factor
        return pace * self.thread_efficiency if self.threads > 1 else pace


def described():
    """A Markdown table of all parameters."""
    lines = ["| parameter | default | unit | from |", "|---|---|---|---|"]
    for field in dataclasses.fields(Farm):
        default = field.default if isinstance(field.default, str) else f"{field.default:g}"
        lines.append(f"| {field.name} | {default} | {field.metadata['unit']} | {field.metadata['source']} |")
    return "\n".join(lines) + "\n"
