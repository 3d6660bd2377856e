"""Which column is which quantity: by names that codes use, or as the user says; a frame for every time of a table."""

import re
from dataclasses import replace

import numpy as np

from tisph.config.fields import nearest
from tisph.errors import ConfigError

PLACES = ("pos", "position", "positions", "points", "coordinates", "coords", "r")
SPEEDS = ("u", "v", "vel", "velo", "velocity", "velocities")

NAMES = {axis: [axis, f"p{axis}", f"pos{axis}", *(f"{base}_{axis}" for base in PLACES), f"{axis}u"] for axis in "xyz"}
NAMES |= {
    speed: [speed, f"v{axis}", f"u{axis}", f"vel{axis}", *(f"{base}_{axis}" for base in SPEEDS), f"{axis}_velocity"]
    for speed, axis in zip("uvw", "xyz", strict=True)
}
NAMES |= {f"stress_{pair}": [f"stress_{pair}", f"s{pair}"] for pair in ("xx", "xy", "yy")}
NAMES |= {"density": ["density", "rho", "c_rho", "rhop"], "pressure": ["pressure", "p"]}
NAMES |= {"r": ["r", "radius"], "u_r": ["u_r", "ur", "v_r", "vr"]}
NAMES |= {"u_theta": ["u_theta", "utheta", "u_t", "v_theta", "vtheta", "u_phi", "v_phi"]}
NAMES |= {f"stress_{pair}": [f"stress_{pair}"] for pair in ("tt", "xt", "yt")}
NAMES |= {"time": ["t", "time", "timevalue"], "step": ["step", "timestep", "time_step"]}
"""What a quantity is called, the most likely name first, in small letters and with ``_`` for all that is no letter."""

NEEDED = {"y": ("z", "r"), "u": ("u_theta",)}
"""Quantities that data must have, and others in their place."""

UNIT = re.compile(r"(.+?)\s*(?:\[([^\[\]]*[^\W\d_][^\[\]]*)\]|\((.*[^\W\d_].*)\))")
"""A name and its unit, ``y [m]`` or ``u (m/s)``."""

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


def by_quantity(frame, chosen, path):
    """The frame with columns (points,) and units by quantity; ``chosen`` are names, or numbers from 1, of columns.

    Without it columns are recognised by their names. ConfigError where a chosen or a needed one is missing.
    """
    stated = {column: UNIT.fullmatch(column) for column in frame.columns}
    names = {column: match[1] if match else column for column, match in stated.items()}
    units = {column: match[2] or match[3] for column, match in stated.items() if match} | frame.units
    found = {}
    for quantity in NAMES:
        wanted, numbered = chosen.get(quantity), enumerate(names.items(), 1)
        called = [column for number, (column, name) in numbered if wanted in (column, name, str(number))]
        if wanted and not called:
            raise ConfigError(f"{path}: has no column {wanted}; it has {shown(names)}")
        free = {column: name for column, name in names.items() if not {column, name} & set(chosen.values())}
        if column := called[0] if wanted else recognised(quantity, free):
            found[quantity] = column
    if missing := [name for name, others in NEEDED.items() if not {name, *others} & found.keys()]:
        text = f"no column is recognised as {' or '.join(missing)}; say which it is with --columns {missing[0]}=NAME"
        raise ConfigError(f"{path}: {text}; the columns are {shown(names)}")
    units = {quantity: units[column] for quantity, column in ({"time": "time"} | found).items() if column in units}
    return replace(frame, columns={quantity: frame.columns[column] for quantity, column in found.items()}, units=units)


def recognised(quantity, names):
    """The column that is called like a quantity, None without one; ``names`` are the columns' without their units."""
    found = {}
    for column, name in names.items():
        plain = re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_")
        found.setdefault("T" if name == "T" else plain, column)  # a temperature
    if any({f"{base}_0", f"{base}_1"} <= found.keys() for base in PLACES):  # ParaView numbers components
        found = {re.sub("_([012])$", lambda end: f"_{'xyz'[int(end[1])]}", name): each for name, each in found.items()}
    found |= {name: column for column, name in names.items()}  # PySPH's V is not its v
    return next((found[name] for name in NAMES[quantity] if name in found), None)


def in_plane(frame, chosen):
    """The frame, by quantity, with the axes of its plane as x and y: without the axis along which it has no extent."""
    places = {axis: frame.columns[axis] for axis in "xyz" if axis in frame.columns}
    if "z" not in places or chosen.keys() & {"x", "y"}:
        return frame
    extent = {axis: np.ptp(np.nan_to_num(place, nan=np.nanmean(place))) for axis, place in places.items()}
    flat = [axis for axis in "zyx" if extent.get(axis, 0.0) <= FLAT * max(extent.values())]
    if not flat:
        return replace(frame, notes=(*frame.notes, "z varies, too, and is left out: x and y of the data are taken"))
    if (dropped := "y" if "y" not in places else flat[0]) == "z":
        return frame
    kept = [name for name in "xyzuvw" if name not in (dropped, {"x": "u", "y": "v"}[dropped])]
    names = {name: name for name in {*frame.columns, "time"} if name not in "xyzuvw"} | dict(
        zip(kept, "xyuv", strict=True)
    )
    columns = {names[name]: column for name, column in frame.columns.items() if name in names}
    units = {names[name]: unit for name, unit in frame.units.items() if name in names}
    note = f"{kept[0]} and {kept[1]} of the data are taken as x and y"
    return replace(frame, columns=columns, units=units, notes=(*frame.notes, note))


def by_time(frame, path):
    """Frames for every value of the column of times, or of steps where there are no times."""
    columns = {name: column for name, column in frame.columns.items() if name not in ("time", "step")}
    key = next((name for name in ("time", "step") if name in frame.columns), None)
    if key is None or frame.time is not None:
        return [replace(frame, columns=columns)]
    if not np.isfinite(frame.columns[key]).all():
        raise ConfigError(f"{path}: has points without a {key}")
    values, first, which = np.unique(frame.columns[key], return_index=True, return_inverse=True)
    found = []
    for index in np.argsort(first):
        part = {name: column[which == index] for name, column in columns.items()}
        time, label = float(values[index]) if key == "time" else None, f"{key} {values[index]:.12g}"
        found.append(replace(frame, columns=part, time=time, label=label))
    return found


def shown(names):
    """The first twelve names in words."""
    return ", ".join(list(names)[:12]) + (f" and {len(names) - 12} more" if len(names) > 12 else "")
