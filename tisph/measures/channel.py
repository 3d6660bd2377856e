"""Measures of the particles of a channel: velocity at points, and shear stress at walls.

Velocity at a point (X, Y): the coefficients c minimise sum_j w_j (c . b_j - u_j)^2 over the particles j within the
radius R, with b = (1, X', Y', X'^2, X'Y', Y'^2) of X' = (x_j - X)/R, Y' = (y_j - Y)/R and the Wendland
weight w = (1 - q)^4 (1 + 4 q), q = |(X', Y')|; the value is c_0. It is exact for velocity fields up to
quadratic, for all positions of the particles and also next to a wall: a linear basis would leave an error of u_yy
R^2/29 in a curved profile, which exceeds the error of the flow. The radius is fixed, while ``fits`` uses the nearest
particles, so that points on a wall have as narrow a fit as others.

Shear stress at a wall: with d the distance from the wall, u - u_wall = a d + b d^2 + c d^3 + e d^4 is fitted by
weighted least squares to the particles within R = 5 spacings, weight (1 - d/R)^2 (1 + 2 d/R); u_wall is the velocity of
the wall at that time. Where the fluid slips, u_wall is the velocity of the fluid at d = 0, with a coefficient of its
own; if the slip length is at least a spacing, the total stress is viscosity * (u_wall - velocity of the wall) over the
slip length, which needs no derivative and is right directly after a jump of the velocity. Else the solvent stress is
+-mu_s a. The polymer stress is S_xy at d = 0 in a parabola fitted in the same way to the same particles. Nothing is
assumed of the curvature at the wall, which depends on a body acceleration, an accelerating wall and a polymer. For
exact fields the errors fall with the fourth (a) and third (S_xy) power of the spacing.

The quartic term is for thin layers: without it the error is of third order where u_yyyy differs from 0 at the wall,
and 0.7 % next to an oscillating wall with five spacings in its penetration depth; with it, less than 0.1 %. For S_xy
one term more would lower an imperceptible error of 0.01 %, and treble the weight of the row next to the wall, in which
an impulsive start has its largest error.

Source: P. Lancaster and K. Salkauskas, Math. Comput. 37 (1981) 141-158; weight: H. Wendland, Adv. Comput.
Math. 4 (1995) 389-396.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from tisph.geometry.motion import Schedule, StressControlledWall, WallMotion
from tisph.geometry.region import nearest_image
from tisph.measures.flow import FlowInBox, PolymerParameters
from tisph.snapshot import Snapshot


@dataclass(frozen=True, kw_only=True)
class ChannelFlow(FlowInBox):
    """Flow along x between the walls ``bottom`` at y = 0 and ``top`` at y = ``gap``, with the period ``length``.

    ``acceleration`` acts on the fluid along x; ``polymer`` is None without one. ``slip_lengths`` [length] of the
    (bottom, top) wall: the fluid at a wall is faster than the wall by slip length * shear stress / dynamic viscosity.
    """

    gap: float
    length: float
    bottom: WallMotion | StressControlledWall | Schedule
    top: WallMotion | StressControlledWall | Schedule
    acceleration: float = 0.0
    polymer: PolymerParameters | None = None
    slip_lengths: tuple[float, float] = (0.0, 0.0)

    @property
    def extent(self) -> tuple[float, float]:
        """Length and gap."""
        return self.length, self.gap

    @property
    def pair(self) -> tuple[Any, Any]:
        """The bottom and the top wall."""
        return self.bottom, self.top

    @property
    def driven_side(self) -> int | None:
        """The stress-controlled wall: 0 the bottom, 1 the top one; None where the velocities of both are given."""
        return next((side for side, wall in enumerate(self.pair) if wall.stress_controlled), None)

    @property
    def polymer_viscosity(self) -> float:
        """Kinematic viscosity that the polymer adds; 0 without polymer."""
        return self.kinematic_viscosity * (1.0 - self.polymer.solvent_fraction) if self.polymer else 0.0

    def viscous_stress(self, shear_rate: Any) -> Any:
        """Return the shear stress of the solvent, or of an inelastic fluid, at a ``shear_rate``."""
        if self.rheology is None or self.polymer:
            return self.density * self.solvent_viscosity * shear_rate
        law = self.rheology.law(self.kinematic_viscosity, self.density)
        return self.density * law.viscosity(shear_rate**2) * shear_rate


PROBE_RADIUS = 3.0
"""Radius R in particle spacings: 28 particles, and 14 in three rows for a point on a wall; 6 are needed."""


class Probes:
    """Fixed points at which the velocity along x is interpolated from the particles around them.

    ``x`` and ``y`` of shape (points,), inside the channel, which is periodic in x.
    """

    def __init__(self, channel: ChannelFlow, x: np.ndarray, y: np.ndarray):
        self.x = np.asarray(x, dtype=float)
        self.y = np.asarray(y, dtype=float)
        self._length = channel.length
        self._radius = PROBE_RADIUS * channel.spacing
        self._centre = 0.5 * (self.x.min() + self.x.max())
        self._half_width = 0.5 * np.ptp(self.x) + self._radius
        self._low, self._high = self.y.min() - self._radius, self.y.max() + self._radius

    def velocity(self, snapshot: Snapshot) -> np.ndarray:
        """Return the velocity along x at the points (points,); NaN where no particle is within the radius."""
        near = np.abs(nearest_image(snapshot.x - self._centre, self._length)) < self._half_width
        near &= (snapshot.y > self._low) & (snapshot.y < self._high)
        x, y, u = snapshot.x[near], snapshot.y[near], snapshot.u[near]
        point, particle = np.nonzero(np.abs(y - self.y[:, None]) < self._radius)
        along = nearest_image(x[particle] - self.x[point], self._length) / self._radius
        across = (y[particle] - self.y[point]) / self._radius
        distance = np.sqrt(along * along + across * across)
        within = np.flatnonzero(distance < 1.0)
        along, across, distance, particle = along[within], across[within], distance[within], particle[within]
        counts = np.bincount(point[within], minlength=self.x.size)
        found = np.flatnonzero(counts)
        square = (1 - distance) * (1 - distance)
        weight = square * square * (1 + 4 * distance)
        ones = np.ones_like(along)
        basis = np.stack([ones, along, across, along * along, along * across, across * across], axis=1)
        weighted = basis * weight[:, None]
        values = np.full(self.x.size, np.nan)
        if found.size:
            first = (np.cumsum(counts) - counts)[found]
            moments = np.add.reduceat(weighted[:, :, None] * basis[:, None, :], first)
            sums = np.add.reduceat(weighted * u[particle, None], first)
            try:
                values[found] = np.linalg.solve(moments, sums[..., None])[:, 0, 0]
            except np.linalg.LinAlgError:  # a void in a diverging flow gives a value instead of an exception
                inverse = np.linalg.pinv(moments, rcond=1e-12, hermitian=True)
                values[found] = (inverse @ sums[..., None])[:, 0, 0]
        return values


def interpolate(snapshot: Snapshot, channel: ChannelFlow, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the velocity along x at the points (``x``, ``y``), arrays of one shape (points,). See ``Probes``."""
    return Probes(channel, x, y).velocity(snapshot)


