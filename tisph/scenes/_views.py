"""Views of a scene: profiles along lines, time series, the views of a movie, and quantities of two-dimensional flow."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tisph.measures.fits import (
    interpolated,
    max_void_radius,
    min_distance,
    stream_function,
    velocity_gradients,
    vorticity,
    wall_points,
    with_walls,
)
from tisph.measures.flow import FlowInBox
from tisph.measures.metrics import with_reference
from tisph.measures.substance import Substance
from tisph.snapshot import Snapshot

ROUNDING = 1e-6  # spacings
_AT_REST = 1e-3  # of reference velocity over length: a shear rate that errors alone may make
SHOWN = 3
"""Most free bodies in the panel of a movie, and with paths in its picture."""

_TIMES, _POINTS = 60, 101  # at which the range of a reference is evaluated


@dataclass(frozen=True)
class Line:
    """A straight line through the box along an axis, and the particles on it.

    ``along``: ``x`` or ``y``; ``ends``: first and last coordinate along the line; ``place``: the other coordinate. The
    particles on the line are at most ``half_width`` from ``place``, and half of their own widths where these vary: all
    particles where nothing depends on it.
    """

    along: str
    ends: tuple[float, float]
    place: Any
    half_width: float = math.inf

    def of(self, snapshot: Snapshot) -> np.ndarray:
        """Return the coordinate of each particle along the line."""
        return getattr(snapshot, self.along)

    def near(self, snapshot: Snapshot) -> np.ndarray | slice:
        """Return the index of the particles on the line, in their own order."""
        if self.half_width == math.inf:
            return slice(None)
        across = getattr(snapshot, "x" if self.along == "y" else "y")
        return np.abs(across - self.place) <= np.minimum(self.half_width, (0.5 + ROUNDING) * snapshot.widths(math.inf))

    def particles(self, snapshot: Snapshot) -> np.ndarray:
        """Return the indices of the particles on the line, in the order of their coordinate along it."""
        chosen = np.arange(len(snapshot.x))[self.near(snapshot)]
        return chosen[np.argsort(self.of(snapshot)[chosen], kind="stable")]

    def coordinates(self, count: int) -> np.ndarray:
        """Return ``count`` evenly spaced coordinates from end to end."""
        return np.linspace(*self.ends, count)

    def even_coordinates(self, count: int) -> np.ndarray:
        """Return ``count`` coordinates, each of an equal part of the fluid that the line stands for."""
        return self.coordinates(count)

    def points(self, coordinates: Any) -> tuple[Any, Any]:
        """Return places (x, y) at ``coordinates`` along the line; they broadcast."""
        return (coordinates, self.place) if self.along == "x" else (self.place, coordinates)

    def in_fluid(self, scene: FlowInBox, coordinates: np.ndarray, t: float) -> np.ndarray:
        """Return whether the points at ``coordinates`` (n,) are outside all bodies of ``scene`` at time ``t``."""
        places = np.stack(np.broadcast_arrays(*self.points(coordinates)), axis=1)
        wet = np.ones(len(places), dtype=bool)
        for body in scene.bodies:
            wet &= body.nearest(places, t).distance > -1e-9 * scene.spacing
        return wet


@dataclass(frozen=True)
class Radius(Line):
    """The distance from the axis at ``place`` (2,), between ``ends``; nothing depends on the angle."""

    along: str = "r"
    ends: tuple[float, float] = (0.0, 1.0)
    place: tuple[float, float] = (0.0, 0.0)

    def of(self, snapshot: Snapshot) -> np.ndarray:
        """Return the distance of each particle from the axis."""
        return np.hypot(snapshot.x - self.place[0], snapshot.y - self.place[1])

    def even_coordinates(self, count: int) -> np.ndarray:
        """See ``Line.even_coordinates``: the radii of rings of equal area."""
        inner, outer = self.ends
        return np.sqrt(np.linspace(inner**2, outer**2, count))

    def points(self, coordinates: Any) -> tuple[Any, Any]:
        """Return places (x, y) at the distances ``coordinates`` along x from the axis."""
        return self.place[0] + coordinates, self.place[1]


@dataclass(frozen=True)
class Profile:
    """A quantity along a ``line``.

    ``of``: function of a snapshot that returns the quantity (particles,). ``unit``: a kind of unit that
    ``report/labels.py`` knows, or the label of a unit. ``exact``: function of places x, y and times, which broadcast,
    that returns the reference; None without one. ``reference``: its name in pictures; ``steady``: whether it is one of
    the steady state alone. ``scale``: value and name of the scale over which errors are shown, if any.
    """

    name: str
    unit: str
    line: Line
    of: Callable
    exact: Callable | None = None
    scale: tuple[float, str] | None = None
    reference: str = "exact"
    steady: bool = False

    def interpolated(self, scene: FlowInBox, snapshot: Snapshot, coordinates: np.ndarray) -> np.ndarray:
        """Return the quantity at ``coordinates`` (n,) along the line, interpolated between particles (n,).

        By the least-squares fits of ``measures/fits.py``, for velocities also to points on walls; NaN in bodies, after
        a run has gone wrong, and of data of another code on some line, which do not fill half of the region.
        """
        if 2 * len(snapshot.x) < scene.particles:
            return np.full(len(coordinates), np.nan)
        given = walled(scene, snapshot) if self.unit == "velocity" else snapshot
        places = np.stack([given.x, given.y], axis=1).astype(float)
        points = np.stack(np.broadcast_arrays(*self.line.points(coordinates)), axis=1)
        found = interpolated(scene, places, self.of(given)[:, None], points)[:, 0]
        return np.where(self.line.in_fluid(scene.seen(snapshot), coordinates, snapshot.t), found, np.nan)

    def without_reference(self) -> "Profile":
        """Return the profile without its reference."""
        return replace(self, exact=None, scale=None)

    def of_slip_walls(self, wall_velocity: Callable, t: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the velocities of walls with slip at the ends of the line, if any, and their coordinates.

        ``wall_velocity``: ``Scene.slip_wall_velocity``.
        """
        points = np.stack(np.broadcast_arrays(*self.line.points(np.array(self.line.ends))), axis=1)
        velocity = wall_velocity(points, t)
        known = np.isfinite(velocity[:, 0]) & (self.unit == "velocity")
        if not known.any():
            return np.empty(0), np.empty(0)
        none, (x, y), (u, v) = np.zeros(known.sum()), points[known].T, velocity[known].T
        walls = Snapshot(t, 0, x, y, u, v, density=none, pressure=none)
        return np.asarray(self.of(walls)), np.array(self.line.ends)[known]

    def extremes(self, start: float, end: float) -> tuple[float, float]:
        """Return the smallest and largest finite value of the reference on the line from time ``start`` to ``end``.

        The times are denser early on, where a start changes fastest; the last two are 1/30 of the run apart.
        """
        assert self.exact is not None
        times = start + (end - start) * np.linspace(0.0, 1.0, _TIMES) ** 2
        places = self.line.points(self.line.coordinates(_POINTS)[:, None])
        values = self.exact(*places, times[None, :])
        values = values[np.isfinite(values)]
        return float(values.min()), float(values.max())

    def spread(self, start: float, end: float) -> np.ndarray:
        """Return the reference (n,) at places that are even in the fluid and times that are even in the run."""
        assert self.exact is not None
        places = self.line.points(self.line.even_coordinates(_POINTS)[:, None])
        return self.exact(*places, np.linspace(start, end, _TIMES)[None, :]).ravel()


