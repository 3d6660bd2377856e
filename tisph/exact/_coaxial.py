"""What flows around and along an axis have in common: ``start_up`` at radii."""

import numpy as np

from tisph.exact.start_up import Flow, StartUp, Wall


class Coaxial:
    """Flow of a ``fluid`` between cylinders of ``radii``, or inside of one where the first is 0.

    ``walls``: (inner, outer) from t = 0 on, of which the inner one counts for nothing where there is none; ``before``:
    the same whose developed flow it starts from, or None for rest. ``flow``: what else a ``start_up.Flow`` has. Radii
    ``r`` and times ``t`` >= 0 broadcast; results have their shape.
    """

    def __init__(self, radii, fluid, walls, before, flow, elements):
        inner, outer = radii
        if not 0 <= inner < outer < np.inf:
            raise ValueError(f"radii must grow outwards from 0, not {inner}, {outer}")
        self.radii = radii

        def flow_of(pair):
            return Flow(outer - inner, pair[0] if inner else Wall(), pair[1], inner_radius=inner, **flow)

        self._solved = StartUp(fluid, flow_of(walls), before and flow_of(before), **elements)

    def velocity(self, r, t):
        """Velocity; at t = 0 the walls have their new velocity already, the fluid its old one."""
        return self._solved.velocity(self._place(r), t)

    def shear_rate(self, r, t):
        """Shear rate du/dr, or around the axis r d(u/r)/dr (1/time); infinite at t = 0 where a wall jumps."""
        return self._solved.shear_rate(self._place(r), t)

    def shear_stress(self, r, t):
        """Shear stress of solvent and polymer together, per unit density."""
        return self._solved.shear_stress(self._place(r), t)

    def polymer_stress(self, r, t):
        """Stress of all modes per unit density, shape (3, ...): with x along the flow S_xx, S_xr and S_rr."""
        return self._solved.polymer_stress(self._place(r), t)

    def conformation_excess(self, r, t):
        """C of each mode at radii ``r`` (radii,) and one time ``t``, in the order xx, xr, rr (and that across both)."""
        return self._solved.conformation_excess(self._place(r), t)

    def _place(self, r):
        """Distance from the inner cylinder; round-off leaves none outside."""
        return np.clip(np.asarray(r, dtype=float) - self.radii[0], 0.0, self.radii[1] - self.radii[0])
