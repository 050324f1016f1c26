"""The farm itself: workers on hosts that render chunks, write frames, are slow, get lost, and come back.

    a worker asks the engine; when it has a chunk:
        starts the program, and checks the frames of the chunk that are there already
        reads the pages of the first view that its host does not hold
        in some steps: computes frames while the pages that they need anew are read; writes these frames
        enters them in a manifest
    a lost worker's chunk goes back to the queue when the loss is seen; whole frames stay
"""
import bisect
import dataclasses
import itertools
import random

from engine import Engine
from events import Events
from ledger import Ledger
from pagecache import PageCache
from sharing import Sharing
from storage import Storage


class Host:
    """Cores and page cache that some workers share."""

    def __init__(self, events, farm, factor):
        self.cores = Sharing(events, lambda jobs: farm.core_pace(jobs, factor))
        self.cache = PageCache(farm.page_cache_bytes, farm.block_bytes)
        self.factor = factor


class Task:
    """A chunk on its way: the next frame to render, and how often it was begun."""

    def __init__(self, chunk, factor, zone):
        self.chunk, self.factor, self.zone = chunk, factor, zone
        self.next, self.attempts, self.ready = chunk.first, 0, 0.0


class Worker:
    """A process at a time on a host, and what it does since when."""

    def __init__(self, host, zone):
        self.host, self.zone = host, zone
        self.task, self.given, self.since = None, None, 0.0
        self.timer, self.job, self.transfer = None, None, None
        self.paged = 0.0
        self.prefix, self.step_end, self.extra, self.computed, self.lost = [], 0, 0.0, False, False


