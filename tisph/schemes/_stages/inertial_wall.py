"""A stress-controlled wall with a mass: ``walls.py`` with a velocity U that is found with that of the fluid,

    mass U' = stress - s sigma,    s = 1 on the upper wall, -1 on the lower one,

sigma being the shear stress of the fluid at the wall: that of the even polynomial through the stresses of the particles
near it, whose slope there the momentum equation gives, sigma_y = U' - g. In a stage U' = (U - known)/(gamma h), so that
all that the wall prescribes is linear in U: the velocities of a stage are u_a + (U - U*) w, both by the same matrix,
u_a those of the present U*, w the response to one more. Laws that are linear need one solution of each; others repeat
both. What the images have of U'' is left out: it is of fourth order.
"""

import numpy as np

from tisph.schemes._stages.esdirk import DEFECT, A, weighted
from tisph.schemes._stages.stress_controlled import StressControlledWall, one_sided
from tisph.schemes._stages.walls import WallSystem


class InertialWall(StressControlledWall):
    """A wall with a mass; its acceleration at the stages is in ``rates``."""

    kept = "slope", "third", "velocity", "displacement"

    def __init__(self, channel, side, obeys_momentum, model):
        self.mass = (channel.bottom, channel.top)[side].mass_per_area / channel.density
        self.drive = channel.acceleration
        super().__init__(channel, side, obeys_momentum, model)

    def first_jumps(self):
        """Return jumps of velocity and acceleration at the start: the stress has only the wall to accelerate then."""
        return self.channel.wall_jumps[self.side], self.later_jumps(0.0)[1]

    def later_jumps(self, time):
        """Return those at a later ``time``: of the acceleration, with the stress."""
        schedule, density = self.schedule, self.channel.density
        before = 0.0 if time == 0.0 else float(schedule.after(np.nextafter(time, 0.0)).stress(time))
        return 0.0, (float(schedule.after(time).stress(time)) - before) / density / self.mass

    def begin(self, time, dt, fluid, operators):
        """Begin a step of ``dt`` at ``time``; ``fluid``: C and shear rate at the wall at each stage."""
        super().begin(time, dt, fluid, operators)
        self.fluid, self.response = fluid, 0.0
        self.slope_rates, self.third_rates = [], []
        self.set_out(0, time)
        self.accelerate(self.velocity, 0.0)

    def set_out(self, stage, time):
        """Begin a stage at ``time``, with what the rates so far lead to."""
        gamma_dt, weights, dt = self.gamma_dt if stage else 0.0, A[stage], self.dt
        self.stress = float(self.stress_of(time))
        self.system = WallSystem(gamma_dt, self.model, self.viscosity, self.fluid[stage])
        self.known, self.known_slope, self.known_third = self.velocity, self.slope, self.third
        if stage:
            self.known = self.known + dt * weighted(weights, self.rates)
            self.known_slope = self.known_slope + dt * weighted(weights, self.slope_rates)
            self.known_third = self.known_third + dt * weighted(weights, self.third_rates)
        self.series.append(None)
        self.stress_series.append(None)

    def accelerate(self, velocity, rate):
        """Let the wall have a ``velocity`` and its time derivative ``rate`` in the present stage."""
        self.stage_velocity, self.rate = velocity, rate
        found, self.state_rates = self.system.derivatives(self.known_slope, self.known_third, rate - self.drive, 0.0)
        self.ends = found[:2]
        self.series[-1], self.stress_series[-1] = [2.0 * velocity, found[2], found[3] / 12.0], found[4:]

    def set(self, velocity):
        """Let the wall have a ``velocity`` in the present implicit stage."""
        self.accelerate(velocity, (velocity - self.known) / self.gamma_dt)

    def prepare(self, stages, start):
        """Find the wall's acceleration at the ``start`` of a step, by the stress of the fluid there."""
        totals = []
        for rate in (0.0, 1.0):  # all is linear in the acceleration
            self.accelerate(self.velocity, rate)
            shear_rate = stages.shear_rate(start.velocity, 0)
            stress = self.viscosity * shear_rate + self.model.shear_stress(start.state, shear_rate)
            totals.append(self.fitted_stress(stress, rate - self.drive))
        more = totals[1] - totals[0]
        rate = (self.stress + self.normal_sign * totals[0]) / (self.mass - self.normal_sign * more)
        self.accelerate(self.velocity, rate)
        self.total = totals[0] + rate * more
        self.velocities = []
        self.close(None)

    def open(self, stage, time):
        """Begin an implicit stage at ``time``, with the velocity that the rates so far lead to."""
        self.set_out(stage, time)
        self.set(self.known + self.gamma_dt * self.rates[-1])

    def match(self, stages, solution, gamma_dt, tangent, tolerance):
        """Let the wall have the velocity at which its momentum balances; see ``CoupledWall.match``."""
        velocity, shear_rate, stress = solution
        sheared = self.respond(stages, gamma_dt, tangent, tolerance)
        if sheared is None:
            return None
        total = self.fitted_stress(self.viscosity * shear_rate + stress, self.rate - self.drive)
        more = self.fitted_stress((self.viscosity + tangent) * sheared, 1.0 / gamma_dt)
        residual = self.mass * self.rate - self.stress - self.normal_sign * total
        change = -residual / (self.mass / gamma_dt - self.normal_sign * more)
        self.total = total + change * more
        self.set(self.stage_velocity + change)
        return velocity + change * self.response, shear_rate + change * sheared, stress + change * tangent * sheared

    def respond(self, stages, gamma_dt, tangent, tolerance):
        """Find the ``response`` of the fluid's velocities to the wall's; return that of the shear rates, or None."""
        operators, nothing = stages.operators, np.zeros_like(self.known_slope)
        found, _ = self.system.derivatives(nothing, nothing, 1.0 / gamma_dt, 0.0)
        series = one_sided(self.side, [2.0, found[2], found[3] / 12.0])
        boundary = operators.boundary_gradient(series)
        right = self.viscosity * operators.boundary_laplacian(series)
        right += operators.gradient(tangent * boundary, 1.0) + operators.boundary_stress(self.side, *found[4:])
        guess = self.response + np.zeros_like(right)
        response = operators.solve(gamma_dt * self.viscosity, gamma_dt * tangent, gamma_dt * right, guess, tolerance)
        if response is None:
            return None
        self.response = response
        return operators.gradient(response, -1.0) + boundary

    def fitted_stress(self, stress, rate):
        """Return that at the wall by the even fit to ``stress`` (fluid); ``rate``: U' - g."""
        return float(self.weights @ (stress[self.near] - self.normal_sign * rate * self.distance))

    def close(self, velocity):
        """End a stage, in which the fluid has the ``total`` stress at the wall."""
        self.rates.append(self.rate)
        self.slope_rates.append(self.state_rates[0])
        self.third_rates.append(self.state_rates[1])
        self.velocities.append(self.stage_velocity)
        self.stresses.append(self.total)

    @property
    def defect(self):
        """What second and third order differ by in the velocity."""
        return self.dt * weighted(DEFECT, self.rates)

    def conclude(self):
        """Accept the step: its end is the start of the next."""
        super().conclude()
        self.slope, self.third = self.ends
