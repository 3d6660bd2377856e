"""Start-up flow of any fluid between two walls, plane or cylinders: a numerical reference, to 1e-8.

Equations for 0 < y < gap, with g = -(dp/dx)/density, all stresses over the density:

    du/dt = g + d/dy [ flux(du/dy) + sum of S_xy ],    dC/dt = law.sheared(C, du/dy),    S = law.stress(C)

for each law (mode) of a polymer, C the deviation of its conformation tensor from rest (``tisph/rheology``), and flux =
solvent_viscosity * du/dy, or viscosity((du/dy)^2) * du/dy of a generalised Newtonian liquid. The walls move with given
velocities, or are driven by a stress (``geometry/plate.py``), with mass_per_area * dU/dt = stress - shear stress of the
liquid; the flow starts from rest at t = 0, or, with ``before``, from the developed flow of other walls. Where what
drives changes at once later on, a new solution begins, in the root of the time from then on.

Between cylinders y = r - R1. Seen by who turns with the liquid, the flow is simple shear of the rate r d(u/r)/dr, x
around the axis and y outwards, so that the laws are the same; u/r has the place of u, as ``_elements`` says.

A wall whose velocity jumps at t = 0, or later, makes a layer sqrt(t) deep. Where a solvent of constant viscosity takes
it, its own start (``_layer``) is left to a closed form, u = v + that, and v is smooth. Liquids that remember nothing
start with the jump between the wall and the next point. The periodic flow of a
Newtonian fluid whose wall oscillates is added to the solution of the rest, which decays.

Numerics: polynomials on elements that are finest at the walls (``_elements``), collocation in sqrt(t) (``_stiff``).
Solved once, as far as it is asked for; no result depends on what was asked before.

Accuracy, relative to the largest value in the gap, measured against closed forms and against other orders: polymers
with solvent fractions from 0.01 on: velocity, stress and N1 1e-8 from solvent_viscosity t/gap^2 = 1e-5 on, 1e-11 once
the layers have crossed the gap; without memory: velocity 1e-6, stress 2e-6 from t* = 1e-3 on after a jump of a wall,
and 1e-8 in developed flow, 1e-6 where a plug has edges of 1e-3 of the gap; stress 1e-6 at a rate of 0, 5e-5 there.
Viscosities that differ by more than some 1e3 within the gap lose digits to rounding, and may end in an UnsolvedError. A
polymer takes about a second of processor time, a liquid without memory less in a driven flow, and more after a jump of
a wall: until the layer is as deep as an element is wide, steps are as short as it takes the front to pass from point to
point. At large regularisation a liquid with a yield stress does not get beyond that: UnsolvedError.
"""

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from tisph.exact._elements import Elements, graded_edges
from tisph.exact._layer import LaterWall, Layer, jump
from tisph.exact._sheared import Equations
from tisph.exact._stiff import Solution

ORDER = 16
FINEST, WIDEST = 1e-3, 0.0625
"""Order of the elements, and the width over the gap of those at the walls and in the middle."""

REFINEMENTS = 3
"""Solutions for the residual of a periodic flow: the first one alone loses digits to rounding, 1e-8 in places."""

REMEMBERED, MOST_DOUBLINGS, STEADY = 20.0, 8, 1e-9
"""Longest times of the liquid, viscous and relaxation, after which a flow may be developed. It is where as long a time
again changes all by less than STEADY of the largest value; else the time is doubled."""


@dataclass(frozen=True)
class Polymer:
    """Kinematic viscosity of the solvent (> 0, else ValueError) and ``laws`` of the polymer's modes, over density.

    Without any it is a Newtonian liquid.

    ``tolerance`` of a step in time and its ``stages``: with 7 there are twice as many steps, in 1.5 times the time.
    """

    layered: ClassVar[bool] = True
    tolerance: ClassVar[float] = 1e-9
    stages: ClassVar[int] = 9

    solvent_viscosity: float
    laws: tuple[Any, ...]

    def __post_init__(self):
        if not self.solvent_viscosity > 0:
            raise ValueError(f"solvent_viscosity must be above 0, not {self.solvent_viscosity}")

    @property
    def longest_time(self):
        """The longest relaxation time."""
        return max((law.relaxation_time for law in self.laws), default=0.0)

    @property
    def total_viscosity(self):
        """Kinematic viscosity at vanishing shear rate."""
        return self.solvent_viscosity + sum(law.polymer_viscosity for law in self.laws)

    def flux(self, rate):
        """The solvent's shear stress."""
        return self.solvent_viscosity * rate

    carried = flux
    """That of the part of the shear rate which has inertia of its own."""


