"""Start-up flow of any fluid between two walls, plane or cylinders, or in a pipe: a numerical reference, to 1e-8.

Equations for 0 < y < gap, with g = -(dp/dx)/density, all stresses per unit density:

    du/dt = g + d/dy [ flux(du/dy) + sum of S_xy ],    dC/dt = law.rate_in_shear(C, du/dy),  S = law.stress(C)

for each law (mode) of a polymer, C the excess of its conformation tensor over rest (``tisph/rheology``), and flux =
solvent_viscosity * du/dy, or viscosity((du/dy)^2) * du/dy of a generalised Newtonian fluid. The walls move with given
velocities, or are stress-controlled (``geometry/motion.py``), with mass_per_area * dU/dt = stress - shear
stress of the fluid; the flow starts from rest at t = 0, or, with ``before``, from the developed flow of other walls.
Where a wall velocity or stress jumps later on, a new solution begins, in the root of the time from then on.

Along an axis, y = r - R1, and around it, with rate = r d(u/r)/dr, the pressure p per unit density and the angle theta:

    du/dt = g + (1/r) d/dr [r (flux(du/dr) + sum of S_xr)]
    du/dt = (1/r^2) d/dr [r^2 (flux(rate) + sum of S_rtheta)],    dp/dr = u^2/r + dS_rr/dr + (S_rr - S_thetatheta)/r

In the frame that rotates with the fluid the flow around the axis is simple shear, x around the axis and y outwards, so
that the laws are the same; u/r takes the place of u (``_collocation``). With R1 = 0 there is no inner wall.

A wall whose velocity jumps at t = 0, or later, makes a layer sqrt(t) deep. In a solvent of constant viscosity the
layer is a closed form (``_sheared``), u = v + layer, and v is smooth. Generalised Newtonian fluids start with the jump
between the wall and the next point. The periodic flow of a Newtonian fluid whose wall, or g, oscillates is added to
the solution of the rest, which decays.

Numerics: polynomials on elements that are finest at the walls, collocation in sqrt(t) (``_collocation``).
Solved once, as far as it is asked for; no result depends on what was asked before.

Accuracy, relative to the largest value in the gap, measured against closed forms and against other orders: polymers
with solvent fractions from 0.01 on: velocity, stress and N1 1e-8 from solvent_viscosity t/gap^2 = 1e-5 on, 1e-11 once
the layers have crossed the gap; inelastic: velocity 1e-6, stress 2e-6 from t* = 1e-3 on after a jump of a wall,
and 1e-8 in developed flow, 1e-6 where a plug has edges of 1e-3 of the gap; stress 1e-6 at a rate of 0, 5e-5 there.
Viscosities that differ by more than some 1e3 within the gap lose digits to round-off, and may end in an UnsolvedError.
A polymer takes about a second of processor time, an inelastic fluid less in a driven flow, and more after a jump of
a wall: until the layer is as deep as an element is wide, steps are as short as it takes the front to pass from point to
point. At large regularisation a fluid with a yield stress does not get beyond that: UnsolvedError.

Sources: R. B. Bird, R. C. Armstrong and O. Hassager, Dynamics of Polymeric Liquids 1 (2nd ed. 1987), appendix B, for
the equations; P. Szymanski, J. Math. Pures Appl. 11 (1932) 67-107, and J. R. Womersley, J. Physiol. 127 (1955) 553-563,
for the closed forms of a Newtonian fluid in a pipe under constant and oscillating g.
"""

from dataclasses import dataclass, replace
from typing import Any, ClassVar, Protocol

import numpy as np

from tisph.exact._collocation import Elements, RadauSolution, graded_edges
from tisph.exact._sheared import AnalyticLayer, Equations, ShiftedWall, jump


class ViscosityLaw(Protocol):
    """Law of an inelastic fluid; the result has the unit of the viscosity that the law was made with."""

    def viscosity(self, shear_rate_squared: Any) -> Any:
        """Return the viscosity at the square of the shear rate [1/time^2]."""


