"""The pressure gradient that keeps a mean velocity, such as 0 in a tube that is closed at its ends.

Velocity and pressure of a step depend linearly on its acceleration g along x, and with them the mean velocity m over a
cross-section. The first g of a step is extrapolated from the last steps. Each outer iteration changes it by
-(m - wanted m)/(dm/dg), with dm/dg from the last two iterations.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from tisph.numerics.stokes import Unknowns
from tisph.runtime import view
from tisph.schemes.implicit.planar.equations import Equations
from tisph.schemes.implicit.planar.parts import Coupling
from tisph.schemes.implicit.planar.problem import Problem
from tisph.schemes.implicit.planar.wall_boundary import WallBoundary

SETTLED = 0.3
"""Part of the tolerance of a step, times the velocity, that m may be off by."""


KEPT = "acceleration", "response", "levels"
"""Numbers that a checkpoint keeps."""


class MeanVelocityControl(Coupling):
    """The ``Coupling`` that finds the ``acceleration`` g along x for the ``kept_mean_velocity`` of a problem.

    ``response``: dm/dg over dt/gamma_0; it is 1 without the parts that pressure and viscosity take. ``levels``: pairs
    of a time and g of the last two steps, newest first.
    """

    def __init__(self, problem: Problem, boundary: WallBoundary) -> None:
        assert problem.kept_mean_velocity is not None
        assert problem.section_weights is not None
        self.wanted, self.section_weights = problem.kept_mean_velocity, problem.section_weights
        self.problem, self.boundary = problem, boundary
        self.acceleration, self.response = 0.0, 1.0
        self.levels: list[tuple[float, float]] = []
        self.time = self.scale = self.allowed = 0.0
        self.tried: tuple[float, float] | None = None
        self.weights = np.empty(0)

    def start(self, equations: "Equations", tolerance: float) -> bool:
        """Apply the impulse of a pressure that gives the fluid its mean velocity; return whether it was solved for.

        It is a part of the impulse of flow past bodies at rest.
        """
        self._measure_section(self.problem.start_time)
        fluid, walls = slice(self.boundary.points.in_fluid), self.boundary.slots
        newest, solution = self.boundary.newest_velocities, view(equations.velocity.x)
        solution[: len(newest)] = newest
        wanted = self.wanted - self._mean(equations)
        if wanted == 0.0:
            return True
        solution[walls] = 0.0
        solution[walls, 0] = -1.0
        solved, before = equations.find_impulse(tolerance), newest[fluid].copy()
        self.boundary.levels.subtract_gradient(equations.pressure.x)
        unit = newest[fluid] - before
        unit[:, 0] += 1.0
        newest[fluid] = before
        solution[fluid], solution[walls] = unit, 0.0
        self.response = self._mean(equations)
        newest[fluid] += wanted / self.response * unit
        return solved

    def _measure_section(self, time: float) -> None:
        """Compute the weights of the present positions, at ``time``, in the mean velocity."""
        self.time = time
        self.weights = self.section_weights(self.boundary.positions + self.problem.origin, time)

    def _mean(self, equations: "Equations") -> float:
        """Return the mean velocity of the present solution."""
        return float(self.weights @ view(equations.velocity.x)[: len(self.weights), 0].astype(float))

    def prepare(self, equations: "Equations", dt: float, gamma0: float, time: float, allowed: float) -> None:
        """Begin a step ``dt`` that ends at ``time``, whose velocities may have an error ``allowed``."""
        self._measure_section(time)
        self.scale, self.tried, self.allowed = dt / gamma0, None, SETTLED * allowed
        guess = self.levels[0][1] if self.levels else 0.0
        if len(self.levels) > 1:
            (newest, g), (before, other) = self.levels
            guess += (g - other) * (time - newest) / (newest - before)
        self._accelerate(equations, guess)

    def _accelerate(self, equations: "Equations", acceleration: float) -> None:
        self.acceleration = acceleration
        equations.accelerate(acceleration)
        self.boundary.accelerate(acceleration)

    def unknowns(self, dt: float) -> Unknowns:
        """Return the correction of the acceleration as an unknown, with the mean velocity as its equation."""
        from scipy.sparse import csr_matrix

        walls, one = self.boundary.velocity.size, np.ones(1)
        nothing, section = csr_matrix((walls, 1)), csr_matrix(self.weights[None])
        wanted, response = np.array([self.wanted]), self.response * self.scale * one
        shape = nothing, nothing.T.tocsr(), one, 0.0 * one, 0.0 * one, section, wanted
        return Unknowns(*shape, 0.0 * one, self.scale * one, response)

    def take(self, equations: "Equations", correction: np.ndarray) -> None:
        """Add the ``correction`` (1,) that was found to the acceleration."""
        self._accelerate(equations, self.acceleration + float(correction[0]))

    def correct(self, equations: "Equations") -> bool:
        """Change the acceleration by the mean velocity of the solution; return whether it had converged."""
        mean = self._mean(equations)
        if self.tried and self.acceleration != self.tried[0]:
            slope = (mean - self.tried[1]) / (self.acceleration - self.tried[0]) / self.scale
            self.response = slope if slope > 0.0 else self.response
        if not abs(mean - self.wanted) > self.allowed:
            return True
        self.tried = self.acceleration, mean
        self._accelerate(equations, self.acceleration + (self.wanted - mean) / (self.response * self.scale))
        return False

    def store(self, time: float) -> None:
        """Store the acceleration of the step as the newest level."""
        self.levels = [(self.time, self.acceleration), *self.levels][:2]

    @property
    def drive(self) -> float:
        """The acceleration."""
        return self.acceleration

    def host_state(self) -> dict[str, Any]:
        """Return the numbers that a resumed run needs."""
        return {name: getattr(self, name) for name in KEPT}

    def restore_host_state(self, state: Mapping[str, Any]) -> None:
        """Restore the numbers of ``host_state``."""
        for name in KEPT:
            setattr(self, name, state[name])
