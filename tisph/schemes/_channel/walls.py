"""Walls and the images beyond them: the Taylor series of velocity and stress at the wall.

Images have twice the even part of the velocity's series less that of their source (``schemes/_channel/ghosts.py``):
2 U, and by the momentum equation at the wall u_yy = (U' - g - S_y)/nu_s and u_yyyy. With an extra stress S the slopes
of its states C obey the derivative of the law there,

    C_y' = F_C C_y + F_u' u_yy,    S_y = S_C C_y,

and so, but for products of slopes, do the third derivatives, with u_yyyy and (u_yy)' in the places of u_yy and U' - g.
They are integrated beside the particles, by the same method; the matrices are those of the fluid at the wall at the
stages, extrapolated from the last two steps. The image of the stress is S_I = S_F - 2 d S_d - d^3/3 S_ddd.
"""

import numpy as np

from tisph.schemes._channel.stages import GAMMA, A, C, weighted

OBEY_MOMENTUM = {"comoving_image": False, "consistent_image": True, "virtual_image": False}
"""Treatments that the implicit scheme serves, and whether their series follow from the momentum equation."""


class PrescribedWall:
    """A wall of given velocity beside a Newtonian fluid, and the interface of other kinds of walls.

    ``side``: 0 bottom, 1 top. ``normal_sign``: of the normal into the fluid. ``even_reflection``: whether images of
    velocities have the sign of their sources. ``series``: at each stage of a step c0, c1, c2 of c0 + c1 d^2 + c2 d^4;
    with an even reflection that times d. ``stress_series``: S_y and S_yyy likewise, or S and S_yy.
    ``jumps``: of its velocity, and of its acceleration relative to the drive, when the run starts. ``kept``: names of
    the numbers that a resumed run needs.
    """

    even_reflection = False
    defect = 0.0
    kept: tuple[str, ...] = ()

    def __init__(self, channel, side, obeys_momentum):
        self.channel, self.side, self.obeys_momentum = channel, side, obeys_momentum
        self.normal_sign = 1.0 if side == 0 else -1.0
        self.schedule = (channel.bottom, channel.top)[side]
        self.jumps = self.first_jumps()
        self.enter(channel.start_time)

    def first_jumps(self):
        """Return ``jumps``."""
        channel, acceleration = self.channel, self.schedule.acceleration(0.0)
        if channel.start_time > 0.0:
            return 0.0, 0.0
        if not channel.starts_developed:
            return channel.wall_jumps[self.side], acceleration - channel.acceleration
        before = 0.0 if self.schedule.before is not None else acceleration
        return channel.wall_jumps[self.side], acceleration - before

    def later_jumps(self, time):
        """Return by how much velocity and acceleration jump at a ``time`` after the start."""
        return next((tuple(both) for when, *both in self.schedule.breakpoints if when == time), (0.0, 0.0))

    def enter(self, time):
        """Follow the motion that the wall has from ``time`` on, to the next change."""
        self.motion, self.steady_series = self.schedule.after(time), None

    def begin(self, time, dt, fluid, operators):
        """Begin a step of ``dt`` at ``time``; ``fluid`` and ``operators`` are for walls of other kinds."""
        if self.steady_series is None or self.schedule.oscillates:
            self.steady_series = [self.series_at(time + c * dt) for c in C]
        self.series, self.stress_series = self.steady_series, [(0.0, 0.0)] * len(C)

    def series_at(self, time):
        """Return the series at ``time``."""
        velocity = 2.0 * self.motion.velocity(time)
        if not self.obeys_momentum:
            return [velocity, 0.0, 0.0]
        nu = self.channel.kinematic_viscosity
        second = (self.motion.acceleration(time) - self.channel.acceleration) / nu
        return [velocity, second, self.motion.jerk(time) / nu**2 / 12.0]

    def acceleration(self, time):
        """Return the acceleration of the wall where the momentum equation there has it, else 0."""
        return self.motion.acceleration(time)

    def prepare(self, stages, start):
        """Take up the flow at the ``start`` of a step: it does not alter a wall of given velocity."""

    def open(self, stage, time):
        """Begin an implicit stage at ``time``."""

    def match(self, stages, solution, *system):
        """Return velocity, shear rate and stress of a stage with a wall that moves as it must, or None.

        ``system``: the stage's g h, the tangent, and the tolerance of linear systems.
        """
        return solution

    def close(self, velocity):
        """End an implicit stage with these velocities of the fluid."""

    def apply_stress_jump(self, operators, time):
        """Return the change of the fluid's velocities by a stress on the impulsively started wall, or None for none."""

    def conclude(self):
        """Accept the step: its end is the start of the next."""

    def host_state(self):
        """Return the numbers that a resumed run needs."""
        return {name: np.asarray(getattr(self, name)).tolist() for name in self.kept}

    def restore_host_state(self, state):
        """Take up the numbers of ``host_state``."""
        for name in self.kept:
            setattr(self, name, np.array(state[name]) if isinstance(state[name], list) else state[name])


