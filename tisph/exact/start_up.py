"""Start-up flow of any fluid between two walls, plane or cylinders, or in a pipe: a numerical reference, to 1e-8.

Equations for 0 < y < gap, with g = -(dp/dx)/density, all stresses per unit density:

    du/dt = g + d/dy [ flux(du/dy) + sum of S_xy ],    dC/dt = law.rate_in_shear(C, du/dy),  S = law.stress(C)

for each law (mode) of a polymer, C the excess of its conformation tensor over rest (``tisph/rheology``), and flux =
solvent_viscosity * du/dy, or viscosity((du/dy)^2) * du/dy in a generalised Newtonian fluid. The walls move with given
velocities, or are stress-controlled (``geometry/motion.py``), with mass_per_area * dU/dt = stress - shear stress of the
fluid; or the fluid slips along them (``SlippingWall``); the flow starts from rest at t = 0, or, with ``before``, from
the developed flow of other walls. At a later jump of a wall velocity or stress a new solution begins, in the square
root of the time since the jump.

Along an axis, y = r - R1, and around it, with rate = r d(u/r)/dr, the pressure p per unit density and the angle theta:

    du/dt = g + (1/r) d/dr [r (flux(du/dr) + sum of S_xr)]
    du/dt = (1/r^2) d/dr [r^2 (flux(rate) + sum of S_rtheta)],    dp/dr = u^2/r + dS_rr/dr + (S_rr - S_thetatheta)/r

In the frame that rotates with the fluid the flow around the axis is simple shear, x around the axis and y outwards, so
that the laws are the same; the unknown is u/r in place of u (``_collocation``). With R1 = 0 there is no inner wall.

A wall whose velocity jumps at t = 0, or later, makes a layer sqrt(t) deep. In a solvent of constant viscosity the
layer is a closed form (``_sheared``), u = v + layer, and v is smooth. Generalised Newtonian fluids start with the jump
between the wall and the next point. The periodic flow of a Newtonian fluid whose wall, or g, oscillates is added to
the solution of the rest, which decays.

Numerics: polynomials on elements that are finest at the walls, collocation in sqrt(t) (``_collocation``).
The solution is computed once, up to the latest requested time; results do not depend on earlier requests.

Accuracy, relative to the largest value in the gap, measured against closed forms and against other orders: polymers
with solvent fractions from 0.01 on: velocity, stress and N1 1e-8 from solvent_viscosity t/gap^2 = 1e-5 on, 1e-11 once
the layers have crossed the gap; inelastic: velocity 1e-6, stress 2e-6 from t* = 1e-3 on after a jump of a wall,
and 1e-8 in developed flow, 1e-6 where a plug has edges of 1e-3 of the gap; stress 1e-6 at a rate of 0, 5e-5 there.
Viscosities that differ by more than some 1e3 within the gap lose digits to round-off, and may end in an UnsolvedError.
A polymer takes about a second of processor time, an inelastic fluid less in a driven flow, and more after a jump of
a wall: until the layer is as deep as an element is wide, a step is as short as the time in which the front passes from
point to point. At large regularisation the solution of a fluid with a yield stress ends there: UnsolvedError.

Sources: R. B. Bird, R. C. Armstrong and O. Hassager, Dynamics of Polymeric Liquids 1 (2nd ed. 1987), appendix B, for
the equations; P. Szymanski, J. Math. Pures Appl. 11 (1932) 67-107, and J. R. Womersley, J. Physiol. 127 (1955) 553-563,
for the closed forms of a Newtonian fluid in a pipe under constant and oscillating g.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from tisph.exact._collocation import Elements, RadauSolution, graded_edges
from tisph.exact._fluids import Fluid
from tisph.exact._sheared import AnalyticLayer, Equations, ShiftedWall, jump


class Steady:
    """Base of motions that are constant in time."""

    oscillates = False
    angular_frequency = 0.0
    jump_times = ()

    def after(self, time: float) -> Any:
        """Return the motion from ``time`` on: the same."""
        return self


@dataclass(frozen=True)
class Wall(Steady):
    """A wall of constant ``speed``."""

    stress_controlled: ClassVar[bool] = False

    speed: float = 0.0

    def velocity(self, t: Any) -> np.ndarray:
        """Return ``speed`` in the shape of ``t``."""
        return self.speed + 0.0 * np.asarray(t)

    def acceleration(self, t: Any) -> np.ndarray:
        """Return 0 in the shape of ``t``."""
        return 0.0 * np.asarray(t)


@dataclass(frozen=True)
class SlippingWall:
    """A wall with the given ``motion`` U along which the fluid slips: its stress on the fluid is friction * (U - u).

    u is the velocity of the fluid at the wall, and ``friction`` the kinematic viscosity over the slip length, 0 for an
    infinite one. The node of this fluid thus has the stress friction * U and the ``friction`` of u.
    """

    stress_controlled: ClassVar[bool] = True
    mass_per_area: ClassVar[float] = 0.0

    motion: Any
    friction: float

    def __getattr__(self, name: str) -> Any:
        """Return an attribute of the motion, such as ``oscillates`` or ``jump_times``."""
        return getattr(self.motion, name)

    def after(self, time: float) -> "SlippingWall":
        """Return the wall with its motion from ``time`` on."""
        return replace(self, motion=self.motion.after(time))

    def stress(self, t: Any) -> np.ndarray:
        """Return friction * U at time(s) ``t``."""
        return self.friction * self.motion.velocity(t)


def slipping(motion: Any, slip_length: float, kinematic_viscosity: float) -> Any:
    """Return a wall with this ``motion``, along which the fluid slips unless ``slip_length`` is 0."""
    return SlippingWall(motion, kinematic_viscosity / slip_length) if slip_length else motion


@dataclass(frozen=True)
class Axis(Steady):
    """The axis r = 0 in place of an inner wall; it behaves as a stress-controlled wall without mass and stress."""

    stress_controlled: ClassVar[bool] = True
    mass_per_area: ClassVar[float] = 0.0
    friction: ClassVar[float] = 0.0

    def stress(self, t: Any) -> np.ndarray:
        """Return 0 in the shape of ``t``."""
        return 0.0 * np.asarray(t)


@dataclass(frozen=True)
class Flow:
    """Walls y = 0 and y = ``gap``, and the acceleration g along planes or along the axis.

    Walls have ``velocity(t)`` and ``acceleration(t)``, or are a ``StressControlledWall`` per unit density, or a
    ``SlippingWall``. They jump at the times ``jump_times``; ``after(time)`` is their motion from that time on.
    ``inner_radius``: radius of the cylinder y = 0; None between planes; 0 if y = 0 is the axis, and ``bottom`` has no
    effect. Cylinders have angular velocities, or, in flow ``along`` the axis, velocities.

    g = ``acceleration`` + cosine cos(w t) + sine sin(w t), w = angular_frequency > 0, all attributes of ``pulsation``;
    or ``acceleration`` + the values at times of a ``geometry.motion.Schedule`` as ``pulsation``.
    """

    gap: float
    bottom: Any = Wall()
    top: Any = Wall()
    acceleration: float = 0.0
    inner_radius: float | None = None
    along: bool = False
    pulsation: Any = None

    @property
    def walls(self) -> tuple[Any, Any]:
        """The walls, or the axis, at y = 0 and y = ``gap``."""
        return Axis() if self.inner_radius == 0.0 else self.bottom, self.top

    def largest_drive(self, viscous_time: float) -> float:
        """Return the scale of the velocity that g drives: g gap^2/(12 nu), or less if g oscillates fast."""
        part, found = self.pulsation, abs(self.acceleration) * viscous_time / 12
        if part is None:
            return found
        longest = min(viscous_time / 12, 1 / part.angular_frequency) if part.angular_frequency else viscous_time / 12
        return found + np.hypot(part.cosine, part.sine) * longest

    def drive_from(self, begin: float) -> Callable:
        """Return g as a function of times since ``begin``, continued beyond its next jump."""
        part = self.pulsation
        if part is None or part.angular_frequency:
            return lambda times: self.drive(begin + times)
        ramp = part.after(begin)
        return lambda times: self.acceleration + ramp.velocity(begin + times)

    @property
    def jump_times(self) -> tuple[float, ...]:
        """Times at which g, or its slope, jumps."""
        return getattr(self.pulsation, "jump_times", ())

    def drive(self, times: np.ndarray) -> np.ndarray:
        """Return the acceleration g at ``times``."""
        part, steady = self.pulsation, self.acceleration + 0.0 * times
        if part is None:
            return steady
        angle = part.angular_frequency * times
        return steady + part.cosine * np.cos(angle) + part.sine * np.sin(angle)


REFINEMENTS = 3
"""Iterative refinements of a periodic flow: one solution alone has round-off errors of 1e-8 in places."""


def steady_newtonian(start_up: "StartUp") -> np.ndarray:
    """Return the continuous field (nodes,) of the steady flow v'' + k/r v' = -g/nu of a ``StartUp`` (``_collocation``).

    Poiseuille and Couette flow: a parabola, and y, log r or r^-2.
    """
    flow, y, viscosity = start_up.flow, start_up.elements.node_positions, start_up.fluid.total_viscosity
    power, radius = start_up.elements.power, flow.inner_radius or 0.0
    half = flow.acceleration / (2 * (power + 1) * viscosity)
    parabola = half * (flow.gap - y) * (flow.gap + y + 2 * radius)
    if radius == 0.0 and power:
        return flow.top.speed + parabola

    def grown(y: Any) -> Any:
        return y if power == 0 else np.log1p(y / radius) if power == 1 else radius**-2 - (radius + y) ** -2

    share = grown(y) / grown(flow.gap)
    # the parabola is 0 at the top only
    return flow.bottom.speed + (flow.top.speed - flow.bottom.speed) * share + parabola - parabola[0] * (1 - share)


def periodic(equations: Equations, frequency: float, amplitude: complex, node: int | None = None) -> np.ndarray:
    """Return the complex amplitude x (nodes,) of the flow Re[x e^(iwt)] under the acceleration Re[amplitude e^(iwt)].

    With a ``node``, the wall at that node has the velocity Re[amplitude e^(iwt)] instead. The equation is (iw - J) x =
    the acceleration, or i w amplitude at that wall, or friction * amplitude if the fluid slips along it.
    """
    forcing, x = np.zeros((2, 1, equations.size), dtype=complex)
    if node is None:
        forcing[0] = amplitude * equations.share
    else:
        forcing[0, node] = amplitude * (equations.friction[node] if equations.free[node] else 1j * frequency)
    # not at t = 0, when the layer of a jump is infinitely thin
    jacobian = equations.jacobian(x[0].real, 1 / frequency)
    assert jacobian is not None
    solve = jacobian.solver(np.array([1j * frequency]))
    for _ in range(REFINEMENTS):
        rates = equations.rates(np.concatenate([x.real, x.imag]), (0.0, 0.0))
        x = x + solve(forcing - 1j * frequency * x + rates[0] + 1j * rates[1])
    return x[0]


ORDER = 16
FINEST, WIDEST = 1e-3, 0.0625
"""Order of the elements, and their width over the gap at the walls and in the middle."""

REMEMBERED, MOST_DOUBLINGS, STEADY = 20.0, 8, 1e-9
"""A flow may be developed after this many times the longer of the viscous and the relaxation time. It counts as
developed if the same time again changes all values by less than STEADY of the largest; else the time is doubled."""


def _edges(fluid: Fluid, flows: Any, finest: float) -> np.ndarray:
    """Return the element edges over the gap. An inelastic fluid has plugs, and by symmetry a kink at mid-gap."""
    if fluid.subtracts_layer:
        return graded_edges(1.0, finest, WIDEST)
    if any(flow.bottom != flow.top or flow.inner_radius == 0.0 for flow in flows):
        return graded_edges(1.0, finest, WIDEST / 2)
    half = graded_edges(0.5, finest, WIDEST / 2)
    return np.concatenate([half[:-1], 1 - half[::-1]])


class StartUp:
    """The flow of a ``fluid`` from rest, or from the developed flow ``before``.

    Heights ``y`` and times ``t`` >= 0 (else ValueError) broadcast; results have their shape. Stresses are per unit
    density. ``order`` and ``finest``, the width over the gap of the elements at the walls, or all ``edges`` over the
    gap, set the elements. UnsolvedError where the solution cannot be continued.
    """

    def __init__(
        self,
        fluid: Fluid,
        flow: Flow,
        before: Any = None,
        *,
        order: int = ORDER,
        finest: float = FINEST,
        edges: np.ndarray | None = None,
    ) -> None:
        self.fluid, self.flow = fluid, flow
        edges = _edges(fluid, (flow, before or flow), finest) if edges is None else edges
        self.elements = Elements(flow.gap * edges, order, flow.inner_radius, flow.along)
        walls, self._ends = flow.walls, [0, self.elements.size - 1]
        given = [not wall.stress_controlled for wall in walls]
        jumps = [float(wall.velocity(0.0)) if own else 0.0 for wall, own in zip(walls, given, strict=True)]
        start = None
        if before is not None:
            if (before.gap, before.inner_radius, before.along) != (flow.gap, flow.inner_radius, flow.along):
                raise ValueError(f"the flow before has a gap of {before.gap}, the flow one of {flow.gap}")
            start = _developed(fluid, before, order, edges)
            jumps = [(new - old) * own for new, old, own in zip(jumps, start[self._ends], given, strict=True)]
        driven = flow.largest_drive(flow.gap**2 / fluid.total_viscosity)
        self.begins = sorted({0.0, *flow.jump_times, *(time for wall in walls for time in wall.jump_times)})
        self._jumps = [(0.0, *jumps), *((time, *(jump(wall, time) for wall in walls)) for time in self.begins[1:])]
        sizes = [*np.ravel([both for _, *both in self._jumps]), *([] if start is None else start[self._ends])]
        self.speed = max(1e-200, driven, *np.abs(sizes))
        self.layer = AnalyticLayer(self.elements, self._jumps if fluid.subtracts_layer else (), fluid.layer_flux(1.0))
        self.equations = self._equations(0.0)
        self._oscillations = list(self._periodic_parts())
        begun = (np.zeros(self.equations.size) if start is None else start) - self._oscillating(0.0)
        self._constant = begun if self._stays(before, jumps) else None
        self._pieces = [self._solution(self.equations, begun, jumps)]

    def _stays(self, before: Any, jumps: Any) -> bool:
        """Return whether the state stays as it begins: only layers and periodic flows, added in closed form, change."""
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

    def _equations(self, begin: float) -> Equations:
        """Return the equations from the time ``begin`` on."""
        walls = [
            _at_speed(wall, 0.0) if self._has_periodic_part(wall) else ShiftedWall(wall.after(begin), begin)
            for wall in self.flow.walls
        ]
        flow = replace(self.flow, pulsation=None) if self._has_periodic_drive else self.flow
        layer = self.layer.later(begin)
        return Equations(self.elements, self.fluid, walls, flow.drive_from(begin), layer, self.speed)

    def _solution(self, equations: Equations, start: np.ndarray, jumps: Any) -> RadauSolution:
        first = 1e-3 * self.flow.gap / np.sqrt(self.fluid.total_viscosity)
        if not self.fluid.subtracts_layer:
            start[self._ends] += jumps
        return RadauSolution(equations, start, first, self.fluid.tolerance, self.fluid.stages)

    def _at(self, time: float) -> np.ndarray:
        """Return the state (size,) at one ``time`` >= 0."""
        if self._constant is not None:
            return self._constant + self._oscillating(time)
        piece = max(int(np.searchsorted(self.begins, time)) - 1, 0)
        while len(self._pieces) <= piece:
            begin, end = self.begins[len(self._pieces) - 1 :][:2]
            state, (_, *jumps) = self._pieces[-1].at(end - begin), self._jumps[len(self._pieces)]
            self._pieces.append(self._solution(self._equations(end), state, jumps))
        return self._pieces[piece].at(time - self.begins[piece]) + self._oscillating(time)

    def _has_periodic_part(self, wall: Any) -> bool:
        """Return whether the periodic flow of an oscillating ``wall`` is added to the solution, which is linear."""
        given = not wall.stress_controlled or isinstance(wall, SlippingWall)
        return _newtonian(self.fluid) and given and wall.angular_frequency != 0.0

    @property
    def _has_periodic_drive(self) -> bool:
        """Whether the periodic flow of an oscillating g is added to the solution, which is linear."""
        return _newtonian(self.fluid) and bool(self.flow.pulsation and self.flow.pulsation.angular_frequency)

    def _periodic_parts(self) -> Iterator[tuple[float, np.ndarray]]:
        """Yield angular frequency and complex amplitude (size,) of the periodic flows of oscillating walls and of g.

        The remaining flow decays, so that many periods cost no more than one.
        """
        pairs = zip(self._ends, self.flow.walls, strict=True)
        parts: list[Any] = [(node, wall) for node, wall in pairs if self._has_periodic_part(wall)]
        if self._has_periodic_drive:
            parts.append((None, self.flow.pulsation))
        for node, of in parts:
            frequency = of.angular_frequency
            yield frequency, periodic(self.equations, frequency, of.cosine - 1j * of.sine, node)

    def _oscillating(self, time: float) -> np.ndarray:
        """Return the state (size,) of the periodic flows at one ``time``."""
        return sum((x * np.exp(1j * frequency * time)).real for frequency, x in self._oscillations)

    def velocity(self, y: Any, t: Any) -> np.ndarray:
        """Return the velocity u along the walls; at t = 0 walls have their new velocity, the fluid its old one."""
        return self._by_time(self._velocity, y, t)

    def shear_rate(self, y: Any, t: Any) -> np.ndarray:
        """Return du/dy, or r d(u/r)/dr (1/time); infinite at t = 0 on a wall whose velocity jumps."""
        return self._by_time(self._shear_rate, y, t)

    def polymer_stress(self, y: Any, t: Any) -> np.ndarray:
        """Return the stress of all modes together (3, ...): S_xx, S_xy and S_yy; N1 = S_xx - S_yy."""
        return self._by_time(self._stress, y, t, (3,))

    def conformation_excess(self, y: np.ndarray, t: float) -> list[np.ndarray]:
        """Return C (components, heights) of each mode at heights ``y`` (heights,) and one time ``t``."""
        return [self.elements.interpolated(c, y) for c in self.equations.conformation_excess(self._at(t))]

    def shear_stress(self, y: Any, t: Any) -> np.ndarray:
        """Return the shear stress of solvent and polymer together."""
        return self._by_time(self._whole_stress, y, t)

    def _steady(self) -> np.ndarray:
        """Return the steady state (size,); its v includes the layer."""
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

    def _velocity(self, y: np.ndarray, time: float) -> np.ndarray:
        v = self._at(time)[: self.elements.size]
        own = self.elements.interpolated(v[self.elements.nodes], y)
        return self.elements.lever(y) * (own + self.layer.field(y, time))

    def _shear_rate(self, y: np.ndarray, time: float) -> np.ndarray:
        own = self.elements.shear_rate(self._at(time)[: self.elements.size])
        return self.elements.interpolated(own, y) + self.layer.shear_rate(y, time)

    def _stress(self, y: np.ndarray, time: float) -> np.ndarray:
        excess = StartUp.conformation_excess(self, y, time)
        whole = [law.stress(tuple(c)) for law, c in zip(self.fluid.laws, excess, strict=True)]
        return sum((np.stack(stress[:3]) for stress in whole), np.zeros((3, len(y))))

    def _whole_stress(self, y: np.ndarray, time: float) -> np.ndarray:
        stress = self._inner_stress(y, time)
        for place, sign, wall in zip((0.0, self.flow.gap), (-1.0, 1.0), self.flow.walls, strict=True):
            if time == 0.0 and isinstance(wall, SlippingWall):  # the wall moves, and the fluid is not sheared yet
                pull = self.elements.lever(y) * wall.stress(0.0) - wall.friction * self._velocity(y, 0.0)
                stress = np.where(y == place, sign * pull, stress)
        return stress

    def _inner_stress(self, y: np.ndarray, time: float) -> np.ndarray:
        if self.fluid.subtracts_layer:
            return self.fluid.flux(self._shear_rate(y, time)) + self._stress(y, time)[1]
        # the stress is smoother than the shear rate where the viscosity changes much, as in a plug
        v = self._at(time)[: self.elements.size]
        return self.elements.interpolated(self.fluid.flux(self.elements.shear_rate(v)), y)

    def _by_time(self, profile: Callable, y: Any, t: Any, parts: tuple[int, ...] = ()) -> np.ndarray:
        """Return the values of ``profile(heights, time)``, called once for each time; a scalar for scalar arguments.

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


