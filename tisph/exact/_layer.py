"""The layer that a solvent's walls make when they jump, as closed form: what is left of a start without it is smooth.

Between planes it is the start-up flow of the solvent alone (``couette``). Between cylinders q = r^(3/2) w, with the
angular velocity w = u/r, obeys

    dq/dt = nu (d2q/dr2 - 3/(4 r^2) q)

the plane equation but for its last term. The layer takes q from the plane flow between the same walls, and leaves
-3/(4 r^2) nu w, its drift, to the equation of the rest.
"""

import numpy as np

from tisph.exact import couette


class Layer:
    """Layer at walls whose ``jumps`` (bottom, top) are in the unit of the continuous field of ``elements``.

    ``viscosity``: the kinematic one of the solvent. Between cylinders the continuous field is the angular velocity.
    ``shear_rates`` and ``drift`` have clocks that start at ``begin``.
    """

    def __init__(self, elements, jumps, viscosity, begin=0.0):
        self.begin, self._numbers = begin, (elements, jumps, viscosity)
        self.elements, self.viscosity = elements, viscosity
        self.jumps, self.curved = any(jumps), elements.inner_radius is not None
        gap = float(elements.edges[-1])
        bottom, top = (float(jump * elements.arm(y) ** 1.5) for jump, y in zip(jumps, (0.0, gap), strict=True))
        self._plane = {"gap": gap, "kinematic_viscosity": viscosity, "bottom": bottom, "top": top}

    def later(self, begin):
        """The same layer on a clock that starts at ``begin``."""
        return Layer(*self._numbers, begin)

    def velocity(self, y, t):
        """Velocity along the walls, or around the axis."""
        return self.elements.arm(y) ** -0.5 * couette.velocity(y, t, **self._plane)

    def shear_rate(self, y, t):
        """Shear rate arm d(u/arm)/dy."""
        arm = self.elements.arm(y)
        rate = arm**-0.5 * couette.shear_rate(y, t, **self._plane)
        return rate - 1.5 / arm * self.velocity(y, t) if self.curved else rate

    def shear_rates(self, times):
        """Shear rate (times, count, p + 1) at the points of the elements."""
        if not self.jumps:
            return np.zeros((len(times), *self.elements.y.shape))
        return self.shear_rate(self.elements.y, self.begin + times[:, None, None])

    def drift(self, times):
        """Rate of the continuous field (times, size) that the layer leaves to the rest; 0.0 between planes."""
        if not (self.jumps and self.curved):
            return 0.0
        nodes = self.elements.node_places
        scale = -0.75 * self.viscosity * self.elements.arm(nodes) ** -3
        return scale * self.velocity(nodes, self.begin + times[:, None])
