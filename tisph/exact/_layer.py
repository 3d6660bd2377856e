"""The layer that a solvent's walls make when they jump, as closed form: the rest of a start without it is smooth.

Between planes it is the start-up flow of the solvent alone (``couette``). Between cylinders q = r^(3/2) w, with the
angular velocity w = u/r, obeys

    dq/dt = nu (d2q/dr2 - 3/(4 r^2) q)

the plane equation but for its last term. The layer takes q from the plane flow between the same walls, and leaves
-3/(4 r^2) nu w, its drift, to the equation of the rest. And walls on the clock that begins with a later jump.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from tisph.exact import couette


class AnalyticLayer:
    """Layers at walls whose ``jumps``, triples (time, bottom, top), are in the unit of ``elements``' continuous field.

    ``viscosity``: the kinematic one of the solvent. Between cylinders the continuous field is the angular velocity.
    Nothing is felt of a jump at its very time, but of one at t = 0, where the walls have started. ``shear_rates`` and
    ``drift`` have clocks that start at ``begin``.
    """

    def __init__(self, elements, jumps, viscosity, begin=0.0):
        self.begin, self.all = begin, jumps
        self.elements, self.viscosity = elements, viscosity
        self.jumps = [(time, *both) for time, *both in jumps if any(both)]
        self.curved = elements.inner_radius is not None
        self.gap = float(elements.edges[-1])
        self.factors = [float(elements.radius(y) ** 1.5) for y in (0.0, self.gap)]

    def later(self, begin):
        """The layers of the jumps up to ``begin``, on a clock that starts then."""
        return AnalyticLayer(self.elements, [jump for jump in self.all if jump[0] <= begin], self.viscosity, begin)

    def velocity(self, y, t):
        """Velocity along the walls, or around the axis."""
        return self.elements.radius(y) ** -0.5 * self._summed(couette.velocity, y, t)

    def shear_rate(self, y, t):
        """Shear rate radius d(u/radius)/dy."""
        radius = self.elements.radius(y)
        rate = radius**-0.5 * self._summed(couette.shear_rate, y, t)
        return rate - 1.5 / radius * self.velocity(y, t) if self.curved else rate

    def _summed(self, profile, y, t):
        total = np.zeros(np.broadcast_shapes(np.shape(y), np.shape(t)))
        for time, *both in self.jumps:
            if time == 0.0 or time < np.min(t):
                bottom, top = (jump * factor for jump, factor in zip(both, self.factors, strict=True))
                flow = {"gap": self.gap, "kinematic_viscosity": self.viscosity, "bottom": bottom, "top": top}
                total = total + profile(y, t - time, **flow)
        return total

    def shear_rates(self, times):
        """Shear rate (times, count, p + 1) at the points of the elements."""
        if not self.jumps:
            return np.zeros((len(times), *self.elements.y.shape))
        return self.shear_rate(self.elements.y, self.begin + times[:, None, None])

    def drift(self, times):
        """Rate of the continuous field (times, size) that the layer leaves to the rest; 0.0 between planes."""
        if not (self.jumps and self.curved):
            return 0.0
        nodes = self.elements.node_positions
        scale = -0.75 * self.viscosity * self.elements.radius(nodes) ** -3
        return scale * self.velocity(nodes, self.begin + times[:, None])


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
