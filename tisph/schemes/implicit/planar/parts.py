"""The parts of a step of two-dimensional flow, each as the class that stands for "none" and has nothing to do.

``TimeLevels`` (``time_levels.py``) holds the states of the particles, with their coordinates. The other parts are an
``ExtraStress``, which itself is no stress, a ``Boundary``, which itself is no wall, and any number of ``Coupling``s.
Each part owns its fields: other parts read them, and give it theirs as arguments. Velocities are the unknowns of the
coordinates; pressures and stresses are per unit density.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from tisph.numerics import SKIN
from tisph.runtime import ti, view
from tisph.schemes.implicit.planar.corner_singularities import Corners
from tisph.schemes.implicit.planar.problem import Problem
from tisph.schemes.implicit.planar.time_levels import TimeLevels, TimeWeights

MOST_ITERATIONS = 20
"""Outer iterations of a step with couplings."""

COARSE_SIDE = 0.5
"""By how much supports are wider where the spacing grows, over its growth within a support: on the coarse side a
support would be empty."""

if TYPE_CHECKING:
    from tisph.numerics.stokes import Unknowns, WallRows
    from tisph.schemes.implicit.planar.equations import Equations


def rate_squared(strain: np.ndarray) -> np.ndarray:
    """Return the square 2 D:D (n,) of the shear rate for 2 D (6, n), its components xx, xr, rr, tt, xt, rt."""
    xx, xr, rr, tt, xt, rt = strain
    return 0.5 * (xx**2 + rr**2 + tt**2) + xr**2 + xt**2 + rt**2


@ti.data_oriented
class ExtraStress:
    """The stress of a fluid in addition to the stress of its constant (solvent) viscosity; here none (Newtonian fluid).

    ``nonlinear``: whether it depends on the velocity at the end of the step, which needs a second outer iteration.
    ``operators``: least-squares operators of the viscous term. ``viscosity``: kinematic viscosity of the implicit part
    of the stress in the present step. ``resolution_name``: name in ``Snapshot`` of the number that ``store`` returns.
    ``fields``: fields (fluid,) that particles carry from step to step. ``parts``: objects that a checkpoint keeps.
    """

    nonlinear, viscosity, resolution_name = False, 0.0, "added_power"
    operators: Any

    def __init__(self, levels: TimeLevels) -> None:
        self.operators = levels.operators
        self.fields: tuple[Any, ...] = ()
        self.parts: Mapping[str, Any] = {}

    @ti.func
    def local_viscosity(self, i, viscosity):
        """Return the viscosity at a point: the constant ``viscosity`` of the step."""
        return viscosity

    @ti.func
    def with_viscous_divergence(self, i, divergence):
        """Return a ``divergence`` plus the divergence of the viscous term, 0 for a constant viscosity."""
        return divergence

    def local_viscosities(self, viscosity: float, points: int) -> np.ndarray:
        """Return the viscosities (points,) of the implicit part of the stress: the ``viscosity`` of the step."""
        return np.full(points, viscosity)

    def set_factor(self, factor: Any) -> None:
        """Take the ``factor`` (points,) of viscosity and relaxation times that the temperature has."""

    def power(self, strain: np.ndarray, viscosity: float) -> np.ndarray:
        """Return the power (points,) of all stresses per mass; ``viscosity`` of the solvent.

        ``strain`` (6, points): 2 D, its components xx, xr, rr, tt, xt and rt; t is the direction around the axis.
        """
        return viscosity * rate_squared(strain)

    def begin(self, values: Sequence[np.ndarray] = ()) -> None:
        """Compute the stress of the first velocities, with ``values`` of the ``fields`` that earlier flow has left."""

    def prepare(self, weights: TimeWeights, dt: float, time: float) -> None:
        """Begin a step ``dt`` that ends at ``time``."""

    def add_stress(self, velocity: Any, forcing: Any, dt: float) -> None:
        """Add dt times the divergence of the stress of a ``velocity`` to the ``forcing``, two fields (points,).

        The stress is without its implicit part.
        """

    def store(self, velocity: Any, step: int) -> Any:
        """Store the stress of the ``velocity`` at the end of a ``step``; return a number that judges its resolution.

        Raises ``DivergedError`` where it is not resolved at all.
        """

    def remap(self) -> None:
        """Transfer the stress with a shift of the particles."""

    def wall_stress(self) -> Any:
        """Return the newest stress (xx, xy, yy, ...; count) at the points on walls."""
        return 0.0

    def present_wall_stress(self) -> Any:
        """Return the same for the newest iterate of a step."""
        return 0.0

    def implicit_wall_stress(self, strain: np.ndarray) -> Any:
        """Return the stress (xx, xy, yy, ...; count) at the points on walls in a step with 2 D = ``strain``."""
        return 0.0

    def at(self, weights: TimeWeights, offset: float, levels: Sequence[np.ndarray], radius: np.ndarray) -> Any:
        """Return the polymer stresses (components, n) at a time ``offset`` before the end of the last step.

        ``levels``: values of ``fields``, each (n, ...); ``radius`` (n,).
        """
        return ()


@ti.data_oriented
class Boundary:
    """The walls of the fluid; here none (periodic box).

    ``velocity`` (count, components): velocities of the walls at the points. ``corners``: known flow in corners.
    ``outlet``: field with the first slot of the points of an open end whose pressure is known, None without one.
    ``parts``: ``BoundaryPart``s, whose conditions hold beside those of walls of given motion. ``pressure_gradient``: by
    which given pressures drive the fluid.
    """

    bounded, pressure_gradient = False, 0.0
    outlet: Any = None
    parts: "Sequence[BoundaryPart]" = ()
    velocity: np.ndarray

    def __init__(self, problem: Problem, levels: TimeLevels, support: float) -> None:
        self.problem, self.levels, self.support = problem, levels, support
        self.velocity = np.zeros((0, levels.components))
        self.corners = Corners()

    @property
    def slots(self) -> slice:
        """Slots of the points on walls."""
        return self.levels.points.on_walls

    @ti.func
    def divergence_to_keep(self, i, kept, gamma0):
        """Return the divergence that a step leaves at a particle, times gamma_0: ``kept`` = k gamma_0 of the newest."""
        return kept * self.levels.divergence[i]

    @ti.func
    def error_weight(self, i):
        """Return the weight of a particle in the error of a step: 1."""
        return 1.0

    def reset(self) -> None:
        """Return to the state before the first step."""

    def reject(self) -> None:
        """Take back the changes of an attempt that was rejected."""

    def predict(self, weights: TimeWeights, dt: float, time: float) -> bool:
        """Predict particles and bodies at the end of a step ``dt``, at ``time``; return False where bodies overlap."""
        return True

    def move(self, time: float) -> None:
        """Set the points on walls at ``time``, and all that depends on the distances of particles from walls."""
        points = self.levels.points
        if points.graded:
            relative = self.set_spacing(view(points.position)[: points.fluid], time)
            self.set_supports(np.ones(points.fluid), relative)

    def renew_points(self, time: float) -> Any:
        """Place points on walls anew at ``time``: there are none."""
        return None

    def places_on_walls(self, time: float) -> np.ndarray:
        """Return the positions (0, 2) of the points on walls."""
        return np.empty((0, 2))

    def set_spacing(self, positions: np.ndarray, time: float) -> np.ndarray:
        """Set the spacings at ``positions`` (points, 2) and ``time``; return them over the largest one, (points,)."""
        points, problem = self.levels.points, self.problem
        if not points.graded:
            return np.ones(points.fluid)
        relative = problem.wanted_spacing.at(positions.astype(float) + problem.origin, time) / problem.spacing
        points.set_spacing(relative)
        return relative

    def set_supports(self, factor: np.ndarray, relative: np.ndarray) -> None:
        """Set the supports by their ``factor`` (points,) near walls and the ``relative`` spacing (points,)."""
        points, spacing = self.levels.points, self.problem.spacing * relative
        if points.graded:
            growth = np.minimum(self.problem.growth * self.support, 1.0 / relative - 1.0)
            factor = factor * (1.0 + COARSE_SIDE * growth)
        view(self.levels.operators.support_factor)[: points.fluid] = factor * relative
        view(points.radius)[: points.fluid] = self.support * factor * spacing + SKIN * spacing

    def set_rows(self) -> None:
        """Replace the Laplacian at the points on walls by the normal derivative."""

    def entered(self, position: np.ndarray) -> np.ndarray:
        """Return positions (n, 2) at a time within the last step, of particles that have all entered by then."""
        return position

    def begin_step(self, weights: TimeWeights) -> None:
        """Extrapolate the curl of the vorticity at walls to the end of a step."""

    def solver_velocity(self) -> np.ndarray:
        """Return the velocities (count, components) that the solver has at the points on walls."""
        return self.velocity

    def outlet_pressure(self, velocity: np.ndarray) -> np.ndarray:
        """Return p - nu du/dx (points,) at outlets for a ``velocity`` (points, components) of all points."""
        return np.zeros(0)

    def stokes_rows(self) -> "WallRows":
        """Return the equations of velocity and pressure at the points, of a ``StokesSolver``."""
        raise NotImplementedError

    def add_normal_momentum(self, equations: "Equations", dt: float, gamma0: float, viscosity: float) -> None:
        """Set the right-hand side of the pressure at walls, equation (8), for the present forcing and velocity."""

    def add_impulse_momentum(self, right: Any, velocity: Any) -> None:
        """Set the ``right``-hand side of the impulse at walls that start to move at ``velocity``, two fields."""

    def update_normal_curls(self, velocity: Any) -> None:
        """Compute the curl of the vorticity at walls from a ``velocity`` field (points,)."""

    def apply_impulse(self, equations: "Equations", tolerance: float) -> bool:
        """Apply the impulse that removes the divergence of given initial velocities; return whether it was solved."""
        if not self.problem.has_own_start:
            return True
        self.levels.measure()
        solved = equations.find_impulse(tolerance, diverges=True)
        self.levels.subtract_gradient(equations.pressure.x)
        return solved

    def begin(self, equations: "Equations") -> None:
        """Give the points on walls their velocities after the start, and the equations their accelerations."""

    def begin_without_inertia(self, time: float) -> None:
        """Begin at ``time``, with a flow that no earlier one alters."""

    def forget(self) -> None:
        """Forget earlier times, at which the motion was another one."""

    def jump(self, time: float) -> None:
        """Give the points on walls the velocities after a jump at ``time``."""

    def accelerate(self, acceleration: float) -> None:
        """Change the body force along x, which acts on free bodies as well."""

    def accept(self, time: float) -> None:
        """Store the curl of the vorticity and the loads of the newest fields, at ``time``."""

    def measure_loads(self, time: float) -> None:
        """Store the loads of the newest fields, at ``time``."""

    def seen(self, time: float, weights: TimeWeights, offset: float) -> Mapping[str, Any]:
        """Return bodies and ends in a ``Snapshot`` at ``time``, an ``offset`` before the end of the last step."""
        return {}

    def residual(self, least: float) -> float:
        """Return the divergence over the gradient of the velocities, or the ``least`` one, as root mean squares."""
        return self.levels.residual(least)

    def numbers(self) -> Mapping[str, Any]:
        """Return the numbers of the boundary for ``summary.json``."""
        return {}

    def host_state(self) -> Any:
        """Return the numbers outside the fields that a resumed run needs."""
        return None

    def restore_host_state(self, state: Any) -> None:
        """Restore the numbers of ``host_state``."""


@ti.data_oriented
class BoundaryPart:
    """A condition on a part of the boundary, beside those of walls of given motion; here none.

    A part owns its state, and returns values: the ``Boundary`` has the fields of all points, and asks each of its parts
    in turn. ``finds_impulse``: whether a coupling of the part finds the impulse of the start. ``outlet``: field with
    the first slot of the points whose pressure the part knows, None without any. ``pressure_gradient``: mean one by
    these pressures, per unit density.
    """

    finds_impulse, pressure_gradient = False, 0.0
    outlet: Any = None

    @ti.func
    def kept_part(self, i, kept, gamma0):
        """Return the part of the divergence that a step leaves at a particle, times gamma_0, for the usual ``kept``."""
        return kept

    @ti.func
    def divergence_before(self, i, divergence):
        """Return the ``divergence`` of the newest velocities at a particle."""
        return divergence

    @ti.func
    def error_weight(self, i, weight):
        """Return the ``weight`` of a particle in the error of a step."""
        return weight

    @ti.func
    def row_weight(self, i, k, slope):
        """Return the weight of neighbour ``k`` in the pressure's row of a point, ``slope`` in the normal derivative."""
        return slope

    @ti.func
    def open_part(self, i, value):
        """Return the part of the right-hand ``value`` of that row which holds where walls come close to each other."""
        return value

    def couplings(self, rounding: float, slow: bool) -> "list[Coupling]":
        """Return the couplings of the part: unknowns that each step has to find for it.

        ``rounding``: relative error of residuals. ``slow``: whether all is solved for in one system.
        """
        return []

    def reset(self, time: float) -> None:
        """Return to the state before the start, at ``time``."""

    def predict(self, weights: TimeWeights, dt: float, time: float) -> bool:
        """Predict the end of a step ``dt``, at ``time``; return False where bodies overlap."""
        return True

    def reject(self) -> None:
        """Take back the changes of ``predict``."""

    def accept(self, time: float) -> None:
        """Store the end of a step, at ``time``, whose fields are the newest ones."""

    def forget(self) -> None:
        """Forget earlier times, at which the motion was another one."""

    def velocity(self, velocity: np.ndarray) -> np.ndarray:
        """Return the ``velocity`` (count, components) at the points, with those that the part knows."""
        return velocity

    def acceleration(self, acceleration: np.ndarray) -> np.ndarray:
        """Return the ``acceleration`` (count, components) of the fluid at the points, for that of the walls."""
        return acceleration

    def supports(self, factor: np.ndarray, positions: np.ndarray) -> np.ndarray:
        """Return the factors (points,) of the supports at ``positions`` (points, 2), for the ``factor`` near walls."""
        return factor

    def approach(self, distances: np.ndarray) -> None:
        """Take note of the ``distances`` (points, walls) of all points from the nearest walls."""

    def set_rows(self) -> None:
        """Replace rows of points whose pressure is no normal derivative."""

    def begin_step(self) -> None:
        """Begin a step whose operators are known."""

    def set_values(self, equations: "Equations", gamma0: float, viscosity: float) -> None:
        """Set values of velocity and pressure that follow from the present velocity."""

    def end_impulse(self, equations: "Equations") -> None:
        """Take note of the impulse of the start, whose potential is the present pressure."""

    def begin(self) -> None:
        """Begin with the velocities after the start."""

    def accelerate(self, acceleration: float) -> None:
        """Change the body force along x."""

    def stokes_rows(self, rows: "WallRows") -> "WallRows":
        """Return the ``rows`` of the points in a ``StokesSolver`` with those of the part."""
        return rows

    def outlet_pressure(self, velocity: np.ndarray) -> np.ndarray:
        """Return p - nu du/dx (points,) at outlets for a ``velocity`` (points, components) of all points."""
        return np.zeros(0)

    def entered(self, position: np.ndarray) -> np.ndarray:
        """Return positions (n, 2) at a time within the last step, of particles that have all entered by then."""
        return position

    def compared(self, groups: list[list[int]]) -> list[list[int]]:
        """Return the ``groups`` of bodies, by their numbers, whose forces are compared from step to step."""
        return groups

    def contact_loads(self, time: float) -> Any:
        """Return the loads (bodies, 4) of contacts at ``time``, None where there are none."""
        return None

    def seen(self, time: float, weights: TimeWeights, offset: float) -> Mapping[str, Any]:
        """Return numbers of a ``Snapshot`` at ``time``, an ``offset`` before the end of the last step, by name."""
        return {}

    def residual(self, least: float) -> float:
        """Return a divergence over the gradient of the velocities, or the ``least`` one, that counts as well."""
        return 0.0

    def numbers(self) -> Mapping[str, Any]:
        """Return the numbers of the part for ``summary.json``."""
        return {}

    def places(self) -> Any:
        """Return numbers from which the places of the walls at present can be restored."""
        return None

    def host_state(self) -> Mapping[str, Any]:
        """Return the numbers outside the fields that a resumed run needs, by name."""
        return {}

    def restore_host_state(self, state: Mapping[str, Any], places: Any = None) -> None:
        """Restore the numbers of ``host_state``, with these ``places`` if given."""


