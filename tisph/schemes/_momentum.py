"""The balance of momentum along the channel: what walls and drive put in, against what the fluid has."""

from tisph.runtime import ti, view

EVERY_STEP_UNTIL = 64
STRIDE = 16
"""Wall forces are summed at every step first, when impulsive walls pull hardest, then at every STRIDE-th: the
trapezoidal rule over 16 steps of a force ~ t^-1/2 has an error of 0.4 % right after step 64, and less and less."""


@ti.data_oriented
class WallForces:
    """Force along x that each wall exerts on the fluid, by the pairs of particles that straddle it."""

    def __init__(self, lists, operators):
        self.particles, self.cells, self.operators = lists.particles, lists.cells, operators
        self.pull = ti.field(ti.f64, shape=2)

    def __call__(self, now):
        """Return the acceleration along x summed over the particles, by the bottom and the top wall."""
        self.add_up(now)
        return view(self.pull).copy()

    @ti.kernel
    def add_up(self, now: ti.i32):
        """Sum what wall particles do to the fluid in the rows of cells at the walls."""
        self.pull[0] = 0.0
        self.pull[1] = 0.0
        ti.loop_config(serialize=True)
        for i in range(self.particles.fluid_number[None]):
            first_top = self.cells.start[self.cells.place(self.cells.rows[None], 0)]
            if i < self.cells.start[self.cells.place(1, self.cells.columns[None])] or i >= first_top:
                pull = self.operators.wall_pull(now, i)
                self.pull[0] += pull[0]
                self.pull[1] += pull[1]


class MomentumBalance:
    """Adds up the impulses of the walls over the run; all per unit of density and of a particle's area.

    ``impulse``: of the bottom and the top wall by the trapezoidal rule over the middles of steps; ``initial`` is
    the sum of velocities along x at the start. Kept in plain numbers so that a checkpoint holds them.
    """

    def __init__(self, start_time):
        self.start_time = self.time = start_time
        self.initial = 0.0
        self.impulse = [0.0, 0.0]
        self.force = None

    def due(self, steps):
        """Tell whether the forces of step number ``steps`` are to be added."""
        return steps < EVERY_STEP_UNTIL or steps % STRIDE == 0

    def add(self, time, force):
        """Take the wall forces at ``time``; the first count from the start on."""
        before = self.force if self.force is not None else force
        self.impulse = [
            float(total + 0.5 * (time - self.time) * (old + new))
            for total, old, new in zip(self.impulse, before, force, strict=True)
        ]
        self.time, self.force = time, [float(one) for one in force]

    def add_impulse(self, impulse):
        """Take the impulses of the walls in a step as they are."""
        self.impulse = [float(total + more) for total, more in zip(self.impulse, impulse, strict=True)]

    def report(self, channel, time, velocity_sum):
        """Return the balance at ``time`` in the units of the config, per unit length out of the plane.

        ``closure`` is the relative imbalance, a fraction of the largest of the terms; None where nothing happened.
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