@dataclass(frozen=True)
class Viscous:
    """Generalised Newtonian: ``law.viscosity(shear_rate_squared)``, kinematic; ``total_viscosity``, typical of it.

    ``tolerance`` of a step in time: at a jump the front passes point by point, and 1e-10 takes twice the time, while
    the elements leave 5e-8. More ``stages`` make steps longer, but Newton's method slower. ``layered``: whether a jump
    of a wall is left to a closed form.
    """

    layered: ClassVar[bool] = False
    tolerance: ClassVar[float] = 1e-8
    stages: ClassVar[int] = 5

    law: Any
    total_viscosity: float
    laws: tuple[Any, ...] = ()
    longest_time: float = 0.0

    def flux(self, rate):
        """Shear stress."""
        return self.law.viscosity(rate * rate) * rate

    def carried(self, rate):
        """Nothing: the whole flow is solved for."""
        return 0.0 * rate


@dataclass(frozen=True)
class Wall:
    """A wall of constant ``speed``."""

    driven: ClassVar[bool] = False
    oscillates: ClassVar[bool] = False
    angular_frequency: ClassVar[float] = 0.0
    changes: ClassVar[tuple[float, ...]] = ()

    speed: float = 0.0

    def during(self, time):
        """The wall itself: it does not change."""
        return self

    def velocity(self, t):
        """``speed``, of the shape of ``t``."""
        return self.speed + 0.0 * np.asarray(t)

    def acceleration(self, t):
        """0, of the shape of ``t``."""
        return 0.0 * np.asarray(t)


@dataclass(frozen=True)
class Flow:
    """Walls y = 0 and y = ``gap``, and the acceleration g along planes.

    Walls have ``velocity(t)`` and ``acceleration(t)``, or are ``Plate`` over the density; they change at once at the
    times ``changes``, and ``during(time)`` is what they are from then on. ``inner_radius``: that of the cylinder y = 0,
    None between planes. Cylinders have angular velocities.
    """

    gap: float
    bottom: Any = Wall()
    top: Any = Wall()
    acceleration: float = 0.0
    inner_radius: float | None = None


def _edges(liquid, flows, finest):
    """Edges over the gap. Liquids without memory have plugs, and kinks where the rate is 0: mid-gap, by symmetry."""
    if liquid.layered:
        return graded_edges(1.0, finest, WIDEST)
    if any(flow.bottom != flow.top for flow in flows):
        return graded_edges(1.0, finest, WIDEST / 2)
    half = graded_edges(0.5, finest, WIDEST / 2)
    return np.concatenate([half[:-1], 1 - half[::-1]])


