"""Temperature and dissolved substances in two-dimensional flow: quantities T that particles carry, and that diffuse.

Along the path of a particle there is no convective term. With the weights gamma_0 and alpha_q of backward differences,
the diffusivity kappa, and the rate r of sources and viscous heating, all at the end of a step dt (docs/theory/heat.md),

    (gamma_0 - dt kappa L) T = sum_q alpha_q T_q + dt r        in the fluid,                             (3)
    T = T_w    or    n . G T = -q/(C kappa)                    at a point of a wall,                     (4)

where q is the flux into the fluid, n points into it, and C is the amount in a volume per T. At an inlet T is given, at
an outlet n . G T = 0. L and G are the operators of the velocities, those of even functions in axisymmetric flow. Values
at points whose flux is given are eliminated, so that the system has the particles as unknowns.

Viscous heating is the power of all stresses, for a Newtonian fluid nu (2 D:D)/c. A temperature acts on the flow by the
body force -beta (T - T_0) g, and by the factor a(T) of viscosity and relaxation times. T is found for the extrapolated
velocities when a step begins, and found anew from each outer iteration's velocities where these heat the fluid.
"""

from collections.abc import Mapping, Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np

from tisph.errors import DivergedError
from tisph.geometry.ends import Inlet, OpenEnd
from tisph.measures.substance import Condition, Substance
from tisph.numerics.point_cloud import active
from tisph.numerics.stokes import SparseRows
from tisph.runtime import real, ti, view
from tisph.schemes.implicit.planar.open_ends import UNJUDGED
from tisph.schemes.implicit.planar.parts import Boundary, ExtraStress
from tisph.schemes.implicit.planar.time_levels import VELOCITIES, TimeLevels, TimeWeights, gradients, transfer

RESIDUAL = 1e-2
"""Residual of a system, over the error of T that a step may have."""

STRICT = 10.0
"""Factor of the errors of T beside those of velocities: a slab that heats up, 25 across, has errors of 3e-5 and 1.4e-5
at t = 0.02 and 0.1 in 85 and 116 steps with 1, and of 2.2e-5 and 2.8e-6 in 141 and 194 steps with 10; the spacing alone
has 2e-5 and 6e-7. Where T drives the flow, velocities have the larger errors."""

MOST_ITERATIONS = 400
"""Iterations of a linear system, which has diagonal preconditioning."""

FLOW_LEVELS = 3
"""Levels of the flows through walls, for values within a step."""

OUTWARD = Condition()
"""Condition at an outlet."""


class Transport:
    """The substances of a flow; here none. ``factor``: of the viscosity, at the points. ``fields``: of particles."""

    fields: Sequence[Any] = ()
    parts: Mapping[str, Any] = {}
    factor: Any = 1.0

    @property
    def cause_of_speed(self) -> str:
        """Cause of velocities that grow without end, for a message; empty where it is not a temperature."""
        return ""

    def begin(self, values: Sequence[np.ndarray], time: float) -> None:
        """Start at ``time``, with ``values`` of the ``fields`` that earlier flow has left, if any."""

    def body_force(self) -> np.ndarray | None:
        """Return the body force (points, 2) at present; None without one."""
        return None

    def prepare(self, weights: TimeWeights, dt: float, time: float, tolerance: float, velocity: Any) -> bool:
        """Find T at the end of a step, at ``time``, for an extrapolated ``velocity``; return whether it was solved."""
        return True

    def correct(self, velocity: Any) -> bool:
        """Find T for a ``velocity`` of the step; return whether it was solved."""
        return True

    def error(self, speed: float) -> tuple[float, float]:
        """Return the difference from the extrapolated T, and of lower order, for a scale of ``speed``."""
        return 0.0, 0.0

    def store(self, time: float, dts: Sequence[float]) -> None:
        """Store the T of the step that ends at ``time``; ``dts``: this step and those before it."""

    def remap(self) -> None:
        """Transfer the levels with a shift of the particles."""

    def seen(self, weights: TimeWeights, offset: float, values: Sequence[np.ndarray]) -> Mapping[str, Any]:
        """Return numbers of a ``Snapshot`` an ``offset`` before the end of the last step.

        ``values``: those of ``fields`` in the order of the snapshot.
        """
        return {}

    def host_state(self) -> Mapping[str, Any]:
        """Return the numbers outside the fields that a resumed run needs."""
        return {}

    def restore_host_state(self, state: Mapping[str, Any]) -> None:
        """Restore the numbers of ``host_state``."""


