"""Where the data lie in the scene: axes, origin and spacing, given or found, and a snapshot of them.

What is not in the data is NaN in the snapshot, so that all that depends on it has no number.
"""

from dataclasses import dataclass, fields, replace

import numpy as np

from tisph.errors import ConfigError
from tisph.measures.metrics import root_mean_square
from tisph.snapshot import STRESSES, Bodies, Snapshot

AXES = [(along, towards) for along in ("x", "-x", "y", "-y") for towards in ("y", "-y", "x", "-x")]
ORIENTATIONS = [pair for pair in AXES if pair[0][-1] != pair[1][-1]]
"""Axes of the data along which x and y of the scene point; the first one is that of the scene."""

BETTER = 0.2
"""Another orientation is taken where its error is below that fraction of the error as the data are."""

DOUBTFUL = 0.1
"""Error over U below which no other orientation is looked for."""

BEYOND = 1.0
"""Spacings beyond the walls from which on the data do not fit between them."""

EVEN = 0.2
"""Heights that lie closer than that part of their mean distance are of particles, not of one line across."""

COLUMNS = 8
"""Columns of particles that a line across the channel stands for: enough for the fits that read between points."""

GOLDEN = 0.6180339887498949


@dataclass(frozen=True)
class Aligned:
    """Data in the scene: a ``Snapshot`` with its reference, the scene with the spacing of the data, how many ``points``
    the data have, which may be repeated along the channel in the snapshot, and in words how they were aligned."""

    scene: object
    snapshot: Snapshot
    points: int
    notes: tuple[str, ...] = ()

    def noted(self, text):
        """The same with one more note."""
        return replace(self, notes=(*self.notes, text))


def orientation(text):
    """Pair of axes from a text such as ``x,-y``; ConfigError for any other."""
    pair = tuple(part.strip() for part in text.split(","))
    if pair not in ORIENTATIONS:
        known = " ".join(",".join(each) for each in ORIENTATIONS)
        raise ConfigError(f"--orientation {text}: must be one of {known}, the data's axes along x and y of the scene")
    return pair


def align(columns, scene, t, *, axes=None, origin=None):
    """``Aligned`` of data by quantity, in the units of the config, at time ``t``.

    ``axes`` is one of ``ORIENTATIONS``, ``origin`` the place in the data of the point (0, 0) of the scene: both are
    found between plane walls where they are not given. ConfigError where the data do not fit.
    """
    if not scene.parallel:
        missing = [name for name in ("x", *scene.fields) if name in "xyuv" and name not in columns]
        if missing:
            raise ConfigError(f"--columns: this flow needs {' and '.join(missing)}, too")
        return _aligned(_reoriented(columns, axes or ORIENTATIONS[0], origin or (0.0, 0.0)), scene, t, ())
    return _between_walls(columns, scene, t, axes, origin)


def _between_walls(columns, scene, t, axes, origin):
    """As they are if they fit; else, or where another orientation has far less error, as they fit best."""
    choices = [axes] if axes else [pair for pair in ORIENTATIONS if _has(columns, pair)]
    as_is = _tried(columns, scene, t, choices[0], origin) if choices else None
    if as_is and not as_is.notes and _error(as_is) < DOUBTFUL * scene.reference_velocity:
        return as_is
    tried = [each for pair in choices if (each := _tried(columns, scene, t, pair, origin))]
    if not tried:
        y = columns["y"]
        text = f"y reaches from {y.min():.4g} to {y.max():.4g}, the walls are {scene.gap:g} apart"
        raise ConfigError(f"the data do not fit between the walls: {text}; give --unit, --origin or --orientation")
    best = min(tried, key=_error)
    return as_is if as_is and not as_is.notes and _error(best) > BETTER * _error(as_is) else best


def _has(columns, axes):
    """Whether the data have a velocity along the walls and heights with these ``axes``."""
    speed = {"x": "u", "y": "v"}[axes[0][-1]]
    return axes[1][-1] in columns and speed in columns and ("x" in columns or axes[0] == "x")


def _tried(columns, scene, t, axes, origin):
    """``Aligned`` with these axes, None where the data do not fit."""
    spacing = _spacing(columns, scene)
    reoriented = _reoriented(columns, axes, origin or (0.0, 0.0))
    low, high = reoriented["y"].min(), reoriented["y"].max()
    mirrored = ", or the velocities have the wrong sign" if axes == ("-x", "y") else ""
    text = f"x and y of the scene point along {axes[0]} and {axes[1]} of the data{mirrored}"
    notes = () if axes == ORIENTATIONS[0] else (text,)
    if low < -BEYOND * spacing or high > scene.gap + BEYOND * spacing:
        if origin or abs(high - low + spacing - scene.gap) > 2 * BEYOND * spacing:
            return None
        shift = 0.5 * (scene.gap - low - high)
        reoriented["y"] = reoriented["y"] + shift
        wall = shift if axes[1].startswith("-") else -shift
        notes += (f"the bottom wall was found at {axes[1].strip('-')} = {wall:.6g} of the data",)
    elif high - low < 0.5 * scene.gap:
        return None
    return _aligned(reoriented, scene, t, notes)


