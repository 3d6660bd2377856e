"""Both walls of a channel over a step, and their impulse on the fluid where they change at once.

A wall whose velocity jumps by J has U' = J delta(t) and U'' = J delta'(t); one whose acceleration relative to the
drive jumps by J_1 has U'' = J_1 delta(t). Put into the images' series (``walls.py``) and integrated over the jump, they
change the velocities once, at the start, by

    du = J (g_2 + A g_4) + J_1/nu g_4,    g_2k = sum of the operator's entries of the wall's images, times 2 d^2k/(2k)!

which is what the layer that the particles cannot resolve yet has taken up (the fourth-order continuation of the impulse
in ``schemes/wcsph/_boundaries.py``).

With an extra stress, y being the velocities, the states of the particles, and those at the walls, the discrete
equations are y' = M y + B_1 U' + B_2 U'' + ...: J changes y by (B_1 + M B_2) J, and J_1 by B_2 J_1. All is linearised
about the fluid at the wall. Those are the first terms of a series in s = modulus * spacing^2/nu_s^2. Where the
polymer's is larger than that of the solvent they say nothing, and move fluid faster than the wall. What the wall asks
of the solvent alone passes to the whole fluid in the time lambda nu_s/nu, which is nu_p/(nu_s s) of what a layer takes
to be one spacing thick: the wall gives the impulse of an inelastic fluid then, with the total viscosity, on which it
does not depend, and the polymer is still at rest.
"""

import numpy as np

from tisph.schemes._channel.stages import C
from tisph.schemes._channel.stress_controlled import InertialWall, MasslessWall, one_sided
from tisph.schemes._channel.walls import OBEY_MOMENTUM, CoupledWall, PrescribedWall


class WallPair:
    """The (bottom, top) wall of a ``channel``; ``model`` of the extra stress of the fluid, or None.

    ``obeys_momentum``: whether the series of the images follow from the momentum equation. ``any_jump``: whether
    something changes at once, at the start or later.
    """

    def __init__(self, channel, treatment, model):
        self.model, self.obeys_momentum = model, OBEY_MOMENTUM[treatment]
        self.walls = [_wall(channel, side, self.obeys_momentum, model) for side in range(2)]
        self.steady = model is None and not any(wall.schedule.oscillates for wall in self.walls)
        changes = (any(wall.jumps) or wall.schedule.jump_times or wall.even_reflection for wall in self.walls)
        self.any_jump = any(map(bool, changes))
        self.past = self.present = None

    def __iter__(self):
        return iter(self.walls)

    @property
    def even_reflection(self):
        """Whether images of velocities beyond the (bottom, top) wall have the sign of their sources."""
        return tuple(wall.even_reflection for wall in self.walls)

    @property
    def stress_controlled(self):
        """The stress-controlled wall, or None."""
        return next((wall for wall in self.walls if wall.schedule.stress_controlled), None)

    def reset(self):
        """Go back to before the first step."""
        self.past = self.present = None
        for wall in self.walls if self.model else ():
            wall.forget()

    def enter(self, time):
        """Follow the motions from ``time`` on; what the fluid near walls was before says nothing any more."""
        self.past = None
        for wall in self.walls:
            wall.enter(time)

    def begin(self, time, dt, near, operators):
        """Begin a step of ``dt`` at ``time``; ``near`` (2, components + 1): C and shear rate of the fluid at the walls.

        They change as they did over the last step.
        """
        if self.model is not None:
            self.present, change = (time, near), 0.0
            if self.past is not None:
                before, values = self.past
                change = (near - values) / (time - before)
            near = np.array([near + c * dt * change for c in C])
        for side, wall in enumerate(self.walls):
            wall.begin(time, dt, None if self.model is None else near[:, side], operators)

    def conclude(self):
        """Accept the step: its end is the start of the next."""
        self.past = self.present
        for wall in self.walls:
            wall.conclude()

    def series(self, stage):
        """Return the series of the (bottom, top) wall at a ``stage`` of the step."""
        return [wall.series[stage] for wall in self.walls]

    def stress_series(self, stage):
        """Return the derivatives of S_xy along y at the (bottom, top) wall at a ``stage`` of the step."""
        return [wall.stress_series[stage] for wall in self.walls]

    def host_state(self):
        """Return the numbers that a resumed run needs."""
        past = self.past and (self.past[0], self.past[1].tolist())
        return {"walls": [wall.host_state() for wall in self.walls], "past": past}

    def restore_host_state(self, state):
        """Take up the numbers of ``host_state``."""
        self.past = state["past"] and (state["past"][0], np.array(state["past"][1]))
        for wall, own in zip(self.walls, state["walls"], strict=True):
            wall.restore_host_state(own)


