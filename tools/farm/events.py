"""A clock that runs from event to event.

Events of one moment come in the order in which they were asked for, so that a run is the same every time.
"""
import heapq


class Events:
    """Simulated time in seconds from 0, and what is to happen when."""

    def __init__(self):
        self.now = 0.0
        self.count = 0
        self._heap = []

    def at(self, time, call, *words):
        """Asks for `call(*words)` at a time that is not past; the answer is for `cancel`."""
        self.count += 1
        event = [max(time, self.now), self.count, call, words]
        heapq.heappush(self._heap, event)
        return event

    def after(self, seconds, call, *words):
        """Asks for a call so many seconds from now."""
        return self.at(self.now + seconds, call, *words)

    @staticmethod
    def cancel(event):
        """Takes an event back, also one that has happened."""
        event[2] = None

    def run(self, finished):
        """Goes on until `finished()` or nothing is left to happen."""
        while self._heap and not finished():
            time, _, call, words = heapq.heappop(self._heap)
            if call is not None:
                self.now = time
                call(*words)
