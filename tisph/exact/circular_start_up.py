"""Start-up flow of any fluid between two cylinders, or within one: a numerical reference, to 1e-8.

The velocity u around the axis, the polymer stress S in polar components and the pressure p per unit density obey

    du/dt = 1/r^2 d/dr [ r^2 (solvent_viscosity rate + S_rt) ],    rate = r d(u/r)/dr
    dp/dr = u^2/r + dS_rr/dr + (S_rr - S_tt)/r

with t for the angle, and each law (mode) of the polymer in simple shear, x around the axis and y outwards: see
``start_up``, which solves it. The cylinders turn with given angular velocities, counterclockwise is positive.

Source of the equations: R. B. Bird, R. C. Armstrong and O. Hassager, Dynamics of Polymeric Liquids 1 (2nd ed. 1987),
appendix B. Accuracy: that of ``start_up``.
"""

import numpy as np

from tisph.exact._coaxial import Coaxial


class CircularStartUp(Coaxial):
    """Flow of a ``ViscoelasticFluid`` between two cylinders that turn as ``inner`` and ``outer`` from t = 0 on.

    Both have ``velocity(t)`` and ``acceleration(t)``, of an angle (``start_up.Wall``). The fluid was at rest, or
    in the developed flow of the pair ``before`` of cylinders. With ``inner_radius`` 0 there is the outer one alone,
    around a fluid that spins up. ``elements``: what ``StartUp`` takes by name. ValueError for radii that do not grow
    outwards from 0, UnsolvedError as of ``StartUp``. Stresses have x around the axis.
    """

    def __init__(self, inner_radius, outer_radius, fluid, inner, outer, before=None, **elements):
        super().__init__((inner_radius, outer_radius), fluid, (inner, outer), before, {}, elements)

    def torque(self, t, *, density):
        """Torques (inner, outer), counterclockwise, of the fluid on the cylinders, per length along the axis."""
        return tuple(
            sign * 2 * np.pi * r**2 * density * self._solved.shear_stress(self._place(r), t)
            for sign, r in zip((1, -1), self.radii, strict=True)
        )

    def pressure(self, r, t, *, density):
        """Pressure at radii ``r`` and one time, of zero mean over the area."""
        elements = self._solved.elements
        radius, places = elements.radii, self.radii[0] + elements.y
        along, _, across = self.polymer_stress(places, t)
        u = self.velocity(places, t)
        if t == 0:  # what turns is what turned before
            u -= elements.levers * self._solved.layer.field(elements.y, t)
        inward = np.divide(u**2 + across - along, radius, out=np.zeros_like(u), where=radius > 0.0)
        pressure = across + elements.integral(inward)
        area = elements.half_width * elements.weights * radius
        mean = np.sum(area * pressure) / np.sum(area)
        values = elements.interpolated(pressure, self._place(r).ravel()) - mean
        return density * values.reshape(np.shape(r))[()]