class Coupling:
    """Unknowns that are found together with velocity and pressure in the outer iterations of a step; here none.

    ``rounding``: residual of the pressure below which there is only rounding. ``sets_curls``: whether ``correct`` sets
    the curl of the vorticity at walls.
    """

    rounding, sets_curls = 0.0, False

    def start(self, equations: "Equations", tolerance: float) -> bool:
        """Apply the impulse at the start; return whether its system was solved."""
        return True

    def correct_start(self, equations: "Equations", tolerance: float) -> bool:
        """Correct the first accelerations by the first pressure; return whether they had converged."""
        return True

    def prepare(self, equations: "Equations", dt: float, gamma0: float, time: float, allowed: float) -> None:
        """Begin a step ``dt`` that ends at ``time``, whose velocities may have an error ``allowed``."""

    def unknowns(self, dt: float) -> "Unknowns":
        """Return the unknowns of a step ``dt`` in a system that is solved for all of them together."""
        raise NotImplementedError

    def take(self, equations: "Equations", found: np.ndarray) -> None:
        """Take the unknowns (m,) that were ``found`` by it."""

    def correct(self, equations: "Equations") -> bool:
        """Correct the unknowns by the flow of the last outer iteration; return whether they had converged."""
        return True

    def error(self) -> tuple[float, float]:
        """Return differences from extrapolated unknowns, also by a level less [velocity]; infinite if not converged."""
        return 0.0, 0.0

    def store(self, time: float) -> None:
        """Store the unknowns at the ``time`` at the end of a step."""

    @property
    def drive(self) -> float | None:
        """Acceleration along x that is found, None where it is no unknown."""
        return None

    def host_state(self) -> Mapping[str, Any]:
        """Return the numbers that a resumed run needs, by name."""
        return {}

    def restore_host_state(self, state: Mapping[str, Any]) -> None:
        """Restore the numbers of ``host_state``."""
