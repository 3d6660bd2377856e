"""The balance of momentum along the channel: the impulses of walls and drive against the momentum of the fluid."""

from collections.abc import Iterable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tisph.scenes._channel import Channel

EVERY_STEP_UNTIL = 64
STRIDE = 16
"""Wall forces are summed at every step at first, when impulsively started walls exert the largest forces, then at every
STRIDE-th step: the trapezoidal rule over 16 steps of a force ~ t^-1/2 has an error of 0.4 % after step 64, and less
later."""


class MomentumBalance:
    """Sums the impulses of the walls over the run, per unit density and per area of a particle.

    ``impulse``: of the bottom and the top wall, by the trapezoidal rule over the middles of steps; ``initial``: sum of
    the velocities along x at the start. All are plain numbers, for a checkpoint.
    """

    def __init__(self, start_time: float):
        self.start_time = self.time = start_time
        self.initial = 0.0
        self.impulse = [0.0, 0.0]
        self.force: list[float] | None = None

    def due(self, steps: int) -> bool:
        """Return whether the forces of step number ``steps`` are to be added."""
        return steps < EVERY_STEP_UNTIL or steps % STRIDE == 0

    def add(self, time: float, force: Iterable[float]) -> None:
        """Add the impulse of the wall ``force`` (bottom, top) up to ``time``; the first one acts from the start on."""
        before = self.force if self.force is not None else force
        self.impulse = [
            float(total + 0.5 * (time - self.time) * (old + new))
            for total, old, new in zip(self.impulse, before, force, strict=True)
        ]
        self.time, self.force = time, [float(one) for one in force]

    def add_impulse(self, impulse: Iterable[float]) -> None:
        """Add the impulses of both walls in a step."""
        self.impulse = [float(total + more) for total, more in zip(self.impulse, impulse, strict=True)]

    def report(self, channel: "Channel", time: float, velocity_sum: float) -> dict[str, float | None]:
        """Return the balance at ``time`` in the units of the config, per unit length out of the plane.

        ``closure`` is the imbalance over the largest of the terms; None where all terms are 0.
        """
        particle_mass = channel.density * channel.spacing**2
        rest = time - self.time
        walls = [total + rest * force for total, force in zip(self.impulse, self.force or [0.0, 0.0], strict=True)]
        terms = {
            "change": particle_mass * (velocity_sum - self.initial),
            "drive": channel.density * channel.gap * channel.length * channel.acceleration * (time - self.start_time),
            "bottom_wall": particle_mass * walls[0],
            "top_wall": particle_mass * walls[1],
        }
        largest = max(abs(value) for value in terms.values())
        missing = terms["change"] - terms["drive"] - terms["bottom_wall"] - terms["top_wall"]
        return {**terms, "closure": abs(missing) / largest if largest > 0 else None}