class PolymerLaw(Protocol):
    """Law of one polymer mode: evolution of C, the excess of its conformation tensor over rest, and its stress S.

    ``c``: components xx, xy, yy and, where the law needs it, zz, each an array, a number or a Taichi expression.
    ``rate``: shear rate du/dy of the same shape. Stresses have the unit of ``polymer_viscosity`` / time.
    """

    components: int
    relaxation_time: float
    polymer_viscosity: float

    def stress(self, c: Any) -> tuple:
        """Return the components of S."""

    def rate_in_shear(self, c: Any, rate: Any) -> tuple:
        """Return the components of dC/dt in simple shear."""


class Rheology(Protocol):
    """Parameters of a non-Newtonian fluid, by a config (``tisph/rheology``).

    ``carries_stress``: whether the fluid is a polymer solution. Only a polymer solution has ``relaxation_time`` [time]
    of the first mode (mean of several modes), ``solvent_fraction`` of the total viscosity, and ``laws``; only an
    inelastic fluid has ``law``. Laws have the unit of the viscosity that they are made with.
    """

    type: str
    carries_stress: bool
    relaxation_time: float
    solvent_fraction: float

    def laws(self, viscosity: float) -> tuple[PolymerLaw, ...]:
        """Return the law of each polymer mode of a fluid with this total ``viscosity``."""

    def law(self, viscosity: float, density: float) -> ViscosityLaw:
        """Return the law of an inelastic fluid of this ``viscosity``, which is dynamic viscosity / ``density``."""


class Steady:
    """Base of motions that are constant in time."""

    oscillates = False
    angular_frequency = 0.0
    jump_times = ()

    def after(self, time):
        """The same: it does not change."""
        return self


@dataclass(frozen=True)
class Wall(Steady):
    """A wall of constant ``speed``."""

    stress_controlled: ClassVar[bool] = False

    speed: float = 0.0

    def velocity(self, t):
        """``speed``, of the shape of ``t``."""
        return self.speed + 0.0 * np.asarray(t)

    def acceleration(self, t):
        """0, of the shape of ``t``."""
        return 0.0 * np.asarray(t)


@dataclass(frozen=True)
class Axis(Steady):
    """The axis r = 0 in the place of an inner wall, with methods of a wall of no mass and no stress."""

    stress_controlled: ClassVar[bool] = True
    mass_per_area: ClassVar[float] = 0.0

    def stress(self, t):
        """0, of the shape of ``t``."""
        return 0.0 * np.asarray(t)


@dataclass(frozen=True)
class Flow:
    """Walls y = 0 and y = ``gap``, and the acceleration g along planes or along the axis.

    Walls have ``velocity(t)`` and ``acceleration(t)``, or are a ``StressControlledWall`` per unit density; they change
    at once at the times ``jump_times``, and ``after(time)`` is what they are from then on. ``inner_radius``: that of
    the cylinder y = 0, None between planes; 0 where there is none and y = 0 is the axis, whatever ``bottom`` is.
    Cylinders have angular velocities, or, ``along`` the axis, velocities.

    g = ``acceleration`` + cosine cos(w t) + sine sin(w t), w = angular_frequency > 0, all attributes of ``pulsation``.
    """

    gap: float
    bottom: Any = Wall()
    top: Any = Wall()
    acceleration: float = 0.0
    inner_radius: float | None = None
    along: bool = False
    pulsation: Any = None

    @property
    def walls(self):
        """What is at y = 0 and y = ``gap``."""
        return Axis() if self.inner_radius == 0.0 else self.bottom, self.top

    def largest_drive(self, viscous_time):
        """A velocity that g reaches: g gap^2/(12 nu), or less where g oscillates fast."""
        part, found = self.pulsation, abs(self.acceleration) * viscous_time / 12
        if part is None:
            return found
        return found + np.hypot(part.cosine, part.sine) * min(viscous_time / 12, 1 / part.angular_frequency)

    def drive(self, times):
        """The acceleration g at ``times``."""
        part, steady = self.pulsation, self.acceleration + 0.0 * times
        if part is None:
            return steady
        angle = part.angular_frequency * times
        return steady + part.cosine * np.cos(angle) + part.sine * np.sin(angle)


