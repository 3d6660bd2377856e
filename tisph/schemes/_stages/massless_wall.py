"""A stress-controlled wall without a mass: ``walls.py`` with the shear rate known in place of the velocity.

The shear rate e = u_y at the wall follows from the stress that the fluid has to take,

    s sigma(e, C) = stress,    sigma = nu_s e + S_xy(C),    s = 1 on the upper wall, -1 on the lower one,

stage by stage and by itself, C being the conformation of the fluid at the wall, which obeys the law for the shear rate
e. Images have the Taylor series that the even terms cancel of, u_I = u_F - 2 d u_d - d^3/3 u_ddd and S_I = 2 S - S_F +
d^2 S_dd, where the momentum equation, differentiated along y, ties nu_s u_yyy + S_yy = e', and C_yy follows as C_y does
in ``walls.py``. The velocity of the wall is that of the even polynomial through the particles near it, whose odd terms
are known.
"""

import math

import numpy as np

from tisph.errors import DivergedError
from tisph.schemes._stages.esdirk import GAMMA, A, weighted
from tisph.schemes._stages.stress_controlled import StressControlledWall, one_sided
from tisph.schemes._stages.walls import WallSystem

MOST_ITERATIONS = 60
ROUND_OFF = 1e-13
"""Of the stress, that the balance at a massless wall is solved to."""


class MasslessWall(StressControlledWall):
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
        stress_rate = float(self.control.stress_rate(time))
        self.change = (-self.normal_sign * stress_rate - relaxation) / (self.viscosity + tangent)
        return self.rate - before

    def apply_stress_jump(self, operators, time):
        """Return the change of the fluid's velocities by the stress that jumps at ``time``.

        What the layer that the particles cannot resolve yet takes up is as in ``impulse.py``: a shear rate that jumps
        by J has e' = J delta(t) and e'' = J delta'(t), in the series -d^3/3 e'/nu - d^5/60 e''/nu^2.
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
        """Return the equations of what changes along y, at the present state."""
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
        """Return that of the wall by the even fit to ``velocity`` (fluid), with the wall's shear rate and u_yyy."""
        odd = self.normal_sign * (shear_rate * self.distance + third * self.distance**3 / 6.0)
        return float(self.weights @ (velocity[self.near] - odd))

    def keep(self, rate, state_rate, second_rate):
        """Keep what a stage has found."""
        self.rates.append(rate)
        self.state_rates.append(state_rate)
        self.second_rates.append(second_rate)
        self.stresses.append(self.total)

    def state_excess(self, component):
        """Return what the images of a component of C have more than their sources, as of the stress."""
        return self.state[component], self.second[component]

    def conclude(self):
        """Accept the step: its end is the start of the next."""
        super().conclude()
        self.state, self.second = self.stage_state, self.stage_second
        self.rate, self.change = self.shear_rate, self.rates[-1]
        if not math.isfinite(self.rate):
            raise DivergedError("u: the shear rate at the stress-controlled wall is not finite")