def walled(scene: FlowInBox, snapshot: Snapshot) -> Snapshot:
    """Return a ``snapshot`` that has a particle with the velocity of the wall at each point of ``fits.with_walls``."""
    (x, y), (u, v) = (part.T for part in with_walls(scene, snapshot))
    w = snapshot.w
    if w is not None:
        walls = wall_points(scene.seen(snapshot), snapshot.t)
        w = np.concatenate([w, *(body.spin.velocity(snapshot.t) * points[:, 1] for body, points in walls)])
    return replace(snapshot, x=x, y=y, u=u, v=v, w=w)


@dataclass(frozen=True)
class MovieView:
    """The quantity that colours the fluid in a movie, and the profile beside it.

    ``of``: function of a snapshot that returns the quantity. ``signed``: colours span minus to plus the largest
    magnitude if it has both signs, else they start at 0, or at ``base``; without ``from_zero`` they span the least to
    the largest value. Ranges of the run: ``ends`` spans the profile, and ``values``, which are even over fluid and
    time, give the limits of the colours; None if only the frames show them. ``error``: name in a snapshot and in words
    of the field whose error is written beside the movie; None for the velocity. ``walls``: velocities of walls that
    the axis of the profile spans, too.
    """

    name: str
    signed: bool
    of: Callable
    profile: Profile
    ends: Sequence[float] | None
    values: np.ndarray | None = None
    error: tuple[str, str] | None = None
    from_zero: bool = True
    base: float = 0.0
    walls: Sequence[float] = ()