WALL_RADIUS = 5.0
"""Radius R in particle spacings: five rows of particles for at most four coefficients."""


def wall_shear(channel: ChannelFlow, snapshot: Snapshot) -> tuple[float, float]:
    """Return the shear stress (bottom, top) of the particles, averaged along the walls [mass/(length time^2)].

    It is the total stress, density * solvent viscosity * du/dy + S_xy. Where viscosity and relaxation times have the
    factor a of the temperature at the wall, a shear rate has the stress that the law gives for a times this rate.
    """
    found, temperature = [], channel.temperature
    for side, (wall, slip_length) in enumerate(zip(channel.pair, channel.slip_lengths, strict=True)):
        near, powers = _powers(channel, side, snapshot)
        u, weight, sign = snapshot.u[near], powers[:, 0], -1.0 if side else 1.0
        if slip_length >= channel.spacing:
            slip = _fitted(powers, weight * u)[0] - wall.velocity(snapshot.t)
            found.append(sign * channel.dynamic_viscosity * slip / slip_length)
            continue
        if wall.stress_controlled or slip_length:  # the wall, or the fluid at it, has the velocity of the particles
            rate = _fitted(powers, weight * u)[1]
        else:
            rate = _fitted(powers[:, 1:], weight * (u - wall.velocity(snapshot.t)))[0]
        rate = sign * rate / (WALL_RADIUS * channel.spacing)
        if temperature and temperature.law:
            at_wall = _fitted(powers, weight * snapshot.field(temperature.name)[near])[:1]
            rate = rate * float(temperature.factor(at_wall)[0])
        stress = channel.viscous_stress(rate)
        if channel.polymer is not None:
            stress += _fitted(powers[:, :3], weight * snapshot.stress_xy[near])[0]  # type: ignore[index]
        found.append(stress)
    return found[0], found[1]


def wall_shear_error(sample: Mapping[str, Any]) -> float | None:
    """Return the larger relative error of the wall shear at the two walls, from a sample's numbers; None without one.

    Both errors are relative to the larger of the two exact stresses, since the stress at a wall that the flow has not
    reached yet is nearly 0.
    """
    names = ("wall_shear_bottom", "wall_shear_top")
    numbers = [sample[name + ending] for name in names for ending in ("", "_exact")]
    if None in numbers:
        return None
    bottom, bottom_exact, top, top_exact = numbers
    scale = max(abs(bottom_exact), abs(top_exact))
    return max(abs(bottom - bottom_exact), abs(top - top_exact)) / scale if scale > 0 else None


def wall_velocity(channel: ChannelFlow, side: int, snapshot: Snapshot) -> float:
    """Return the velocity of the fluid at the bottom (``side`` 0) or top wall (1), by the particles."""
    near, powers = _powers(channel, side, snapshot)
    return _fitted(powers, powers[:, 0] * snapshot.u[near])[0]


def _powers(channel: ChannelFlow, side: int, snapshot: Snapshot) -> tuple[np.ndarray, np.ndarray]:
    """Return the particles (n,) near a wall, and roots of their weights times d/R to the powers 0 to 4 (n, 5)."""
    radius, distance = WALL_RADIUS * channel.spacing, channel.gap - snapshot.y if side else snapshot.y
    near = np.flatnonzero(distance < radius)
    fraction = distance[near] / radius
    powers = np.empty((len(near), 5))
    powers[:, 0] = (1 - fraction) * np.sqrt(1 + 2 * fraction)
    for k in range(1, 5):
        np.multiply(powers[:, k - 1], fraction, out=powers[:, k])
    return near, powers


def _fitted(basis: np.ndarray, values: np.ndarray) -> np.ndarray:
    return np.linalg.lstsq(basis, values, rcond=None)[0]


def integral(times: np.ndarray, velocities: np.ndarray) -> np.ndarray:
    """Return the integral from the first of ``times`` to each of them, by a smooth curve through ``velocities``."""
    from scipy.interpolate import PchipInterpolator  # few runs need it

    return PchipInterpolator(times, velocities).antiderivative()(times) if len(times) > 1 else np.zeros(len(times))
