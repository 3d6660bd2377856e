"""Flow between two walls whose viscosity depends on temperature, heated by dissipation: steady, and from rest on.

Equations across plates (y), and along or around an axis (r), with constant density, conductivity k and heat capacity c:

    plates   rho u_t = (mu u')' + F,              rho c T_t = k T'' + mu u'^2
    along    rho u_t = (1/r) (r mu u')' + F,      rho c T_t = (k/r) (r T')' + mu u'^2
    around   rho v_t = (1/r^2) (r^2 mu g)',       rho c T_t = (k/r) (r T')' + mu g^2,     g = r (v/r)'

The viscosity mu(T, g) is any function of T and the shear rate g. F = G + B (T - T0) with a pressure gradient G = -dp/dx
and the buoyancy B per temperature, -rho beta times gravity along x. Each wall has a given speed or stress, and a given
temperature or heat flux. Units: as in ``heat``.

Numerics: the spectral elements of ``_collocation`` for u (v/r around an axis) and T. Stresses and heat fluxes of walls
enter the weak form; nodes at walls with a given speed or temperature are known. Steady states by Newton's method,
continued from the fluid without dissipation; start-up by collocation in the root of the time since the start, or
since the last time at which a wall speed jumps or bends.

Accuracy, relative to the largest value: 1e-12 in steady flow up to Nahme numbers of 2000, and 3e-9 in start-up. A wall
speed that jumps while dissipation heats the fluid has an error of 5e-8 from t* = nu t/gap^2 = 0.01 on, 3e-7 at 0.001.

Sources: R. B. Bird, W. E. Stewart and E. N. Lightfoot, Transport Phenomena, tables B.8 and B.9 and section 10.9, for
the equations; R. Nahme, Ingenieur-Archiv 11 (1940) 191-209, for the coupling by the viscosity.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tisph.errors import UnsolvedError
from tisph.exact import heat
from tisph.exact._collocation import Elements, RadauSolution, graded_edges
from tisph.exact._fluids import derivative

ORDER = 16
"""Order of the elements."""

FINEST, WIDEST = 0.002, 0.25
"""Widths of the elements at the walls and in the middle, over the gap."""

NEWTON_STEPS = 20
NEWTON_TOLERANCE = 1e-8
"""Relative size of the last step of Newton's method, whose error is about the square of it."""

FIRST_SHARE, LEAST_SHARE = 0.25, 1e-3
"""First and least growth of the share of the dissipation in the continuation to a steady state."""

TOLERANCE, STAGES = 1e-11, 9
"""Relative tolerance and stages of a step in time."""


@dataclass(frozen=True)
class Wall(heat.Wall):
    """A wall with a ``speed`` along the flow, or, if it is None, with a ``stress`` on the fluid.

    In start-up the ``speed`` may be a function of time. Around an axis the stress is the torque on the fluid per length
    over 2 pi R^2.
    """

    speed: float | Callable[[float], float] | None = 0.0
    stress: float = 0.0

    def speed_at(self, time: float) -> float:
        """Return the speed at a ``time``, 0 if the stress is given."""
        return float(self.speed(time) if callable(self.speed) else self.speed or 0.0)


@dataclass(frozen=True)
class HeatedShear:
    """A fluid of ``viscosity(T, g)`` between ``walls`` at the coordinates ``ends``, (lower, upper) or (inner, outer).

    ``viscosity`` is a real-analytic function of arrays. ``geometry``: "plates", or "along" or "around" an axis with
    radii as ``ends``; with the first radius 0 the fluid fills a pipe or a circle, and the first wall has no effect.
    ``conductivity`` k, ``heat_capacity`` c per mass, ``pressure_gradient`` G, ``buoyancy`` B [force per volume and
    temperature], ``reference`` T0. ``heating``: whether dissipation heats the fluid. ValueError for other ends,
    geometries and drives.
    """

    ends: tuple[float, float]
    walls: tuple[Wall, Wall]
    viscosity: Callable[[Any, Any], Any]
    conductivity: float
    density: float = 1.0
    heat_capacity: float = 1.0
    pressure_gradient: float = 0.0
    buoyancy: float = 0.0
    reference: float = 0.0
    heating: bool = True
    geometry: str = "plates"

    def __post_init__(self) -> None:
        if self.geometry not in ("plates", "along", "around"):
            raise ValueError(f"the geometry is 'plates', 'along' or 'around', not {self.geometry!r}")
        if not self.ends[0] < self.ends[1] or (self.geometry != "plates" and self.ends[0] < 0):
            raise ValueError(f"the coordinates of the walls must grow, radii from 0 on, not {self.ends}")
        if self.geometry == "around" and (self.pressure_gradient or self.buoyancy):
            raise ValueError("around an axis no pressure gradient and no buoyancy drives the flow")

    def steady(self) -> "Profiles":
        """Return the steady flow that is continuous with the flow without dissipation (the colder one of two).

        ValueError if the walls determine no velocity or no temperature, UnsolvedError if there is no steady flow, as
        above the largest stress of ``heat.ExponentialCouette``.
        """
        held = [wall.temperature for wall in self.walls if wall.temperature is not None]
        system = _System(self, held[0] if held else 0.0)
        speeds, temperatures = ([value is not None for value in pair] for pair in system.given())
        if not any(speeds) or not any(temperatures):
            raise ValueError("a steady flow needs a wall with a given speed, and one with a given temperature")
        share, growth = 0.0, FIRST_SHARE
        found = system.newton(system.with_walls(np.zeros(2 * system.size), 0.0), 0.0)
        while found is not None and share < 1.0 and self.heating:
            values, aim = found, min(1.0, share + growth)
            following = system.newton(values, aim)
            if following is not None:
                found, share = following, aim
            elif growth > LEAST_SHARE:
                growth /= 2
            else:
                found = None
        if found is None:
            raise UnsolvedError("Newton's method found no steady flow; at a given stress or flux there may be none")
        return Profiles(system, found)


