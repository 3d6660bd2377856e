"""What an impulsively started wall does: the impulse on the fluid through the series of the images.

A wall whose velocity jumps by J has U' = J delta(t) and U'' = J delta'(t); one whose acceleration relative to the
drive jumps by J_1 has U'' = J_1 delta(t). Put into the images' series (``walls.py``) and integrated over the jump, they
change the velocities once, at the start, by

    du = J (g_2 + A g_4) + J_1/nu g_4,    g_2k = sum of the operator's entries of the wall's images, times 2 d^2k/(2k)!

which is what the layer that the particles cannot resolve yet has taken up (the fourth-order continuation of
``schemes/wcsph/_impulse.py``).

With an extra stress, y being the velocities, the states of the particles, and those at the walls, the discrete
equations are y' = M y + B_1 U' + B_2 U'' + ...: J changes y by (B_1 + M B_2) J, and J_1 by B_2 J_1. All is linearised
about the fluid at the wall. Those are the first terms of a series in s = modulus * spacing^2/nu_s^2. Where the
polymer's is larger than that of the solvent they say nothing, and move fluid faster than the wall. What the wall asks
of the solvent alone passes to the whole fluid in the time lambda nu_s/nu, which is nu_p/(nu_s s) of what a layer takes
to be one spacing thick: the wall gives the impulse of an inelastic fluid then, with the total viscosity, on which it
does not depend, and the polymer is still at rest.
"""

import numpy as np

from tisph.schemes._stages.stress_controlled import one_sided


def apply_impulse(stages, flow, time):
    """Let walls that change at once at ``time`` do so: change ``flow``, which ``stages`` advance, and the walls.

    Returns the velocity gained from the (bottom, top) wall, summed over the particles.
    """
    walls, gains = stages.walls, [0.0, 0.0]
    walls.enter(time)
    near = stages.wall_values(flow)
    for wall in walls:
        jumps = wall.jumps_at(time)
        if walls.obeys_momentum and any(jumps):
            start = ImpulsiveStart(stages, wall)
            gained = (
                start.coupled_change(flow, *jumps, near[wall.side]) if stages.model else start.velocity_change(*jumps)
            )
            flow.velocity += gained
            gains[wall.side] += float(gained.sum(dtype=float))
    for wall in walls:
        gained = wall.apply_stress_jump(stages.operators, time)
        if gained is not None:
            flow.velocity += gained
            gains[wall.side] += float(gained.sum(dtype=float))
    return gains


class ImpulsiveStart:
    """The impulse of one ``wall`` on what ``stages`` advance."""

    def __init__(self, stages, wall):
        self.stages, self.operators, self.wall, self.nu = stages, stages.operators, wall, stages.viscosity
        self.fourth = 0.0, 0.0, 1.0 / (12.0 * self.nu**2)  # of the series, for U'' = 1
        self.velocity_2 = self.nu * self.spread(self.fourth)

    def spread(self, series):
        """Return the Laplacian of images of this wall alone with such a series."""
        return self.operators.boundary_laplacian(one_sided(self.wall.side, series))

    def sheared(self, series):
        """Return their gradient."""
        return self.operators.boundary_gradient(one_sided(self.wall.side, series))

    def by_velocity(self, fourth):
        """Return the change of the velocities for U' = 1, whose series has u_yy = 1/nu and this ``fourth`` term."""
        return self.nu * (self.spread((0.0, 1.0 / self.nu, fourth)) + self.operators.laplacian(self.velocity_2))

    def velocity_change(self, jump, rate):
        """Return the change of the velocities of a Newtonian fluid."""
        return jump * self.by_velocity(0.0) + rate * self.velocity_2

    def coupled_change(self, flow, jump, rate, fluid):
        """Return the change of the velocities; change the states of ``flow`` and at the wall, where ``fluid`` is."""
        operators, model, wall, nu = self.operators, self.stages.model, self.wall, self.nu
        decay, stretching, stress, _ = model.jacobian(fluid[:-1], fluid[-1])
        modulus, third_2 = float(stress @ stretching), stretching / nu**2
        fourth = -modulus / (6.0 * nu**3)  # by the stress's own part and its slope's
        sheared_2 = self.sheared(self.fourth)
        alone, velocity = self.by_velocity(0.0), self.by_velocity(fourth)
        velocity += operators.gradient(modulus * sheared_2, 1.0) + operators.boundary_stress(
            wall.side, 0.0, stress @ third_2
        )
        if jump != 0.0 and np.abs(velocity - alone).max() > np.abs(alone).max():
            total = nu - stress @ np.linalg.solve(decay, stretching)
            return jump * alone + rate * nu / total * self.velocity_2
        sheared = self.sheared((0.0, 1.0 / nu, fourth)) + operators.gradient(self.velocity_2, -1.0)
        wall.slope = wall.slope + jump * stretching / nu
        falling = (decay - np.outer(stretching, stress) / nu) @ third_2 - modulus / nu * third_2
        wall.third = wall.third + jump * falling + rate * third_2
        model.apply_shear(flow.state, jump * sheared + rate * sheared_2)
        flow.state += np.multiply.outer(decay @ stretching, jump * sheared_2)
        return jump * velocity + rate * self.velocity_2
