"""The parts of a step of two-dimensional flow, as protocols, and the implementations that stand for "none".

``TimeLevels`` (``time_levels.py``) holds the states of the particles, with their ``Coordinates``. The other parts are
the ``Boundary``, the ``ExtraStress`` and the ``Coupling``s. Each part owns its fields: other parts read them, and give
it theirs as arguments. Velocities are unknowns of the ``Coordinates``, pressures and stresses are per unit density.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from tisph.runtime import ti
from tisph.schemes._two_dimensional.time_levels import TimeLevels

MOST_ITERATIONS = 20
"""Outer iterations of a step with couplings."""

if TYPE_CHECKING:
    from tisph.schemes._two_dimensional.equations import Equations
    from tisph.schemes._two_dimensional.time_levels import TimeWeights
    from tisph.snapshot import Bodies


class Coordinates(Protocol):
    """Planar or axisymmetric: the unknowns of a velocity, and factors of the radius in the equations for them.

    Its other members are functions of kernels, see ``time_levels.AxisymmetricCoordinates``.
    """

    axisymmetric: bool
    components: int
    """Number of unknowns of a velocity: 2 or 3."""

    def add_centripetal(self, velocity: Any, forcing: Any, dt: float, repeated: bool) -> None:
        """Add the centripetal term of a ``velocity`` to the ``forcing`` of a step ``dt``, two fields (points,).

        In ``repeated`` outer iterations it replaces the term of the previous iterate.
        """


class ExtraStress(Protocol):
    """The stress of a fluid in addition to the stress of its constant (solvent) viscosity."""

    nonlinear: bool
    """Whether it depends on the velocity at the end of the step, which needs a second outer iteration."""

    operators: Any
    """Least-squares operators for the viscous term."""

    viscosity: float
    """Kinematic viscosity of its implicit part in the present step."""

    resolution_name: str
    """Name in ``Snapshot`` of the number that ``store`` returns."""

    @property
    def fields(self) -> Sequence[Any]:
        """Fields (fluid,) that particles carry from step to step."""

    parts: Mapping[str, Any]
    """Objects that a checkpoint keeps, by name."""

    def local_viscosity(self, i: Any, viscosity: Any) -> Any:
        """Return, in kernels, the viscosity at a point; ``viscosity`` is the constant one of the step."""

    def with_viscous_divergence(self, i: Any, divergence: Any) -> Any:
        """Return, in kernels, a ``divergence`` plus the divergence of an implicit viscous term that varies."""

    def begin(self) -> None:
        """Compute the stress of the first velocities."""

    def prepare(self, weights: "TimeWeights", dt: float, time: float) -> None:
        """Begin a step ``dt`` that ends at ``time``."""

    def add_stress(self, velocity: Any, forcing: Any, dt: float) -> None:
        """Add dt times the divergence of the stress of a ``velocity`` to the ``forcing``, two fields (points,).

        The stress is that without its implicit part; it replaces the stress of the previous outer iteration.
        """

    def store(self, velocity: Any, step: int) -> Any:
        """Store the stress of the ``velocity`` at the end of a step; return a number that tells whether it is resolved.

        Raises ``DivergedError`` where it is not at all.
        """

    def remap(self) -> None:
        """Transfer the stress with a shift of the particles."""

    def wall_stress(self) -> Any:
        """Return the newest stress (xx, xy, yy, ...; count) at the points on walls."""

    def implicit_wall_stress(self, strain: np.ndarray) -> Any:
        """Return the stress (xx, xy, yy, ...; count) at the points on walls for a 2 D in the present step."""

    def at(self, weights: "TimeWeights", offset: float, levels: Sequence[np.ndarray], radius: np.ndarray) -> Any:
        """Return the polymer stresses (components, n) at a time ``offset`` before the end of the last step.

        ``levels``: values of ``fields``, each (n, ...); ``radius`` (n,).
        """


@ti.data_oriented
class NewtonianStress:
    """No extra stress: the viscosity of the fluid is constant."""

    nonlinear, viscosity, resolution_name = False, 0.0, "added_power"
    parts: Mapping[str, Any] = {}

    def __init__(self, levels: "TimeLevels") -> None:
        self.operators = levels.operators
        self.fields: tuple[Any, ...] = ()

    def begin(self) -> None:
        """Compute nothing."""

    def prepare(self, weights: TimeWeights, dt: float, time: float) -> None:
        """Prepare nothing."""

    def add_stress(self, velocity: np.ndarray, forcing: Any, dt: float) -> None:
        """Add nothing."""

    def store(self, velocity: Any, step: int) -> Any:
        """Store nothing."""

    def remap(self) -> None:
        """Transfer nothing."""

    def wall_stress(self) -> Any:
        """Return no stress."""
        return 0.0

    def implicit_wall_stress(self, strain: np.ndarray) -> Any:
        """Return no stress."""
        return 0.0

    def at(self, weights: TimeWeights, offset: float, levels: Sequence[np.ndarray], radius: np.ndarray) -> Any:
        """Return no polymer stress."""
        return ()

    @ti.func
    def local_viscosity(self, i, viscosity):
        """Return the ``viscosity`` of the step."""
        return viscosity

    @ti.func
    def with_viscous_divergence(self, i, divergence):
        """Return a ``divergence`` as it is: a constant viscosity adds nothing."""
        return divergence


class Boundary(Protocol):
    """The walls of the fluid. Points on them, ``slots`` of all points, are unknowns of the pressure.

    Its rows in the linear systems are those of ``WallBoundary``.
    """

    slots: slice
    """The points on walls among all points."""

    bounded: bool
    """Whether there are walls."""

    velocity: np.ndarray
    """Velocities (count, components) of the walls at the points."""

    def retained(self, i: Any, retained: Any, gamma0: Any) -> Any:
        """Return, in kernels, the part of the divergence that a step leaves at a particle: ``retained`` = k gamma_0."""

    def reset(self) -> None:
        """Return to the state before the first step."""

    def predict(self, weights: "TimeWeights", dt: float, time: float) -> bool:
        """Predict particles and bodies at the end of a step ``dt``, at ``time``; return False where bodies overlap."""

    def move(self, time: float) -> None:
        """Set the points on walls at ``time``, and everything that depends on the distance of particles from walls."""

    def impose_neumann_rows(self) -> None:
        """Replace the Laplacian at the points on walls by the normal derivative."""

    def begin_step(self, weights: "TimeWeights") -> None:
        """Extrapolate the curl of the vorticity at walls to the end of a step."""

    def solver_velocity(self) -> np.ndarray:
        """Return the velocities (count, components) that the solver has at the points on walls."""

    def add_force(self, forcing: Any, weights: "TimeWeights", dt: float) -> None:
        """Add the force of the known flow in singular corners to the ``forcing`` field of a step ``dt``."""

    def add_normal_momentum(self, equations: "Equations", dt: float, gamma0: float, viscosity: float) -> None:
        """Set the right-hand side of the pressure at walls, equation (8)."""

    def update_normal_curls(self, velocity: Any) -> None:
        """Compute the curl of the vorticity at walls from a ``velocity`` field (points,)."""

    def apply_impulse(self, equations: "Equations", tolerance: float) -> bool:
        """Apply the impulse of walls that start to move; return whether its system was solved."""

    def begin(self, equations: "Equations") -> None:
        """Give the points on walls their first velocities and accelerations."""

    def jump(self, time: float) -> None:
        """Give the points on walls the velocities after a jump at ``time``."""

    def accelerate(self, acceleration: float) -> None:
        """Change the body force along x, which acts on free bodies as well."""

    def add_impulse_momentum(self, right: Any, velocity: Any) -> None:
        """Set the ``right``-hand side of the impulse at walls that start to move at ``velocity``, two fields."""

    def store(self, time: float) -> None:
        """Store the curls and loads at the ``time`` at the end of a step."""

    def measure_loads(self, time: float) -> None:
        """Store the loads of the newest fields, at ``time``."""

    def find_fastest(self) -> None:
        """Replace the fastest velocity of the levels by that with the known flow in singular corners."""

    def whole_flow(
        self,
        weights: TimeWeights,
        offset: float,
        position: np.ndarray,
        velocity: np.ndarray,
        pressure: np.ndarray,
        created: np.ndarray,
    ) -> tuple[Any, Any, Any]:
        """Return position, velocity and pressure (n, ...) with the known flow in singular corners."""

    def bodies(self, time: float, weights: "TimeWeights", offset: float) -> "Bodies | None":
        """Return the bodies at ``time``, an ``offset`` before the end of the last step."""

    @property
    def load_scatter(self) -> Any:
        """Largest scatter of the force on a body from step to step, and the number of the body; None if unknown."""

    def numbers(self) -> Mapping[str, Any]:
        """Return numbers for ``summary.json``."""

    def host_state(self) -> Any:
        """Return the numbers outside the fields that a resumed run needs."""

    def restore_host_state(self, state: Any) -> None:
        """Restore the numbers of ``host_state``."""


@ti.data_oriented
class NoBoundary:
    """A periodic box without walls."""

    bounded, load_scatter = False, None

    def __init__(self, problem: Any, levels: "TimeLevels") -> None:
        self.problem, self.levels = problem, levels
        self.slots = slice(problem.n_fluid, problem.n_fluid)
        self.velocity = np.zeros((0, levels.components))

    def reset(self) -> None:
        """Reset nothing."""

    def predict(self, weights: TimeWeights, dt: float, time: float) -> bool:
        """Return True: nothing overlaps."""
        return True

    def move(self, time: float) -> None:
        """Move nothing."""

    def impose_neumann_rows(self) -> None:
        """Impose nothing."""

    def begin_step(self, weights: TimeWeights) -> None:
        """Extrapolate nothing."""

    def solver_velocity(self) -> np.ndarray:
        """Return no velocities."""
        return self.velocity

    def add_normal_momentum(self, equations: "Equations", dt: float, gamma0: float, viscosity: float) -> None:
        """Add nothing."""

    def update_normal_curls(self, velocity: np.ndarray) -> None:
        """Update nothing."""

    def add_impulse_momentum(self, right: Any, velocity: np.ndarray) -> None:
        """Add nothing."""

    def measure_loads(self, time: float) -> None:
        """Measure nothing."""

    def add_force(self, forcing: Any, weights: TimeWeights, dt: float) -> None:
        """Add no force."""

    def apply_impulse(self, equations: "Equations", tolerance: float) -> bool:
        """Remove the divergence of given initial velocities; return whether its system was solved."""
        solved = True
        if self.problem.has_own_start:
            self.levels.measure()
            solved = equations.find_impulse(tolerance, diverges=True)
            self.levels.subtract_gradient(equations.pressure.x)
        return solved

    def begin(self, equations: "Equations") -> None:
        """Begin with nothing."""

    def jump(self, time: float) -> None:
        """Do nothing."""

    def accelerate(self, acceleration: float) -> None:
        """Accelerate nothing."""

    def store(self, time: float) -> None:
        """Store nothing."""

    def find_fastest(self) -> None:
        """Leave the fastest velocity as it is."""

    def whole_flow(
        self,
        weights: TimeWeights,
        offset: float,
        position: np.ndarray,
        velocity: np.ndarray,
        pressure: np.ndarray,
        created: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return position, velocity and pressure as they are."""
        return position, velocity, pressure

    def bodies(self, time: float, weights: TimeWeights, offset: float) -> None:
        """Return no bodies."""

    def numbers(self) -> dict[str, Any]:
        """Return no numbers."""
        return {}

    def host_state(self) -> None:
        """Return nothing: there is no state."""

    def restore_host_state(self, state: Any) -> None:
        """Restore nothing."""

    @ti.func
    def retained(self, i, retained, gamma0):
        """Return the part of the divergence that a step leaves at a particle."""
        return retained


class Coupling(Protocol):
    """Unknowns that are found together with velocity and pressure in the outer iterations of a step.

    A flow without any has an empty tuple of them. ``rounding``: residual of the pressure below which there is only
    rounding.
    """

    rounding: float
    sets_curls: bool
    """Whether ``correct`` sets the curl of the vorticity at walls."""

    def start(self, equations: "Equations", tolerance: float) -> bool:
        """Apply the impulse at the start; return whether its system was solved."""

    def correct_start(self, equations: "Equations", tolerance: float) -> bool:
        """Correct the first accelerations by the first pressure; return whether they had converged."""

    def prepare(self, equations: "Equations", dt: float, gamma0: float, time: float, allowed: float) -> None:
        """Begin a step ``dt`` that ends at ``time``, whose velocities may have an error ``allowed``."""

    def correct(self, equations: "Equations") -> bool:
        """Correct the unknowns by the flow of the last outer iteration; return whether they had converged."""

    def error(self) -> float:
        """Return the error of the step in the unknowns [velocity]; infinite where they have not converged."""

    def store(self, time: float) -> None:
        """Store the unknowns at the ``time`` at the end of a step."""