@dataclass(frozen=True)
class TimeSeries:
    """Numbers that are recorded in time.

    ``measure`` is a function of a snapshot that returns the numbers (numbers,); ``content`` describes them in words.
    ``columns`` and ``exact_columns`` are the names of numbers and references in ``history.csv``; ``exact`` returns the
    references (records, numbers) at times (records,), or None. ``places``: coordinates at which the numbers are
    measured, if any. ``angular_frequency``: that at which the numbers oscillate
    fastest, or 0. ``drifting``: columns that go on changing in a steady state.

    For the plot, ``labels`` are pairs for the legend: a name, and a value or None. ``name`` and ``unit`` are for the
    axis, ``scale`` is the magnitude of the numbers. If the numbers are of different kinds, ``sizes`` are the magnitude
    of each, and ``panels`` the pair (name, unit) of the axes of each; numbers with the same pair share axes, and a
    number with None is not drawn. ``levels``: steady value of each number, NaN if unknown; ``level_name``: their name.
    ``reference``: name of ``exact`` in pictures where it is that of another flow. ``may_be_steady``: whether numbers
    without ``sizes`` are judged (``measures/steadiness.py``), as numbers with them are. ``event``: name of an event
    that a movie marks at its first time, and whether numbers (numbers,) show it.
    """

    content: str
    name: str
    unit: str
    scale: float
    columns: Sequence[str]
    labels: Sequence[tuple[str, float | None]]
    measure: Callable
    exact_columns: Sequence[str] = ()
    exact: Callable = lambda times: None
    places: Sequence[float] | np.ndarray = ()
    angular_frequency: float = 0.0
    sizes: Sequence[float] = ()
    panels: Sequence[tuple[str, str] | None] = ()
    levels: Sequence[float] = ()
    drifting: Sequence[str] = ()
    level_name: str = "exact, when steady"
    reference: str = ""
    may_be_steady: bool = False
    event: tuple[str, Callable[[np.ndarray], bool]] | None = None

    @property
    def judged_sizes(self) -> dict[str, float]:
        """Size of each number by its column, infinite where it goes on changing in steady flow; empty if not judged."""
        pairs = zip(self.columns, self.sizes or len(self.columns) * [self.scale] * self.may_be_steady, strict=False)
        return {name: math.inf if name in self.drifting else size for name, size in pairs}

    def without_reference(self) -> "TimeSeries":
        """Return the series without its reference."""
        return replace(self, exact_columns=(), exact=lambda times: None, levels=())

    def only(self, kinds: str | tuple[str, ...], name: str, unit: str) -> "TimeSeries":
        """Return the series of the numbers whose columns begin with one of ``kinds``."""
        chosen = [index for index, column in enumerate(self.columns) if column.startswith(kinds)]
        return replace(
            self,
            name=name,
            unit=unit,
            columns=[self.columns[index] for index in chosen],
            labels=[(self.columns[index].replace("_", " "), None) for index in chosen],
            measure=lambda snapshot: self.measure(snapshot)[chosen],
            exact=lambda times: None if (exact := self.exact(times)) is None else exact[:, chosen],
            sizes=(),
            panels=(),
            levels=[self.levels[index] for index in chosen] if self.levels else (),
            drifting=(),
        )