def _reoriented(columns, axes, origin):
    """Columns as the scene has its axes, the places from ``origin``, a place of the data."""
    place = dict(zip("xy", origin, strict=True))
    reoriented = {name: array for name, array in columns.items() if name not in "xyuv"}
    for axis, name, speed in zip(axes, "xy", "uv", strict=True):
        sign, old = (-1.0 if axis.startswith("-") else 1.0), axis[-1]
        if old in columns:
            reoriented[name] = sign * (columns[old] - place[old])
        if (theirs := {"x": "u", "y": "v"}[old]) in columns:
            reoriented[speed] = sign * columns[theirs]
    return reoriented


def _error(aligned):
    """Root mean square error of the velocities, in whatever unit they are: with the best factor, which is no mirror."""
    u, exact = aligned.snapshot.u, aligned.snapshot.reference["u"]
    size = np.sum(u**2)
    return root_mean_square((max(np.sum(u * exact) / size, 0.0) if size else 0.0) * u - exact)


def _spacing(columns, scene):
    """Spacing of the points: of a lattice with as many of them and the same extent; of a profile along y."""
    count = len(columns["y"])
    if not scene.parallel:
        return scene.spacing * np.sqrt(scene.particles / count)
    if _is_profile(columns):
        return max(float(np.ptp(columns[name])) for name in "xy" if name in columns) / max(count - 1, 1)
    if "x" not in columns:
        return np.sqrt(scene.length * scene.gap / count)
    width, height = np.ptp(columns["x"]), np.ptp(columns["y"])
    both, more = width + height, count - 1
    return float(both + np.sqrt(both**2 + 4 * more * width * height)) / (2 * more)


def _is_profile(columns):
    """Whether the points are one line across the channel: they are on one, or as far apart as those on one are."""
    if "x" in columns:
        ranges = [float(np.ptp(columns[name])) for name in "xy"]
        return min(ranges) <= 1e-9 * max(ranges)
    steps = np.diff(np.sort(columns["y"]))
    return bool(steps.min(initial=np.inf) > EVEN * steps.mean()) if len(steps) else True


def _aligned(columns, scene, t, notes):
    spacing, points = _spacing(columns, scene), len(columns["y"])
    if scene.parallel:
        columns, scene = _in_channel(columns, scene, spacing)
    elif abs(spacing / scene.spacing - 1) > 1e-6:
        scene = _with_spacing(scene, spacing)
    x, y = columns["x"], columns["y"]
    low = scene.origin
    places = [
        axis - np.floor((axis - start) / size) * size if periodic else np.clip(axis, start, start + size)
        for axis, start, size, periodic in zip((x, y), low, scene.extent, scene.periodic, strict=True)
    ]
    nothing = np.full(len(y), np.nan)
    known = {name: columns.get(name, nothing) for name in ("u", "v", "density", "pressure")}
    stresses = {name: columns.get(name, nothing) for name in STRESSES} if scene.polymer else {}
    exact = {name: scene.exact(name, *places, t) for name in scene.fields}
    bodies = Bodies.at(t, scene.bodies) if scene.bodies else None  # of whose forces the data say nothing
    snapshot = Snapshot(t=t, step=0, x=places[0], y=y, **known, **stresses, reference=exact, bodies=bodies)
    return Aligned(scene, snapshot, points, notes)


def _in_channel(columns, scene, spacing):
    """Columns and scene of the length that the data have; nothing depends on x, so that it may be made up."""
    rows = max(round(scene.gap / spacing), 1)
    spacing = scene.gap / rows
    length = scene.length
    if _is_profile(columns):
        points, length = len(columns["y"]), COLUMNS * spacing
        x = np.repeat((np.arange(COLUMNS) + 0.5) * spacing, points)
        columns = {name: np.tile(array, COLUMNS) for name, array in columns.items()} | {"x": x}
    elif "x" not in columns:
        rank = np.argsort(np.argsort(columns["y"], kind="stable"))
        columns = columns | {"x": rank * GOLDEN % 1.0 * length}  # as evenly as may be, also among neighbours in y
    else:
        own = float(np.ptp(columns["x"])) + spacing
        length = length if abs(own - length) < 1.5 * spacing else own
    return columns, replace(scene, length=length, spacing=spacing, rows=rows, columns=round(length / spacing))


def _with_spacing(scene, spacing):
    """The scene with another spacing, and as many rows and columns as fit."""
    counts = dict(zip(("columns", "rows"), (round(size / spacing) for size in scene.extent), strict=True))
    names = {each.name for each in fields(scene)}
    return replace(scene, spacing=spacing, **{name: number for name, number in counts.items() if name in names})