@dataclass(frozen=True)
class ViscoelasticFluid:
    """Kinematic viscosity of the solvent (> 0, else ValueError) and ``laws`` of the polymer's modes, over density.

    Without any it is a Newtonian fluid.

    ``tolerance`` of a step in time and its ``stages``: with 7 there are twice as many steps, in 1.5 times the time.
    """

    subtracts_layer: ClassVar[bool] = True
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

    layer_flux = flux
    """That of the part of the shear rate which has inertia of its own."""


@dataclass(frozen=True)
class InelasticFluid:
    """Generalised Newtonian: ``law.viscosity(shear_rate_squared)``, kinematic; ``total_viscosity``, typical of it.

    ``tolerance`` of a step in time: at a jump the front passes point by point, and 1e-10 takes twice the time, while
    the elements leave 5e-8. More ``stages`` make steps longer, but Newton's method slower. ``subtracts_layer``: whether
    a jump of a wall is left to a closed form.
    """

    subtracts_layer: ClassVar[bool] = False
    tolerance: ClassVar[float] = 1e-8
    stages: ClassVar[int] = 5

    law: Any
    total_viscosity: float
    laws: tuple[Any, ...] = ()
    longest_time: float = 0.0

    def flux(self, rate):
        """Shear stress."""
        return self.law.viscosity(rate * rate) * rate

    def layer_flux(self, rate):
        """Nothing: the whole flow is solved for."""
        return 0.0 * rate


def fluid_of(rheology, kinematic_viscosity, density):
    """The fluid with the parameters ``rheology``, None of a Newtonian one."""
    if rheology is None:
        return ViscoelasticFluid(kinematic_viscosity, ())
    if rheology.carries_stress:
        return ViscoelasticFluid(rheology.solvent_fraction * kinematic_viscosity, rheology.laws(kinematic_viscosity))
    return InelasticFluid(rheology.law(kinematic_viscosity, density), kinematic_viscosity)


REFINEMENTS = 3
"""Solutions for the residual of a periodic flow: the first one alone loses digits to round-off, 1e-8 in places."""


def steady_newtonian(start_up):
    """The continuous field (nodes,) of the steady flow of a ``StartUp``, v'' + k/r v' = -g/nu (``_collocation``).

    Poiseuille and Couette flow: a parabola, and y, log r or r^-2.
    """
    flow, y, viscosity = start_up.flow, start_up.elements.node_positions, start_up.fluid.total_viscosity
    power, radius = start_up.elements.power, flow.inner_radius or 0.0
    half = flow.acceleration / (2 * (power + 1) * viscosity)
    parabola = half * (flow.gap - y) * (flow.gap + y + 2 * radius)
    if radius == 0.0 and power:
        return flow.top.speed + parabola

    def grown(y):
        return y if power == 0 else np.log1p(y / radius) if power == 1 else radius**-2 - (radius + y) ** -2

    share = grown(y) / grown(flow.gap)
    # the parabola is 0 at the top only
    return flow.bottom.speed + (flow.top.speed - flow.bottom.speed) * share + parabola - parabola[0] * (1 - share)


def periodic(equations, frequency, amplitude, node=None):
    """Complex amplitude x (nodes,) of the flow Re[x e^(iwt)] under the acceleration Re[amplitude e^(iwt)].

    Or between walls of which that at ``node`` has the velocity Re[amplitude e^(iwt)]: (iw - J) x = the acceleration,
    or i w amplitude at that wall.
    """
    forcing, x = np.zeros((2, 1, equations.size), dtype=complex)
    if node is None:
        forcing[0] = amplitude * equations.share
    else:
        forcing[0, node] = 1j * frequency * amplitude
    # not at t = 0, when the layer of a jump is infinitely thin
    solve = equations.jacobian(x[0].real, 1 / frequency).solver(np.array([1j * frequency]))
    for _ in range(REFINEMENTS):
        rates = equations.rates(np.concatenate([x.real, x.imag]), (0.0, 0.0))
        x = x + solve(forcing - 1j * frequency * x + rates[0] + 1j * rates[1])
    return x[0]


