"""Start-up flow of any fluid between two walls, plane or cylinders, or in a pipe: a numerical reference, to 1e-8.

Equations for 0 < y < gap, with g = -(dp/dx)/density, all stresses per unit density:

    du/dt = g + d/dy [ flux(du/dy) + sum of S_xy ],    dC/dt = law.rate_in_shear(C, du/dy),  S = law.stress(C)

for each law (mode) of a polymer, C the excess of its conformation tensor over rest (``tisph/rheology``), and flux =
solvent_viscosity * du/dy, or viscosity((du/dy)^2) * du/dy of a generalised Newtonian fluid. The walls move with given
velocities, or are stress-controlled (``geometry/stress_controlled.py``), with mass_per_area * dU/dt = stress - shear
stress of the fluid; the flow starts from rest at t = 0, or, with ``before``, from the developed flow of other walls.
Where a wall velocity or stress jumps later on, a new solution begins, in the root of the time from then on.

Between cylinders y = r - R1. Seen by who turns with the fluid, the flow is simple shear of the rate r d(u/r)/dr, x
around the axis and y outwards, so that the laws are the same; u/r has the place of u, as ``_elements`` says. Along the
axis du/dt = g + (1/r) d/dr [r (flux(du/dr) + sum of S_xr)], x along the axis. With R1 = 0 there is no inner wall.

A wall whose velocity jumps at t = 0, or later, makes a layer sqrt(t) deep. Where a solvent of constant viscosity takes
it, its own start (``_layer``) is left to a closed form, u = v + that, and v is smooth. Fluids that remember nothing
start with the jump between the wall and the next point. The periodic flow of a Newtonian fluid whose wall, or g,
oscillates is added to the solution of the rest, which decays.

Numerics: polynomials on elements that are finest at the walls (``_elements``), collocation in sqrt(t) (``_stiff``).
Solved once, as far as it is asked for; no result depends on what was asked before.

Accuracy, relative to the largest value in the gap, measured against closed forms and against other orders: polymers
with solvent fractions from 0.01 on: velocity, stress and N1 1e-8 from solvent_viscosity t/gap^2 = 1e-5 on, 1e-11 once
the layers have crossed the gap; inelastic: velocity 1e-6, stress 2e-6 from t* = 1e-3 on after a jump of a wall,
and 1e-8 in developed flow, 1e-6 where a plug has edges of 1e-3 of the gap; stress 1e-6 at a rate of 0, 5e-5 there.
Viscosities that differ by more than some 1e3 within the gap lose digits to round-off, and may end in an UnsolvedError.
A polymer takes about a second of processor time, an inelastic fluid less in a driven flow, and more after a jump of
a wall: until the layer is as deep as an element is wide, steps are as short as it takes the front to pass from point to
point. At large regularisation a fluid with a yield stress does not get beyond that: UnsolvedError.
"""

from dataclasses import replace

import numpy as np

from tisph.exact._developed import periodic, steady_newtonian
from tisph.exact._elements import Elements, graded_edges
from tisph.exact._flow import Axis, Flow, Wall
from tisph.exact._fluids import InelasticFluid, ViscoelasticFluid, fluid_of
from tisph.exact._layer import AnalyticLayer, ShiftedWall, jump
from tisph.exact._sheared import Equations
from tisph.exact._stiff import RadauSolution

__all__ = ["Flow", "InelasticFluid", "StartUp", "ViscoelasticFluid", "Wall", "fluid_of"]

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
        return [self.elements.interpolated(c, y) for c in self.equations.conformation_excess(self._at(t))]

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
        conformation_excess = self.conformation_excess(y, time)
        whole = [law.stress(tuple(c)) for law, c in zip(self.fluid.laws, conformation_excess, strict=True)]
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
