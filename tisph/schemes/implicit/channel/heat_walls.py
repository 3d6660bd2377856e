"""Diffusion of a temperature or a dissolved substance between the walls of a channel: equation (9) of ``heat.py``.

Images continue T beyond the walls. With the distance d from a wall of given T_w, and from a wall of given flux q into
the fluid,

    T_I = 2 (T_w + d^2/2 T_dd + d^4/24 T_dddd) - T_F,    T_I = T_F - 2 (d T_d + d^3/6 T_ddd + d^5/120 T_ddddd),

where by (9) at the wall T_dd = (T_w' - r)/kappa and T_dddd = (T_w''/kappa - r_dd)/kappa; T_d = -q/(C kappa) with the
amount C in a volume per T, T_ddd = (T_d' - r_d)/kappa and T_ddddd = T_d''/kappa^2. r and its derivatives at a wall
are those of a polynomial that fits r near it. A condition that differs from the initial T changes T at once near the
wall, as a jump of the velocity does (``walls.py``).
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.polynomial import polynomial

from tisph.errors import DivergedError
from tisph.measures.substance import Substance
from tisph.scenes._channel import Channel
from tisph.schemes.implicit.channel.stages import EVEN_POWERS, FIT_TERMS, C, ClosedOperators, Series
from tisph.schemes.implicit.channel.walls import NEAR, TERMS, one_sided

ODD_POWERS = (1, 3, 5)
"""Powers of the wall distance in the fit for the slope at a wall of given T."""

FLOW_POWERS = (1, 2, 3, 4)
FLOW_RADIUS = 5.0
"""The fit for the flow through a wall of given T: powers of the wall distance, and its radius in spacings."""

NODES = np.linspace(0.0, 1.0, 4)
CUBIC = np.linalg.inv(NODES[:, None] ** np.arange(4))
"""Parts of a step at which conditions are evaluated, and the cubic through these values."""

SAME = 1e-10
"""Difference over the size of values, up to which they count as equal."""


class NearWall:
    """The points near a wall: their indices ``points``, ``distance`` from it, and weights of fits to their values."""

    def __init__(self, points: np.ndarray, distance: np.ndarray, radius: float) -> None:
        near = np.flatnonzero(distance < radius)
        self.points, self.distance = points[near], distance[near]
        part, scale = self.distance[:, None] / radius, radius ** -np.arange(FIT_TERMS)
        self.derivatives = np.linalg.pinv(part ** np.arange(FIT_TERMS)) * (scale * [1.0, 1.0, 2.0])[:, None]
        self.even = np.linalg.pinv(part ** np.array(EVEN_POWERS))[0]
        self.odd = np.linalg.pinv(part ** np.array(ODD_POWERS))[0] / radius


class Equation:
    """Equation (9) of one ``substance``, and its conditions at the walls.

    ``given``: for both walls and each stage T or T_d at the wall, and its first and second time derivative. ``even``:
    whether the (bottom, top) wall has a given flux. ``jumps``: whether a condition differs from the T at the start.
    """

    def __init__(self, substance: Substance, operators: ClosedOperators, channel: Channel) -> None:
        self.substance, self.channel, self.diffusivity = substance, channel, substance.diffusivity
        self.even = tuple(condition.value is None for condition in substance.conditions)
        self.closed = operators.of_field(self.even, self.diffusivity)
        self.begin(channel.start_time, 0.0)
        self.jumps = any(any(self.jump(side)) for side in range(2))

    def condition(self, side: int, time: float) -> float:
        """Return T at a wall, or T_d."""
        condition, height = self.substance.conditions[side], np.array([side * self.channel.gap])
        formula: Any = condition.flux if self.even[side] else condition.value
        factor = -1.0 / (self.substance.capacity * self.diffusivity) if self.even[side] else 1.0
        return factor * float(formula(np.zeros(1), height, time)[0])

    def begin(self, time: float, dt: float) -> None:
        """Find the conditions in the stages of a step of length ``dt`` at ``time``."""
        self.given = []
        for side, condition in enumerate(self.substance.conditions):
            formula: Any = condition.flux if self.even[side] else condition.value
            if not (formula.varies and dt):
                self.given.append([(self.condition(side, time), 0.0, 0.0)] * len(C))
                continue
            cubic = CUBIC @ [self.condition(side, time + part * dt) for part in NODES]
            if not np.all(np.isfinite(cubic)):
                raise DivergedError(f"{self.substance.name}: the condition at a wall is not finite")
            self.given.append(
                [tuple(polynomial.polyval(c, polynomial.polyder(cubic, k)) / dt**k for k in range(3)) for c in C]
            )

    def series(self, stage: int, r: np.ndarray, near: "Sequence[NearWall]") -> list[Series]:
        """Return the ``Series`` of the images beyond both walls in a ``stage``."""
        kappa = self.diffusivity
        found: list[Series] = []
        for side, wall in enumerate(near):
            given, rate, second_rate = self.given[side][stage]
            r_wall, r_slope, r_curvature = wall.derivatives @ r[wall.points]
            if self.even[side]:
                third, fifth = (rate - r_slope) / kappa, second_rate / kappa**2
                found.append([-2.0 * given, -third / 3.0, -fifth / 60.0])
            else:
                second, fourth = (rate - r_wall) / kappa, (second_rate / kappa - r_curvature) / kappa
                found.append([2.0 * given, second, fourth / 12.0])
        return found

    def rate(self, values: np.ndarray, r: np.ndarray, near: "Sequence[NearWall]") -> np.ndarray:
        """Return T' (n,) at the start of a step, by T = ``values``."""
        return self.diffusivity * (self.closed.laplacian(values) + self.at_walls(0, r, near)) + r

    def at_walls(self, stage: int, r: np.ndarray, near: "Sequence[NearWall]") -> np.ndarray:
        """Return the part of A T from the walls in a ``stage``."""
        return self.closed.boundary_laplacian(self.series(stage, r, near))

    def fit(self, side: int, stage: int, wall: NearWall, values: np.ndarray, r: np.ndarray) -> tuple[float, float]:
        """Return the T_d of ``values`` (n,) at a wall of given T, or T at one of given flux; and r there."""
        given, rate, _ = self.given[side][stage]
        distance, near = wall.distance, values[wall.points]
        r_wall, r_slope, _ = wall.derivatives @ r[wall.points]
        if self.even[side]:
            third = (rate - r_slope) / self.diffusivity
            return float(wall.even @ (near - given * distance - third / 6.0 * distance**3)), float(r_wall)
        second = (rate - r_wall) / self.diffusivity
        return float(wall.odd @ (near - given - second / 2.0 * distance**2)), float(r_wall)

    def gain(self, stage: int, near: Sequence[NearWall], values: np.ndarray, r: np.ndarray) -> float:
        """Return the amount that the fluid receives in a time in a ``stage`` through walls, and by r (n,)."""
        channel, slopes = self.channel, 0.0
        for side, wall in enumerate(near):
            fitted = self.given[side][stage][0] if self.even[side] else self.fit(side, stage, wall, values, r)[0]
            slopes += float(fitted)
        return self.substance.capacity * channel.length * (channel.gap * float(r.mean()) - self.diffusivity * slopes)

    def jump(self, side: int) -> tuple[float, float]:
        """Return the jump at a wall when the run starts: of T and of its rate, or of T_d and 0."""
        channel, time = self.channel, self.channel.start_time
        distance = np.polynomial.chebyshev.chebpts1(TERMS) + 1.0
        scale = 2.0 / (NEAR * channel.gap)
        heights = distance / scale if side == 0 else channel.gap - distance / scale
        x, given = np.zeros(TERMS), self.given[side][0]
        value, slope, second, *_ = polynomial.polyfit(distance, self.substance.initial(x, heights, time), TERMS - 1)
        if self.even[side]:
            jump = given[0] - scale * slope
            return (jump if abs(jump) > SAME * self.substance.scale * scale else 0.0), 0.0
        source = self.substance.source(x, heights, time)[0]
        jump, rate = given[0] - value, given[1] - self.diffusivity * 2.0 * scale**2 * second - source
        least = SAME * self.substance.scale
        return (jump if abs(jump) > least else 0.0), (rate if abs(rate) > least * self.diffusivity * scale**2 else 0.0)

    def impulse(self) -> np.ndarray:
        """Return the change of T by the jumps at walls when the run starts; see ``walls.py`` for the terms."""
        closed, kappa = self.closed, self.diffusivity
        total: Any = 0.0
        for side in range(2):
            jump, rate_jump = self.jump(side)
            first, second = (
                ([-1.0 / 3.0, 0.0], [0.0, -1.0 / 60.0]) if self.even[side] else ([1.0, 0.0], [0.0, 1.0 / 12.0])
            )
            one, two = (closed.boundary_laplacian(one_sided(side, [0.0, *each])) for each in (first, second))
            total = total + jump * (one + closed.laplacian(two)) + rate_jump / kappa * two
        return total

    def solve(
        self, part: Sequence[np.ndarray], stage: int, near: Sequence[NearWall], gamma_dt: float, tolerance: float
    ) -> np.ndarray:
        """Solve (1 - g kappa A) T = T_K + g r in a ``stage``, with the ``part`` T_K, r and a guess; NaN on failure."""
        known, r, guess = part
        right = known + gamma_dt * (self.diffusivity * self.at_walls(stage, r, near) + r)
        found = self.closed.solve(gamma_dt, None, right, guess, tolerance)
        return np.full_like(known, np.nan) if found is None else found

    def flow(self, side: int, heights: np.ndarray, values: np.ndarray, time: float) -> float:
        """Return the amount that flows from a wall into the fluid in a time, by ``values`` (n,) at ``heights``."""
        slope, channel = self.condition(side, time), self.channel
        if not self.even[side]:
            distance = heights if side == 0 else channel.gap - heights
            near = np.flatnonzero(distance < FLOW_RADIUS * channel.spacing)
            powers = distance[near, None] ** np.array(FLOW_POWERS)
            slope = float(np.linalg.lstsq(powers, values[near] - slope, rcond=None)[0][0])
        return -self.substance.capacity * self.diffusivity * slope * channel.length
