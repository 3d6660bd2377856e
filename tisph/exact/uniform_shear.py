"""A fluid that is sheared uniformly: what a rheometer would show if the fluid had no inertia.

    shear stress = flux(rate) + sum of S_xy,    dC/dt = law.rate_in_shear(C, rate(t)),    S = law.stress(C)

for each law (mode) of a polymer, from rest; C and laws as in ``start_up``, stresses of the unit of the laws' viscosity.
Ordinary differential equations, integrated with an error of 1e-8 of the largest value (LSODA, piece by piece between
changes of the rate). The steady stress is that after ``REMEMBERED`` of the longest relaxation times.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

REMEMBERED = 60.0
RATES = 32
"""Points of the quadrature over the shear rate: errors of the mean velocity are below 1e-4, of a yield stress too."""

RELATIVE, ABSOLUTE = 1e-10, 1e-13
"""Tolerances of a step."""


@dataclass(frozen=True)
class UniformShear:
    """``flux(rate)``: shear stress of the solvent, or of an inelastic fluid; ``laws`` of a polymer's modes."""

    flux: Any
    laws: tuple[Any, ...] = ()

    def response(self, rates, times):
        """Shear stress and N1 at ascending ``times`` (n,), two arrays (n,).

        ``rates``: pairs (begin, function of time) ascending from (0, ...) on: the shear rate from each begin on, which
        at the begin itself is still that before it.
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

    def steady(self, rate):
        """Shear stress and N1 of steady shear of a ``rate``."""
        end = REMEMBERED * max((law.relaxation_time for law in self.laws), default=0.0)
        start = np.zeros(sum(law.components for law in self.laws))
        _, state = self._solved(lambda t: rate + 0.0 * t, 0.0, end, start, np.zeros(0))
        stress, normal = self._stresses(state[:, None], np.array([rate]))
        return float(stress[0]), float(normal[0])

    def mean_velocity(self, drive, gap):
        """Mean velocity of developed flow between plates at rest, ``gap`` apart, under a ``drive`` [stress/length] > 0.

        u_mean = [(gap/2)^2 rate_w - integral of (stress/drive)^2 d rate from 0 to rate_w]/gap, since the stress is
        ``drive`` times the distance from mid-gap (Weissenberg and Rabinowitsch); rate_w: shear rate at the walls.
        """
        from scipy.optimize import brentq

        at_wall = 0.5 * drive * gap
        highest = 1.0
        while self.steady(highest)[0] < at_wall:
            highest *= 2.0
        wall_rate = brentq(lambda rate: self.steady(rate)[0] - at_wall, 0.0, highest, rtol=1e-6)
        points, weights = np.polynomial.legendre.leggauss(RATES)
        part = 0.5 * (1.0 + points)
        squares = np.array([self.steady(wall_rate * each**3)[0] ** 2 for each in part]) / drive**2
        below = wall_rate * float(np.sum(0.5 * weights * 3.0 * part**2 * squares))
        return (0.25 * gap**2 * wall_rate - below) / gap

    def _parts(self, state):
        ends = np.cumsum([0, *(law.components for law in self.laws)])
        return [state[a:b] for a, b in pairwise(ends.tolist())]

    def _stresses(self, states, rate):
        shear, normal = self.flux(rate), np.zeros(len(rate))
        for law, c in zip(self.laws, self._parts(states), strict=True):
            xx, xy, yy = law.stress(tuple(c))[:3]
            shear, normal = shear + xy, normal + (xx - yy)
        return shear, normal

    def _solved(self, rate, begin, end, start, times):
        """States (components, n) at ``times``, and at the ``end``."""
        if not self.laws or end <= begin:
            return np.repeat(start[:, None], len(times), axis=1), start
        from scipy.integrate import solve_ivp  # a fifth of a second, of no use to most runs

        def change(t, state):
            now = float(rate(t))
            parts = zip(self.laws, self._parts(state), strict=True)
            return np.concatenate([[1.0 * one for one in law.rate_in_shear(tuple(c), now)] for law, c in parts])

        moments = np.append(times[times < end], end)
        found = solve_ivp(change, (begin, end), start, "LSODA", moments, rtol=RELATIVE, atol=ABSOLUTE).y
        return found[:, np.searchsorted(moments, times)], found[:, -1]