@dataclass(frozen=True)
class ExtraSeries:
    """Further columns of ``history.csv``, which are not drawn.

    ``measure``: function of a snapshot that returns the numbers ``columns``. ``final``: function of all times
    (records,) and numbers (records, columns), called when a run ends, that returns (records, final columns).
    """

    columns: Sequence[str]
    measure: Callable
    final_columns: Sequence[str]
    final: Callable


@dataclass(frozen=True)
class Colour:
    """A quantity that may colour a movie.

    ``of``: function of a scene and a snapshot that returns the quantity (particles,); ``unit``: a kind of unit;
    ``signed``: whether the quantity has both signs; ``from_zero``: whether its colours span ``base``, its value in a
    fluid at rest in plane and in axisymmetric flow. ``fields``: the fields of a snapshot that it needs beside places,
    velocities and shear stress.
    """

    words: str
    unit: str
    of: Callable
    signed: bool = True
    from_zero: bool = True
    fields: tuple[str, ...] = ()
    base: tuple[float, float] = (0.0, 0.0)


def _strain(scene: FlowInBox, snapshot: Snapshot) -> np.ndarray:
    """Return the rate of strain D_xx, D_yy, D_tt, D_xy, D_xt, D_yt at the particles (6, particles); t: around an axis.

    In axisymmetric flow D_tt = v/y, D_xt = (dw/dx)/2 and D_yt = (dw/dy - w/y)/2; else these are 0.
    """
    (u_x, u_y, v_x, v_y), none = velocity_gradients(scene, snapshot, degree=2), np.zeros(len(snapshot.x))
    if snapshot.w is None:
        return np.stack([u_x, v_y, none, 0.5 * (u_y + v_x), none, none])
    w_x, w_y = velocity_gradients(scene, replace(snapshot, u=snapshot.w), degree=2)[:2]
    return np.stack(
        [u_x, v_y, snapshot.v / snapshot.y, 0.5 * (u_y + v_x), 0.5 * w_x, 0.5 * (w_y - snapshot.w / snapshot.y)]
    )


