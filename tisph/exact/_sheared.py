"""Equations of a fluid that is sheared between two walls, on the spectral elements of ``_collocation``.

    dv/dt = g + d/dy [ flux(rate) + sum S_xy(C) ],    dC/dt = law.rate_in_shear(C, rate),    rate = dv/dy + layer

and around or along an axis as in ``_collocation.Elements``. The state is v at the nodes, then the components of C
of each law at the points of each element. Derivatives of laws are computed by complex steps, exact to round-off.

In a system (shift - J) x = b the C at each point depend on the shear rate there alone. Eliminating them leaves a banded
matrix for v, however many modes there are.

``AnalyticLayer``, the shear of a solvent whose walls jump, is a closed form. Between planes it is the start-up flow Q
of the solvent alone (``couette``). Around or along an axis the continuous field of the elements obeys dv/dt = nu
(d2v/dr2 + k/r dv/dr), k = 3 or 1. The layer is v = h Q, with Q the plane flow between the same walls, or, with the axis
in the fluid, the plane flow between r = -R and R, which is even in r. It leaves

    nu h [(2 a + k/r) dQ/dr + (da/dr + a^2 + k a/r) Q],    a = (dh/dr)/h

its drift, in the equation of the remainder u - layer. The drift is as smooth as Q for h = r^(-k/2), a = -k/(2 r), which
has no term with dQ/dr; and for h = (R^2 + r^2)^(-k/2), a = -k r/(R^2 + r^2), which is even in r, and whose term with
dQ/dr is 0 at the wall.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from tisph.exact import couette
from tisph.exact._collocation import Elements
from tisph.exact._fluids import STEP, Fluid, PolymerLaw, derivative


class AnalyticLayer:
    """Layers at walls whose ``jumps``, triples (time, bottom, top), are in the unit of ``elements``' continuous field.

    ``viscosity``: kinematic viscosity of the solvent. A jump has no effect at its own time, except at t = 0, where the
    walls have their new velocities. ``shear_rates`` and ``drift`` have clocks that start at ``begin``.
    """

    def __init__(self, elements: Elements, jumps: Any, viscosity: float, begin: float = 0.0) -> None:
        self.begin, self.all = begin, jumps
        self.elements, self.viscosity = elements, viscosity
        self.jumps = [(time, *both) for time, *both in jumps if any(both)]
        self.gap, self.axis = float(elements.edges[-1]), elements.inner_radius == 0.0

    def later(self, begin: float) -> "AnalyticLayer":
        """Return the layers of the jumps up to ``begin``, on a clock that starts then."""
        return AnalyticLayer(self.elements, [jump for jump in self.all if jump[0] <= begin], self.viscosity, begin)

    def field(self, y: Any, t: Any) -> np.ndarray:
        """Return the continuous field: the velocity along the walls, or the angular velocity around the axis."""
        return self._factor(y)[0] * self._summed(couette.velocity, y, t)

    def shear_rate(self, y: Any, t: Any) -> np.ndarray:
        """Return the shear rate lever d(field)/dy."""
        factor, slope, _ = self._factor(y)
        rate = self._summed(couette.shear_rate, y, t)
        if self.elements.power:
            rate = rate + slope * self._summed(couette.velocity, y, t)
        return self.elements.lever(y) * factor * rate

    def _factor(self, y: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return h, a and da/dr."""
        k, r = self.elements.power, self.elements.radius(y)
        if self.axis:
            squares = self.gap**2 + r * r
            return squares ** (-k / 2), -k * r / squares, -k * (self.gap**2 - r * r) / squares**2
        return r ** (-k / 2), -k / (2 * r), k / (2 * r * r)

    def _summed(self, profile: Callable, y: Any, t: Any) -> np.ndarray:
        """Return the sum over all jumps of Q or dQ/dr, the plane start-up ``profile``."""
        total = np.zeros(np.broadcast_shapes(np.shape(y), np.shape(t)))
        for time, *both in self.jumps:
            if time == 0.0 or time < np.min(t):
                bottom, top = (jump / self._factor(end)[0] for jump, end in zip(both, (0.0, self.gap), strict=True))
                flow = {"gap": self.gap, "kinematic_viscosity": self.viscosity, "bottom": bottom, "top": top}
                if self.axis:
                    flow |= {"gap": 2 * self.gap, "bottom": top}
                total = total + profile(y + self.gap * self.axis, t - time, **flow)
        return total

    def shear_rates(self, times: np.ndarray) -> np.ndarray:
        """Return the shear rate (times, count, p + 1) at the points of the elements."""
        if not self.jumps:
            return np.zeros((len(times), *self.elements.y.shape))
        return self.shear_rate(self.elements.y, self.begin + times[:, None, None])

    def drift(self, times: np.ndarray) -> np.ndarray | float:
        """Return the layer's drift (times, size) in the equation of the remainder; 0.0 between planes."""
        if not (self.jumps and self.elements.power):
            return 0.0
        y, t = self.elements.node_positions, self.begin + times[:, None]
        factor, slope, bend = self._factor(y)
        # on the axis, which has no mass, the number has no effect, but must be finite
        curvature = self.elements.power / np.maximum(self.elements.radius(y), 1e-100)
        drift = (bend + slope * (slope + curvature)) * self._summed(couette.velocity, y, t)
        if self.axis:
            drift = drift + (2 * slope + curvature) * self._summed(couette.shear_rate, y, t)
        return self.viscosity * factor * drift


