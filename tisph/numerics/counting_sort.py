"""The stable counting sort of particles, points and ghosts into cells.

It runs in one thread and without atomics, and so gives the same order whatever the number of threads.
"""

from tisph.runtime import ti


@ti.func
def counting_sort(cell: ti.template(), start: ti.template(), order: ti.template(), cells, first, second):
    """Sort slots by their ``cell`` into ``order``, with cell c from ``start[c + 1]`` to ``start[c + 2]`` - 1.

    ``first``: number of slots from 0 on. ``second``: number of further slots, and the first of them.
    """
    total = first + second[0]
    for c in range(cells + 1):
        start[c] = 0
    start[cells + 1] = total
    for number in range(total):
        start[cell[slot_of(number, first, second[1])] + 1] += 1
    for c in range(cells):
        start[c + 1] += start[c]
    for back in range(total):
        k = slot_of(total - 1 - back, first, second[1])
        # from the end of each cell to its beginning, which leaves in start[c + 1] the beginning of the cell
        start[cell[k] + 1] -= 1
        order[start[cell[k] + 1]] = k


@ti.func
def slot_of(number, first, second):
    """Return the slot of item ``number``: the first ``first`` items have slots from 0, the others from ``second``."""
    return number + ti.select(number < first, 0, second - first)