def _newtonian(fluid: Fluid) -> bool:
    return fluid.subtracts_layer and not fluid.laws


def _at_speed(wall: Any, speed: float) -> Any:
    """Return a wall of constant ``speed``, along which the fluid slips as along ``wall``."""
    return replace(wall, motion=Wall(speed)) if isinstance(wall, SlippingWall) else Wall(speed)


def _developed(fluid: Fluid, flow: Flow, order: int, edges: np.ndarray) -> np.ndarray:
    """Return the state (size,) at t = 0 of a developed ``flow``: steady, plus the periodic flow of oscillating walls.

    ValueError for walls that oscillate in a fluid that is not Newtonian.
    """
    walls = flow.bottom, flow.top
    slips = any(isinstance(wall, SlippingWall) for wall in walls)
    constant = [_at_speed(wall, 0.0 if wall.oscillates else float(wall.velocity(0.0))) for wall in walls]
    still = replace(flow, bottom=constant[0], top=constant[1], pulsation=None)
    steady = StartUp(fluid, still, order=order, edges=edges)
    state = steady_newtonian(steady) if _newtonian(fluid) and not slips else steady._steady()
    for node, wall in zip(steady._ends, still.walls, strict=True):
        if not wall.stress_controlled:
            state[node] = wall.speed
    if not (flow.pulsation or any(wall.oscillates for wall in flow.walls)):
        return state
    if not _newtonian(fluid):
        raise ValueError("only a Newtonian fluid has a periodic flow to start from")
    return state + StartUp(fluid, flow, order=order, edges=edges)._oscillating(0.0)