class StartUp:
    """The ``flow`` from rest and the uniform temperature ``initial`` at t = 0 on.

    ``breaks``: times > 0 at which the speed of a wall jumps or bends. A change that is not named may fall between the
    points of a step.
    """

    def __init__(self, flow: HeatedShear, initial: float = 0.0, breaks: Sequence[float] = ()) -> None:
        self.system = _System(flow, initial)
        self.begins = [0.0, *sorted(breaks)]
        self._solutions: list[RadauSolution] = []
        self._start = np.zeros(2 * self.system.size)
        self._scales = self._estimated(initial)

    def at(self, time: float) -> "Profiles":
        """Return the fields at a ``time`` >= 0."""
        piece = max(int(np.searchsorted(self.begins, time)) - 1, 0)
        while len(self._solutions) <= piece:
            self._solutions.append(self._piece(len(self._solutions)))
        values = self.system.with_walls(self._start, time)
        values[self.system.free] = self._solutions[piece].at(time - self.begins[piece])
        return Profiles(self.system, values)

    def _piece(self, number: int) -> RadauSolution:
        """Return the solution from the break with this ``number`` on."""
        begin, flow = self.begins[number], self.system.flow
        start = self.at(begin).values if number else self._start
        viscosity = float(flow.viscosity(self.system.level, 0.0))
        diffusivity = max(viscosity, flow.conductivity / flow.heat_capacity) / flow.density
        first = 1e-3 * (flow.ends[1] - flow.ends[0]) / np.sqrt(diffusivity)
        equations = _InTime(self.system, self._start, begin, self._scales)
        return RadauSolution(equations, start[self.system.free], first, TOLERANCE, STAGES)

    def _estimated(self, initial: float) -> np.ndarray:
        """Return estimates (2 size,) of the largest velocity and change of temperature, for tolerances."""
        flow, gap = self.system.flow, self.system.flow.ends[1] - self.system.flow.ends[0]
        viscosity, around = float(flow.viscosity(initial, 0.0)), flow.geometry == "around"
        warmer = [
            abs(wall.heat_flux) * gap / flow.conductivity
            if wall.temperature is None
            else abs(wall.temperature - initial)
            for wall in flow.walls
        ]
        moments = [*self.begins, *(gap**2 * flow.density / viscosity * np.linspace(0.0, 1.0, 9))]
        speeds = [abs(wall.speed_at(moment)) for wall in flow.walls for moment in moments]
        force = abs(flow.pressure_gradient) + abs(flow.buoyancy) * (max(warmer) + abs(initial - flow.reference))
        stresses = [force * gap, *(abs(wall.stress) for wall in flow.walls if wall.speed is None)]
        speed = max(*speeds, max(stresses) * gap / viscosity, 1e-200)
        warmest = max(*warmer, flow.heating * viscosity * speed**2 / flow.conductivity, 1e-200)
        return np.repeat([speed / flow.ends[1] if around else speed, warmest], self.system.size)


class Profiles:
    """Fields across the gap; coordinates ``y`` are y or r, and results have their shape."""

    def __init__(self, system: "_System", values: np.ndarray) -> None:
        self.system, self.values = system, values
        self._field, self._temperature = np.split(values, 2)

    def velocity(self, y: Any) -> np.ndarray:
        """Return the velocity."""
        elements = self.system.elements
        return self._at(y, elements.levers * self._field[elements.nodes])

    def temperature(self, y: Any) -> np.ndarray:
        """Return the temperature."""
        return self.system.level + self._at(y, self._temperature[self.system.elements.nodes])

    def shear_stress(self, y: Any) -> np.ndarray:
        """Return the shear stress mu g."""
        rate = self.system.elements.shear_rate(self._field)
        return self._at(y, self.system.viscosity(self._temperature, rate) * rate)

    def heat_flux(self, y: Any) -> np.ndarray:
        """Return the heat flux -k dT/dy towards larger y."""
        return self._at(y, -self.system.flow.conductivity * self.system.thermal.shear_rate(self._temperature))

    def _at(self, y: Any, values: np.ndarray) -> np.ndarray:
        place = np.asarray(y, dtype=float) - self.system.flow.ends[0]
        return self.system.elements.interpolated(values, place.ravel()).reshape(place.shape)[()]


