"""The engine that hands tasks to workers: one controller, who serves one worker after the other."""
import collections

#: Seconds of the controller for each task, and from there to the start of the process; tasks in one array at most.
ENGINES = {
    "local": (0.001, 0.0, None),
    "hq": (0.001, 0.003, None),
    "parallel": (0.0064, 0.0, None),
    "slurm": (0.2, 0.5, 1001),
}


class Engine:
    """Queues of tasks, one for each zone of the flight, and a queue of workers that wait for one.

    A worker gets the next task of its own zone, or of the zone that has most left. With one zone that is a plain
    queue.
    """

    def __init__(self, events, service_s, latency_s, begin, zones=1):
        self.events, self.service_s, self.latency_s, self.begin = events, service_s, latency_s, begin
        self.served = 0
        self._zones = [collections.deque() for _ in range(zones)]
        self._tasks, self._workers, self._busy = 0, collections.deque(), False

    def put(self, task, first=False):
        """Takes a task in, at the end of its zone's queue or before all others there."""
        task.ready = self.events.now
        self._tasks += 1
        zone = self._zones[task.zone % len(self._zones)]
        if first:
            zone.appendleft(task)
        else:
            zone.append(task)
        self._serve()

    def ask(self, worker):
        """Takes in a worker that has nothing to do."""
        self._workers.append(worker)
        self._serve()

    def forget(self, worker):
        """Drops a worker that was lost while it waited."""
        if worker in self._workers:
            self._workers.remove(worker)

    def _serve(self):
        if not self._busy and self._tasks and self._workers:
            self._busy = True
            self.events.after(self.service_s, self._served)

    def _served(self):
        self._busy = False
        if self._tasks and self._workers:
            self.served += 1
            self._tasks -= 1
            worker = self._workers.popleft()
            zone = self._zones[worker.zone % len(self._zones)]
            task = (zone or max(self._zones, key=len)).popleft()
            worker.given = task
            worker.timer = self.events.after(self.latency_s, self.begin, worker, task)
        self._serve()
