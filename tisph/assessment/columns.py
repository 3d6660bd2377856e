"""From the columns of the data to quantities in the units of the config; a frame for every time of a table.

Quantities are recognised by names that codes use, or chosen by the user. Units are those that the header of the file
states, or the user says.
"""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from tisph.config.fields import nearest
from tisph.errors import ConfigError


@dataclass(frozen=True)
class Frame:
    """Columns of one time, arrays (points,) by name, in the names, units and axes of the file.

    ``time``: None if the file does not state it; ``label`` may then distinguish frames of a file. ``units`` (name of a
    column, or ``time`` -> unit): where the file states one. ``notes`` say in words how the file was read.
    """

    columns: dict[str, np.ndarray]
    time: float | None = None
    label: str = ""
    units: dict[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


SIZES = {
    "length": {"m": 1.0, "dm": 0.1, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "km": 1e3, "in": 0.0254, "ft": 0.3048},
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0, "h": 3600.0},
    "mass": {"kg": 1.0, "g": 1e-3, "mg": 1e-6, "t": 1e3, "lb": 0.45359237},
    "pressure": {"Pa": 1.0, "hPa": 1e2, "kPa": 1e3, "MPa": 1e6, "mPa": 1e-3, "bar": 1e5},
    "force": {"N": 1.0, "mN": 1e-3, "uN": 1e-6, "kN": 1e3},
}
"""Base quantity -> name of a unit -> its size in the SI unit."""

POWERS = {
    **{base: {base: 1} for base in ("length", "time", "mass")},
    "velocity": {"length": 1, "time": -1},
    "density": {"mass": 1, "length": -3},
    "pressure": {"mass": 1, "length": -1, "time": -2},
    "rate": {"time": -1},
    "viscosity": {"mass": 1, "length": -1, "time": -1},
    "force": {"mass": 1, "length": 1, "time": -2},
    "torque": {"mass": 1, "length": 2, "time": -2},
    "force per length": {"mass": 1, "time": -2},
}
"""Quantity -> powers of length, time and mass. Stresses are pressures."""

QUANTITIES = {"x": "length", "y": "length", "z": "length", "u": "velocity", "v": "velocity", "w": "velocity"}
QUANTITIES |= {"r": "length", "u_r": "velocity", "u_theta": "velocity", "density": "density", "time": "time"}
"""Name of a column -> its quantity; columns of other names are pressures."""

SYMBOL = r"([^\W\d_]+)\^?([-+]?\d+)?"
SIGNS = str.maketrans("²³⁻¹−·⋅×µμ", "23-1-***uu")
"""Pattern of a symbol in a unit with its power; signs that have several spellings."""


def in_config(frame: Frame, texts: Sequence[str] | None, labels: Any, path: Path) -> Frame:
    """Return the frame, with columns by quantity, in the units of the config, whose names are ``labels``.

    ``texts`` such as ``length=cm`` or ``velocity=0.01`` take precedence over units that the file states. The unit of a
    quantity without either is derived from the texts. ConfigError for an unknown quantity or unit.
    """
    given, factors, notes = {}, {}, []
    for text in texts or ():
        quantity, equals, unit = (part.strip() for part in text.partition("="))
        if not equals or quantity not in POWERS:
            raise ConfigError(f"--unit {text}: must look like length=cm, for one of {', '.join(POWERS)}")
        given[quantity] = factor(quantity, unit, labels, f"--unit {text}")
    for name in (*frame.columns, "time"):
        if name == "temperature":  # which nothing converts
            factors[name] = 1.0
            continue
        quantity, stated = QUANTITIES.get(name, "pressure"), frame.units.get(name)
        factors[name] = given.get(quantity, 1.0)
        if stated and quantity in given:
            notes.append(f"the file says that {name} is in {stated}, --unit {quantity} was taken")
        elif stated:
            factors[name] = factor(quantity, stated, labels, f"{path}: {name} [{stated}]")
            notes += [f"{name} is in {stated}, as the file says"] if factors[name] != 1.0 else []
        elif quantity not in given:
            for base, power in POWERS[quantity].items():
                factors[name] *= given.get(base, 1.0) ** power
    bare = [name for name in frame.columns if name in "xyuv" and not frame.units.get(name)]
    if bare and any(factors[name] != 1.0 for name in frame.columns if frame.units.get(name)) and not given:
        notes.append(f"{' and '.join(bare)}, without a unit in the file, is taken to be in that of the config")
    columns = {name: column * factors[name] for name, column in frame.columns.items()}
    time = None if frame.time is None else frame.time * factors["time"]
    return replace(frame, columns=columns, time=time, notes=(*frame.notes, *notes))