class _System:
    """The weak form of a ``flow``: vectors of values hold u, or v/r, at all nodes, then T - ``level`` at all nodes.

    Differences of T from a level near all of them keep the digits that the heat flux needs.
    """

    def __init__(self, flow: HeatedShear, level: float) -> None:
        low, high = flow.ends
        self.level = level
        edges, radius = (high - low) * graded_edges(1.0, FINEST, WIDEST), None if flow.geometry == "plates" else low
        self.flow = flow
        self.elements = Elements(edges, ORDER, radius, along=flow.geometry == "along")
        self.thermal = Elements(edges, ORDER, radius, along=True)
        self.size = self.elements.size
        self.masses = np.concatenate(
            [flow.density * self.elements.mass, flow.density * flow.heat_capacity * self.thermal.mass]
        )
        self.dissipated = self.thermal.half_width * self.thermal.weights * self.thermal.radii
        self.wall_terms, known = np.zeros(2 * self.size), np.zeros(2 * self.size, dtype=bool)
        for place, end, wall in self._walls():
            power = min(self.elements.power, 2), min(self.thermal.power, 1)
            self.wall_terms[place] = wall.stress * self.elements.radius(end - low) ** power[0]
            self.wall_terms[self.size + place] = wall.heat_flux * self.thermal.radius(end - low) ** power[1]
            known[place], known[self.size + place] = wall.speed is not None, wall.temperature is not None
        self.free = np.flatnonzero(~known)
        self.known = known

    def _walls(self) -> list[tuple[int, float, Wall]]:
        """Return node, coordinate and conditions of each wall."""
        walls = list(zip((0, self.size - 1), self.flow.ends, self.flow.walls, strict=True))
        return walls[1:] if self.elements.inner_radius == 0.0 else walls

    def given(self) -> tuple[list, list]:
        """Return the given speeds and the given temperatures of the walls."""
        walls = [wall for *_, wall in self._walls()]
        return [wall.speed for wall in walls], [wall.temperature for wall in walls]

    def with_walls(self, values: np.ndarray, time: float) -> np.ndarray:
        """Return a copy of ``values`` with the given speeds and temperatures of the walls at a ``time``."""
        values = values.copy()
        for place, end, wall in self._walls():
            if wall.speed is not None:
                values[place] = wall.speed_at(time) / self.elements.lever(end - self.flow.ends[0])
            if wall.temperature is not None:
                values[self.size + place] = wall.temperature - self.level
        return values

    def viscosity(self, temperature: np.ndarray, rate: np.ndarray) -> np.ndarray:
        """Return mu at the points of the elements, from T - level (..., size) at nodes and the shear rate at points."""
        return self.flow.viscosity(self.level + temperature.take(self.elements.nodes, axis=-1), rate) + 0.0 * rate

    def residual(self, values: np.ndarray, share: float = 1.0) -> np.ndarray:
        """Return force and heating (..., 2 size) of nodes, with a ``share`` of the dissipation."""
        flow, elements, thermal = self.flow, self.elements, self.thermal
        field, temperature = np.split(values, 2, axis=-1)
        rate = elements.shear_rate(field)
        stress = self.viscosity(temperature, rate) * rate
        force = flow.pressure_gradient + flow.buoyancy * (temperature + (self.level - flow.reference))
        momentum = elements.mass * (elements.weak_divergence(stress) + force)
        heating = thermal.mass * thermal.weak_divergence(flow.conductivity * thermal.shear_rate(temperature))
        if flow.heating and share:
            heating = heating + thermal.assembled(share * self.dissipated * stress * rate)
        return np.concatenate([momentum, heating], axis=-1) + self.wall_terms

    def jacobian(self, values: np.ndarray, share: float = 1.0) -> np.ndarray:
        """Return the derivatives (2 size, 2 size) of the ``residual`` at ``values`` (2 size,)."""
        flow, elements, thermal = self.flow, self.elements, self.thermal
        field, temperature = np.split(values, 2)
        rate, local = elements.shear_rate(field), self.level + temperature[elements.nodes]
        mu = self.viscosity(temperature, rate)
        warmer = derivative(lambda one: flow.viscosity(one, rate), local) + 0.0 * rate
        faster = mu + rate * derivative(lambda one: flow.viscosity(local, one), rate)
        slopes = elements.matrix * (elements.levers / elements.half_width)[..., None]
        result = np.zeros((2, self.size, 2, self.size))
        share = share * flow.heating

        def add(row: int, column: int, parts: np.ndarray) -> None:
            for nodes, part in zip(elements.nodes, parts, strict=True):
                result[row, nodes[:, None], column, nodes] += part

        add(0, 0, -elements.stiffness(faster))
        add(0, 1, -elements.matrix.T * (elements.fluxes * warmer * rate)[:, None])
        add(1, 0, (share * self.dissipated * (mu + faster) * rate)[..., None] * slopes)
        add(1, 1, -thermal.stiffness(np.full(rate.shape, flow.conductivity)))
        add(1, 1, np.eye(elements.order + 1) * (share * self.dissipated * warmer * rate**2)[:, None])
        result[0, np.arange(self.size), 1, np.arange(self.size)] += flow.buoyancy * elements.mass
        return result.reshape(2 * self.size, -1)

    def newton(self, values: np.ndarray, share: float) -> np.ndarray | None:
        """Return the steady values with a ``share`` of the dissipation, None if Newton's method does not converge."""
        from scipy.sparse import csc_array
        from scipy.sparse.linalg import splu

        values, free = values.copy(), self.free
        with np.errstate(all="ignore"):
            for _ in range(NEWTON_STEPS):
                jacobian = self.jacobian(values, share)
                if not np.isfinite(jacobian).all():
                    return None
                change = np.zeros(2 * self.size)
                try:
                    factor = splu(csc_array(jacobian[np.ix_(free, free)]))
                except RuntimeError:  # the matrix is singular
                    return None
                change[free] = factor.solve(self.residual(values, share)[free])
                values -= change
                if np.all(np.abs(change) <= NEWTON_TOLERANCE * self._scales(values)):
                    return values
        return None

    def _scales(self, values: np.ndarray) -> np.ndarray:
        """Return estimates (2 size,) of the largest u, or v/r, and of the largest difference of T."""
        field, temperature = np.split(values, 2)
        rate = self.elements.shear_rate(field)
        gap = self.flow.ends[1] - self.flow.ends[0]
        dissipated = np.max(self.viscosity(temperature, rate) * rate**2) * gap**2 / self.flow.conductivity
        warmest = np.ptp(temperature) + dissipated
        return np.repeat([np.abs(field).max(), warmest], self.size) + 1e-200


