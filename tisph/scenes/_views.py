"""Views of a scene: profiles along lines, numbers followed in time, what a movie shows and can be coloured by."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tisph.measures.fits import stream_function, velocity_gradients, vorticity
from tisph.measures.metrics import with_reference

_TIMES, _POINTS = 60, 101  # at which a reference is looked at


@dataclass(frozen=True)
class Line:
    """A straight line through the box ``along`` the axis ``x`` or ``y``, and the particles on it.

    ``ends`` are the first and the last coordinate along the line. The particles on it are those no further than
    ``half_width`` from ``place``, the other coordinate: all of them where nothing depends on that.
    """

    along: str
    ends: tuple[float, float]
    place: float
    half_width: float = math.inf

    def of(self, snapshot) -> np.ndarray:
        """Coordinate of each particle along the line."""
        return getattr(snapshot, self.along)

    def near(self, snapshot) -> np.ndarray | slice:
        """Index of the particles on the line, in the order in which they are."""
        if self.half_width == math.inf:
            return slice(None)
        across = getattr(snapshot, "x" if self.along == "y" else "y")
        return np.abs(across - self.place) <= self.half_width

    def particles(self, snapshot) -> np.ndarray:
        """Indices of the particles on the line, in the order of their coordinate along it."""
        chosen = np.arange(len(snapshot.x))[self.near(snapshot)]
        return chosen[np.argsort(self.of(snapshot)[chosen], kind="stable")]

    def coordinates(self, count: int) -> np.ndarray:
        """``count`` evenly spaced coordinates from end to end."""
        return np.linspace(*self.ends, count)

    def points(self, coordinates) -> tuple[np.ndarray | float, np.ndarray | float]:
        """Places (x, y) at ``coordinates`` along the line; they broadcast."""
        return (coordinates, self.place) if self.along == "x" else (self.place, coordinates)

    def in_fluid(self, scene, coordinates, t) -> np.ndarray:
        """Whether the points at ``coordinates`` (n,) are in none of the bodies of ``scene`` at time ``t``."""
        places = np.stack(np.broadcast_arrays(*self.points(coordinates)), axis=1)
        wet = np.ones(len(places), dtype=bool)
        for body in scene.bodies:
            wet &= body.nearest(places, t).distance > -1e-9 * scene.spacing
        return wet


@dataclass(frozen=True)
class Radius(Line):
    """The distance from ``place`` (2,), from one of ``ends`` to the other: nothing depends on the angle around it."""

    along: str = "r"
    ends: tuple[float, float] = (0.0, 1.0)
    place: tuple[float, float] = (0.0, 0.0)

    def of(self, snapshot):
        """Distance of each particle."""
        return np.hypot(snapshot.x - self.place[0], snapshot.y - self.place[1])

    def points(self, coordinates):
        """Places (x, y) at ``coordinates`` along x from the middle."""
        return self.place[0] + coordinates, self.place[1]


@dataclass(frozen=True)
class Profile:
    """A quantity along a line: ``of`` takes it from a snapshot, array (particles,), ``exact`` is its reference.

    ``exact`` takes places x and y and times, which broadcast; it is None where there is no reference, and called
    ``reference`` in pictures. ``unit`` is a kind of unit that ``report/labels.py`` knows. With a ``scale`` (a value and
    its name) errors are shown over it.
    """

    name: str
    unit: str
    line: Line
    of: Callable
    exact: Callable | None = None
    scale: tuple[float, str] | None = None
    reference: str = "exact"

    def extremes(self, start: float, end: float) -> tuple[float, float]:
        """The smallest and largest finite value that the reference takes on the line from time ``start`` to ``end``.

        More times early on, where a start changes fastest. Between the last two times lies 1/30 of the run: what
        peaks there in between can pass the range by little.
        """
        times = start + (end - start) * np.linspace(0.0, 1.0, _TIMES) ** 2
        places = self.line.points(self.line.coordinates(_POINTS)[:, None])
        values = self.exact(*places, times[None, :])
        values = values[np.isfinite(values)]
        return float(values.min()), float(values.max())


@dataclass(frozen=True)
class MovieView:
    """What colours the fluid in a movie, and the profile beside it.

    ``of`` takes the colours' quantity from a snapshot; with ``signed`` they go from minus to plus the largest size of
    ``ends`` if those have both signs, else from 0. ``ends`` are the smallest and largest value of the profile in the
    run, None where the frames must tell. ``error`` names the field whose error is written beside it, in words; None for
    the velocity.
    """

    name: str
    signed: bool
    of: Callable
    profile: Profile
    ends: Sequence[float] | None
    error: tuple[str, str] | None = None


@dataclass(frozen=True)
class TimeSeries:
    """Numbers that are followed in time: ``measure`` takes them from a snapshot, array (numbers,).

    ``content`` says in words what they are, ``places`` where they are read, if that is somewhere. ``columns`` are their
    names in ``history.csv``, ``exact_columns`` those of their references, which ``exact`` returns for times (records,)
    as an array (records, numbers), or None; ``labels`` are pairs for the legend: a name, and a value or None. ``name``
    and ``unit`` are for the axis of the plot, ``scale`` is the size of the values, ``angular_frequency`` that of their
    fastest oscillation, or 0. ``probes`` (``measures/channel.py``) read them from the particles around some
    places, if they are velocities at places: a scheme need not give the others then. Where the numbers are of different
    kinds, ``sizes`` are theirs, and ``panels`` a pair as ``name`` and ``unit`` for the axes that each of them is drawn
    on: numbers of the same pair share axes, and those of None are on none. ``levels``: what they come to in the steady
    state, NaN where it is unknown; ``level_name`` says what those are. ``drifting``: columns that go on changing in a
    steady state.
    """

    content: str
    name: str
    unit: str
    scale: float
    columns: Sequence[str]
    labels: Sequence[str]
    measure: Callable
    exact_columns: Sequence[str] = ()
    exact: Callable = lambda times: None
    places: Sequence[float] = ()
    angular_frequency: float = 0.0
    probes: Any = None
    sizes: Sequence[float] = ()
    panels: Sequence[tuple[str, str] | None] = ()
    levels: Sequence[float] = ()
    drifting: Sequence[str] = ()
    level_name: str = "exact, when steady"

    def only(self, kinds, name, unit):
        """Those of the numbers whose columns begin with one of ``kinds``, as they are measured."""
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
    """Numbers that stand in ``history.csv`` beside those that are followed, and are not drawn.

    ``measure`` takes them, ``columns``, from a snapshot; ``final`` takes all times (records,) and numbers (records,
    columns) when a run ends, and returns what follows from them, (records, final columns).
    """

    columns: Sequence[str]
    measure: Callable
    final_columns: Sequence[str]
    final: Callable


@dataclass(frozen=True)
class Colour:
    """``of`` takes the quantity from a scene and a snapshot, array (particles,); ``unit`` is a kind of unit.

    ``signed``: whether it takes both signs. ``fields`` are those of the snapshot that it needs beside places,
    velocities and shear stress.
    """

    words: str
    unit: str
    of: Callable
    signed: bool = True
    fields: tuple[str, ...] = ()


def _shear_stress(scene, snapshot):
    """Return that of the polymer, or without one mu (du/dy + dv/dx)."""
    if scene.polymer:
        return snapshot.stress_xy
    gradients = velocity_gradients(scene, snapshot, degree=2)
    return scene.dynamic_viscosity * (gradients[1] + gradients[2])


def _conformation_trace(scene, snapshot):
    """Return tr A of a polymer whose stress S is the modulus G times A - 1: 2 + (S_xx + S_yy)/G in the plane.

    In axisymmetric flow tr A = 3 + (S_xx + S_yy + S_tt)/G, with the stress around the axis.
    """
    viscosity = (1.0 - scene.polymer.solvent_fraction) * scene.dynamic_viscosity
    plane = 2.0 + (snapshot.stress_xx + snapshot.stress_yy) * scene.polymer.relaxation_time / viscosity
    return plane + 1.0 + snapshot.stress_tt * scene.polymer.relaxation_time / viscosity if scene.axisymmetric else plane


def _error(scene, snapshot):
    """Return |u - u_exact|; a component of which no reference is known should be 0."""
    names = [name for name in ("u", "v", "w") if getattr(snapshot, name) is not None]
    exact = with_reference(scene, snapshot, [name for name in names if name in scene.fields]).reference
    return np.linalg.norm([getattr(snapshot, name) - exact.get(name, 0.0) for name in names], axis=0)


def _speed(snapshot):
    speed = np.hypot(snapshot.u, snapshot.v)
    return speed if snapshot.w is None else np.hypot(speed, snapshot.w)


_NORMAL = ("stress_xx", "stress_yy")

COLOURS = {
    "speed": Colour("speed", "velocity", lambda _, snapshot: _speed(snapshot), signed=False),
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
    "conformation_trace": Colour(
        "trace of the conformation tensor", "number", _conformation_trace, signed=False, fields=_NORMAL
    ),
    "error": Colour("error of the velocity", "velocity", _error, signed=False),
}
"""By the names that ``output.video.color_by`` takes; dye is no quantity of the flow (``report/field.py``)."""


ERRORS = {"pressure": ("pressure", "p"), "shear_stress": ("stress_xy", "Sxy")}
"""Fields, with a name in words, whose error is written beside a movie of them; of others it is that of the velocity."""


def movie_view(scene, name, end):
    """Return what a movie to time ``end`` coloured by ``name`` shows, with the scene's own profile where it has one.

    The range is known before the run where that profile has an exact solution at all times.
    """
    colour, own = COLOURS[name], scene.movie_profiles()
    profile = own.get(name)
    of = profile.of if profile and colour.words != "speed" else lambda snapshot: colour.of(scene, snapshot)
    words = profile.name if profile and colour.unit == "stress" and name != "pressure" else colour.words
    return MovieView(
        name=words,
        signed=colour.signed,
        of=of,
        profile=profile or Profile(colour.words, colour.unit, own["speed"].line, of),
        ends=scene.movie_ends(name, profile, end) if profile and profile.exact and "u" in scene.fields else None,
        error=ERRORS[name] if ERRORS.get(name, ("",))[0] in scene.fields else None,
    )