ORDER = 16
FINEST, WIDEST = 1e-3, 0.0625
"""Order of the elements, and the width over the gap of those at the walls and in the middle."""

REMEMBERED, MOST_DOUBLINGS, STEADY = 20.0, 8, 1e-9
"""Longest times of the fluid, viscous and relaxation, after which a flow may be developed. It is where as long a time
again changes all by less than STEADY of the largest value; else the time is doubled."""


def _edges(fluid, flows, finest):
    """Edges over the gap. Inelastic fluids have plugs, and kinks where the rate is 0: mid-gap, by symmetry."""
    if fluid.subtracts_layer:
        return graded_edges(1.0, finest, WIDEST)
    if any(flow.bottom != flow.top or flow.inner_radius == 0.0 for flow in flows):
        return graded_edges(1.0, finest, WIDEST / 2)
    half = graded_edges(0.5, finest, WIDEST / 2)
    return np.concatenate([half[:-1], 1 - half[::-1]])


class StartUp:
    """The flow of a ``ViscoelasticFluid`` or ``InelasticFluid`` fluid from rest, or from the developed flow ``before``.

    Heights ``y`` and times ``t`` >= 0 broadcast; results have their shape. Stresses are per unit density. ``order`` and
    ``finest``, the width over the gap of those at the walls, or all ``edges`` over the gap, set the elements.
    UnsolvedError where no solution is found that goes on, ValueError for other times.
    """

    def __init__(self, fluid, flow, before=None, *, order=ORDER, finest=FINEST, edges=None):
        self.fluid, self.flow = fluid, flow
        edges = _edges(fluid, (flow, before or flow), finest) if edges is None else edges
        self.elements = Elements(flow.gap * edges, order, flow.inner_radius, flow.along)
        walls, self._ends = flow.walls, [0, self.elements.size - 1]
        jumps, start = [0.0 if wall.stress_controlled else float(wall.velocity(0.0)) for wall in walls], None
        if before is not None:
            if (before.gap, before.inner_radius, before.along) != (flow.gap, flow.inner_radius, flow.along):
                raise ValueError(f"the flow before has a gap of {before.gap}, the flow one of {flow.gap}")
            start = _developed(fluid, before, order, edges)
            jumps = [new - old for new, old in zip(jumps, start[self._ends], strict=True)]
            jumps[0] *= flow.inner_radius != 0.0
        driven = flow.largest_drive(flow.gap**2 / fluid.total_viscosity)
        self.begins = sorted({0.0, *(time for wall in walls for time in wall.jump_times)})
        self._jumps = [(0.0, *jumps), *((time, *(jump(wall, time) for wall in walls)) for time in self.begins[1:])]
        sizes = [*np.ravel([both for _, *both in self._jumps]), *([] if start is None else start[self._ends])]
        self.speed = max(1e-200, driven, *np.abs(sizes))
        self.layer = AnalyticLayer(self.elements, self._jumps if fluid.subtracts_layer else (), fluid.layer_flux(1.0))
        self.equations = self._equations(0.0)
        self._oscillations = list(self._periodic_parts())
        begun = (np.zeros(self.equations.size) if start is None else start) - self._oscillating(0.0)
        self._constant = begun if self._stays(before, jumps) else None
        self._pieces = [self._solution(self.equations, begun, jumps)]

    def _stays(self, before, jumps):
        """Whether the state stays as it begins, since layers and periodic flows are all that changes."""
        flow, plane = self.flow, self.flow.inner_radius is None
        walls = [wall for wall in flow.walls if not isinstance(wall, Axis)]
        if any(wall.stress_controlled or (wall.oscillates and not self._has_periodic_part(wall)) for wall in walls):
            return False
        if before is None:
            steady = flow.acceleration == 0.0 and not (flow.pulsation or any(wall.oscillates for wall in walls))
            return _newtonian(self.fluid) and plane and steady
        pairs = zip(before.walls, flow.walls, strict=True)
        steady = (before.acceleration, before.pulsation) == (flow.acceleration, flow.pulsation)
        steady = steady and all(old == new for old, new in pairs if old.oscillates or new.oscillates)
        return steady and (not any(jumps) or (_newtonian(self.fluid) and plane))

    def _equations(self, begin):
        """Equations of the time from ``begin`` on."""
        walls = [
            Wall() if self._has_periodic_part(wall) else ShiftedWall(wall.after(begin), begin)
            for wall in self.flow.walls
        ]
        flow = replace(self.flow, pulsation=None) if _newtonian(self.fluid) else self.flow
        layer = self.layer.later(begin)
        return Equations(self.elements, self.fluid, walls, lambda t: flow.drive(begin + t), layer, self.speed)

    def _solution(self, equations, start, jumps):
        first = 1e-3 * self.flow.gap / np.sqrt(self.fluid.total_viscosity)
        if not self.fluid.subtracts_layer:
            start[self._ends] += jumps
        return RadauSolution(equations, start, first, self.fluid.tolerance, self.fluid.stages)

    def _at(self, time):
        """State (size,) at one ``time`` >= 0."""
        if self._constant is not None:
            return self._constant + self._oscillating(time)
        piece = max(int(np.searchsorted(self.begins, time)) - 1, 0)
        while len(self._pieces) <= piece:
            begin, end = self.begins[len(self._pieces) - 1 :][:2]
            state, (_, *jumps) = self._pieces[-1].at(end - begin), self._jumps[len(self._pieces)]
            self._pieces.append(self._solution(self._equations(end), state, jumps))
        return self._pieces[piece].at(time - self.begins[piece]) + self._oscillating(time)

    def _has_periodic_part(self, wall):
        """Whether the periodic flow of a ``wall`` that oscillates is added to the solution, which is linear."""
        return _newtonian(self.fluid) and not wall.stress_controlled and wall.angular_frequency != 0.0

    def _periodic_parts(self):
        """Yield angular frequency and complex amplitude (size,) of the periodic flows of walls that have one, and of g.

        The rest decays, so that many periods cost no more than one.
        """
        parts = [each for each in zip(self._ends, self.flow.walls, strict=True) if self._has_periodic_part(each[1])]
        if self.flow.pulsation and _newtonian(self.fluid):
            parts.append((None, self.flow.pulsation))
        for node, of in parts:
            frequency = of.angular_frequency
            yield frequency, periodic(self.equations, frequency, of.cosine - 1j * of.sine, node)

    def _oscillating(self, time):
        """What the periodic flows add to the state at one ``time``."""
        return sum((x * np.exp(1j * frequency * time)).real for frequency, x in self._oscillations)

    def velocity(self, y, t):
        """Velocity u along the walls; at t = 0 the walls have their new velocity already, the fluid its old one."""
        return self._by_time(self._velocity, y, t)

    def shear_rate(self, y, t):
        """Velocity gradient du/dy, or r d(u/r)/dr (1/time); infinite at t = 0 on a wall whose velocity jumps."""
        return self._by_time(self._shear_rate, y, t)

    def polymer_stress(self, y, t):
        """Stress of all modes together, shape (3, ...): S_xx, S_xy and S_yy; N1 = S_xx - S_yy."""
        return self._by_time(self._stress, y, t, (3,))

    def conformation_excess(self, y, t):
        """C of each mode at heights ``y`` (heights,) and one time ``t``: list of arrays (components, heights)."""
        return self._excess(y, t)

    def _excess(self, y, time):
        return [self.elements.interpolated(c, y) for c in self.equations.conformation_excess(self._at(time))]

    def shear_stress(self, y, t):
        """Shear stress of solvent and polymer together."""
        return self._by_time(self._whole_stress, y, t)

    def _steady(self):
        """The state (size,) that the flow ends in: v is all of the velocity then."""
        time = REMEMBERED * max(self.fluid.longest_time, self.flow.gap**2 / self.fluid.total_viscosity)
        for _ in range(MOST_DOUBLINGS):  # a fluid that thins takes longer
            state = self._at(time)
            later = self._at(2 * time)
            time *= 2
            if np.max(np.abs(later - state) / self.equations.scales(later[None])) < STEADY:
                break
        state = later
        size = self.elements.size
        whole = state[:size] + self.layer.field(self.elements.node_positions, time)
        return np.concatenate([whole, state[size:]])

    def _velocity(self, y, time):
        v = self._at(time)[: self.elements.size]
        own = self.elements.interpolated(v[self.elements.nodes], y)
        return self.elements.lever(y) * (own + self.layer.field(y, time))

    def _shear_rate(self, y, time):
        own = self.elements.shear_rate(self._at(time)[: self.elements.size])
        return self.elements.interpolated(own, y) + self.layer.shear_rate(y, time)

    def _stress(self, y, time):
        whole = [law.stress(tuple(c)) for law, c in zip(self.fluid.laws, self._excess(y, time), strict=True)]
        return sum((np.stack(stress[:3]) for stress in whole), np.zeros((3, len(y))))

    def _whole_stress(self, y, time):
        if self.fluid.subtracts_layer:
            return self.fluid.flux(self._shear_rate(y, time)) + self._stress(y, time)[1]
        # smoother than the shear rate where the viscosity changes much, as in a plug
        v = self._at(time)[: self.elements.size]
        return self.elements.interpolated(self.fluid.flux(self.elements.shear_rate(v)), y)

    def _by_time(self, profile, y, t, parts=()):
        """Values of ``profile(heights, time)``, called once for each different time; a scalar for scalar arguments.

        ``parts``: the shape of the value at one height and time.
        """
        heights, times = np.broadcast_arrays(np.asarray(y, dtype=float), np.asarray(t, dtype=float))
        if np.any(times < 0):
            raise ValueError("this flow starts at t = 0: it is defined for t >= 0 only")
        result = np.empty((*parts, *times.shape))
        for time in sorted(set(times.ravel().tolist()), reverse=True):  # np.unique would import numpy.ma
            here = times == time
            result[..., here] = profile(heights[here], time)
        return result[()]


