"""The flow rate between open ends: the same through all cross-sections, at all times.

Pressures of a channel with open ends answer each error of the flow rate Q: a column of fluid of length l gains dQ in a
step dt by a pressure rho l dQ/(H dt). The pressure equation sums the divergence of all particles from the inlet on, and
truncation errors of the operators, which change with the arrangement of the particles, do not cancel in this sum: in
front of a blunt inlet, 28 across and 3 long, the pressure drop scattered from step to step by more than its value.

Therefore a step asks for dQ/dt itself. Sections s = 1, 2, ... cross the channel between the ends. Without divergence
the velocities of a step, with the acceleration a = (gamma_0 u - u^)/dt along paths, obey at each of them

    R_s = integral over the section of (a - u . grad u) . n  -  dQ/dt  -  (Q - Q_s)/T  =  0,

where n is the direction of the flow, Q the inflow, and Q_s the flow rate through the section; around an axis integrals
are over the area of the section. T is the time of the fluid from section to section: in this time errors of the flow
rate vanish. Between sections the pressure equation gets the uniform source (R_s - R_(s-1))/area, which is the mean
divergence that the operators miss there.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from tisph.measures.fits import sum_weights
from tisph.runtime import real, ti, view
from tisph.schemes.implicit.planar.equations import Equations
from tisph.schemes.implicit.planar.parts import Coupling
from tisph.schemes.implicit.planar.problem import Problem
from tisph.schemes.implicit.planar.time_levels import VELOCITIES, gradients
from tisph.schemes.implicit.planar.wall_boundary import WallBoundary

CLEAR, APART, MOST_SECTIONS = 6.0, 8.0, 12
"""Distance of sections from the ends and least distance between two, in particle spacings; their largest number."""

SETTLED = 1e-3
"""Largest pressure over the length of the channel by a residual, over density times reference velocity squared."""

UNCHANGED = 0.1
"""Change of the residuals by a correction, over their size, below which the linear systems are not solved accurately
enough to see it."""

LEAST_REYNOLDS = 0.3
"""Least Reynolds number of a spacing, U dx/nu, at which flow rates are controlled. In viscous flow pressures answer the
viscous drop, beside which their noise is small, and corrections do not converge: with 0.04 there are 19 in a step. With
0.3 there are 9 beside a free circle, whose velocities take 5; the pressure at the inlet then scatters by 0.04 %. With
0.5 it scatters by 0.14 %, and without control by 1.5 %."""


@ti.data_oriented
class FlowRateControl(Coupling):
    """The ``Coupling`` that finds the sources of the pressure equation for which the flow rate obeys the inflow.

    ``response``: change of a residual over its value that the source has which removes it in a fluid without viscosity.
    """

    def __init__(self, problem: Problem, boundary: WallBoundary, ends: Any) -> None:
        self.problem, self.boundary, self.levels, self.ends = problem, boundary, boundary.levels, ends
        self.inlet, self.axisymmetric = boundary.walls.bodies[-2], problem.axisymmetric
        self.along = float(self.inlet.shape.normal[0])
        self.response = 1.0
        self.placed: list[tuple[float, ...]] = []
        self.slopes = ti.field(real(), self.levels.points.slots + 1)
        low, high = sorted(problem.open_ends)
        clear = CLEAR * problem.spacing
        count = int(min(MOST_SECTIONS, (high - low - clear) // (APART * problem.spacing)))
        places = low + clear + (high - low - 2.0 * clear) * np.arange(count) / max(count - 1, 1)
        self.places = places if self.along > 0.0 else (low + high - places)
        self.length = high - low
        self.renewal = self.length / max(count, 1) / problem.reference_velocity

    def prepare(self, equations: "Equations", dt: float, gamma0: float, time: float, allowed: float) -> None:
        """Begin a step ``dt`` that ends at ``time``: place the sections, and compute the weights of their integrals."""
        from scipy.spatial import cKDTree

        problem, fluid = self.problem, self.levels.points.in_fluid
        positions, self.dt, self.gamma0 = self.boundary.positions, dt, gamma0
        self.place_sections(positions, time)
        tree = cKDTree(positions, boxsize=(0.0, 0.0))
        weights = [sum_weights(tree, nodes, lengths) for nodes, lengths in zip(self.nodes, self.lengths, strict=True)]
        self.weights = np.reshape(weights, (len(weights), len(positions)))
        self.sources, self.residual = np.zeros(len(self.sections) + 1), None
        self.slab = np.searchsorted(self.along * self.sections, self.along * positions[:fluid, 0])
        sizes = problem.circumferences(positions[:fluid, 1])
        areas = np.bincount(self.slab, sizes * self.levels.points.areas, len(self.sections) + 1)
        self.area = np.maximum(areas, sizes.min()) * problem.spacing**2

    def place_sections(self, positions: np.ndarray, time: float) -> None:
        """Set the places ``sections`` (n,) along x, and ``nodes`` (n, m, 2) and ``lengths`` (n, m) of their integrals.

        Around an axis the lengths are areas of rings. Sections that cross a body are left out. They change where a body
        has moved.
        """
        placed = [(*place.centre, place.angle) for place in (body.at(time) for body in self.ends.solid)]
        if placed == self.placed:
            return
        origin, spacing, self.placed = self.problem.origin, self.problem.spacing, placed
        on_walls = positions[self.boundary.slots, 1] + origin[1]
        low, high = on_walls.min(), on_walls.max()
        if self.problem.reaches_axis:
            low = 0.0
        heights = np.linspace(low, high, 4 * int(np.ceil((high - low) / spacing)))
        rule = np.polynomial.legendre.leggauss(max(20, round(0.5 * (high - low) / spacing)))
        grid = np.stack(np.broadcast_arrays(self.places[:, None] + origin[0], heights), axis=-1)
        distance = np.min([body.nearest(grid.reshape(-1, 2), time).distance for body in self.ends.solid], axis=0)
        sections, nodes, lengths = [], [], []
        for place, gap in zip(self.places, distance.reshape(grid.shape[:2]), strict=True):
            wet = np.flatnonzero(gap > 0.0)
            if not len(wet) or len(wet) <= wet[-1] - wet[0]:
                continue
            bottom, top = heights[wet[0]] - gap[wet[0]], heights[wet[-1]] + gap[wet[-1]]
            if self.problem.axisymmetric and wet[0] == 0:
                bottom = low
            along = 0.5 * (bottom + top + (top - bottom) * rule[0]) - origin[1]
            sections.append(place)
            nodes.append(np.stack([np.full_like(along, place), along], axis=1))
            lengths.append(0.5 * (top - bottom) * rule[1] * self.problem.circumferences(along))
        self.sections, self.nodes, self.lengths = np.array(sections), nodes, lengths

    def correct(self, equations: "Equations") -> bool:
        """Change the sources by the residuals of the sections; return whether these were small enough."""
        if not len(self.sections):
            return True
        self.measure_acceleration(equations.velocity.x, equations.alpha, self.gamma0, self.dt)
        n, area = self.levels.points.fluid, self.inlet.area
        inflow = area * self.inlet.course.velocity(self.ends.level_times)
        slope = (self.gamma0 * inflow[0] - view(equations.alpha)[: len(inflow) - 1] @ inflow[1:]) / self.dt
        slopes, rates = (
            self.along * (self.weights @ values[:n].astype(float))
            for values in (view(self.slopes), view(equations.velocity.x)[:, 0])
        )
        residual = slopes - slope - (inflow[0] - rates) / self.renewal
        pressure = np.abs(residual).max() * self.length / area
        if not pressure > SETTLED * self.problem.reference_velocity**2:
            return True
        if self.residual is not None:
            change = 1.0 - residual @ self.residual / (self.residual @ self.residual)
            if abs(change) < UNCHANGED:
                return True
            self.response = float(np.clip(self.response * change, 0.5, 1.5))
        self.residual = residual
        self.sources[:-1] -= np.diff(residual, prepend=0.0) / self.area[:-1] / self.response
        equations.sources = self.sources[self.slab]
        return False

    def host_state(self) -> dict[str, float]:
        """Return the number that a resumed run needs."""
        return {"response": self.response}

    def restore_host_state(self, state: Mapping[str, float]) -> None:
        """Restore the number of ``host_state``."""
        self.response = state["response"]

    @ti.kernel
    def measure_acceleration(self, velocity: ti.template(), alpha: ti.template(), gamma0: float, dt: float):
        """Compute du/dt = (gamma_0 u - u^)/dt - u . grad u at fixed places, for a ``velocity`` field.

        Around an axis v du/dr = r^2 V du/ds.
        """
        ti.loop_config(serialize=self.levels.operators.serial_light)
        for i in range(self.levels.points.particles[None]):
            d_dx, d_dy = gradients(self.levels.operators, velocity, i)
            own = velocity[i]
            if ti.static(self.axisymmetric):
                own.y *= self.levels.coordinates.radius(i) ** 2
            along = gamma0 * own.x
            for level in ti.static(range(VELOCITIES)):
                along -= alpha[level] * self.levels.carried(level, i).x
            self.slopes[i] = along / dt - own.x * d_dx.x - own.y * d_dy.x