class Coaxial(StartUp):
    """Flow of a ``fluid`` between cylinders of ``radii``, or inside one cylinder if the first radius is 0.

    ``walls``: (inner, outer) from t = 0 on; the inner one has no effect if its radius is 0. ``before``: walls (inner,
    outer) whose developed flow is the start, or None for rest. ``flow``: other attributes of the ``Flow``;
    ``elements``: keyword arguments of ``StartUp``. Radii ``r`` and times ``t`` >= 0 broadcast; results have their
    shape. Stresses have x along the flow and y along radii. ValueError for radii that do not grow outwards from 0.
    """

    def __init__(
        self,
        radii: tuple[float, float],
        fluid: Fluid,
        walls: tuple[Any, Any],
        before: tuple[Any, Any] | None,
        flow: dict[str, Any],
        elements: dict[str, Any],
    ) -> None:
        inner, outer = radii
        if not 0 <= inner < outer < np.inf:
            raise ValueError(f"radii must grow outwards from 0, not {inner}, {outer}")
        self.radii = radii

        def flow_of(pair: tuple[Any, Any]) -> Flow:
            return Flow(outer - inner, pair[0] if inner else Wall(), pair[1], inner_radius=inner, **flow)

        super().__init__(fluid, flow_of(walls), before and flow_of(before), **elements)

    def conformation_excess(self, r: np.ndarray, t: float) -> list[np.ndarray]:
        """Return C (components, radii) of each mode at radii ``r`` (radii,) and one time ``t``: xx, xr, rr (and zz)."""
        return super().conformation_excess(self._place(r), t)

    def _by_time(self, profile: Callable, r: Any, t: Any, parts: tuple[int, ...] = ()) -> np.ndarray:
        return super()._by_time(profile, self._place(r), t, parts)

    def _place(self, r: Any) -> np.ndarray:
        """Return the distance from the inner cylinder, clipped because round-off may put radii outside."""
        return np.clip(np.asarray(r, dtype=float) - self.radii[0], 0.0, self.radii[1] - self.radii[0])


