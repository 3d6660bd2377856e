"""Stress-controlled walls with and without a mass: ``walls.py`` with a velocity U that follows from the given stress.

All is per unit density. With a mass

    mass U' = stress - s sigma,    s = 1 on the upper wall, -1 on the lower one,

sigma being the shear stress of the fluid at the wall: that of the even polynomial through the stresses of the particles
near it, whose slope there the momentum equation gives, sigma_y = U' - g. In a stage U' = (U - known)/(gamma h), so that
all that the wall prescribes is linear in U: the velocities of a stage are u_a + (U - U*) w, both by the same matrix,
u_a those of the present U*, w the response to one more. Laws that are linear need one solution of each; others repeat
both. What the images have of U'' is left out: it is of fourth order.

Without a mass the shear rate e = u_y at the wall is known in place of the velocity. It follows from the stress that the
fluid has to take,

    s sigma(e, C) = stress,    sigma = nu_s e + S_xy(C),

stage by stage and by itself, C being the conformation of the fluid at the wall, which obeys the law for the shear rate
e. Images have the Taylor series that the even terms cancel of, u_I = u_F - 2 d u_d - d^3/3 u_ddd and S_I = 2 S - S_F +
d^2 S_dd, where the momentum equation, differentiated along y, ties nu_s u_yyy + S_yy = e', and C_yy follows as C_y does
in ``walls.py``. The velocity of the wall is that of the even polynomial through the particles near it, whose odd terms
are known.
"""

import math

import numpy as np

from tisph.errors import DivergedError
from tisph.schemes._channel.stages import DEFECT, GAMMA, A, B, weighted
from tisph.schemes._channel.walls import CoupledWall, WallSystem

MOST_ITERATIONS = 60
ROUND_OFF = 1e-13
"""Of the stress, that the balance at a massless wall is solved to."""


class WallOfGivenStress(CoupledWall):
    """The common part of walls with and without a mass.

    ``velocity`` and ``displacement`` at the start of the step; ``velocities`` of the wall, and ``stresses`` of the
    fluid there, at the stages that are done.
    """

    def __init__(self, channel, side, obeys_momentum, model):
        super().__init__(channel, side, obeys_momentum, model)
        self.control = self.schedule.over(channel.density)

    def forget(self):
        """Go back to before the first step."""
        super().forget()
        self.velocity = self.displacement = 0.0

    def begin(self, time, dt, fluid, operators):
        """Begin a step of ``dt`` at ``time``."""
        self.dt, self.gamma_dt = dt, GAMMA * dt
        self.stress_of = self.control.after(time).stress
        self.near, self.distance, self.weights = operators.even_fit(self.side)
        self.velocities, self.stresses, self.rates = [self.velocity], [], []
        self.series, self.stress_series = [], []

    def acceleration(self, time):
        """Return 0: the stress on the fluid is known."""
        return 0.0

    @property
    def mean_stress(self):
        """Shear stress of the fluid at the wall, the mean over the last step."""
        return weighted(B, self.stresses)

    def conclude(self):
        """Accept the step: its end is the start of the next."""
        self.displacement += self.dt * weighted(B, self.velocities)
        self.velocity = self.velocities[-1]


def one_sided(side, series):
    """Return the series of both walls, with 0 for the other wall."""
    both = [[0.0] * 3, [0.0] * 3]
    both[side] = series
    return both


class InertialWall(WallOfGivenStress):
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
        """Begin a stage at ``time`` from the rates of the stages before."""
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
        """Find the ``response`` of the fluid's velocities to the wall's; return that of shear rates, or None."""
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
        """Difference of second and third order in the velocity."""
        return self.dt * weighted(DEFECT, self.rates)

    def conclude(self):
        """Accept the step: its end is the start of the next."""
        super().conclude()
        self.slope, self.third = self.ends