@ti.data_oriented
class CarriedSubstances(Transport):
    """The ``Transport`` of the substances of a problem.

    ``values`` (fluid): the ``VELOCITIES`` last levels of each substance, newest first. ``present`` (substances,
    points): T in the present step. ``flows`` and ``received``: levels of those of a ``Snapshot``.
    """

    def __init__(self, boundary: Boundary, levels: TimeLevels, extra_stress: ExtraStress) -> None:
        self.boundary, self.levels, self.extra_stress = boundary, levels, extra_stress
        self.problem = boundary.problem
        self.operators, self.points = levels.operators, levels.points
        self.substances: Sequence[Substance] = self.problem.substances
        kind = ti.types.vector(VELOCITIES * len(self.substances), real())
        self.values = self.points.count(ti.field(kind, self.points.slots + 1))
        self.d_dx, self.d_dy = (ti.field(kind, self.points.slots + 1) for _ in range(2))
        self.d_dx.used = self.d_dy.used = None
        self.fields, self.parts = (self.values,), {"transport": self}
        self.heated = any(each.heating for each in self.substances)
        self.flows: list[np.ndarray] = []
        self.rates: list[np.ndarray] = []
        self.received = [np.zeros(len(self.substances))]

    @property
    def stored(self) -> np.ndarray:
        """Levels (points, substances, levels), in place."""
        return active(self.values).reshape(-1, len(self.substances), VELOCITIES)

    @property
    def places(self) -> tuple[np.ndarray, np.ndarray]:
        """Places x, y (points,) of all points in the frame of the scene."""
        return self.problem.places(view(self.points.position)[: self.points.fluid].astype(float))

    @property
    def radius(self) -> Any:
        """Distances (points,) from the axis; 1 in planar flow."""
        return self.places[1] if self.problem.axisymmetric else 1.0

    @property
    def factor(self) -> Any:
        """Factor (points,) of viscosity and relaxation times, 1 without an effect."""
        result: Any = 1.0
        for each, values in zip(self.substances, self.present, strict=True):
            if each.law:
                result = result * each.factor(values)
        if not np.all(np.isfinite(result)):
            raise DivergedError("temperature: it has left the range in which its law has a viscosity")
        return result

    @property
    def cause_of_speed(self) -> str:
        """Cause of velocities that grow without end: heat by which the viscosity falls."""
        pairs = zip(self.substances, self.present, strict=True)
        highest = max((float(values.max()) for each, values in pairs if each.heating and each.law), default=None)
        if highest is None:
            return ""
        return (
            f": the temperature has risen to {highest:.4g}, and heat is made faster than walls take it; no steady flow"
        )

    def begin(self, values: Sequence[np.ndarray], time: float) -> None:
        """Start with the initial values, or with ``values`` of an earlier flow; points on walls have their own."""
        x, y = self.places
        for number, each in enumerate(self.substances):
            self.stored[:, number] = each.initial(x, y, time)[:, None]
        if values:
            self.stored[...] = values[0].reshape(self.stored.shape)
        self.present = self.stored[:, :, 0].T.astype(float)
        for number, each in enumerate(self.substances):
            known, given, _ = self.conditions(each, time)
            self.present[number, known] = given
        self.stored[:, :, 0] = self.present.T

    def condition(self, each: Substance, body: Any) -> Condition:
        """Return the condition of a substance at a ``body``: a wall, a body in the fluid, or an open end."""
        if isinstance(body, OpenEnd):
            return Condition(value=each.inlet) if isinstance(body, Inlet) else OUTWARD
        return each.conditions[next(n for n, other in enumerate(self.problem.all_bodies) if other is body)]

    def conditions(self, each: Substance, time: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return slots of points on walls whose value is known, these values, and n . G T (count,) at all points."""
        walls, first = self.problem.walls, self.points.in_fluid
        known, given, slope = [np.empty(0, dtype=int)], [np.empty(0)], np.zeros(self.points.fluid - first)
        if walls is None:
            return known[0], given[0], slope
        x, y = (part[first:] for part in self.places)
        for body, part in zip(walls.bodies, walls.parts, strict=True):
            condition = self.condition(each, body)
            if condition.value:
                known.append(first + np.arange(part.start, part.stop))
                given.append(condition.value(x[part], y[part], time))
            elif condition.flux:
                slope[part] = -condition.flux(x[part], y[part], time) / (each.capacity * each.diffusivity)
        return np.concatenate(known), np.concatenate(given), slope

    def assemble(self) -> None:
        """Set the matrices of the present operators: Laplacian, derivatives, and rows (4) of points on walls."""
        from scipy.sparse import diags, vstack

        first, n, slopes = self.points.in_fluid, self.points.fluid, (self.operators.d_dx, self.operators.d_dy)
        fluid, walls = SparseRows(self.points, 0, first), SparseRows(self.points, first, n)
        self.laplacian = fluid.matrix(self.operators.laplacian)
        by_x, by_y = (walls.matrix(slope) for slope in slopes)
        if self.heated:
            self.slopes = [
                vstack([fluid.matrix(s), at_walls]) for s, at_walls in zip(slopes, (by_x, by_y), strict=True)
            ]
        self.normal_rows: Any = None
        if self.problem.walls:
            x, y = self.boundary.normals.T  # type: ignore[attr-defined]
            y = y * self.radius[first:] if self.problem.axisymmetric else y
            self.normal_rows = diags(x) @ by_x + diags(y) @ by_y
            outlet = self.boundary.outlet
            if outlet is not None:
                last = int(view(outlet)) - first
                through = SparseRows(self.points, first + last, n).matrix(self.operators.laplacian)
                self.normal_rows = vstack([self.normal_rows[:last], through]).tocsr()

    def body_force(self) -> np.ndarray | None:
        """Return -beta (T - T_0) g (points, 2); None where no T acts on the fluid."""
        pairs = zip(self.substances, self.present, strict=True)
        forces = [np.outer(values - each.reference, each.buoyancy) for each, values in pairs if each.buoyancy.any()]
        return np.sum(forces, axis=0) if forces else None

    def prepare(self, weights: TimeWeights, dt: float, time: float, tolerance: float, velocity: Any) -> bool:
        """Find T at the end of a step for an extrapolated ``velocity``; return whether it was solved."""
        self.dt, self.time, self.tolerance = dt, time, tolerance
        self.gamma0, alpha = weights.bdf()
        self.assemble()
        levels = self.stored.astype(float)
        self.history = levels @ alpha
        self.extrapolated, self.lower = (
            levels @ weights.extrapolation(VELOCITIES),
            levels @ weights.lower_extrapolation(),
        )
        self.present = self.extrapolated.T.copy()
        return self.solve_all(velocity)

    def correct(self, velocity: Any) -> bool:
        """Find T for a ``velocity`` of the step, where it heats the fluid; return whether it was solved."""
        return not self.heated or self.solve_all(velocity)

    def solve_all(self, velocity: Any) -> bool:
        """Solve (3) and (4) for all substances; return whether they were solved."""
        power = self.power(view(velocity)[: self.points.fluid].astype(float)) if self.heated else 0.0
        x, y = (part[: self.points.in_fluid] for part in self.places)
        self.made = []
        solved = True
        for number, each in enumerate(self.substances):
            made = each.heating * power + (each.source(x, y, self.time) if each.has_source else 0.0)
            self.made.append(np.broadcast_to(made, x.shape))
            right = self.history[: self.points.in_fluid, number] + self.dt * made
            solved = self.solve(number, each, right) and solved
        return solved

    def solve(self, number: int, each: Substance, right: np.ndarray) -> bool:
        """Solve (3) and (4) for one substance with this ``right``-hand side; return whether it was solved."""
        from scipy.sparse.linalg import LinearOperator, bicgstab, splu

        first, n, values = self.points.in_fluid, self.points.fluid, self.present[number]
        known, given, slope = self.conditions(each, self.time)
        open_points = np.setdiff1d(np.arange(first, n), known)
        diffusion, whole = self.dt * each.diffusivity, np.zeros(n)
        rows = self.normal_rows[open_points - first] if len(open_points) else None
        factors = splu(rows[:, open_points].tocsc()) if rows is not None else None

        def laplacian(fluid: Any, given: Any, slope: Any) -> np.ndarray:
            """Return L T of values in the fluid, with these conditions at walls; ``whole`` has all values then."""
            whole[:first], whole[known], whole[open_points] = fluid, given, 0.0
            if rows is not None and factors is not None:
                whole[open_points] = factors.solve(slope - rows @ whole)
            return self.laplacian @ whole

        right = right + diffusion * laplacian(0.0, given, slope[open_points - first])
        inverse = 1.0 / (self.gamma0 - diffusion * self.laplacian.diagonal())
        allowed = RESIDUAL * self.tolerance * each.scale * np.sqrt(first)
        matrix, jacobi = (
            LinearOperator((first, first), function)
            for function in (lambda v: self.gamma0 * v - diffusion * laplacian(v, 0.0, 0.0), inverse.__mul__)
        )
        found, failed = bicgstab(
            matrix, right, values[:first], rtol=0.0, atol=allowed, maxiter=MOST_ITERATIONS, M=jacobi
        )
        laplacian(found, given, slope[open_points - first])
        values[...] = whole
        return not failed

    def power(self, velocity: np.ndarray) -> np.ndarray:
        """Return the power of all stresses per mass at the particles, for a ``velocity`` (points, numbers)."""
        by_x, by_y = ((matrix @ velocity).T for matrix in self.slopes)
        if not self.problem.axisymmetric:
            along, shear, none = by_x[0] - by_y[1], by_x[1] + by_y[0], np.zeros_like(by_x[0])
            strain = np.stack([along, shear, -along, none, none, none])
        else:
            radius, across = self.radius, velocity[:, 1]
            radial = across + radius**2 * by_y[1]
            shears = radius * (by_y[0] + by_x[1]), radius * by_x[2], radius**2 * by_y[2]
            strain = np.stack([-2.0 * (across + radial), shears[0], 2.0 * radial, 2.0 * across, *shears[1:]])
        return self.extra_stress.power(strain, self.problem.solvent_viscosity)[: self.points.in_fluid]

    def error(self, speed: float) -> tuple[float, float]:
        """Return ``STRICT`` times the differences from extrapolated T, for a scale ``speed``."""
        first, weights = self.points.in_fluid, np.broadcast_to(self.points.areas, self.points.in_fluid)
        for end in self.problem.open_ends:
            away = np.abs(view(self.points.position)[:first, 0] - end) / self.problem.spacing
            weights = np.where(away > UNJUDGED, weights, 0.0)
        differences = []
        for guess in (self.extrapolated, self.lower):
            squares = np.average(np.square(self.present.T - guess)[:first], weights=weights, axis=0)
            scaled = np.sqrt(squares) / [each.scale for each in self.substances]
            differences.append(STRICT * speed * float(scaled.max()))
        return differences[0], differences[1]

    def flow(self) -> np.ndarray:
        """Return the amounts (substances, bodies) that flow from each wall into the fluid in a time."""
        walls, found = self.problem.walls, np.zeros((len(self.substances), 0))
        if walls is None:
            return found
        length = walls.length * self.problem.circumferences(view(self.points.position)[self.points.on_walls, 1])
        slopes = [self.normal_rows @ values for values in self.present]
        return np.array(
            [
                [-each.capacity * each.diffusivity * float(length[part] @ slope[part]) for part in walls.parts]
                for each, slope in zip(self.substances, slopes, strict=True)
            ]
        )

    def integral(self, rate: np.ndarray) -> float:
        """Return the integral of a ``rate`` (particles,) over the fluid, as samples have it (``Scene.mean``)."""
        if not rate.any():
            return 0.0
        fluid, mean = self.points.in_fluid, self.problem.mean
        areas = np.broadcast_to(self.points.areas, fluid)
        x, y = (part[:fluid] for part in self.places)
        seen = SimpleNamespace(x=x, y=y, weight=areas / areas.mean())
        rate = rate * self.problem.circumferences(view(self.points.position)[:fluid, 1])
        whole = self.problem.spacing**2 * float(areas.sum())
        return whole * (mean(seen, rate) if mean else float(np.average(rate, weights=areas)))

    def store(self, time: float, dts: Sequence[float]) -> None:
        """Store the T of the step that ends at ``time``, and what it has received."""
        stored = self.stored
        stored[:, :, 1:] = stored[:, :, :-1].copy()
        stored[:, :, 0] = self.present.T
        self.measure()
        self.flows = [self.flow(), *self.flows][:FLOW_LEVELS]
        made = [each.capacity * self.integral(rate) for each, rate in zip(self.substances, self.made, strict=True)]
        self.rates = [self.flows[0].sum(axis=1) + np.array(made), *self.rates][:VELOCITIES]
        steps = [0.0, *dts][: len(self.rates)]
        weights = TimeWeights(steps, dts[0]).integral(dts[0]) if len(steps) > 1 else np.array([dts[0]])
        received = self.received[0] + sum(w * rate for w, rate in zip(weights, self.rates, strict=False))
        self.received = [received, *self.received][:VELOCITIES]

    def seen(self, weights: TimeWeights, offset: float, values: Sequence[np.ndarray]) -> Mapping[str, Any]:
        """Return the substances, their flows and what the fluid has received, for a ``Snapshot``."""
        levels = values[0].reshape(-1, len(self.substances), VELOCITIES)
        found = levels @ weights.interpolation(offset, VELOCITIES) if offset else levels[:, :, 0]
        names = [each.name for each in self.substances]
        past = {"flows": self.flows, "received": self.received}
        numbers = {
            name: np.tensordot(weights.interpolation(offset, len(each)), each, 1) for name, each in past.items() if each
        }
        return {"substances": dict(zip(names, found.T.copy(), strict=True)), **numbers}

    def host_state(self) -> Mapping[str, Any]:
        """Return the numbers outside the fields that a resumed run needs."""
        state = {"flows": self.flows, "rates": self.rates, "received": self.received}
        return {name: np.asarray(values).tolist() for name, values in state.items()}

    def restore_host_state(self, state: Mapping[str, Any]) -> None:
        """Restore the numbers of ``host_state``."""
        names = ("flows", "rates", "received")
        self.flows, self.rates, self.received = ([np.array(values) for values in state[name]] for name in names)
        self.present = self.stored[:, :, 0].T.astype(float)

    @ti.kernel
    def measure(self):
        """Compute the gradients of all levels."""
        ti.loop_config(serialize=self.operators.serial)
        for i in range(self.points.particles[None]):
            self.d_dx[i], self.d_dy[i] = gradients(self.operators, self.values, i)

    @ti.kernel
    def remap(self):
        """Transfer all levels with a shift."""
        ti.loop_config(serialize=self.operators.serial)
        for i in range(self.points.particles[None]):
            moved = self.levels.coordinates.shifted(i, self.levels.shift.moved[i])
            self.values[i] += transfer(self.operators, self.d_dx, self.d_dy, i, moved)
