"""Processor sharing: jobs that are served at once, each at the same pace.

    pace(n): what each of n jobs gets per second
    v: what a job that was always there would have got; a job that comes at v with work w ends at v + w

Only the first end is an event, so that a job that comes or goes costs the logarithm of their number.
"""
import heapq


class Job:
    """Work that is being done, in seconds of an undisturbed core."""

    __slots__ = ("begin", "end", "done")

    def __init__(self, begin, end, done):
        self.begin, self.end, self.done = begin, end, done


class Sharing:
    """The cores of a host."""

    def __init__(self, events, pace):
        self.events, self.pace = events, pace
        self.members, self.virtual, self.since = 0, 0.0, 0.0
        self._heap, self._count, self._timer = [], 0, None

    def add(self, work, done):
        """Begins a job; `done()` is called at its end."""
        self._advance()
        job = Job(self.virtual, self.virtual + work, done)
        self._count += 1
        self.members += 1
        heapq.heappush(self._heap, (job.end, self._count, job))
        self._arm()
        return job

    def remove(self, job):
        """Ends a job early, and tells how much of it was done."""
        self._advance()
        job.done = None
        self.members -= 1
        self._arm()
        return min(self.virtual, job.end) - job.begin

    def _advance(self):
        now = self.events.now
        if self.members:
            self.virtual += self.pace(self.members) * (now - self.since)
        self.since = now

    def _arm(self):
        if self._timer is not None:
            self.events.cancel(self._timer)
            self._timer = None
        while self._heap and self._heap[0][2].done is None:
            heapq.heappop(self._heap)
        if self._heap:
            wait = max(0.0, self._heap[0][0] - self.virtual) / self.pace(self.members)
            self._timer = self.events.after(wait, self._ring)

    def _ring(self):
        self._advance()
        end, _, job = heapq.heappop(self._heap)
        self.virtual = max(self.virtual, end)
        self._timer = None
        self.members -= 1
        done, job.done = job.done, None
        self._arm()
        done()
