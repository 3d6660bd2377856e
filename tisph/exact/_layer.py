"""The layer that a solvent's walls make when they jump, as closed form: the rest of a start without it is smooth.

Between planes it is the start-up flow Q of the solvent alone (``couette``). Around or along an axis the continuous
field of ``_elements`` obeys dv/dt = nu (d2v/dr2 + k/r dv/dr), k = 3 or 1. The layer is v = h Q, Q of the plane flow
between the same walls, or, with the axis in the fluid, of that between r = -R and R, which is even in r. It leaves

    nu h [(2 a + k/r) dQ/dr + (da/dr + a^2 + k a/r) Q],    a = (dh/dr)/h

its drift, to the equation of the rest. That is as smooth as Q for h = r^(-k/2), a = -k/(2 r), which has no part with
dQ/dr; and for h = (R^2 + r^2)^(-k/2), a = -k r/(R^2 + r^2), which is even in r, and where that part is 0 at the wall.
And walls on the clock that begins with a later jump.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from tisph.exact import couette


class AnalyticLayer:
    """Layers at walls whose ``jumps``, triples (time, bottom, top), are in the unit of ``elements``' continuous field.

    ``viscosity``: the kinematic one of the solvent. Nothing is felt of a jump at its very time, but of one at t = 0,
    where the walls have started. ``shear_rates`` and ``drift`` have clocks that start at ``begin``.
    """

    def __init__(self, elements, jumps, viscosity, begin=0.0):
        self.begin, self.all = begin, jumps
        self.elements, self.viscosity = elements, viscosity
        self.jumps = [(time, *both) for time, *both in jumps if any(both)]
        self.gap, self.axis = float(elements.edges[-1]), elements.inner_radius == 0.0

    def later(self, begin):
        """The layers of the jumps up to ``begin``, on a clock that starts then."""
        return AnalyticLayer(self.elements, [jump for jump in self.all if jump[0] <= begin], self.viscosity, begin)

    def field(self, y, t):
        """The continuous field: the velocity along the walls, or the angular one around the axis."""
        return self._factor(y)[0] * self._summed(couette.velocity, y, t)

    def shear_rate(self, y, t):
        """Shear rate lever d(field)/dy."""
        factor, slope, _ = self._factor(y)
        rate = self._summed(couette.shear_rate, y, t)
        if self.elements.power:
            rate = rate + slope * self._summed(couette.velocity, y, t)
        return self.elements.lever(y) * factor * rate

    def _factor(self, y):
        """h, a and da/dr."""
        k, r = self.elements.power, self.elements.radius(y)
        if self.axis:
            squares = self.gap**2 + r * r
            return squares ** (-k / 2), -k * r / squares, -k * (self.gap**2 - r * r) / squares**2
        return r ** (-k / 2), -k / (2 * r), k / (2 * r * r)

    def _summed(self, profile, y, t):
        total = np.zeros(np.broadcast_shapes(np.shape(y), np.shape(t)))
        for time, *both in self.jumps:
            if time == 0.0 or time < np.min(t):
                bottom, top = (jump / self._factor(end)[0] for jump, end in zip(both, (0.0, self.gap), strict=True))
                flow = {"gap": self.gap, "kinematic_viscosity": self.viscosity, "bottom": bottom, "top": top}
                if self.axis:
                    flow |= {"gap": 2 * self.gap, "bottom": top}
                total = total + profile(y + self.gap * self.axis, t - time, **flow)
        return total

    def shear_rates(self, times):
        """Shear rate (times, count, p + 1) at the points of the elements."""
        if not self.jumps:
            return np.zeros((len(times), *self.elements.y.shape))
        return self.shear_rate(self.elements.y, self.begin + times[:, None, None])

    def drift(self, times):
        """Rate of the continuous field (times, size) that the layer leaves to the rest; 0.0 between planes."""
        if not (self.jumps and self.elements.power):
            return 0.0
        y, t = self.elements.node_positions, self.begin + times[:, None]
        factor, slope, bend = self._factor(y)
        # on the axis, which has no mass, any finite number will do
        curvature = self.elements.power / np.maximum(self.elements.radius(y), 1e-100)
        drift = (bend + slope * (slope + curvature)) * self._summed(couette.velocity, y, t)
        if self.axis:
            drift = drift + (2 * slope + curvature) * self._summed(couette.shear_rate, y, t)
        return self.viscosity * factor * drift


def jump(wall, time):
    """By how much the velocity of a wall that has changes jumps at one of them."""
    return 0.0 if wall.stress_controlled else float(wall.after(time).velocity(time) - wall.velocity(time))


@dataclass(frozen=True)
class ShiftedWall:
    """A ``wall`` on a clock that starts at ``begin``."""

    wall: Any
    begin: float

    @property
    def stress_controlled(self):
        return self.wall.stress_controlled

    @property
    def mass_per_area(self):
        return self.wall.mass_per_area

    def acceleration(self, t):
        return self.wall.acceleration(self.begin + t)

    def stress(self, t):
        return self.wall.stress(self.begin + t)
