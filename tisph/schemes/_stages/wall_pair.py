"""Both walls of a channel over a step, each of the kind that the config asks for."""

import numpy as np

from tisph.schemes._stages.esdirk import C
from tisph.schemes._stages.inertial_wall import InertialWall
from tisph.schemes._stages.massless_wall import MasslessWall
from tisph.schemes._stages.walls import OBEY_MOMENTUM, CoupledWall, PrescribedWall


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
