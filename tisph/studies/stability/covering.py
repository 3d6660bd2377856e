"""A covering set: rows of values in which every two values that can be had together meet at least once.

Two libraries were tried. allpairspy 2.5 misses 19 of 622 pairs of the stability matrix, because of the values that
exclude one another; covertable 3.2 finds them all, in 45 rows, where this needs 48.
"""

from itertools import combinations

import numpy as np


def covering_set(axes, exists):
    """Return rows, dicts with a value of every axis, that together have every possible pair of values.

    ``axes``: values by the name of the axis. ``exists(values)``: whether two values, a dict of two axes, can be had
    together. Greedy: each row is the first of those that bring the most new pairs, so that the set is always the same.
    """
    values = [(name, value) for name, choices in axes.items() for value in choices]
    sizes = [len(choices) for choices in axes.values()]
    first = np.cumsum([0, *sizes[:-1]])
    rows = np.indices(sizes).reshape(len(sizes), -1).T + first  # every row there is, as places in ``values``
    possible = np.array([[exists(dict([one, other])) for other in values] for one in values])
    columns = list(combinations(range(len(sizes)), 2))
    pairs = np.stack([rows[:, one] * len(values) + rows[:, other] for one, other in columns], axis=1)
    whole = possible.ravel()[pairs].all(axis=1)
    rows, pairs = rows[whole], pairs[whole]
    missing = np.zeros(possible.size, dtype=bool)
    missing[pairs] = True
    chosen = []
    while missing.any():
        best = int(np.argmax(missing[pairs].sum(axis=1)))
        missing[pairs[best]] = False
        chosen.append(dict(values[place] for place in rows[best]))
    return chosen
