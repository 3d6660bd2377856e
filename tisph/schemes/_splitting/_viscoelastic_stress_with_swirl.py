"""Polymer stress in axisymmetric flow with swirl: all six components, xx, xr, rr, tt, xt and rt, t around the axis.

The velocity gradient is that less the rotation w/r of the axes r and t along the path of a particle: it also has
L_tx = dw/dx and L_tr = dw/dr - w/r, and nothing in place of xt and rt. Differentiated are P_xt/r and P_rt/r^2; a stress
T exerts the force dT_xt/dx + dT_rt/dr + 2 T_rt/r around the axis.
"""

import numpy as np

from tisph.runtime import ti
from tisph.schemes._splitting._log_conformation_with_swirl import ModesWithSwirl, conformation_excess, logarithm, rate
from tisph.schemes._splitting._viscoelastic_stress_of_revolution import XR, ViscoelasticStressOfRevolution

XT, RT = 4, 5


@ti.data_oriented
class ViscoelasticStressWithSwirl(ViscoelasticStressOfRevolution):
    """As ``ViscoelasticStressOfRevolution``, with six components."""

    gradient_numbers, stress_numbers = 7, 6
    kind, powers, swirls = ModesWithSwirl, ((XR, 1), (XT, 1), (RT, 2)), True
    conformation_excess, logarithm = staticmethod(conformation_excess), staticmethod(logarithm)
    rate = staticmethod(rate)

    def implicit(self):
        """Return 2 nu* D with its components xr and xt over r, and rt over r^2."""
        around = np.stack([self.gradients[5] / self.radius, self.gradients[6] / self.radius**2])
        return np.concatenate([super().implicit(), self.viscosity * around])

    def take_known(self, gradient):
        """Let a velocity gradient (7, count) at the points on walls be what is known of it there."""
        super().take_known(gradient)
        gradient[5:] = self.walls.gradient_around(gradient[5:])

    def force_around(self, stress, by_x, by_r):
        """Return the force (points,) around the axis over r of a ``stress`` and its derivatives by x and r."""
        return (by_x[XT] + by_r[RT] + 2.0 * stress[RT] / self.radius) / self.radius

    def traction_rows(self, stress):
        """Return the components (5, count) of a stress that tractions are made of."""
        return stress[[0, 1, 2, XT, RT]]