def factor(quantity: str, unit: str, labels: Any, where: str) -> float:
    """Return one ``unit`` of the data, such as ``mm``, ``kg/m^3`` or a number, in the unit of the config."""
    try:
        return float(unit)
    except ValueError:
        value, powers, symbols = 1.0, dict.fromkeys(("length", "time", "mass"), 0), _symbols(labels)
    for index, part in enumerate(unit.translate(SIGNS).split("/")):
        for symbol, power in re.findall(SYMBOL, part):
            if symbol not in symbols or re.sub(rf"{SYMBOL}|[\s().*1]", "", part):
                raise ConfigError(f"{where}: {symbol} is not known; give a number, or one of {', '.join(symbols)}")
            number = int(power or 1) * (-1 if index else 1)
            value *= symbols[symbol][0] ** number
            for base, exponent in symbols[symbol][1].items():
                powers[base] += number * exponent
    if {base: power for base, power in powers.items() if power} != POWERS[quantity]:
        raise ConfigError(f"{where}: is no unit of {quantity}")
    return value


def _symbols(labels: Any) -> dict[str, tuple[float, dict[str, int]]]:
    """Return symbol -> its size in the config's units, and its powers.

    If the config's label of a quantity is unknown, it is the only symbol of this quantity.
    """
    found: dict[str, tuple[float, dict[str, int]]] = {}
    for base in ("length", "time", "mass"):
        label = getattr(labels, base)
        sizes = SIZES[base] if label in SIZES[base] else {label: 1.0}
        found |= {symbol: (size / sizes[label], POWERS[base]) for symbol, size in sizes.items()}
    if {"m", "s", "kg"} <= found.keys():
        pascal = found["kg"][0] / found["m"][0] / found["s"][0] ** 2
        found |= {symbol: (size * pascal, POWERS["pressure"]) for symbol, size in SIZES["pressure"].items()}
        newton = pascal * found["m"][0] ** 2
        found |= {symbol: (size * newton, POWERS["force"]) for symbol, size in SIZES["force"].items()}
    return found


PLACE = "(pos|positions?|points|coordinates|coords|r)_?"
NAMES = {axis: f"{axis}|{PLACE}{axis}|p{axis}|{axis}u|{axis}_coordinate" for axis in "xyz"}
NAMES |= {u: f"{u}|(u|v|vel|velo|velocity|velocities)_?{x}|{x}_velocity" for u, x in zip("uvw", "xyz", strict=True)}
NAMES |= {f"stress_{pair}": f"(stress_|s){pair}" for pair in ("xx", "xy", "yy")}
NAMES |= {
    "density": "density|(c_)?rho|rhop",
    "pressure": "pressure|p",
    "time": "t|time|timevalue",
    "temperature": "temp|temperature",
    "step": "(time_?)?step",
}
NAMES |= {"r": "r|radius", "u_r": "[uv]_?r", "u_theta": "[uv]_?(theta|phi)"}
NAMES |= {f"stress_{pair}": f"stress_{pair}" for pair in ("tt", "xt", "yt")}
"""Quantity -> pattern of its names, in lower case, with ``_`` for characters other than letters and digits."""

NEEDED = {"y": ("z", "r"), "u": ("u_theta",)}
"""Quantity that data must have -> quantities that may replace it."""

UNIT = re.compile(r"(.+?)\s*(?:\[([^\[\]]*[^\W\d_][^\[\]]*)\]|\((.*[^\W\d_].*)\))")
"""Pattern of a name with its unit, ``y [m]`` or ``u (m/s)``."""

FLAT = 1e-6
"""Variation of a coordinate, over the size of the data, that counts as none: round-off of single precision."""


REPEATED = 0.01
"""Difference of velocities at one place, over the largest velocity, above which they belong to several times."""


def parsed(texts: Sequence[str], path: str = "--columns") -> dict[str, str]:
    """Return quantity -> name of its column, from texts such as ``x=1,y=2,u=3``; ConfigError for other texts."""
    chosen = {}
    for part in ",".join(texts).split(",") if texts else ():
        quantity, equals, name = (piece.strip() for piece in part.partition("="))
        if quantity not in NAMES or not name or not equals:
            hint = nearest(quantity, list(NAMES)) if equals else "; write it as x=1,y=2,u=3"
            raise ConfigError(f"{path} {part}: the quantities are {', '.join(NAMES)}{hint}")
        chosen[quantity] = name
    return chosen


