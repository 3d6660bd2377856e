"""Start-up flow of any fluid between two cylinders: a numerical reference, to 1e-8.

The velocity u around the axis, the polymer stress S in polar components and the pressure p per unit density obey

    du/dt = 1/r^2 d/dr [ r^2 (solvent_viscosity rate + S_rt) ],    rate = r d(u/r)/dr
    dp/dr = u^2/r + dS_rr/dr + (S_rr - S_tt)/r

with t for the angle, and each law (mode) of the polymer in simple shear, x around the axis and y outwards: see
``start_up``, which solves it. The cylinders turn with given angular velocities, counterclockwise is positive.

Source of the equations: R. B. Bird, R. C. Armstrong and O. Hassager, Dynamics of Polymeric Liquids 1 (2nd ed. 1987),
appendix B. Accuracy: that of ``start_up``.
"""

import numpy as np

from tisph.exact.start_up import Flow, StartUp


class CircularStartUp:
    """Flow of a ``ViscoelasticFluid`` between two cylinders that turn as ``inner`` and ``outer`` from t = 0 on.

    Both have ``velocity(t)`` and ``acceleration(t)``, of an angle (``start_up.Wall``). The fluid was at rest, or
    in the developed flow of the pair ``before`` of cylinders. Radii ``r`` and times ``t`` >= 0 broadcast; results have
    their shape. ``elements``: what ``StartUp`` takes by name. ValueError for radii that do not grow outwards from above
    0, UnsolvedError as of ``StartUp``.
    """

    def __init__(self, inner_radius, outer_radius, fluid, inner, outer, before=None, **elements):
        if not 0 < inner_radius < outer_radius < np.inf:
            raise ValueError(f"radii must grow outwards from above 0, not {inner_radius}, {outer_radius}")
        self.radii = inner_radius, outer_radius

        def flow(walls):
            return Flow(outer_radius - inner_radius, *walls, inner_radius=inner_radius)

        self._solved = StartUp(fluid, flow((inner, outer)), before and flow(before), **elements)

    def velocity(self, r, t):
        """Velocity around the axis; at t = 0 the walls have their new velocity already, the fluid its old one."""
        return self._solved.velocity(self._place(r), t)

    def shear_rate(self, r, t):
        """Shear rate r d(u/r)/dr (1/time); infinite at t = 0 at a wall whose velocity jumps."""
        return self._solved.shear_rate(self._place(r), t)

    def polymer_stress(self, r, t):
        """Stress of all modes together per unit density, shape (3, ...): S_tt, S_rt and S_rr; N1 = S_tt - S_rr."""
        return self._solved.polymer_stress(self._place(r), t)

    def conformation_excess(self, r, t):
        """C of each mode at radii ``r`` (radii,) and one time ``t``, in the order tt, rt, rr (and zz)."""
        return self._solved.conformation_excess(self._place(r), t)

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
            u -= self._solved.layer.velocity(elements.y, t)
        pressure = across + elements.integral((u**2 + across - along) / radius)
        area = elements.half_width * elements.weights * radius
        mean = np.sum(area * pressure) / np.sum(area)
        values = elements.interpolated(pressure, self._place(r).ravel()) - mean
        return density * values.reshape(np.shape(r))[()]

    def _place(self, r):
        """Distance from the inner cylinder; rounding leaves none outside."""
        return np.clip(np.asarray(r, dtype=float) - self.radii[0], 0.0, self.radii[1] - self.radii[0])