class PipeStartUp(Coaxial):
    """Flow along the axis, from t = 0 on, between pipes of ``radii`` (inner, outer); see ``Coaxial``.

    ``walls`` have velocities along the axis. g, also before t = 0, is the constant ``acceleration`` plus a
    ``pulsation`` with the attributes ``cosine``, ``sine`` and ``angular_frequency`` > 0.
    """

    def __init__(
        self,
        radii: tuple[float, float],
        fluid: Fluid,
        walls: tuple[Any, Any],
        before: Any = None,
        *,
        acceleration: float = 0.0,
        pulsation: Any = None,
        **elements: Any,
    ) -> None:
        drive = {"acceleration": acceleration, "pulsation": pulsation, "along": True}
        super().__init__(radii, fluid, walls, before, drive, elements)

    def force(self, t: Any, *, density: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the forces (inner, outer) of the fluid on the walls along the axis, per length of the axis."""
        inner, outer = (density * self.shear_stress(r, t) for r in self.radii)
        return 2 * np.pi * self.radii[0] * inner, -2 * np.pi * self.radii[1] * outer


class CircularStartUp(Coaxial):
    """Flow around the axis between cylinders with the angular velocities ``inner`` and ``outer`` (``Wall``).

    See ``Coaxial``. With ``inner_radius`` 0 there is only the outer cylinder, around a fluid that spins up.
    """

    def __init__(
        self,
        inner_radius: float,
        outer_radius: float,
        fluid: Fluid,
        inner: Any,
        outer: Any,
        before: Any = None,
        **elements: Any,
    ) -> None:
        super().__init__((inner_radius, outer_radius), fluid, (inner, outer), before, {}, elements)

    def torque(self, t: Any, *, density: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the fluid's torques (inner, outer) on the cylinders, counterclockwise, per length of the axis."""
        # both cylinders in one call: each time is costly, a radius is not
        radii = np.reshape(self.radii, (2, *[1] * np.ndim(t)))
        inner, outer = 2 * np.pi * radii**2 * density * self.shear_stress(radii, t)
        return inner, -outer

    def pressure(self, r: Any, t: Any, *, density: float) -> np.ndarray:
        """Return the pressure at radii ``r`` and one time, of zero mean over the area."""
        elements = self.elements
        radius, places = elements.radii, self.radii[0] + elements.y
        along, _, across = self.polymer_stress(places, t)
        u = self.velocity(places, t)
        if t == 0:  # the fluid still has the velocity of before
            u -= elements.levers * self.layer.field(elements.y, t)
        inward = np.divide(u**2 + across - along, radius, out=np.zeros_like(u), where=radius > 0.0)
        pressure = across + elements.integral(inward)
        area = elements.half_width * elements.weights * radius
        mean = np.sum(area * pressure) / np.sum(area)
        values = elements.interpolated(pressure, self._place(r).ravel()) - mean
        return density * values.reshape(np.shape(r))[()]
