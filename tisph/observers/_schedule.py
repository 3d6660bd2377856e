"""When an observer acts, apart from what it does."""

from bisect import bisect_right


class Schedule:
    """Ascending ``times``; each falls due at the end of the first step that reaches it."""

    def __init__(self, times):
        self.times = list(times)
        self.passed = 0

    def due(self, time):
        """Tell whether a time not yet marked has been reached."""
        return self.passed < len(self.times) and time >= self.times[self.passed]

    def pending(self, time):
        """Return the times up to ``time`` that are not yet marked."""
        return self.times[self.passed : bisect_right(self.times, time)]

    def mark(self, time):
        """Count all times up to ``time`` as done."""
        self.passed = bisect_right(self.times, time)


def even_times(start, end, count):
    """Return ``count`` equally spaced times from ``start`` to ``end``, both included and exact."""
    between = [start + (end - start) * k / (count - 1) for k in range(1, count - 1)]
    return [start, *between, end]