def _newtonian(fluid):
    return fluid.subtracts_layer and not fluid.laws


def _developed(fluid, flow, order, edges):
    """State (size,) at t = 0 of a developed ``flow``: steady, plus the periodic flow of walls that oscillate.

    ValueError where one does whose fluid is not Newtonian.
    """
    walls = flow.bottom, flow.top
    constant = [Wall() if wall.oscillates else Wall(float(wall.velocity(0.0))) for wall in walls]
    still = replace(flow, bottom=constant[0], top=constant[1], pulsation=None)
    steady = StartUp(fluid, still, order=order, edges=edges)
    state = steady_newtonian(steady) if _newtonian(fluid) else steady._steady()
    for node, wall in zip(steady._ends, still.walls, strict=True):
        if not isinstance(wall, Axis):
            state[node] = wall.speed
    if not (flow.pulsation or any(wall.oscillates for wall in flow.walls)):
        return state
    if not _newtonian(fluid):
        raise ValueError("only a Newtonian fluid has a periodic flow to start from")
    return state + StartUp(fluid, flow, order=order, edges=edges)._oscillating(0.0)


class Coaxial(StartUp):
    """Flow of a ``fluid`` between cylinders of ``radii``, or inside of one where the first is 0.

    ``walls``: (inner, outer) from t = 0 on, of which the inner one counts for nothing where there is none; ``before``:
    the same whose developed flow it starts from, or None for rest. ``flow``: other attributes of its ``Flow``. Radii
    ``r`` and times ``t`` >= 0 broadcast; results have their shape. Stresses have x along the flow and y along radii.
    """

    def __init__(self, radii, fluid, walls, before, flow, elements):
        inner, outer = radii
        if not 0 <= inner < outer < np.inf:
            raise ValueError(f"radii must grow outwards from 0, not {inner}, {outer}")
        self.radii = radii

        def flow_of(pair):
            return Flow(outer - inner, pair[0] if inner else Wall(), pair[1], inner_radius=inner, **flow)

        super().__init__(fluid, flow_of(walls), before and flow_of(before), **elements)

    def conformation_excess(self, r, t):
        """C of each mode at radii ``r`` (radii,) and one time ``t``, in the order xx, xr, rr (and that across both)."""
        return super().conformation_excess(self._place(r), t)

    def _by_time(self, profile, r, t, parts=()):
        return super()._by_time(profile, self._place(r), t, parts)

    def _place(self, r):
        """Distance from the inner cylinder; round-off leaves none outside."""
        return np.clip(np.asarray(r, dtype=float) - self.radii[0], 0.0, self.radii[1] - self.radii[0])


