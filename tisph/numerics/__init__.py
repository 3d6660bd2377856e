"""Numerics of the implicit schemes, in any box: points, least-squares operators, linear solvers, shifting."""

SUPPORT = {2: 1.9, 4: 2.9}
"""Radius in particle spacings by order: about 10 and 27 neighbours. With 0.1 less, the systems of sheared disordered
particles become singular."""

SKIN = 0.1
"""Room beyond the support, in particle spacings, for the pairs that shifting moves closer after they were listed."""