class CoupledWall(PrescribedWall):
    """The same beside a fluid with an extra stress; ``slope`` and ``third`` (components) are C_y and C_yyy there."""

    kept = "slope", "third"

    def __init__(self, channel, side, obeys_momentum, model):
        super().__init__(channel, side, obeys_momentum)
        self.model, self.viscosity = model, channel.solvent_viscosity
        self.forget()

    def forget(self):
        """Go back to before the first step."""
        self.slope, self.third = np.zeros((2, self.model.components))

    def initialise(self, derivatives):
        """Start from the ``derivatives`` of the states along y at the wall, 0 to 3 (4, components)."""
        self.slope, self.third = derivatives[1], derivatives[3]

    def begin(self, time, dt, fluid, operators):
        """Integrate over a step of ``dt`` from ``time``; ``fluid``: C and shear rate at the wall at each stage."""
        self.series, self.stress_series, self.ends = [], [], None
        rates, third_rates = [], []
        for stage, (c, values) in enumerate(zip(C, fluid, strict=True)):
            system = WallSystem(GAMMA * dt if stage else 0.0, self.model, self.viscosity, values)
            known, known_third = self.slope, self.third
            if stage:
                known = known + dt * weighted(A[stage], rates)
                known_third = known_third + dt * weighted(A[stage], third_rates)
            motion, when = self.motion, time + c * dt
            driving = motion.acceleration(when) - self.channel.acceleration, motion.jerk(when)
            derivatives, both_rates = system.derivatives(known, known_third, *driving)
            rates.append(both_rates[0])
            third_rates.append(both_rates[1])
            self.prescribe(motion.velocity(when), *derivatives)
        self.ends = derivatives[:2]

    def prescribe(self, velocity, _slope, _third, second, fourth, *stress):
        """Add a stage with this velocity of the wall and derivatives there."""
        if not self.obeys_momentum:
            second = fourth = 0.0
            stress = 0.0, 0.0
        self.series.append([2.0 * velocity, second, fourth / 12.0])
        self.stress_series.append(stress)

    def state_excess(self, component):
        """Return the derivatives of a component of C at the wall, for its images; see ``boundary_stress``."""
        return self.slope[component], 0.0

    def conclude(self):
        """Accept the step: its end is the start of the next."""
        self.slope, self.third = self.ends


class WallSystem:
    """The equations of C_y and u_yy, and of C_yyy and u_yyyy, in a stage, with the law's derivatives at the wall."""

    def __init__(self, gamma_dt, model, viscosity, fluid):
        """``fluid``: C and the shear rate there."""
        decay, self.stretching, self.stress, self.tangent = model.jacobian(fluid[:-1], fluid[-1])
        self.gamma_dt, self.viscosity = gamma_dt, viscosity + self.tangent
        self.matrix = decay - np.outer(self.stretching, self.stress) / self.viscosity

    def solve(self, known, driving):
        """Return C_y, its rate, and u_yy, where nu_s u_yy + S_y is ``driving``."""
        source = self.stretching * driving / self.viscosity
        slope = np.linalg.solve(np.eye(len(source)) - self.gamma_dt * self.matrix, known + self.gamma_dt * source)
        return slope, self.matrix @ slope + source, (driving - self.stress @ slope) / self.viscosity

    def derivatives(self, known, known_third, driving, driving_rate):
        """Return (C_y, C_yyy, u_yy, u_yyyy, S_y, S_yyy) and the rates of the first two.

        ``driving``: the value of nu_s u_yy + S_y.
        """
        slope, rate, second = self.solve(known, driving)
        third, third_rate, fourth = self.solve(known_third, (driving_rate - self.stress @ rate) / self.viscosity)
        stress = self.stress_slope(slope, second), self.stress_slope(third, fourth)
        return (slope, third, second, fourth, *stress), (rate, third_rate)

    def stress_slope(self, slope, curvature):
        """Return S_y."""
        return float(self.stress @ slope) + self.tangent * curvature