class PipeStartUp(Coaxial):
    """Flow of a ``fluid`` of ``start_up`` along the axis, from t = 0 on, between pipes of ``radii`` (inner, outer).

    ``walls``: the pair of them, with ``velocity(t)`` and ``acceleration(t)`` along the axis; where the inner radius is
    0, the first counts for nothing. The fluid was at rest, or in the developed flow of the pair ``before`` of walls.
    g, before t = 0 too: the constant ``acceleration``, and that of a ``pulsation`` with the attributes ``cosine``,
    ``sine`` and ``angular_frequency`` > 0. ``elements``: what ``StartUp`` takes by name. Stresses have x along the
    axis. ValueError for radii that do not grow outwards from 0, UnsolvedError as of ``StartUp``.
    """

    def __init__(self, radii, fluid, walls, before=None, *, acceleration=0.0, pulsation=None, **elements):
        drive = {"acceleration": acceleration, "pulsation": pulsation, "along": True}
        super().__init__(radii, fluid, walls, before, drive, elements)

    def force(self, t, *, density):
        """Forces (inner, outer) of the fluid on the walls along the axis, per length of it."""
        circumferences = 2 * np.pi * self.radii[0], -2 * np.pi * self.radii[1]
        stresses = (density * self.shear_stress(r, t) for r in self.radii)
        return tuple(length * stress for length, stress in zip(circumferences, stresses, strict=True))


