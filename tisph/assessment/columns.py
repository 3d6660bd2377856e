"""Which column is which quantity: by names that codes use, or as the user says; a frame for every time of a table."""

import re
from dataclasses import replace

import numpy as np

from tisph.config.fields import nearest
from tisph.errors import ConfigError

PLACES = "pos position positions points coordinates coords r"
SPEEDS = "u v vel velo velocity velocities"

NAMES = {
    **{
        axis: f"{axis} p{axis} pos{axis} {axis}u {axis}_coordinate "
        + " ".join(f"{base}_{axis}" for base in PLACES.split())
        for axis in "xyz"
    },
    **{
        speed: f"{speed} v{axis} u{axis} vel{axis} {axis}_velocity "
        + " ".join(f"{base}_{axis}" for base in SPEEDS.split())
        for speed, axis in zip("uvw", "xyz", strict=True)
    },
    "density": "density rho c_rho rhop",
    "pressure": "pressure p",
    "stress_xx": "stress_xx sxx",
    "stress_xy": "stress_xy sxy",
    "stress_yy": "stress_yy syy",
    "time": "t time timevalue",
    "step": "step timestep time_step",
}
"""What a quantity is called, the most likely name first, in small letters and with ``_`` for all that is no letter."""

UNIT = re.compile(r"(.+?)\s*(?:\[([^\[\]]*[^\d\[\]][^\[\]]*)\]|\((.*\D.*)\))")
"""A name and its unit, ``y [m]`` or ``u (m/s)``; digits alone are an index."""

FLAT = 1e-6
"""Part of the size of the data below which a coordinate does not vary: round-off of single precision."""


def parsed(texts, path="--columns"):
    """Map of quantities to names of columns from texts such as ``x=1,y=2,u=3``; ConfigError for any other."""
    chosen = {}
    for part in ",".join(texts).split(",") if texts else ():
        quantity, equals, name = (piece.strip() for piece in part.partition("="))
        if quantity not in NAMES or not name or not equals:
            hint = nearest(quantity, list(NAMES)) if equals else "; write it as x=1,y=2,u=3"
            raise ConfigError(f"{path} {part}: the quantities are {', '.join(NAMES)}{hint}")
        chosen[quantity] = name
    return chosen


def frames(found, chosen, path):
    """Frames with columns (points,) by quantity, in the plane in which the data lie, and of one time each.

    ``found`` are the frames of a file; ``chosen`` are names, or numbers from 1, of columns by quantity. Without it
    columns are recognised by their names. ConfigError where a chosen or a needed one is missing.
    """
    planes = [_in_plane(_by_quantity(frame, chosen, path), chosen) for frame in found]
    return [part for frame in planes for part in _by_time(frame, path)]


def _by_quantity(frame, chosen, path):
    """The frame with columns and units by quantity, of the columns that are recognised or chosen."""
    parts = {name: UNIT.fullmatch(name) for name in frame.columns}
    plain = {name: match[1] if match else name for name, match in parts.items()}
    units = {name: match[2] or match[3] for name, match in parts.items() if match} | frame.units
    found, numbered = {}, list(frame.columns)
    for quantity, names in NAMES.items():
        name = chosen.get(quantity)
        if name is None:
            name = recognised(names, {each: plain[each] for each in numbered if each not in chosen.values()})
        elif name not in numbered:
            called = [each for each in numbered if plain[each] == name]
            called += [numbered[int(name) - 1]] if name.isdigit() and 0 < int(name) <= len(numbered) else []
            if not called:
                raise ConfigError(f"{path}: has no column {name}; it has {shown(numbered)}")
            name = called[0]
        if name is not None:
            found[quantity] = name
    if missing := [name for name in ("y", "u") if name not in found and (name == "u" or "z" not in found)]:
        text = f"no column is recognised as {' or '.join(missing)}; say which it is with --columns {missing[0]}=NAME"
        raise ConfigError(f"{path}: {text}; the columns are {shown(numbered)}")
    units = {quantity: units[name] for quantity, name in ({"time": "time"} | found).items() if name in units}
    return replace(frame, columns={quantity: frame.columns[name] for quantity, name in found.items()}, units=units)


def recognised(names, columns):
    """The column with one of ``names``, None without one; ``columns`` are the columns' names without units."""
    found = {}
    for column, name in columns.items():
        plain = "T" if name == "T" else re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_")  # T is a temperature
        found.setdefault(plain, column)
    if any({f"{base}_0", f"{base}_1"} <= found.keys() for base in PLACES.split()):  # ParaView numbers components
        found = {re.sub("_([012])$", lambda end: f"_{'xyz'[int(end[1])]}", name): each for name, each in found.items()}
    found |= {name: column for column, name in columns.items()}  # PySPH's V is not its v
    return next((found[name] for name in names.split() if name in found), None)


def _in_plane(frame, chosen):
    """The frame with the axes of its plane as x and y: without the axis along which the points have no extent."""
    columns = frame.columns
    if "z" not in columns or chosen.keys() & {"x", "y"}:
        return frame
    finite = {axis: columns[axis][np.isfinite(columns[axis])] for axis in "xyz" if axis in columns}
    extent = {axis: float(np.ptp(places)) if len(places) else 0.0 for axis, places in finite.items()}
    flat = [axis for axis in "zyx" if axis in extent and extent[axis] <= FLAT * max(extent.values())]
    dropped = next(iter(flat), "z") if "y" in columns else "y"
    if dropped == "z":
        note = "z varies, too, and is left out: x and y of the data are taken"
        return frame if flat else replace(frame, notes=(*frame.notes, note))
    axes, speed = "xyz".replace(dropped, ""), dict(zip("xyz", "uvw", strict=True))
    names = dict(zip((*axes, *(speed[axis] for axis in axes)), "xyuv", strict=True))
    names |= {name: name for name in {*columns, "time"} if name not in speed and name not in speed.values()}
    return replace(
        frame,
        columns={names[name]: column for name, column in columns.items() if name in names},
        units={names[name]: unit for name, unit in frame.units.items() if name in names},
        notes=(*frame.notes, f"{axes[0]} and {axes[1]} of the data are taken as x and y"),
    )


def _by_time(frame, path):
    """A frame for every value of the column of times, or of steps where there are no times."""
    columns = {name: column for name, column in frame.columns.items() if name not in ("time", "step")}
    key = next((name for name in ("time", "step") if name in frame.columns), None)
    if key is None or frame.time is not None:
        return [replace(frame, columns=columns)]
    if not np.isfinite(frame.columns[key]).all():
        raise ConfigError(f"{path}: has points without a {key}")
    values, first, which = np.unique(frame.columns[key], return_index=True, return_inverse=True)
    return [
        replace(
            frame,
            columns={name: column[which == index] for name, column in columns.items()},
            time=float(values[index]) if key == "time" else None,
            label=f"{key} {values[index]:.12g}",
        )
        for index in np.argsort(first)
    ]


def shown(names):
    """The first twelve names in words."""
    return ", ".join(names[:12]) + (f" and {len(names) - 12} more" if len(names) > 12 else "")
