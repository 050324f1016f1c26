"""Shared storage: one bandwidth for all, a network rate for each host, and processor sharing in both.

    hosts with transfers get the same rate, r = min(host's network, total / number of such hosts)
    the transfers of a host share its rate

V is what a host that was always there would have got; a host's own clock v runs at dV / transfers of it. The next
end of a host's transfers is known in V, and stays true while other hosts come and go.
"""
import heapq


class Transfer:
    """Bytes on their way between the storage and a host."""

    __slots__ = ("lane", "begin", "end", "done")

    def __init__(self, lane, begin, end, done):
        self.lane, self.begin, self.end, self.done = lane, begin, end, done


class Lane:
    """The transfers of one host."""

    def __init__(self):
        self.members, self.virtual, self.since, self.version = 0, 0.0, 0.0, 0
        self.heap = []

    def advance(self, total):
        """Brings the lane's clock up to V."""
        if self.members:
            self.virtual += (total - self.since) / self.members
        self.since = total

    def first(self):
        """The transfer that ends first, or None."""
        while self.heap and self.heap[0][2].done is None:
            heapq.heappop(self.heap)
        return self.heap[0][2] if self.heap else None


class Storage:
    """All transfers of a farm; rates in bytes per second."""

    def __init__(self, events, total_rate, host_rate):
        self.events, self.total_rate, self.host_rate = events, total_rate, host_rate
        self.busy_s, self.moved = 0.0, 0.0
        self._virtual, self._since, self._active, self._count = 0.0, 0.0, 0, 0
        self._heap, self._timer, self._lanes = [], None, {}

    def add(self, host, size, done):
        """Begins a transfer of `size` bytes; `done()` is called at its end."""
        self._advance()
        lane = self._lanes.setdefault(host, Lane())
        lane.advance(self._virtual)
        transfer = Transfer(lane, lane.virtual, lane.virtual + size, done)
        self._count += 1
        heapq.heappush(lane.heap, (transfer.end, self._count, transfer))
        self._active += lane.members == 0
        lane.members += 1
        self._changed(lane)
        return transfer

    def remove(self, transfer):
        """Ends a transfer early, and tells the bytes that were moved."""
        self._advance()
        lane = transfer.lane
        lane.advance(self._virtual)
        transfer.done = None
        moved = min(lane.virtual, transfer.end) - transfer.begin
        self.moved += moved
        self._left(lane)
        return moved

    def _rate(self):
        return min(self.host_rate, self.total_rate / max(1, self._active))

    def _advance(self):
        now = self.events.now
        if self._active:
            rate = self._rate()
            self._virtual += rate * (now - self._since)
            self.busy_s += rate * self._active / self.total_rate * (now - self._since)
        self._since = now

    def _left(self, lane):
        lane.members -= 1
        self._active -= lane.members == 0
        self._changed(lane)

    def _changed(self, lane):
        lane.version += 1
        first = lane.first()
        if first is not None:
            end = self._virtual + max(0.0, first.end - lane.virtual) * lane.members
            self._count += 1
            heapq.heappush(self._heap, (end, self._count, lane.version, lane))
        self._arm()

    def _arm(self):
        if self._timer is not None:
            self.events.cancel(self._timer)
            self._timer = None
        while self._heap and self._heap[0][2] != self._heap[0][3].version:
            heapq.heappop(self._heap)
        if self._heap:
            wait = max(0.0, self._heap[0][0] - self._virtual) / self._rate()
            self._timer = self.events.after(wait, self._ring)

    def _ring(self):
        self._timer = None
        self._advance()
        end, _, _, lane = heapq.heappop(self._heap)
        self._virtual = max(self._virtual, end)
        lane.advance(self._virtual)
        transfer = lane.first()
        heapq.heappop(lane.heap)
        lane.virtual = max(lane.virtual, transfer.end)
        self.moved += transfer.end - transfer.begin
        done, transfer.done = transfer.done, None
        self._left(lane)
        done()
