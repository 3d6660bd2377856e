"""The stable counting sort of everything that lies in cells: particles, points and ghosts, members of grid cells.

It runs in one thread and without atomics, and so gives the same order whatever the number of threads.
"""

from tisph.runtime import ti


@ti.func
def counting_sort(cell: ti.template(), start: ti.template(), order: ti.template(), cells, first, second):
    """Sort slots by their ``cell`` into ``order``: those of cell c from ``start[c + 1]`` to ``start[c + 2]`` - 1.

    ``first`` is the number of the slots from 0 on; ``second``, number and first one of the slots that come after these.
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
    """Return the slot of item ``number``: the first ``first`` lie from slot 0 on, the others from ``second`` on."""
    return number + ti.select(number < first, 0, second - first)