class MasslessWall(WallOfGivenStress):
    """A wall without a mass: ``state`` C and ``second`` C_yy there, the shear ``rate`` e and e', ``change``."""

    even_reflection = True
    kept = "state", "second", "rate", "change", "velocity", "displacement"

    def forget(self):
        """Go back to before the first step."""
        super().forget()
        self.state, self.second = np.zeros((2, self.model.components))
        self.rate = self.change = 0.0

    def initialise(self, derivatives):
        """Start from the ``derivatives`` of the states along y at the wall, 0 to 3 (4, components)."""
        self.state, self.second = derivatives[0], derivatives[2]

    def first_jumps(self):
        """Return jumps of velocity and acceleration at the start: it is the stress that jumps."""
        return self.channel.wall_jumps[self.side], 0.0

    def later_jumps(self, time):
        """Return those at a later ``time``."""
        return 0.0, 0.0

    def jump(self, time):
        """Take up the stress from ``time`` on, where it jumps; return by how much the shear rate does."""
        before, self.known, self.gamma_dt = self.rate, self.state, 0.0
        self.stress = float(self.control.after(time).stress(time))
        self.balance(self.rate)
        self.rate = self.shear_rate
        _, _, by_state, tangent = self.model.jacobian(self.state, self.rate)
        relaxation = float(by_state @ self.state_rate(self.state, self.rate))
        stress_rate = float(self.control.slope(time))
        self.change = (-self.normal_sign * stress_rate - relaxation) / (self.viscosity + tangent)
        return self.rate - before

    def apply_stress_jump(self, operators, time):
        """Return the change of the fluid's velocities by the stress that jumps at ``time``.

        As in ``wall_pair.py`` it is the momentum of the layer that the particles cannot resolve yet: a shear rate that
        jumps by J has e' = J delta(t) and e'' = J delta'(t), in the series -d^3/3 e'/nu - d^5/60 e''/nu^2.
        """
        jump = self.normal_sign * self.jump(time)
        third, fifth = ([0.0, -jump / 3.0, 0.0], [0.0, 0.0, -jump / 60.0])
        change, fourth = (operators.boundary_laplacian(one_sided(self.side, each)) for each in (third, fifth))
        return change + operators.laplacian(fourth)

    def begin(self, time, dt, fluid, operators):
        """Begin a step of ``dt`` at ``time``."""
        super().begin(time, dt, fluid, operators)
        self.gamma_dt, self.known, self.stress = 0.0, self.state, float(self.stress_of(time))
        self.state_rates, self.second_rates = [], []
        self.set(self.rate)
        system = self.system()
        second, second_rate, third = system.solve(self.second, self.change)
        self.prescribe(system, second, third)
        self.keep(self.change, self.state_rate(self.state, self.rate), second_rate)
        self.gamma_dt = GAMMA * dt

    def open(self, stage, time):
        """Find the shear rate of an implicit stage at ``time``."""
        weights, dt = A[stage], self.dt
        self.stress = float(self.stress_of(time))
        self.known = self.state + dt * weighted(weights, self.state_rates)
        self.known_second = self.second + dt * weighted(weights, self.second_rates)
        self.known_rate = self.rate + dt * weighted(weights, self.rates)
        self.balance(self.known_rate + self.gamma_dt * self.rates[-1])
        system = self.system()
        rate = (self.shear_rate - self.known_rate) / self.gamma_dt
        self.stage_second, second_rate, third = system.solve(self.known_second, rate)
        self.prescribe(system, self.stage_second, third)
        self.stage_rates = rate, (self.stage_state - self.known) / self.gamma_dt, second_rate

    def prescribe(self, system, second, third):
        """Add a stage by the present shear rate, C_yy and u_yyy."""
        self.third = third
        self.series.append([-2.0 * self.normal_sign * self.shear_rate, -self.normal_sign * third / 3.0, 0.0])
        self.stress_series.append((self.extra_stress, system.stress_slope(second, third)))

    def state_rate(self, state, shear_rate):
        """Return dC/dt of the fluid at the wall."""
        return self.model.rate(state[:, None], np.array([shear_rate]))[:, 0]

    def set(self, shear_rate):
        """Let the fluid at the wall have a ``shear_rate``: its state, stresses, and their derivative."""
        rate, known = np.array([shear_rate]), self.known[:, None]
        state, tangent = self.model.update(known, self.gamma_dt, rate, known)
        self.shear_rate, self.stage_state = shear_rate, state[:, 0]
        self.extra_stress = float(np.ravel(self.model.shear_stress(state, rate))[0])
        self.total, self.tangent = (
            self.viscosity * shear_rate + self.extra_stress,
            self.viscosity + float(np.ravel(tangent)[0]),
        )

    def system(self):
        """Return the equations of the derivatives along y, at the present state."""
        return WallSystem(self.gamma_dt, self.model, self.viscosity, np.append(self.stage_state, self.shear_rate))

    def balance(self, guess):
        """Find the shear rate at which the stress of the fluid is that on the wall."""
        self.set(guess)
        for _ in range(MOST_ITERATIONS):
            residual = self.stress + self.normal_sign * self.total
            if abs(residual) <= ROUND_OFF * (abs(self.stress) + abs(self.extra_stress)):
                return
            self.set(self.shear_rate - self.normal_sign * residual / self.tangent)
        raise DivergedError("u: no shear rate is found at the stress-controlled wall")

    def close(self, velocity):
        """End an implicit stage with these velocities of the fluid."""
        self.velocities.append(self.fitted_velocity(velocity, self.shear_rate, self.third))
        self.keep(*self.stage_rates)

    def fitted_velocity(self, velocity, shear_rate, third):
        """Return the wall's velocity by the even fit to ``velocity`` (fluid), with its shear rate and u_yyy."""
        odd = self.normal_sign * (shear_rate * self.distance + third * self.distance**3 / 6.0)
        return float(self.weights @ (velocity[self.near] - odd))

    def keep(self, rate, state_rate, second_rate):
        """Store the rates of a stage."""
        self.rates.append(rate)
        self.state_rates.append(state_rate)
        self.second_rates.append(second_rate)
        self.stresses.append(self.total)

    def state_excess(self, component):
        """Return the derivatives of a component of C at the wall, for its images; see ``boundary_stress``."""
        return self.state[component], self.second[component]

    def conclude(self):
        """Accept the step: its end is the start of the next."""
        super().conclude()
        self.state, self.second = self.stage_state, self.stage_second
        self.rate, self.change = self.shear_rate, self.rates[-1]
        if not math.isfinite(self.rate):
            raise DivergedError("u: the shear rate at the stress-controlled wall is not finite")