class _InTime:
    """Equations of the free values for ``RadauSolution``, on a clock that starts at ``begin``."""

    def __init__(self, system: _System, start: np.ndarray, begin: float, least: np.ndarray) -> None:
        self.system, self.start, self.begin, self.least = system, start, begin, least

    def forcing(self, times: np.ndarray) -> np.ndarray:
        """Return values (times, 2 size) that are right at the walls."""
        return np.stack([self.system.with_walls(self.start, self.begin + time) for time in times])

    def rates(self, states: np.ndarray, forcing: np.ndarray) -> np.ndarray:
        """Return the time derivatives (times, free) of ``states`` (times, free)."""
        values, free = forcing.copy(), self.system.free
        values[:, free] = states
        return self.system.residual(values)[:, free] / self.system.masses[free]

    def scales(self, states: np.ndarray) -> np.ndarray:
        """Return the largest velocity and change of temperature (free,) in ``states`` (stages, free)."""
        change = np.abs(states - self.start[self.system.free]).max(axis=0)
        of_field = self.system.free < self.system.size
        largest = [np.max(change, where=where, initial=0.0) for where in (of_field, ~of_field)]
        return np.maximum(np.where(of_field, *largest), self.least[self.system.free])

    def jacobian(self, state: np.ndarray, time: float) -> "_Jacobian | None":
        """Return the Jacobian at a ``state`` (free,) and ``time``; None if it is not finite."""
        values, free = self.system.with_walls(self.start, self.begin + time), self.system.free
        values[free] = state
        matrix = self.system.jacobian(values)[np.ix_(free, free)] / self.system.masses[free][:, None]
        return _Jacobian(matrix) if np.isfinite(matrix).all() else None


@dataclass(frozen=True)
class _Jacobian:
    """A dense ``matrix`` J (free, free)."""

    matrix: np.ndarray

    def solver(self, shifts: np.ndarray) -> Callable:
        """Return a function that solves (shift - J) x = b for ``shifts`` (k,) and the rows of complex b (k, free)."""
        from scipy.sparse import csc_array, eye_array
        from scipy.sparse.linalg import splu

        matrix, unit = csc_array(self.matrix), eye_array(len(self.matrix), format="csc")
        factors = [splu((shift * unit - matrix).astype(complex)) for shift in shifts]
        return lambda b: np.stack([factor.solve(row) for factor, row in zip(factors, b, strict=True)])
