"""Least-squares operators: derivatives that are polynomially consistent, also for disordered particles."""

SUPPORT = {2: 1.9, 4: 2.9}
"""Radius in particle spacings by order. About 10 and 27 neighbours: 0.1 less, and sheared disorder becomes singular."""

SKIN = 0.1
"""Room beyond it, in particle spacings, for the pairs that shifting brings together after they were listed."""