def by_quantity(frame: Frame, chosen: dict[str, str], path: Path) -> Frame:
    """Return the frame with columns (points,) and units by quantity.

    ``chosen``: quantity -> name, or number from 1, of its column. Other columns are recognised by their names.
    ConfigError if a chosen or a needed column is missing.
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


def recognised(quantity: str, names: dict[str, str]) -> str | None:
    """Return the column whose name fits a quantity, else None; ``names``: column -> its name without its unit."""
    plain = {
        column: re.sub("[^a-z0-9]+", "_", name.lower()).strip("_") for column, name in names.items() if name != "T"
    }
    counted = any(re.fullmatch(f"{PLACE}0", name) for name in plain.values())  # components, as ParaView counts them
    for index, axis in enumerate("xyz"):
        end = f"_[{'ijk'[index]}{index if counted else ''}]$"
        plain = {column: re.sub(end, f"_{axis}", name) for column, name in plain.items()}
    found = [column for column, name in plain.items() if re.fullmatch(NAMES[quantity], name)]
    # PySPH's V is not its v; longer names add something to the name of the quantity
    return min(found, key=lambda column: (names[column] != quantity, len(names[column])), default=None)


def in_plane(frame: Frame, chosen: dict[str, str]) -> Frame:
    """Return the frame, by quantity, with its plane as x and y: the third axis has neither extent nor velocity.

    A velocity along z may be the velocity around the axis of an axisymmetric flow.
    """
    columns, nothing = frame.columns, np.zeros(len(next(iter(frame.columns.values()))))
    table = np.stack([columns.get(name, nothing) for name in "xyzuvw"])
    table = table[:, np.isfinite(table).all(axis=0)]
    if "z" not in columns or chosen.keys() & {"x", "y"} or not table.size:
        return frame
    extent, speed = np.ptp(table[:3], axis=1), np.abs(table[3:]).max(axis=1)
    still = (speed <= FLAT * speed.max()) | np.array([False, False, True])
    flat = [axis for axis, each in zip("xyz", still & (extent <= FLAT * extent.max()), strict=True) if each]
    dropped = max(flat, default=None) if "y" in columns else "y"
    if dropped in (None, "z"):
        note = "z varies, too, and is left out: x and y of the data are taken"
        return frame if dropped else replace(frame, notes=(*frame.notes, note))
    kept = [name for name in "xyzuvw" if name not in (dropped, {"x": "u", "y": "v"}[dropped])]
    names = dict(zip(kept, "xyuv", strict=True)) | {name: name for name in {*columns, "time"} if name not in "xyzuvw"}
    columns = {names[name]: column for name, column in columns.items() if name in names}
    units = {names[name]: unit for name, unit in frame.units.items() if name in names}
    note = f"{kept[0]} and {kept[1]} of the data are taken as x and y"
    return replace(frame, columns=columns, units=units, notes=(*frame.notes, note))


def by_time(frame: Frame, path: Path) -> list[Frame]:
    """Return a frame for every value in the column of times, or of steps if there are no times."""
    columns = {name: column for name, column in frame.columns.items() if name not in ("time", "step")}
    key = next((name for name in ("time", "step") if name in frame.columns), None)
    if key is None and {"y", "u"} <= columns.keys():
        places = np.stack([columns[name] for name in "xyz" if name in columns])
        order = np.lexsort(places)
        same, steps = (np.diff(places[:, order]) == 0).all(axis=0), np.abs(np.diff(columns["u"][order]))
        if np.any(steps[same] > REPEATED * np.max(np.abs(columns["u"]), initial=0.0)):
            note = "velocities differ at one and the same place: data of several times need --columns time=NAME"
            return [replace(frame, notes=(*frame.notes, note))]
    if key is None:
        return [frame]
    values, first, which = np.unique(frame.columns[key], return_index=True, return_inverse=True)
    if not np.isfinite(values).all():
        raise ConfigError(f"{path}: has points without a {key}")
    if frame.time is not None and (len(values) > 1 or (key == "time" and values[0] != frame.time)):
        raise ConfigError(f"{path}: says t = {frame.time:g}, but its column of {key}s has {shown(map(str, values))}")
    found = []
    for index in np.argsort(first):
        part = {name: column[which == index] for name, column in columns.items()}
        time, label = float(values[index]) if key == "time" else frame.time, f"{key} {values[index]:.12g}"
        found.append(replace(frame, columns=part, time=time, label=label))
    return found


def shown(names: Iterable[str]) -> str:
    """Return the first twelve names in words."""
    names = list(names)
    return ", ".join(names[:12]) + (f" and {len(names) - 12} more" if len(names) > 12 else "")
