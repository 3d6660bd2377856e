"""Index tables of the least-squares systems: which sums of powers fill them, and how they are eliminated.

Plain lists of numbers for the loops of ``operators.py``.
"""


def powers(order, axisymmetric=False):
    """Return the exponents (a, b) of the unknowns x^a y^b, those that operators ask for last.

    In axisymmetric flow those that are not in the basis near the axis come first.
    """
    high = [(degree - b, b) for degree in range(order, 2, -1) for b in range(degree + 1)]
    if axisymmetric:
        high.sort(key=lambda power: _is_even(power, order))
    return [*high, (1, 1), (2, 0), (0, 2), (1, 0), (0, 1)]


def even_powers(order):
    """Return where the exponents begin that are in the basis near the axis, degree counting y as the square it is."""
    return sum(not _is_even(power, order) for power in powers(order))


def _is_even(power, order):
    return power[0] + 2 * power[1] <= order


def moment_indices(order):
    """Return {(a, b): index} of the sums of w x^a y^b that the systems up to ``order`` are made of."""
    exponents = [(degree - b, b) for degree in range(2, 2 * order + 1) for b in range(degree + 1)]
    return {power: index for index, power in enumerate(exponents)}


def moment_chains(order):
    """Return, for each power of x from 0, the indices of the moments by power of y: -1 where none is needed."""
    moments = moment_indices(order)
    return [[moments.get((a, b), -1) for b in range(2 * order - a + 1)] for a in range(2 * order + 1)]


def horner(order, basis):
    """Return, per power of x downwards, the coefficients by falling power of y: -1 for the missing constant.

    ``basis``: the exponents of ``powers``.
    """
    place = {power: index for index, power in enumerate(basis)}
    return [[place.get((a, b), -1) for b in range(order - a, -1, -1)] for a in range(order, -1, -1)]


def moment_of_entries(order, basis):
    """Return the index of the moment in each entry of the lower triangle of M, row by row."""
    moments = moment_indices(order)
    return [moments[(x + a, y + b)] for i, (x, y) in enumerate(basis) for a, b in basis[: i + 1]]


def targets(basis, scale):
    """Return what the Laplacian, d/dx and d/dy ask for of each unknown, lengths being in units of 1/``scale``."""
    degrees = [{(2, 0): 2, (0, 2): 2}, {(1, 0): 1}, {(0, 1): 1}]
    numbers = {2: 2.0 * scale * scale, 1: scale, None: 0.0}
    return [[numbers[asked.get(power)] for power in basis] for asked in degrees]