class StartUp:
    """The flow of a ``Polymer`` or ``Viscous`` liquid from rest, or from the developed flow ``before``.

    Heights ``y`` and times ``t`` >= 0 broadcast; results have their shape. Stresses are over the density. ``order`` and
    ``finest``, the width over the gap of those at the walls, or all ``edges`` over the gap, set the elements.
    UnsolvedError where no solution is found that goes on, ValueError for other times.
    """

    def __init__(self, liquid, flow, before=None, *, order=ORDER, finest=FINEST, edges=None):
        self.liquid, self.flow = liquid, flow
        edges = _edges(liquid, (flow, before or flow), finest) if edges is None else edges
        self.elements = Elements(flow.gap * edges, order, flow.inner_radius)
        walls, self._ends = (flow.bottom, flow.top), [0, self.elements.size - 1]
        jumps, start = [0.0 if wall.driven else float(wall.velocity(0.0)) for wall in walls], None
        if before is not None:
            if (before.gap, before.inner_radius) != (flow.gap, flow.inner_radius):
                raise ValueError(f"the flow before has a gap of {before.gap}, the flow one of {flow.gap}")
            start = _developed(liquid, before, order, edges)
            jumps = [new - old for new, old in zip(jumps, start[self._ends], strict=True)]
        driven = abs(flow.acceleration) * flow.gap**2 / liquid.total_viscosity
        self.begins = sorted({0.0, *(time for wall in walls for time in wall.changes)})
        self._jumps = [(0.0, *jumps), *((time, *(jump(wall, time) for wall in walls)) for time in self.begins[1:])]
        sizes = [*np.ravel([both for _, *both in self._jumps]), *([] if start is None else start[self._ends])]
        self.speed = max(1e-200, driven / 12, *np.abs(sizes))
        self.layer = Layer(self.elements, self._jumps if liquid.layered else (), liquid.carried(1.0))
        self.equations = self._equations(0.0)
        self._only_layers = start is None and self._rest_vanishes()
        self._oscillations = [] if self._only_layers else list(self._periodic_parts())
        begun = np.zeros(self.equations.size) if start is None else start
        self._pieces = [self._solution(self.equations, begun - self._oscillating(0.0), jumps)]

    def _rest_vanishes(self):
        """Whether a flow from rest consists of its layers alone: a Newtonian fluid between planes of constant speed."""
        constant = not any(wall.driven or wall.oscillates for wall in (self.flow.bottom, self.flow.top))
        plane = self.flow.inner_radius is None and self.flow.acceleration == 0.0
        return _newtonian(self.liquid) and plane and constant

    def _equations(self, begin):
        """Equations of the time from ``begin`` on."""
        flow = self.flow
        walls = [
            Wall() if self._has_periodic_part(wall) else LaterWall(wall.during(begin), begin)
            for wall in (flow.bottom, flow.top)
        ]
        return Equations(self.elements, self.liquid, walls, flow.acceleration, self.layer.later(begin), self.speed)

    def _solution(self, equations, start, jumps):
        first = 1e-3 * self.flow.gap / np.sqrt(self.liquid.total_viscosity)
        if not self.liquid.layered:
            start[self._ends] += jumps
        return Solution(equations, start, first, self.liquid.tolerance, self.liquid.stages)

    def _at(self, time):
        """State (size,) at one ``time`` >= 0."""
        if self._only_layers:
            return np.zeros(self.equations.size)
        piece = max(int(np.searchsorted(self.begins, time)) - 1, 0)
        while len(self._pieces) <= piece:
            begin, end = self.begins[len(self._pieces) - 1 :][:2]
            state, (_, *jumps) = self._pieces[-1].at(end - begin), self._jumps[len(self._pieces)]
            self._pieces.append(self._solution(self._equations(end), state, jumps))
        return self._pieces[piece].at(time - self.begins[piece]) + self._oscillating(time)

    def _has_periodic_part(self, wall):
        """Whether the periodic flow of a ``wall`` that oscillates is added to the solution, which is linear."""
        return _newtonian(self.liquid) and not wall.driven and wall.angular_frequency != 0.0

    def _periodic_parts(self):
        """Yield angular frequency and complex amplitude (size,) of the periodic flow of each wall that has one.

        With the complex amplitude a of the wall's velocity the flow is Re[x e^(iwt)], (iw - J) x = i w a at the wall,
        0 elsewhere. The rest decays, so that many periods cost no more than one.
        """
        for node, wall in zip(self._ends, (self.flow.bottom, self.flow.top), strict=True):
            if not self._has_periodic_part(wall):
                continue
            frequency = wall.angular_frequency
            forcing, x = np.zeros((2, 1, self.equations.size), dtype=complex)
            forcing[0, node] = 1j * frequency * (wall.cosine - 1j * wall.sine)
            # not at t = 0, when the layer of a jump is infinitely thin
            solve = self.equations.jacobian(x[0].real, 1 / frequency).solver(np.array([1j * frequency]))
            for _ in range(REFINEMENTS):
                rates = self.equations.rates(np.concatenate([x.real, x.imag]), (0.0, 0.0))
                x = x + solve(forcing - 1j * frequency * x + rates[0] + 1j * rates[1])
            yield frequency, x[0]

    def _oscillating(self, time):
        """What the periodic flows add to the state at one ``time``."""
        return sum((x * np.exp(1j * frequency * time)).real for frequency, x in self._oscillations)

    def velocity(self, y, t):
        """Velocity u along the walls; at t = 0 the walls have their new velocity already, the liquid its old one."""
        return self._by_time(self._velocity, y, t)

    def shear_rate(self, y, t):
        """Velocity gradient du/dy, or r d(u/r)/dr (1/time); infinite at t = 0 on a wall whose velocity jumps."""
        return self._by_time(self._shear_rate, y, t)

    def polymer_stress(self, y, t):
        """Stress of all modes together, shape (3, ...): S_xx, S_xy and S_yy; N1 = S_xx - S_yy."""
        return self._by_time(self._stress, y, t, (3,))

    def deviations(self, y, t):
        """C of each mode at heights ``y`` (heights,) and one time ``t``: list of arrays (components, heights)."""
        return [self.elements.interpolated(c, y) for c in self.equations.deviations(self._at(t))]

    def shear_stress(self, y, t):
        """Shear stress of solvent and polymer together."""
        return self._by_time(self._whole_stress, y, t)

    def _steady(self):
        """The state (size,) that the flow ends in: v is all of the velocity then."""
        time = REMEMBERED * max(self.liquid.longest_time, self.flow.gap**2 / self.liquid.total_viscosity)
        for _ in range(MOST_DOUBLINGS):  # a liquid that thins takes longer
            state = self._at(time)
            later = self._at(2 * time)
            time *= 2
            if np.max(np.abs(later - state) / self.equations.scales(later[None])) < STEADY:
                break
        state = later
        nodes = self.elements.node_places
        carried = self._velocity(nodes, time) / self.elements.arm(nodes)
        return np.concatenate([carried, state[self.elements.size :]])

    def _velocity(self, y, time):
        v = self._at(time)[: self.elements.size]
        own = self.elements.arm(y) * self.elements.interpolated(v[self.elements.nodes], y)
        return own + self.layer.velocity(y, time)

    def _shear_rate(self, y, time):
        own = self.elements.shear_rate(self._at(time)[: self.elements.size])
        return self.elements.interpolated(own, y) + self.layer.shear_rate(y, time)

    def _stress(self, y, time):
        deviations = self.deviations(y, time)
        whole = [law.stress(tuple(c)) for law, c in zip(self.liquid.laws, deviations, strict=True)]
        return sum((np.stack(stress[:3]) for stress in whole), np.zeros((3, len(y))))

    def _whole_stress(self, y, time):
        if self.liquid.layered:
            return self.liquid.flux(self._shear_rate(y, time)) + self._stress(y, time)[1]
        # smoother than the shear rate where the viscosity changes much, as in a plug
        v = self._at(time)[: self.elements.size]
        return self.elements.interpolated(self.liquid.flux(self.elements.shear_rate(v)), y)

    def _by_time(self, profile, y, t, parts=()):
        """Values of ``profile(heights, time)``, called once for each different time; a scalar for scalar arguments.

        ``parts``: the shape of the value at one height and time.
        """
        heights, times = np.broadcast_arrays(np.asarray(y, dtype=float), np.asarray(t, dtype=float))
        if np.any(times < 0):
            raise ValueError("this flow starts at t = 0: it is defined for t >= 0 only")
        result = np.empty((*parts, *times.shape))
        for time in np.unique(times)[::-1]:
            here = times == time
            result[..., here] = profile(heights[here], float(time))
        return result[()]


def _newtonian(liquid):
    return liquid.layered and not liquid.laws


def _developed(liquid, flow, order, edges):
    """State (size,) at t = 0 of a developed ``flow``: steady, plus the periodic flow of walls that oscillate.

    ValueError where one does whose fluid is not Newtonian.
    """
    walls = flow.bottom, flow.top
    steady = replace(flow, **{name: Wall() for name in ("bottom", "top") if getattr(flow, name).oscillates})
    state = StartUp(liquid, steady, order=order, edges=edges)._steady()
    if not any(wall.oscillates for wall in walls):
        return state
    if not _newtonian(liquid):
        raise ValueError("only a Newtonian fluid has a periodic flow to start from")
    return state + StartUp(liquid, flow, order=order, edges=edges)._oscillating(0.0)