class CircularStartUp(Coaxial):
    """Flow of a ``ViscoelasticFluid`` between two cylinders that turn as ``inner`` and ``outer`` from t = 0 on.

    Both have ``velocity(t)`` and ``acceleration(t)``, of an angle (``start_up.Wall``). The fluid was at rest, or
    in the developed flow of the pair ``before`` of cylinders. With ``inner_radius`` 0 there is the outer one alone,
    around a fluid that spins up. ``elements``: what ``StartUp`` takes by name. ValueError for radii that do not grow
    outwards from 0, UnsolvedError as of ``StartUp``. Stresses have x around the axis.
    """

    def __init__(self, inner_radius, outer_radius, fluid, inner, outer, before=None, **elements):
        super().__init__((inner_radius, outer_radius), fluid, (inner, outer), before, {}, elements)

    def torque(self, t, *, density):
        """Torques (inner, outer), counterclockwise, of the fluid on the cylinders, per length along the axis."""
        return tuple(
            sign * 2 * np.pi * r**2 * density * self.shear_stress(r, t)
            for sign, r in zip((1, -1), self.radii, strict=True)
        )

    def pressure(self, r, t, *, density):
        """Pressure at radii ``r`` and one time, of zero mean over the area."""
        elements = self.elements
        radius, places = elements.radii, self.radii[0] + elements.y
        along, _, across = self.polymer_stress(places, t)
        u = self.velocity(places, t)
        if t == 0:  # what turns is what turned before
            u -= elements.levers * self.layer.field(elements.y, t)
        inward = np.divide(u**2 + across - along, radius, out=np.zeros_like(u), where=radius > 0.0)
        pressure = across + elements.integral(inward)
        area = elements.half_width * elements.weights * radius
        mean = np.sum(area * pressure) / np.sum(area)
        values = elements.interpolated(pressure, self._place(r).ravel()) - mean
        return density * values.reshape(np.shape(r))[()]