def _wall(channel, side, obeys_momentum, model):
    schedule = (channel.bottom, channel.top)[side]
    if model is None:
        return PrescribedWall(channel, side, obeys_momentum)
    kind = CoupledWall
    if schedule.stress_controlled:
        kind = MasslessWall if schedule.mass_per_area == 0.0 else InertialWall
    return kind(channel, side, obeys_momentum, model)


def apply_impulse(stages, flow, time):
    """Let walls that change at once at ``time`` do so: change ``flow``, which ``stages`` advance, and the walls.

    Returns the velocity gained from the (bottom, top) wall, summed over the particles.
    """
    walls, gains = stages.walls, [0.0, 0.0]
    walls.enter(time)
    near = stages.wall_values(flow)
    for wall in walls:
        jumps = wall.jumps if time == stages.channel.start_time else wall.later_jumps(time)
        if walls.obeys_momentum and any(jumps):
            gained = change_by_jump(stages, flow, wall, *jumps, near[wall.side])
            flow.velocity += gained
            gains[wall.side] += float(gained.sum(dtype=float))
    for wall in walls:
        gained = wall.apply_stress_jump(stages.operators, time)
        if gained is not None:
            flow.velocity += gained
            gains[wall.side] += float(gained.sum(dtype=float))
    return gains


def change_by_jump(stages, flow, wall, jump, rate, fluid):
    """Return the change of the velocities that ``stages`` advance by a ``wall`` whose velocity and acceleration jump.

    With an extra stress change the states of ``flow`` and at the wall, too; ``fluid``: C and shear rate there.
    """
    operators, model, nu = stages.operators, stages.model, stages.viscosity
    images = lambda *series: one_sided(wall.side, series)  # noqa: E731
    curved = images(0.0, 0.0, 1.0 / (12.0 * nu**2))  # for U'' = 1
    velocity_2 = nu * operators.boundary_laplacian(curved)
    # for U' = 1, whose series has u_yy = 1/nu and this fourth term
    by_velocity = lambda fourth: (  # noqa: E731
        nu * (operators.boundary_laplacian(images(0.0, 1.0 / nu, fourth)) + operators.laplacian(velocity_2))
    )
    alone = by_velocity(0.0)
    if model is None:
        return jump * alone + rate * velocity_2
    decay, stretching, stress, _ = model.jacobian(fluid[:-1], fluid[-1])
    modulus, third_2 = float(stress @ stretching), stretching / nu**2
    fourth = -modulus / (6.0 * nu**3)  # by the stress's own part and its slope's
    sheared_2, velocity = operators.boundary_gradient(curved), by_velocity(fourth)
    velocity += operators.gradient(modulus * sheared_2, 1.0) + operators.boundary_stress(
        wall.side, 0.0, stress @ third_2
    )
    if jump != 0.0 and np.abs(velocity - alone).max() > np.abs(alone).max():
        total = nu - stress @ np.linalg.solve(decay, stretching)
        return jump * alone + rate * nu / total * velocity_2
    sheared = operators.boundary_gradient(images(0.0, 1.0 / nu, fourth)) + operators.gradient(velocity_2, -1.0)
    wall.slope = wall.slope + jump * stretching / nu
    falling = (decay - np.outer(stretching, stress) / nu) @ third_2 - modulus / nu * third_2
    wall.third = wall.third + jump * falling + rate * third_2
    model.apply_shear(flow.state, jump * sheared + rate * sheared_2)
    flow.state += np.multiply.outer(decay @ stretching, jump * sheared_2)
    return jump * velocity + rate * velocity_2
