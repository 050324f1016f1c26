"""The page cache of a host: blocks of the database that were read once, the least recently used going first."""
import collections


class PageCache:
    """Which blocks a host has in memory."""

    def __init__(self, capacity, block):
        self.block = block
        self._limit = max(1, int(capacity // block))
        self._blocks = collections.OrderedDict()

    def take(self, low, high):
        """Touches the bytes from `low` to `high` of the database, and tells how many have to be read."""
        missing = 0
        for number in range(int(low // self.block), -int(-high // self.block)):
            if number in self._blocks:
                self._blocks.move_to_end(number)
                continue
            missing += 1
            self._blocks[number] = None
            if len(self._blocks) > self._limit:
                self._blocks.popitem(last=False)
        return missing * self.block
