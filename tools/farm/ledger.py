"""Where the time of the workers went: every second of every worker stands in one column."""

#: Columns of the ledger, and what they hold.
COLUMNS = {
    "useful": "frames, at their undisturbed seconds",
    "engine": "waiting for the engine though chunks were queued",
    "start": "starting processes, and the first frames' extra cost",
    "read": "waiting for pages",
    "write": "waiting for frames to be written",
    "crowd": "cores that are shared, or slower because others are busy",
    "slow": "slow hosts and slow tasks",
    "lost": "losses: frames begun in vain, detection, repair, checking and starting again",
    "manifest": "waiting for the manifest and merging it",
    "tail": "idle with no chunk left",
}


class Ledger:
    """Seconds of workers by column."""

    def __init__(self):
        self.seconds = dict.fromkeys(COLUMNS, 0.0)

    def add(self, column, seconds):
        """Books seconds of one worker."""
        self.seconds[column] += seconds

    def total(self):
        """All seconds that were booked."""
        return sum(self.seconds.values())