def _contracted(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return the double contraction (particles,) of two symmetric tensors (6, particles), ordered as ``_strain``."""
    return (one * other * [[1.0], [1.0], [1.0], [2.0], [2.0], [2.0]]).sum(axis=0)


def _shear_rate(scene: FlowInBox, snapshot: Snapshot) -> np.ndarray:
    """Return sqrt(2 D:D), |du/dy| in parallel flow."""
    strain = _strain(scene, snapshot)
    return np.sqrt(2.0 * _contracted(strain, strain))


def _viscosity(scene: FlowInBox, snapshot: Snapshot) -> np.ndarray:
    """Return the dynamic viscosity S:D/(2 D:D) of the whole extra stress S; NaN where nothing is deformed.

    Of an inelastic fluid it is the viscosity of its law at the shear rate; of a polymer solution, the solvent's and the
    power that the polymer takes up, below 0 where it gives power back.
    """
    strain = _strain(scene, snapshot)
    squared = 2.0 * _contracted(strain, strain)
    if not scene.polymer:
        law = scene.rheology.law(scene.kinematic_viscosity, scene.density) if scene.rheology else None
        return scene.density * law.viscosity(squared) if law else np.full(len(squared), scene.dynamic_viscosity)
    names = ("stress_xx", "stress_yy", "stress_tt", "stress_xy", "stress_xt", "stress_yt")
    parts = [getattr(snapshot, name) for name in names]
    stress = np.stack([np.zeros_like(squared) if part is None else part for part in parts])
    resting = squared <= (_AT_REST * scene.reference_velocity / scene.reference_length) ** 2
    shared = _contracted(stress, strain) / np.where(resting, np.nan, squared)
    return scene.density * scene.solvent_viscosity + shared


def _shear_stress(scene: FlowInBox, snapshot: Snapshot) -> np.ndarray:
    """Return the polymer's shear stress, or without polymer mu (du/dy + dv/dx), mu being the local viscosity."""
    if snapshot.stress_xy is not None:
        return snapshot.stress_xy
    return 2.0 * _viscosity(scene, snapshot) * _strain(scene, snapshot)[3]


def _conformation_trace(scene: FlowInBox, snapshot: Any) -> np.ndarray:
    """Return tr A for a polymer stress S = G (A - 1) of modulus G: 2 + (S_xx + S_yy)/G in planar flow.

    In axisymmetric flow tr A = 3 + (S_xx + S_yy + S_tt)/G, with the stress S_tt around the axis.
    """
    assert scene.polymer
    viscosity = (1.0 - scene.polymer.solvent_fraction) * scene.dynamic_viscosity
    plane = 2.0 + (snapshot.stress_xx + snapshot.stress_yy) * scene.polymer.relaxation_time / viscosity
    return plane + 1.0 + snapshot.stress_tt * scene.polymer.relaxation_time / viscosity if scene.axisymmetric else plane


def _error(scene: FlowInBox, snapshot: Snapshot) -> np.ndarray:
    """Return |u - u_exact|; a velocity component without a reference is compared with 0."""
    names = [name for name in ("u", "v", "w") if getattr(snapshot, name) is not None]
    exact = with_reference(scene, snapshot, [name for name in names if name in scene.fields]).reference or {}
    return np.linalg.norm([getattr(snapshot, name) - exact.get(name, 0.0) for name in names], axis=0)


def _speed(_: Any, snapshot: Snapshot) -> np.ndarray:
    speed = np.hypot(snapshot.u, snapshot.v)
    return speed if snapshot.w is None else np.hypot(speed, snapshot.w)


_NORMAL = ("stress_xx", "stress_yy")

COLOURS = {
    "speed": Colour("speed", "velocity", _speed, signed=False),
    "u": Colour("u", "velocity", lambda _, snapshot: snapshot.u),
    "v": Colour("v", "velocity", lambda _, snapshot: snapshot.v),
    "swirl": Colour("swirl", "velocity", lambda _, snapshot: snapshot.w),
    "stream_function": Colour("stream function", "flow_rate", stream_function),
    "vorticity": Colour("vorticity", "rate", lambda scene, snapshot: vorticity(scene, snapshot, degree=2)),
    "pressure": Colour("pressure", "stress", lambda _, snapshot: snapshot.pressure, fields=("pressure",)),
    "shear_stress": Colour("shear stress", "stress", _shear_stress),
    "normal_stress_difference": Colour(
        "N1", "stress", lambda _, snapshot: snapshot.stress_xx - snapshot.stress_yy, fields=_NORMAL
    ),
    "shear_rate": Colour("shear rate", "rate", _shear_rate, signed=False),
    "viscosity": Colour("viscosity", "viscosity", _viscosity, fields=_NORMAL),
    "conformation_trace": Colour(
        "trace of the conformation tensor", "number", _conformation_trace, signed=False, fields=_NORMAL, base=(2.0, 3.0)
    ),
    "error": Colour("error of the velocity", "velocity", _error, signed=False),
}
"""Colours by the names of ``output.video.color_by``; dye is no quantity of the flow (``report/field.py``).

Further ones are ``substance_colour``."""


def substance_colour(each: Substance) -> Colour:
    """Return the colour that shows a temperature or a dissolved substance."""

    def of(_: Any, snapshot: Snapshot) -> np.ndarray:
        return snapshot.field(each.name)

    return Colour(each.words, each.unit, of, signed=False, from_zero=False, fields=(each.name,))


ERRORS = {"pressure": ("pressure", "p"), "shear_stress": ("stress_xy", "Sxy")}
"""Colour -> field whose error is written beside the movie, and its name in words; other movies show the velocity's."""


# Quantities of two-dimensional flow ----------------------------------------------------------------------------------


def centre_line(scene: FlowInBox, along: str) -> Line:
    """Return the line ``along`` x or y through the middle of the box, with the particles within half a spacing.

    Rows of a lattice that are half a spacing away on both sides count, whatever the round-off.
    """
    axis = "xy".index(along)
    ends = [(low, low + size) for low, size in zip(scene.origin, scene.extent, strict=True)]
    return Line(along, ends[axis], 0.5 * sum(ends[1 - axis]), half_width=(0.5 + ROUNDING) * scene.spacing)


def velocity_profile(scene: FlowInBox, field: str, along: str, **reference: Any) -> Profile:
    """Return the Profile of the velocity ``field`` on the centre line ``along`` x or y.

    ``reference``: ``exact``, ``scale`` and ``reference`` of the Profile.
    """
    line = centre_line(scene, along)
    return Profile(field, "velocity", line, of=lambda snapshot: getattr(snapshot, field), **reference)


def pressure_profile(scene: FlowInBox, line: Line) -> Profile:
    """Return the Profile of the pressure on a ``line``, shifted so that its mean error over all particles is 0."""

    def exact(x: Any, y: Any, t: Any) -> np.ndarray:
        return scene.exact("pressure", x, y, t)

    def of(snapshot: Snapshot) -> np.ndarray:
        if not scene.isothermal:
            return snapshot.pressure
        off = snapshot.pressure - exact(snapshot.x, snapshot.y, snapshot.t)
        return snapshot.pressure - np.mean(snapshot.weight * off)

    scale = (scene.density * scene.reference_velocity**2, "density U²")
    return Profile(name="p", unit="stress", line=line, of=of, exact=exact, scale=scale)


def vorticity_profile(scene: FlowInBox, line: Line, exact: Callable) -> Profile:
    """Return the Profile of the vorticity on a ``line`` with its ``exact`` value, a function of places and time."""
    return Profile("vorticity", "rate", line, of=lambda snapshot: vorticity(scene, snapshot, degree=2), exact=exact)


def velocity_errors(scene: FlowInBox, snapshot: Snapshot, u: np.ndarray, v: np.ndarray) -> dict[str, float]:
    """Return ``l2``, ``rms`` and ``linf`` of ``sample_metrics`` against ``u``, ``v`` (particles,) of a steady flow."""
    squares, speed = (snapshot.u - u) ** 2 + (snapshot.v - v) ** 2, scene.reference_velocity
    weight = snapshot.weight
    return {
        "l2": np.sqrt(np.sum(weight * squares) / np.sum(weight * (u**2 + v**2))),
        "rms": np.sqrt(np.mean(weight * squares)) / speed,
        "linf": np.sqrt(np.max(squares)) / speed,
    }


def kinetic_energy(scene: FlowInBox, snapshot: Snapshot) -> float:
    """Return the mean of (u^2 + v^2)/2 over the fluid."""
    return 0.5 * scene.mean(snapshot, np.square(snapshot.u) + np.square(snapshot.v))


def energy_series(scene: FlowInBox) -> TimeSeries:
    """Return the ``TimeSeries`` of the kinetic energy, without a reference."""
    return TimeSeries(
        content="mean kinetic energy per mass over time t",
        name="kinetic energy per mass",
        unit="energy",
        scale=0.5 * scene.reference_velocity**2,
        columns=["kinetic_energy"],
        labels=[("mean over the fluid", None)],
        measure=lambda snapshot: np.array([kinetic_energy(scene, snapshot)]),
    )


def planar_diagnostics(scene: FlowInBox, snapshot: Snapshot) -> tuple[float, dict[str, Any]]:
    """Return the mean square of the vorticity, and the diagnostics of a planar flow that need no reference.

    ``divergence_over_gradient``: largest |div u| over the largest velocity gradient (Frobenius norm), None at rest;
    ``min_distance`` and ``max_void_radius``, see ``measures/fits.py``; ``density_variation`` = max
    |density/density_0 - 1|. The gradients are fits (``measures/fits.py``) with errors of about 1e-4 of the largest
    gradient at 50 particles a wavelength, which fall with the fourth power of the spacing.
    """
    slopes = velocity_gradients(scene, snapshot)
    largest = np.max(np.linalg.norm(slopes, axis=0))
    distance, radius = min_distance(scene, snapshot), max_void_radius(scene, snapshot)
    return np.mean(snapshot.weight * np.square(slopes[2] - slopes[1])), {
        "divergence_over_gradient": np.max(np.abs(slopes[0] + slopes[3])) / largest if largest else None,
        "min_distance": distance,
        "max_void_radius": radius,
        "nearest_two": distance,  # the old names of both
        "largest_hole": radius,
        "density_variation": np.max(np.abs(snapshot.density / scene.density - 1)),
    }