class Run:
    """One simulation: a flight, its chunks, a farm and a seed; `makespan_s`, `ledger` and counts are its results."""

    def __init__(self, flight, chunks, farm, seed=0):
        self.frame_seconds = sum(flight.seconds)
        if farm.threads > 1:
            flight = dataclasses.replace(flight, seconds=[cost / farm.threads for cost in flight.seconds])
        self.flight, self.farm = flight, farm
        self.events, self.ledger = Events(), Ledger()
        self.random = random.Random(seed)
        self.storage = Storage(self.events, farm.storage_bytes_per_s, farm.host_bytes_per_s)
        zones = farm.hosts if farm.affinity else 1
        self.engine = Engine(self.events, farm.task_s, farm.latency_s, self._begin, zones)
        self.times_done = [0] * len(flight)
        self.left = sum(chunk.last - chunk.first for chunk in chunks)
        self.losses, self.wasted_frames, self.starts, self.checked = 0, 0, 0, 0
        self.bytes_read, self.bytes_written, self.manifest_bytes = 0.0, 0.0, 0.0
        self._entries, self._manifest_free, self._open = 0, 0.0, len(chunks)

        for chunk in chunks:
            slow = self.random.random() < farm.slow_tasks
            zone = chunk.first * zones // len(flight)
            self.engine.put(Task(chunk, farm.slow_task_factor if slow else 1.0, zone))
        self.workers = list(itertools.islice(self._made_workers(), farm.processes))
        for worker in self.workers:
            self._ask(worker)
            self._live(worker)
        self.events.run(lambda: self._open == 0)
        self._close()

    def _made_workers(self):
        farm, hosts = self.farm, self.farm.hosts
        slow = set(self.random.sample(range(hosts), round(farm.slow_hosts * hosts)))
        for number in range(hosts):
            host = Host(self.events, farm, farm.slow_host_factor if number in slow else 1.0)
            for _ in range(max(1, farm.workers_per_host // farm.threads)):
                yield Worker(host, number)

    # A worker's way through a chunk.

    def _ask(self, worker):
        worker.task, worker.given, worker.since = None, None, self.events.now
        self.engine.ask(worker)

    def _begin(self, worker, task):
        now = self.events.now
        waited = now - max(worker.since, task.ready)
        self.ledger.add("engine", waited)
        self.ledger.add("tail", now - worker.since - waited)
        worker.task, worker.since, worker.timer, worker.given = task, now, None, None
        worker.prefix, worker.step_end, worker.extra, worker.computed = [], 0, 0.0, False
        task.attempts += 1
        self.starts += 1

        there = task.next - task.chunk.first
        self.checked += there
        work = self.farm.start_s + there * self.flight.check_s
        worker.job = worker.host.cores.add(work, lambda: self._started(worker))

    def _started(self, worker):
        worker.job = None
        self._book(worker, "lost" if worker.task.attempts > 1 else "start")
        worker.extra = self.flight.first_s
        task, flight = worker.task, self.flight
        worker.paged = flight.high[task.next]
        self._read(worker, flight.low[task.next], flight.high[task.next], lambda: self._viewed(worker))

    def _viewed(self, worker):
        worker.transfer = None
        self._book(worker, "read")
        self._step(worker)

    def _step(self, worker):
        """Begins to compute some frames while their pages are read."""
        task, chunk = worker.task, worker.task.chunk
        size = -(-(chunk.last - chunk.first) // self.farm.steps)
        worker.step_end = min(chunk.last, task.next + size)
        seconds = self.flight.seconds[task.next : worker.step_end]
        worker.prefix = list(itertools.accumulate(seconds))
        worker.computed = False
        work = worker.prefix[-1] * task.factor + worker.extra
        worker.job = worker.host.cores.add(work, lambda: self._computed(worker))
        low = worker.paged
        worker.paged = self.flight.high[worker.step_end - 1]
        self._read(worker, low, worker.paged, lambda: self._paged(worker))

    def _read(self, worker, low, high, done):
        size = self.farm.database_bytes
        low, high = low % size, low % size + (high - low)
        missing = worker.host.cache.take(low, min(high, size))
        missing += worker.host.cache.take(0, high - size) if high > size else 0
        self.bytes_read += missing
        if missing:
            worker.transfer = self.storage.add(worker.host, missing, done)
        else:
            worker.transfer = None
            done()

    def _computed(self, worker):
        worker.job = None
        self._book_frames(worker, worker.prefix[-1])
        worker.computed = True
        if worker.transfer is None:
            self._write(worker)

    def _paged(self, worker):
        worker.transfer = None
        if worker.computed:
            self._book(worker, "read")
            self._write(worker)

    def _write(self, worker):
        size = sum(self.flight.written[worker.task.next : worker.step_end])
        if size:
            worker.transfer = self.storage.add(worker.host, size, lambda: self._written(worker))
        else:
            self._written(worker)

    def _written(self, worker):
        worker.transfer = None
        self._book(worker, "write")
        task = worker.task
        self._finish_frames(task, worker.step_end)
        worker.extra = 0.0
        if task.next < task.chunk.last:
            self._step(worker)
        else:
            self._enter(worker)

    def _enter(self, worker):
        """Writes the manifest: a part of one's own, or the one of all, for which workers wait."""
        farm, chunk, now = self.farm, worker.task.chunk, self.events.now
        entries = chunk.last - chunk.first
        self._entries += entries
        if farm.manifest == "shared":
            size = 2.0 * self._entries * farm.manifest_entry_bytes
            self._manifest_free = max(now, self._manifest_free)
            self._manifest_free += self._entries * farm.manifest_entry_s + size / farm.host_bytes_per_s
            end = self._manifest_free
        else:
            size = entries * farm.manifest_entry_bytes
            end = now + entries * farm.manifest_entry_s
        self.manifest_bytes += size
        worker.timer = self.events.at(end, self._entered, worker)

    def _entered(self, worker):
        worker.timer = None
        self._book(worker, "manifest")
        self._open -= 1
        self._ask(worker)

    # Losses.

    def _live(self, worker):
        if self.farm.failure_s:
            wait = self.random.expovariate(1.0 / self.farm.failure_s)
            self.events.after(wait, self._lose, worker)

    def _lose(self, worker):
        """Takes a worker away; what it holds comes back when the loss is seen."""
        self.losses += 1
        worker.lost = True
        self.engine.forget(worker)
        task = worker.task or worker.given
        if worker.task is None and task is None:
            self._book(worker, "tail")
        elif worker.task is None:
            self._book(worker, "engine")
        self._interrupt(worker)
        if worker.timer is not None:
            self.events.cancel(worker.timer)
            worker.timer = None
        self._book(worker, "lost")

        worker.task, worker.given = None, None
        if task is not None:
            self.events.after(self.farm.detection_s, self._again, task)
        self.events.after(self.farm.detection_s + self.farm.repair_s, self._back, worker)

    def _interrupt(self, worker):
        """Ends what a worker computes or moves, and keeps the frames that are whole."""
        if worker.job is not None:
            progress = worker.host.cores.remove(worker.job) - worker.extra
            if worker.prefix and worker.task.next < worker.step_end:
                whole = bisect.bisect_right(worker.prefix, progress / worker.task.factor)
                self._keep(worker, whole)
            worker.job = None
        if worker.transfer is not None:
            size = worker.transfer.end - worker.transfer.begin
            moved = self.storage.remove(worker.transfer)
            if worker.computed:
                self._keep(worker, int(len(worker.prefix) * moved / size), booked=True)
            worker.transfer = None

    def _keep(self, worker, whole, booked=False):
        frames = len(worker.prefix)
        self.wasted_frames += booked * (frames - whole) + (not booked and whole < frames)
        useful = worker.prefix[whole - 1] if whole else 0.0
        if booked:
            vain = worker.prefix[-1] - useful
            self.ledger.add("useful", -vain)
            self.ledger.add("lost", vain)
        else:
            useful = min(useful, self.events.now - worker.since)
            self.ledger.add("useful", useful)
            worker.since += useful
        self._finish_frames(worker.task, worker.task.next + whole)

    def _again(self, task):
        if task.next < task.chunk.last:
            self.engine.put(task, first=True)
        else:
            self._open -= 1

    def _back(self, worker):
        worker.lost = False
        self._book(worker, "lost")
        self._ask(worker)
        self._live(worker)

    # Books.

    def _book(self, worker, column):
        now = self.events.now
        self.ledger.add(column, now - worker.since)
        worker.since = now

    def _book_frames(self, worker, useful):
        """Splits the time of computed frames: what they need, what is slow, and what sharing costs."""
        now, host, task = self.events.now, worker.host, worker.task
        work = useful * task.factor + worker.extra
        slow = work * host.factor - useful - worker.extra
        self.ledger.add("useful", useful)
        self.ledger.add("start" if task.attempts == 1 else "lost", worker.extra)
        self.ledger.add("slow", slow)
        self.ledger.add("crowd", now - worker.since - useful - worker.extra - slow)
        worker.since = now

    def _finish_frames(self, task, end):
        for frame in range(task.next, end):
            self.times_done[frame] += 1
        self.bytes_written += sum(self.flight.written[task.next : end])
        self.left -= end - task.next
        task.next = end

    def _close(self):
        """Books what workers did when the last chunk was done, and the merge of the manifests."""
        for worker in self.workers:
            self._book(worker, "lost" if worker.lost else "tail")
        merge = 0.0
        if self.farm.manifest == "parts":
            merge = self._entries * self.farm.manifest_entry_s
            self.manifest_bytes += 2.0 * self._entries * self.farm.manifest_entry_bytes
            self.ledger.add("manifest", merge * len(self.workers))
        self.merge_s = merge
        self.makespan_s = self.events.now + merge

    @property
    def efficiency(self):
        """Useful frame time over all time of all workers."""
        return self.frame_seconds / (len(self.workers) * self.farm.threads * self.makespan_s)
