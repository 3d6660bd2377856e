"""Reference flow between the two cylinders of an ``Annulus``, solved for once; and stresses in polar components."""

from functools import lru_cache

import numpy as np

from tisph.exact.start_up import CircularStartUp, Wall, fluid_of


def reference_flow(annulus):
    """The ``CircularStartUp`` from rest, or on from the developed flow of what the cylinders did before."""
    walls = annulus.inner, annulus.outer
    before = walls if annulus.stays_steady else tuple(Wall(annulus.before(wall)) for wall in walls)
    fluid = annulus.rheology, annulus.kinematic_viscosity, annulus.density
    return _solved(*fluid, annulus.inner_radius, annulus.outer_radius, *walls, before)


@lru_cache(maxsize=8)
def _solved(rheology, kinematic_viscosity, density, inner_radius, outer_radius, inner, outer, before):
    fluid = fluid_of(rheology, kinematic_viscosity, density)
    moved = any(wall.oscillates or wall.velocity(0.0) for wall in before)
    return CircularStartUp(inner_radius, outer_radius, fluid, inner, outer, before if moved else None)


def cartesian(stress, x, y):
    """Components xx, xy, yy (3, ...) of a symmetric ``stress`` (3, ...) in polar ones at ``x``, ``y`` from the axis."""
    cosine, sine = _directions(x, y)
    around, shear, along = stress
    both = sine * cosine
    return np.stack(
        [
            around * sine**2 - 2 * shear * both + along * cosine**2,
            (along - around) * both + shear * (cosine**2 - sine**2),
            around * cosine**2 + 2 * shear * both + along * sine**2,
        ]
    )


def polar(stress, x, y):
    """Shear stress and N1, around the axis less along the radius, of a ``stress`` (3, ...): xx, xy, yy."""
    cosine, sine = _directions(x, y)
    xx, xy, yy = stress
    twice = 2 * sine * cosine, cosine**2 - sine**2
    return 0.5 * (yy - xx) * twice[0] + xy * twice[1], (yy - xx) * twice[1] - 2 * xy * twice[0]


def _directions(x, y):
    """Cosine and sine of the angle of places, in double precision."""
    x, y = (np.asarray(part, dtype=float) for part in (x, y))
    return x / np.hypot(x, y), y / np.hypot(x, y)