def jump(wall: Any, time: float) -> float:
    """Return the jump of the velocity of a wall at the ``time``."""
    return 0.0 if wall.stress_controlled else float(wall.after(time).velocity(time) - wall.velocity(time))


@dataclass(frozen=True)
class ShiftedWall:
    """A ``wall`` on a clock that starts at ``begin``."""

    wall: Any
    begin: float

    @property
    def stress_controlled(self) -> bool:
        return self.wall.stress_controlled

    @property
    def mass_per_area(self) -> float:
        return self.wall.mass_per_area

    @property
    def friction(self) -> float:
        return self.wall.friction

    def acceleration(self, t: Any) -> np.ndarray:
        return self.wall.acceleration(self.begin + t)

    def stress(self, t: Any) -> np.ndarray:
        return self.wall.stress(self.begin + t)


NEGLIGIBLE = 1e-12
"""Fraction of the largest component of C below which a component counts as zero in the tolerance."""


class Equations:
    """Equations of ``fluid`` (``flux``, ``laws``) on ``elements``; walls are (bottom, top), with ``acceleration(t)``.

    ``drive(times)``: the acceleration g.

    Walls that are ``stress_controlled`` (``geometry/motion.py``) have ``stress(t)`` and ``mass_per_area`` per unit
    density instead: the mass of the wall is added to the mass of its node, which obeys the weak form of the momentum
    equation like all others. If its ``friction`` is not 0, the stress - friction u acts on the node, too (slip).

    ``layer``: an ``AnalyticLayer``. ``speed``: least velocity to which the tolerance is relative. ``mass`` (nodes,):
    mass of each node, with its wall if that is stress-controlled. ``friction`` (nodes,): rate of v/v by slip.
    """

    def __init__(
        self,
        elements: Elements,
        fluid: Fluid,
        walls: Sequence,
        drive: Callable,
        layer: AnalyticLayer,
        speed: float,
    ) -> None:
        self.elements, self.fluid, self.layer = elements, fluid, layer
        self.walls = dict(zip((0, elements.size - 1), walls, strict=True))
        self.drive, self.speed = drive, speed
        self.mass, self.friction = elements.mass.copy(), np.zeros(elements.size)
        self.area = elements.radius(elements.node_positions) ** elements.power
        for place, wall in self.walls.items():
            if wall.stress_controlled:
                self.mass[place] += wall.mass_per_area
                self.friction[place] = self.area[place] * wall.friction / self.mass[place]
        self.free = np.ones(elements.size, dtype=bool)
        self.free[[place for place, wall in self.walls.items() if not wall.stress_controlled]] = False
        self.share = self.free * elements.mass / self.mass
        points = elements.y.size
        ends = elements.size + np.cumsum([0, *(law.components * points for law in fluid.laws)])
        self.parts = [slice(a, b) for a, b in pairwise(ends.tolist())]
        self.size = int(ends[-1])

    def conformation_excess(self, states: np.ndarray) -> list[np.ndarray]:
        """Return C (components, ..., count, p + 1) of each law, in ``states`` (..., size)."""
        shape = (*states.shape[:-1], -1, *self.elements.y.shape)
        return [np.moveaxis(states[..., part].reshape(shape), -3, 0) for part in self.parts]

    def shear_rate(self, states: np.ndarray, times: np.ndarray) -> np.ndarray:
        """Return the shear rate (times, count, p + 1)."""
        return self.elements.shear_rate(states[..., : self.elements.size]) + self.layer.shear_rates(times)

    def stress(self, conformation_excess: list[np.ndarray], rate: np.ndarray) -> np.ndarray:
        """Return the shear stress of solvent and laws together."""
        return self.fluid.flux(rate) + sum(
            law.stress(c)[1] for law, c in zip(self.fluid.laws, conformation_excess, strict=True)
        )

    def forcing(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the terms that do not depend on the state at ``times`` (times,).

        The shear rates (times, count, p + 1) of the layer, and the rates of v (times, nodes).
        """
        rates = (self.drive(times)[:, None] + self.layer.drift(times)) * self.share
        for place, wall in self.walls.items():
            if wall.stress_controlled:
                # the layer at the other wall has a stress here, which the weak form leaves out with its flux
                outwards = self.layer_stress(place, times) * (-1.0 if place == 0 else 1.0)
                rates[:, place] += self.area[place] * (wall.stress(times) - outwards) / self.mass[place]
            else:
                rates[:, place] += wall.acceleration(times)
        return self.layer.shear_rates(times), rates

    def layer_stress(self, place: int, times: np.ndarray) -> np.ndarray | float:
        """Return the shear stress of the layer, over the lever, (times,) at the node ``place``; 0 without a layer."""
        if not self.layer.jumps or (place == 0 and self.layer.axis):
            return 0.0
        y = self.elements.node_positions[place]
        return self.fluid.layer_flux(self.layer.shear_rate(y, self.layer.begin + times)) / self.elements.lever(y)

    def rates(self, states: np.ndarray, forcing: tuple[Any, Any]) -> np.ndarray:
        """Return dX/dt (times, size) of ``states`` (times, size), with the ``forcing`` at the same times."""
        layer, own = forcing
        result = np.empty_like(states)
        whole, conformation_excess = (
            self.elements.shear_rate(states[:, : self.elements.size]) + layer,
            self.conformation_excess(states),
        )
        # the inertia of ``layer`` balances its flux through the solvent, except for the drift
        flux = self.stress(conformation_excess, whole) - self.fluid.layer_flux(layer)
        result[:, : self.elements.size] = own + self.elements.weak_divergence(flux) * self.share
        result[:, : self.elements.size] -= self.friction * states[:, : self.elements.size]
        for law, c, part in zip(self.fluid.laws, conformation_excess, self.parts, strict=True):
            change = np.stack([np.broadcast_to(one, whole.shape) for one in law.rate_in_shear(tuple(c), whole)], axis=1)
            result[:, part] = change.reshape(len(states), -1)
        return result

    def scales(self, states: np.ndarray) -> np.ndarray:
        """Return the largest magnitudes (size,) of v and of each component of C in ``states`` (stages, size)."""
        result = np.empty(self.size)
        result[: self.elements.size] = max(self.speed, np.abs(states[:, : self.elements.size]).max())
        for c, part in zip(self.conformation_excess(states), self.parts, strict=True):
            largest = np.abs(c).reshape(len(c), -1).max(axis=1)
            floor = NEGLIGIBLE * largest.max() + 1e-200
            result[part] = np.repeat(np.maximum(largest, floor), self.elements.y.size)
        return result

    def jacobian(self, state: np.ndarray, time: float) -> "Jacobian | None":
        """Return the Jacobian at ``state`` (size,) and ``time``; None if it is not finite."""
        rate = self.shear_rate(state[None], np.array([time]))[0]
        local = [
            _derivatives(law, c, rate) for law, c in zip(self.fluid.laws, self.conformation_excess(state), strict=True)
        ]
        flux = np.broadcast_to(derivative(self.fluid.flux, rate), rate.shape)
        if not all(np.isfinite(part).all() for part in (flux, *(part for parts in local for part in parts))):
            return None
        return Jacobian(self, flux, local)


def _derivatives(law: PolymerLaw, c: Any, rate: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return d(dC/dt)/dC (m, m, ...), d(dC/dt)/drate (m, ...) and dS_xy/dC (m, ...) of a law, by complex steps."""

    def slopes(function: Callable, *arguments: Any) -> np.ndarray:
        parts = function(*arguments)
        return np.stack([np.broadcast_to(np.imag(part) / STEP, rate.shape) for part in parts])

    by_c, shear = [], []
    for k in range(law.components):
        moved = tuple(part + 1j * STEP * (k == j) for j, part in enumerate(c))
        by_c.append(slopes(law.rate_in_shear, moved, rate))
        shear.append(slopes(law.stress, moved)[1])
    return np.stack(by_c, axis=1), slopes(law.rate_in_shear, tuple(c), rate + 1j * STEP), np.stack(shear)


def _inverses(matrices: np.ndarray) -> np.ndarray:
    """Return the inverses of small ``matrices`` (m, m, ...) by Gauss-Jordan elimination without pivoting.

    Round-off errors in them slow Newton's method down, but do not change its result.
    """
    result = matrices.copy()
    for k in range(len(result)):
        pivot = 1 / result[k, k]
        column = -result[:, k] * pivot
        result[k, k] = 0.0
        column[k] = pivot
        row = result[k].copy()
        result[:, k] = 0.0
        result[k] = 0.0
        result += column[:, None] * row
        result[:, k] = column
    return result


class Jacobian:
    """d(dX/dt)/dX; ``flux``: d(flux)/drate (count, p + 1); ``local``: the ``_derivatives`` of each law."""

    def __init__(self, equations: Any, flux: np.ndarray, local: list) -> None:
        self.equations, self.elements = equations, equations.elements
        self.flux, self.local = flux, local

    def solver(self, shifts: np.ndarray) -> Callable:
        """Return a function that solves (shift - J) x = b for ``shifts`` (k,) and the rows of complex b (k, size)."""
        from scipy.linalg.lapack import zgbtrf, zgbtrs

        elements, order = self.elements, self.elements.order
        # elimination of C at each point: C = inverse b_C + by_rate dv/dy; ``pull`` b_C is the shear stress of the first
        points, coefficient = [], np.broadcast_to(self.flux, (len(shifts), *self.flux.shape))
        for part, (by_c, by_rate, shear) in zip(self.equations.parts, self.local, strict=True):
            unit = np.eye(len(by_c))[:, :, None, None, None]
            inverse = _inverses(shifts[:, None, None] * unit - by_c[:, :, None])
            pull = np.einsum("meq,mnkeq->nkeq", shear, inverse)
            by_rate = np.einsum("mnkeq,neq->mkeq", inverse, by_rate)
            coefficient = coefficient + np.einsum("meq,mkeq->keq", shear, by_rate)
            points.append((part, inverse, pull, by_rate))
        factors = [zgbtrf(one.T, order, order, overwrite_ab=True)[:2] for one in self._banded(shifts, coefficient)]

        def solve(b: np.ndarray) -> np.ndarray:
            result = np.empty_like(b)
            shape = (len(b), -1, *elements.y.shape)
            flux = sum(np.einsum("mkeq,kmeq->keq", pull, b[:, part].reshape(shape)) for part, _, pull, _ in points)
            right = b[:, : elements.size] * self.equations.mass
            if points:
                right += elements.weak_divergence(flux) * (elements.mass * self.equations.free)
            for row, (factor, pivots) in zip(right, factors, strict=True):
                row[:] = zgbtrs(factor, order, order, row, pivots)[0]
            result[:, : elements.size] = right
            rate = elements.shear_rate(right)
            for part, inverse, _, by_rate in points:
                own = np.einsum("mnkeq,kneq->kmeq", inverse, b[:, part].reshape(shape))
                own += (by_rate * rate).swapaxes(0, 1)
                result[:, part] = own.reshape(len(b), -1)
            return result

        return solve

    def _banded(self, shifts: np.ndarray, coefficient: np.ndarray) -> np.ndarray:
        """Return shift * mass + stiffness (k, size, 3 p + 1) as successive columns of LAPACK's banded storage.

        The row of a wall with a given velocity has only its diagonal element.
        """
        elements, order = self.elements, self.elements.order
        matrices = np.empty((*coefficient.shape, order + 1), dtype=complex)
        matrices.real, matrices.imag = elements.stiffness(coefficient.real), elements.stiffness(coefficient.imag)
        matrices[:, 0, 0] *= self.equations.free[0]
        matrices[:, -1, -1] *= self.equations.free[-1]
        joint = matrices[:, :-1, -1, -1] + matrices[:, 1:, 0, 0]
        matrices[:, :-1, -1, -1] = matrices[:, 1:, 0, 0] = joint  # both elements write to the same place
        band = np.zeros((len(shifts), elements.size, 3 * order + 1), dtype=complex)
        inner = band.reshape(len(shifts), -1)[:, 2 * order :]
        whole, one = inner.strides
        strides = (whole, order * (3 * order + 1) * one, one, 3 * order * one)
        np.lib.stride_tricks.as_strided(inner, matrices.shape, strides)[:] = matrices
        band[:, :, 2 * order] += (shifts[:, None] + self.equations.friction) * self.equations.mass
        return band
