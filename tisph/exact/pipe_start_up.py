"""Start-up flow of any fluid along a pipe, or between two coaxial pipes: a numerical reference, to 1e-8.

The velocity u along the axis and the polymer stress S obey

    du/dt = g + 1/r d/dr [ r (flux(du/dr) + S_xr) ],    g = acceleration + cosine cos(w t) + sine sin(w t)

with x along the axis, g = -(dp/dx)/density, and each law (mode) of the polymer in simple shear, r across: see
``start_up``, which solves it. Closed forms of a Newtonian fluid are those of P. Szymanski, J. Math. Pures Appl. 11
(1932) 67-107, for constant g, and of J. R. Womersley, J. Physiol. 127 (1955) 553-563, for g that oscillates.

Source of the equations: that of ``circular_start_up``. Accuracy: that of ``start_up``.
"""

import numpy as np

from tisph.exact._coaxial import Coaxial


class PipeStartUp(Coaxial):
    """Flow of a ``fluid`` of ``start_up`` along the axis, from t = 0 on, between pipes of ``radii`` (inner, outer).

    ``walls``: the pair of them, with ``velocity(t)`` and ``acceleration(t)`` along the axis; where the inner radius is
    0, the first counts for nothing. The fluid was at rest, or in the developed flow of the pair ``before`` of walls.
    g, before t = 0 too: the constant ``acceleration``, and that of a ``pulsation`` with the attributes ``cosine``,
    ``sine`` and ``angular_frequency`` > 0. ``elements``: what ``StartUp`` takes by name. Stresses have x along the
    axis. ValueError for radii that do not grow outwards from 0, UnsolvedError as of ``StartUp``.
    """

    def __init__(self, radii, fluid, walls, before=None, *, acceleration=0.0, pulsation=None, **elements):
        drive = {"acceleration": acceleration, "pulsation": pulsation, "along": True}
        super().__init__(radii, fluid, walls, before, drive, elements)

    def force(self, t, *, density):
        """Forces (inner, outer) of the fluid on the walls along the axis, per length of it."""
        circumferences = 2 * np.pi * self.radii[0], -2 * np.pi * self.radii[1]
        stresses = (density * self.shear_stress(r, t) for r in self.radii)
        return tuple(length * stress for length, stress in zip(circumferences, stresses, strict=True))
