"""A fluid in uniform shear: the stresses that a rheometer would measure if the fluid had no inertia.

    shear stress = flux(rate) + sum of S_xy,    dC/dt = law.rate_in_shear(C, rate(t)),    S = law.stress(C)

for each law (mode) of a polymer, from rest; C and laws as in ``_fluids``, stresses in the unit of the laws' viscosity.
The ordinary differential equations are integrated with an error of 1e-8 of the largest value (LSODA, piece by piece
between changes of the rate). The steady stress is the stress after ``REMEMBERED`` times the longest relaxation time.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from tisph.exact._fluids import PolymerLaw

REMEMBERED = 60.0
RATES = 256
"""Shear rates in half a gap of developed flow: errors of the velocity are below 1e-5, of a yield stress too."""

RELATIVE, ABSOLUTE = 1e-10, 1e-13
"""Tolerances of a step."""


@dataclass(frozen=True)
class UniformShear:
    """``flux(rate)``: shear stress of the solvent, or of an inelastic fluid; ``laws`` of a polymer's modes."""

    flux: Callable
    laws: tuple[PolymerLaw, ...] = ()

    def response(self, rates: Sequence[tuple[float, Callable]], times: Any) -> tuple[np.ndarray, np.ndarray]:
        """Return shear stress (n,) and N1 (n,) at ascending ``times`` (n,).

        ``rates``: ascending pairs (begin, function of time) from begin = 0 on: the shear rate after each begin. At the
        begin itself the previous function holds.
        """
        times = np.asarray(times, dtype=float)
        begins = [begin for begin, _ in rates]
        stress, normal = np.empty(len(times)), np.empty(len(times))
        state = np.zeros(sum(law.components for law in self.laws))
        for (begin, rate), end in zip(rates, [*begins[1:], max(times[-1], begins[-1])], strict=True):
            here = (times > begin) & (times <= end) if begin else times <= end
            states, state = self._solved(rate, begin, end, state, times[here])
            stress[here], normal[here] = self._stresses(states, rate(times[here]))
        return stress, normal

    def steady(self, rate: float) -> tuple[float, float]:
        """Return shear stress and N1 in steady shear of a ``rate``."""
        end = REMEMBERED * max((law.relaxation_time for law in self.laws), default=0.0)
        start = np.zeros(sum(law.components for law in self.laws))
        _, state = self._solved(lambda t: rate + 0.0 * t, 0.0, end, start, np.zeros(0))
        stress, normal = self._stresses(state[:, None], np.array([rate]))
        return float(stress[0]), float(normal[0])

    def mean_velocity(self, drive: float, gap: float) -> float:
        """Return the mean velocity of developed flow in a ``gap`` under a ``drive`` [stress/length] > 0."""
        from scipy.optimize import brentq

        at_wall = 0.5 * drive * gap
        highest = 1.0
        while self.steady(highest)[0] < at_wall:
            highest *= 2.0
        wall_rate = brentq(lambda rate: self.steady(rate)[0] - at_wall, 0.0, highest, rtol=1e-6)
        return self._developed(wall_rate, gap)[0]

    def developed(self, mean: float, gap: float, pipe: bool = False) -> tuple[np.ndarray, np.ndarray]:
        """Return distances from mid-gap (n,), up to gap/2, and shear rates (n,) of developed flow.

        ``mean``: mean velocity > 0 in the ``gap``, or in a ``pipe`` of this diameter.
        """
        from scipy.optimize import newton

        newtonian = np.log((8.0 if pipe else 6.0) * mean / gap)
        found = newton(lambda log: np.log(self._developed(np.exp(log), gap, pipe)[0] / mean), newtonian, tol=1e-9)
        return self._developed(np.exp(found), gap, pipe)[1:]

    def _developed(self, wall_rate: float, gap: float, pipe: bool = False) -> tuple[float, np.ndarray, np.ndarray]:
        """Return the mean velocity, distances from mid-gap (n,), and shear rates (n,), by the rate at the walls.

        The stress is proportional to the distance s. u_mean is the integral of rate * s from 0 to gap/2, over gap/2; in
        a ``pipe`` of rate * s^2, over (gap/2)^2.
        """
        from scipy.interpolate import CubicSpline

        rates = wall_rate * np.linspace(0.0, 1.0, RATES) ** 3
        stresses = self._stresses(self.steady_states(rates), rates)[0]
        distances = 0.5 * gap * stresses / stresses[-1]
        mean = 2.0 / gap * CubicSpline(distances, rates * distances).integrate(0.0, 0.5 * gap)
        if pipe:
            mean = 4.0 / gap**2 * CubicSpline(distances, rates * distances**2).integrate(0.0, 0.5 * gap)
        return float(mean), distances, rates

    def steady_states(self, rates: np.ndarray) -> np.ndarray:
        """Return C (components, n) of all modes in steady shear of ``rates`` (n,) that ascend from 0.

        Each state is the root of the law's rate of change, sought from the state at the rate before.
        """
        from scipy.optimize import root

        def change(c: np.ndarray, law: PolymerLaw, rate: float) -> np.ndarray:
            return np.array([1.0 * one for one in law.rate_in_shear(tuple(c), rate)])

        found = [np.zeros((0, len(rates)))]
        for law in self.laws:
            states = [np.zeros(law.components)]
            for rate in rates:
                states.append(root(change, states[-1], (law, rate), tol=1e-12).x)
            found.append(np.transpose(states[1:]))
        return np.concatenate(found)

    def steady_stresses(self, rates: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return shear stress (n,) and N1 (n,) in steady shear of ``rates`` (n,) that ascend from about 0."""
        return self._stresses(self.steady_states(rates), rates)

    def _parts(self, state: np.ndarray) -> list[np.ndarray]:
        ends = np.cumsum([0, *(law.components for law in self.laws)])
        return [state[a:b] for a, b in pairwise(ends.tolist())]

    def _stresses(self, states: np.ndarray, rate: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        shear, normal = self.flux(rate), np.zeros(len(rate))
        for law, c in zip(self.laws, self._parts(states), strict=True):
            xx, xy, yy = law.stress(tuple(c))[:3]
            shear, normal = shear + xy, normal + (xx - yy)
        return shear, normal

    def _solved(
        self, rate: Callable, begin: float, end: float, start: np.ndarray, times: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the states (components, n) at ``times``, and the state (components,) at the ``end``."""
        if not self.laws or end <= begin:
            return np.repeat(start[:, None], len(times), axis=1), start
        from scipy.integrate import solve_ivp  # a fifth of a second, of no use to most runs

        def change(t: float, state: np.ndarray) -> np.ndarray:
            now = float(rate(t))
            parts = zip(self.laws, self._parts(state), strict=True)
            return np.concatenate([[1.0 * one for one in law.rate_in_shear(tuple(c), now)] for law, c in parts])

        moments = np.append(times[times < end], end)
        found = solve_ivp(change, (begin, end), start, "LSODA", moments, rtol=RELATIVE, atol=ABSOLUTE).y
        return found[:, np.searchsorted(moments, times)], found[:, -1]
