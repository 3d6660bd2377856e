"""The balance of momentum along the channel: the impulses of walls and drive against the momentum of the fluid."""

from collections.abc import Iterable, Sequence

from tisph.measures.channel import ChannelFlow

EVERY_STEP_UNTIL = 64
STRIDE = 16
"""Wall forces are summed at every step first, when impulsive walls pull hardest, then at every STRIDE-th: the
trapezoidal rule over 16 steps of a force ~ t^-1/2 has an error of 0.4 % right after step 64, and less and less."""


class MomentumBalance:
    """Adds up the impulses of the walls over the run; all per unit of density and of a particle's area.

    ``impulse``: of the bottom and the top wall by the trapezoidal rule over the middles of steps; ``initial`` is
    the sum of velocities along x at the start. Plain numbers, so that a checkpoint holds them.
    """

    def __init__(self, start_time: float) -> None:
        self.start_time = self.time = start_time
        self.initial = 0.0
        self.impulse = [0.0, 0.0]
        self.force: list[float] | None = None

    def due(self, steps: int) -> bool:
        """Tell whether the forces of step number ``steps`` are to be added."""
        return steps < EVERY_STEP_UNTIL or steps % STRIDE == 0

    def add(self, time: float, force: Iterable[float]) -> None:
        """Add the wall forces at ``time``; the first ones count from the start on."""
        before = self.force if self.force is not None else force
        self.impulse = [
            float(total + 0.5 * (time - self.time) * (old + new))
            for total, old, new in zip(self.impulse, before, force, strict=True)
        ]
        self.time, self.force = time, [float(one) for one in force]

    def report(self, channel: ChannelFlow, time: float, velocity_sum: float) -> dict[str, float | None]:
        """Return the ``momentum_terms`` at ``time``."""
        rest = time - self.time
        walls = [total + rest * force for total, force in zip(self.impulse, self.force or [0.0, 0.0], strict=True)]
        return momentum_terms(channel, time, velocity_sum - self.initial, walls)


def momentum_terms(
    channel: ChannelFlow, time: float, velocity_change: float, impulses: Sequence[float], pull: float = 0.0
) -> dict[str, float | None]:
    """Return the balance of momentum along x up to ``time`` in the units of the config, per length out of the plane.

    ``velocity_change``: of the sum of velocities over the particles; ``impulses``: velocity gained from the (bottom,
    top) wall, likewise; ``pull``: from the acceleration by the temperature, which is part of ``drive``. ``closure`` is
    the imbalance over the largest of the terms; None where all are 0.
    """
    particle_mass = channel.density * channel.spacing**2
    drive = channel.density * channel.gap * channel.length * channel.drive.gained(channel.start_time, time)
    drive += particle_mass * pull
    terms = {
        "change": particle_mass * velocity_change,
        "drive": drive,
        "bottom_wall": particle_mass * impulses[0],
        "top_wall": particle_mass * impulses[1],
    }
    largest = max(abs(value) for value in terms.values())
    missing = terms["change"] - terms["drive"] - terms["bottom_wall"] - terms["top_wall"]
    return {**terms, "closure": abs(missing) / largest if largest > 0 else None}
