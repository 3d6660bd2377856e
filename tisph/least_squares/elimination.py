"""Index tables of the least-squares systems: which sums of powers fill them, and how they are eliminated.

Plain lists of numbers, from which the loops of ``rows.py`` are unrolled when they are compiled.
"""


def powers(order):
    """Return the exponents (a, b) of the unknowns x^a y^b, those that operators ask for last."""
    high = [(degree - b, b) for degree in range(order, 2, -1) for b in range(degree + 1)]
    return [*high, (1, 1), (2, 0), (0, 2), (1, 0), (0, 1)]


def moment_indices(order):
    """Return {(a, b): index} of the sums of w x^a y^b that the systems up to ``order`` are made of."""
    exponents = [(degree - b, b) for degree in range(2, 2 * order + 1) for b in range(degree + 1)]
    return {power: index for index, power in enumerate(exponents)}


def moment_chains(order):
    """Return, for each power of x from 0, the indices of the moments by power of y: -1 where none is needed."""
    moments = moment_indices(order)
    return [[moments.get((a, b), -1) for b in range(2 * order - a + 1)] for a in range(2 * order + 1)]


def horner(order):
    """Return, per power of x downwards, the coefficients by falling power of y: -1 for the missing constant."""
    place = {power: index for index, power in enumerate(powers(order))}
    return [[place.get((a, b), -1) for b in range(order - a, -1, -1)] for a in range(order, -1, -1)]


class Elimination:
    """Unrolled solution M z = e with M = L D L^T for one order, within a set of unknowns ``targets``.

    Lower triangles are stored by rows: entry (i, j) at i (i + 1) / 2 + j. ``fill``: (entry, moment) by rows of M, so
    that no unrolled loop is long, of which Taichi warns. ``columns[k]``: the entries to turn into factors, each with
    what it is used for. ``units``: the entries of e of the Laplacian, d/dx and d/dy as (unknown, degree).
    ``forward`` and ``backward``: the substitutions; forward starts at the first entry of e that is not zero.
    ``targets`` and ``unused``: where the unknowns go among all, and which of those this order does not have.
    """

    def __init__(self, order, moments, targets):
        self.powers = powers(order)
        self.size = size = len(self.powers)
        self.no_unknowns = [0.0] * size
        self.no_entries = [0.0] * _entry(size, 0)
        self.targets = [targets.index(power) for power in self.powers]
        self.unused = [k for k in range(len(targets)) if k not in self.targets]
        self.fill = [
            [(_entry(i, j), moments[(x + self.powers[j][0], y + self.powers[j][1])]) for j in range(i + 1)]
            for i, (x, y) in enumerate(self.powers)
        ]
        self.pivots = [(k, *self.fill[k][k]) for k in range(size)]
        self.columns = [
            [(_entry(j, k), [(_entry(i, j), _entry(i, k)) for i in range(j, size)]) for j in range(k + 1, size)]
            for k in range(size)
        ]
        self.units = [[(size - 4, 2), (size - 3, 2)], [(size - 2, 1)], [(size - 1, 1)]]
        firsts = [size - 4, size - 2, size - 1]
        self.forward = [
            [(i, [(k, _entry(i, k)) for k in range(first, i)]) for i in range(first, size)] for first in firsts
        ]
        self.backward = [
            (i, self.targets[i], [(k, _entry(k, i)) for k in range(i + 1, size)]) for i in range(size - 1, -1, -1)
        ]


def _entry(row, column):
    return row * (row + 1) // 2 + column
