"""Flows of the stability matrix in which the fluid carries circles: what their names say, as whole configs.

Drawn through a periodic square by a force, the fluid by the opposite one; between walls of which one moves; settling in
a box; and a suspension. Unless they are very heavy, forces bring circles to a speed of about 1.
"""

import math

from tisph.studies.flows import digits, merged, walls

RESISTANCES = {0.05: 15.56, 0.2: 51.53, 0.4: 217.89}
"""Force over dynamic viscosity and superficial velocity of square arrays by solid fraction (suites/bodies.yaml)."""

ACROSS = 24
"""Spacings in which radii count, across what has a length of 1; with twice as many, runs are compared."""

RADIUS = 4.0
"""In spacings, where no other one is given."""

LIGHT_TO_HEAVY = (0.0, 0.1, 1.0, 10.0, 1000.0)
"""Densities, over the fluid's."""

FRACTIONS = {3.2: (0.2, 0.3), 4.0: (0.1, 0.2, 0.3, 0.4), 5.0: (0.1, 0.2, 0.3, 0.4)}
"""Area fractions of suspensions as heavy as the fluid by the radius in spacings."""

OFF_MIDDLE = 0.35
"""Height of a circle in shear, which drifts."""


def flows():
    """Yield names, and functions of the viscosity that return configs.

    Numbers in names are the density, the area fraction of what is drawn and of suspensions, and radii in spacings.
    """
    drawn = [(density, 0.2) for density in LIGHT_TO_HEAVY]
    drawn += [(density, fraction) for density in LIGHT_TO_HEAVY[::2] for fraction in (0.05, 0.4)]
    sheared = [(density, RADIUS) for density in LIGHT_TO_HEAVY] + [(1.0, radius) for radius in (2.5, 3.0, 6.0)]
    yield from ((f"drawn{density:g}_{fraction:g}", _drawn(density, fraction)) for density, fraction in drawn)
    yield from ((f"sheared{density:g}_{radius:g}", _sheared(density, radius)) for density, radius in sheared)
    yield from ((f"settling{density:g}", _settling(density)) for density in (0.0, 0.1, 0.5, 2.0, 10.0, 1000.0))
    suspended = [(1.0, fraction, radius) for radius, fractions in FRACTIONS.items() for fraction in fractions]
    for density, fraction, radius in (*suspended, *((density, 0.2, RADIUS) for density in (0.0, 0.5, 10.0, 1000.0))):
        yield f"suspension{density:g}_{fraction:g}_{radius:g}", _suspension(density, fraction, radius)


def _flow(nu, scene, *changes):
    return merged({"scene": scene, "fluid": {"kinematic_viscosity": digits(nu)}}, *changes)


def _circle(x, y, radius, density, **keys):
    place = {"type": "circle", "centre": [x, y], "radius": digits(radius)}
    return {"bodies": [{**place, "motion": "free", "density": density, **keys}]}


def _drawn(density, fraction):
    """Friction of slow flow and the stagnation pressure on a circle balance the force at a velocity of about 1."""
    radius = math.sqrt(fraction / math.pi)
    cell = {"geometry": {"length": 1.0, "height": 1.0}}

    def config(nu):
        force = digits(RESISTANCES[fraction] * nu + radius)
        drive = {"drive": {"acceleration": -force}}
        return _flow(nu, "lattice", cell, drive, _circle(0.5, 0.5, radius, density, force=[force, 0.0]))

    return config


def _between_walls(nu, length, *changes):
    cell = {"geometry": {"gap": 1.0, "length": length}}
    return _flow(nu, "channel", cell, walls(0.0, 1.0), {"initial": {"state": "developed"}}, *changes)


def _sheared(density, radius):
    return lambda nu: _between_walls(nu, 1.0, _circle(0.5, OFF_MIDDLE, radius / ACROSS, density))


def _settling(density):
    """Between walls and corners of two spacings."""
    corners = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]
    box = {"type": "polygon", "centre": [0.5, 0.5], "corners": corners, "corner_radius": digits(2.0 / ACROSS)}
    radius = RADIUS / ACROSS
    excess = abs(density - 1.0) * math.pi * radius**2

    def config(nu):
        gravity = digits((4.0 * math.pi * nu + radius) / excess)
        body = _circle(0.5, 0.5, radius, density)
        return _flow(nu, "region", {"walls": {"around": box}}, {"drive": {"gravity": [0.0, -gravity]}}, body)

    return config


def _suspension(density, fraction, radius):
    circles = {"type": "random_circles", "radius": digits(radius / ACROSS), "fraction": fraction}
    bodies = {**circles, "least_gap": digits(2.0 / ACROSS), "motion": "free", "density": density}
    return lambda nu: _between_walls(nu, 2.0, {"bodies": bodies})
