"""Alignment of data with the scene: axes, origin and spacing, given or found, and a snapshot of the data.

A quantity that the data do not have is NaN in the snapshot, so that no number is computed from it.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tisph.errors import ConfigError
from tisph.measures.fits import NEIGHBOURS, periodic_tree
from tisph.measures.metrics import root_mean_square
from tisph.scenes._channel import Channel
from tisph.scenes._scene import Scene
from tisph.snapshot import Bodies, Snapshot

Axes = tuple[str, str]
Columns = dict[str, np.ndarray]

AXES = [(along, towards) for along in ("x", "-x", "y", "-y") for towards in ("y", "-y", "x", "-x")]
ORIENTATIONS = [pair for pair in AXES if pair[0][-1] != pair[1][-1]]
"""Axes of the data along which x and y of the scene point; in the first pair both have the same axes."""

BETTER = 0.2
"""Another orientation is taken if its error is below this fraction of the error in the given orientation."""

DOUBTFUL = 0.1
"""Error over U below which no other orientation is tried."""

BEYOND = 1.0
"""Distance [spacings] beyond the walls from which on the data do not fit between them."""

EVEN = 0.2
"""Smallest distance of neighbouring heights on a line across, over their mean distance; closer heights belong to
scattered particles."""

LEAST = 5
"""Smallest number of points for a comparison, and of points across a channel for numbers other than errors."""

FILLING = 0.6
"""Points fill a region if their median distance is at least this fraction of the spacing of as many particles."""

COLUMNS = 8
"""Columns of particles that replace a line across the channel: enough for the fits between points."""

GOLDEN = 0.6180339887498949


@dataclass(frozen=True)
class Aligned:
    """Data as a ``snapshot`` with its reference, in a ``scene`` with the spacing of the data.

    ``points``: number of points of the data, which the snapshot of a channel may repeat along x; ``notes``: how the
    data were aligned, in words.
    """

    scene: Scene
    snapshot: Snapshot
    points: int
    notes: tuple[str, ...] = ()

    def noted(self, text: str) -> "Aligned":
        """Return a copy with one more note."""
        return replace(self, notes=(*self.notes, text))


def orientation(text: str) -> Axes:
    """Return the pair of axes from a text such as ``x,-y``; ConfigError for any other text."""
    pair = tuple(part.strip() for part in text.split(","))
    if pair not in ORIENTATIONS:
        known = " ".join(",".join(each) for each in ORIENTATIONS)
        raise ConfigError(f"--orientation {text}: must be one of {known}, the data's axes along x and y of the scene")
    return pair


def align(
    columns: Columns, scene: Scene, t: float, *, axes: Axes | None = None, origin: tuple[float, float] | None = None
) -> Aligned:
    """Return ``Aligned`` of data at time ``t``; ``columns``: arrays by quantity, in the units of the config.

    ``axes`` is one of ``ORIENTATIONS``, ``origin`` the place in the data of the point (0, 0) of the scene: both are
    found between plane walls where they are not given. ConfigError where the data do not fit.
    """
    if not isinstance(scene, Channel):
        columns = oriented(columns, scene, axes, origin)
        return _aligned(*_completed(columns, scene, t), scene, t)
    if missing := [name for name in "yu" if name not in columns]:
        raise ConfigError(f"--columns: this flow needs {' and '.join(missing)}, too")
    return _between_walls(columns, scene, t, axes, origin)


def oriented(
    columns: Columns, scene: Scene, axes: Axes | None = None, origin: tuple[float, float] | None = None
) -> Columns:
    """Return the columns along the axes of the scene, also of data in r, u_r, u_theta; arguments as of ``align``."""
    return _reoriented(_cartesian(columns, scene), axes or ORIENTATIONS[0], origin or (0.0, 0.0))


def _cartesian(columns: Columns, scene: Scene) -> Columns:
    """Return columns along the axes of the scene, also from data in r, u_r, u_theta.

    The flow does not depend on the angle between cylinders, nor on the place along a pipe: if missing, it is invented.
    """
    if scene.axisymmetric:
        names = {"r": "y", "u_r": "v", "u_theta": "w"}
        columns = {new: columns[old] for old, new in names.items() if old in columns} | columns
        given = "x" in columns or "y" not in columns
        return columns if given else columns | {"x": scene.origin[0] + _made_up(columns["y"], scene.extent[0])}
    placed = {"x", "y"} <= columns.keys()
    if "u_theta" not in columns or not (placed or "r" in columns) or not hasattr(scene, "centre"):
        return columns
    around, along = columns["u_theta"], columns.get("u_r", 0.0)
    if placed:
        places, angle = {}, np.arctan2(columns["y"] - scene.centre[1], columns["x"] - scene.centre[0])
    else:
        angle = _made_up(columns["r"], 2 * np.pi)
        unit = {"x": np.cos(angle), "y": np.sin(angle)}
        places = {name: middle + columns["r"] * unit[name] for name, middle in zip("xy", scene.centre, strict=True)}
    u, v = (along * np.cos(angle) - around * np.sin(angle), along * np.sin(angle) + around * np.cos(angle))
    return columns | places | {"u": u, "v": v}


def _made_up(heights: np.ndarray, size: float) -> np.ndarray:
    """Return coordinates within ``size`` on which the flow does not depend: equal on a line, else evenly spread."""
    if _even(heights):
        return np.full(len(heights), 0.5 * size)
    rank = np.argsort(np.argsort(heights, kind="stable"))
    return rank * GOLDEN % 1.0 * size


def _completed(columns: Columns, scene: Scene, t: float) -> tuple[Columns, tuple[str, ...]]:
    """Return columns with 0 for missing velocities that are 0 in the reference, and a note about them."""
    components = [name for name in "uvw" if name in scene.fields]
    missing = [name for name in ("x", "y", *components) if name not in columns]
    if not {"x", "y"} & set(missing):
        places = columns["x"], columns["y"]
        missing = [name for name in missing if np.any(scene.exact(name, *places, t))]
    if missing:
        raise ConfigError(f"--columns: this flow needs {' and '.join(missing)}, too")
    zero = [name for name in components if name not in columns]
    notes = (f"the data have no {' and no '.join(zero)}: 0 is taken, as in the reference",)
    return columns | {name: np.zeros(len(columns["x"])) for name in zero}, notes[: len(zero)]


def _between_walls(
    columns: Columns, scene: Channel, t: float, axes: Axes | None, origin: tuple[float, float] | None
) -> Aligned:
    """Return the data in the given orientation if they fit; else, or if its error is far smaller, in the best one."""
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


def _has(columns: Columns, axes: Axes) -> bool:
    """Return whether the data have a velocity along the walls and heights with these ``axes``."""
    speed = {"x": "u", "y": "v"}[axes[0][-1]]
    return axes[1][-1] in columns and speed in columns and ("x" in columns or axes[0] == "x")


def _tried(
    columns: Columns, scene: Channel, t: float, axes: Axes, origin: tuple[float, float] | None
) -> Aligned | None:
    """Return ``Aligned`` with these axes, None if the data do not fit between the walls."""
    spacing = _spacing(columns, scene)
    reoriented = _reoriented(columns, axes, origin or (0.0, 0.0))
    low, high = reoriented["y"].min(), reoriented["y"].max()
    mirrored = ", or the velocities have the wrong sign" if axes == ("-x", "y") else ""
    text = f"x and y of the scene point along {axes[0]} and {axes[1]} of the data{mirrored}"
    notes: tuple[str, ...] = () if axes == ORIENTATIONS[0] else (text,)
    if low < -BEYOND * spacing or high > scene.gap + BEYOND * spacing:
        if origin or abs(high - low + spacing - scene.gap) > 2 * BEYOND * spacing:
            return None
        shift = 0.5 * (scene.gap - low - high)
        reoriented["y"] = reoriented["y"] + shift
        wall = shift if axes[1].startswith("-") else -shift
        notes += (f"the bottom wall was found at {axes[1].strip('-')} = {wall:.6g} of the data",)
    elif high - low < 0.5 * scene.gap:
        return None
    return _aligned(reoriented, notes, scene, t)


def _reoriented(columns: Columns, axes: Axes, origin: tuple[float, float]) -> Columns:
    """Return columns in the axes of the scene; coordinates are relative to ``origin``, a point of the data."""
    place = dict(zip("xy", origin, strict=True))
    reoriented = {name: array for name, array in columns.items() if name not in "xyuv"}
    for axis, name, speed in zip(axes, "xy", "uv", strict=True):
        sign, old = (-1.0 if axis.startswith("-") else 1.0), axis[-1]
        if old in columns:
            reoriented[name] = sign * (columns[old] - place[old])
        if (theirs := {"x": "u", "y": "v"}[old]) in columns:
            reoriented[speed] = sign * columns[theirs]
    return reoriented


def _error(aligned: Aligned) -> float:
    """Return the root mean square error of the velocities in any unit: with the best factor that is not negative."""
    u, exact = aligned.snapshot.u, (aligned.snapshot.reference or {})["u"]
    size = np.sum(u**2)
    return root_mean_square((max(np.sum(u * exact) / size, 0.0) if size else 0.0) * u - exact)


def _spacing(columns: Columns, scene: Scene) -> float:
    """Return the spacing of the points: of a lattice of as many points with the same extent, or along a profile."""
    count = len(columns["y"])
    if _is_profile(columns):
        width, height = (np.ptp(columns[name]) if name in columns else 0.0 for name in "xy")
        return float(np.hypot(width, height)) / max(count - 1, 1)
    if not scene.parallel:
        return scene.spacing * np.sqrt(scene.particles / count)
    if "x" not in columns:
        return np.sqrt(scene.extent[0] * scene.extent[1] / count)
    width, height = np.ptp(columns["x"]), np.ptp(columns["y"])
    both, more = width + height, count - 1
    return float(both + np.sqrt(both**2 + 4 * more * width * height)) / (2 * more)


def _is_profile(columns: Columns) -> bool:
    """Return whether the points are on one line; if only one coordinate is given, whether their distances are even."""
    if "x" not in columns:
        return _even(columns["y"])
    places = np.stack([columns["x"] - columns["x"].mean(), columns["y"] - columns["y"].mean()])
    least, largest = np.sqrt(np.maximum(np.linalg.eigvalsh(places @ places.T), 0.0))
    return bool(least <= 1e-7 * largest)  # roots of round-off


def _even(heights: np.ndarray) -> bool:
    steps = np.diff(np.sort(heights))
    return bool(steps.min(initial=np.inf) > EVEN * steps.mean()) if len(steps) else True


def _aligned(columns: Columns, notes: tuple[str, ...], scene: Scene, t: float) -> Aligned:
    if scene.wanted_spacing.varies:  # data count with the one spacing of as many particles
        scene = replace(scene, spacing_sources=())
    spacing, points = _spacing(columns, scene), len(columns["y"])
    if isinstance(scene, Channel):
        columns, scene = _in_channel(columns, scene, spacing)
    else:
        _check_inside(columns, scene, t)
        if abs(spacing / scene.spacing - 1) > 1e-6:
            scene = _with_spacing(scene, spacing)
    x, y = columns["x"], columns["y"]
    low = scene.origin
    places = [
        axis - np.floor((axis - start) / size) * size if periodic else np.clip(axis, start, start + size)
        for axis, start, size, periodic in zip((x, y), low, scene.extent, scene.periodic, strict=True)
    ]
    nothing = np.full(len(y), np.nan)
    carried = {each.name: columns.get(each.name, nothing) for each in scene.substances}
    names = {"u", "v", "density", "pressure", *scene.fields} - carried.keys()
    known: dict[str, Any] = {**{name: columns.get(name, nothing) for name in names}, "substances": carried or None}
    exact = {name: scene.exact(name, places[0], places[1], t) for name in scene.fields}
    bodies = Bodies.at(t, scene.bodies) if scene.bodies else None  # of whose forces the data say nothing
    snapshot = Snapshot(t=t, step=0, x=places[0], y=y, **known, reference=exact, bodies=bodies)
    return Aligned(scene, snapshot, points, notes)


def _check_inside(columns: Columns, scene: Scene, t: float) -> None:
    """Raise ConfigError where points lie outside the walls, or below the axis, by more than a spacing."""
    if not scene.bodies:
        return
    points = np.stack([columns["x"], columns["y"]], axis=1)
    outside = max(-scene.distance(points, t).min(), scene.origin[1] - columns["y"].min())
    if outside > BEYOND * scene.spacing:
        text = f"points lie up to {outside:.4g} outside the fluid; give --unit, --origin or --orientation"
        raise ConfigError(f"the data do not fit between the walls: {text}")


def errors_alone(aligned: Aligned) -> str | None:
    """Return in words why nothing but errors can be measured with so few points; None if all numbers can."""
    scene, snapshot, count = aligned.scene, aligned.snapshot, aligned.points
    reason = "so that nothing but errors, and no number that needs a slope or a mean, is given"
    if scene.parallel:
        return f"{count} points: fewer than {LEAST} across the channel, {reason}" if scene.rows < LEAST else None
    places, least = np.stack([snapshot.x, snapshot.y], axis=1), NEIGHBOURS[4]
    if count < least:
        return f"{count} points: fewer than {least}, {reason}"
    distance = periodic_tree(scene, places)[0].query(places, 2)[0][:, 1]
    fills = np.median(distance) >= FILLING * scene.spacing and not _is_profile({"x": snapshot.x, "y": snapshot.y})
    return None if fills else f"{count} points that do not fill the region evenly, {reason}"


def _in_channel(columns: Columns, scene: Channel, spacing: float) -> tuple[Columns, Channel]:
    """Return columns and scene with the length of the data; the flow does not depend on x, which may be invented."""
    rows = max(round(scene.gap / spacing), 1)
    spacing = scene.gap / rows
    length = scene.length
    if _is_profile(columns):
        points, length = len(columns["y"]), COLUMNS * spacing
        x = np.repeat((np.arange(COLUMNS) + 0.5) * spacing, points)
        columns = {name: np.tile(array, COLUMNS) for name, array in columns.items()} | {"x": x}
    elif "x" not in columns:
        columns = columns | {"x": _made_up(columns["y"], length)}
    else:
        own = float(np.ptp(columns["x"])) + spacing
        length = length if abs(own - length) < 1.5 * spacing else own
    return columns, replace(scene, length=length, spacing=spacing, rows=rows, columns=round(length / spacing))


def _with_spacing(scene: Scene, spacing: float) -> Scene:
    """Return the scene with another spacing, and as many rows and columns as fit."""
    columns, rows = (round(size / spacing) for size in scene.extent)
    return replace(scene, spacing=spacing, columns=columns, rows=rows)
