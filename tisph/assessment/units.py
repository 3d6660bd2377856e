"""From the units of the data to those of the config: as the file's header states them, or as the user says."""

import re
from dataclasses import replace

from tisph.errors import ConfigError

SIZES = {
    "length": {"m": 1.0, "dm": 0.1, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "km": 1e3, "in": 0.0254, "ft": 0.3048},
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0, "h": 3600.0},
    "mass": {"kg": 1.0, "g": 1e-3, "mg": 1e-6, "t": 1e3, "lb": 0.45359237},
    "pressure": {"Pa": 1.0, "hPa": 1e2, "kPa": 1e3, "MPa": 1e6, "mPa": 1e-3, "bar": 1e5},
}
"""Units by name, in those of the SI."""

POWERS = {
    **{base: {base: 1} for base in ("length", "time", "mass")},
    "velocity": {"length": 1, "time": -1},
    "density": {"mass": 1, "length": -3},
    "pressure": {"mass": 1, "length": -1, "time": -2},
}
"""Powers of length, time and mass that a quantity is made of. Stresses are pressures."""

QUANTITIES = {"x": "length", "y": "length", "z": "length", "u": "velocity", "v": "velocity", "w": "velocity"}
QUANTITIES |= {"r": "length", "u_r": "velocity", "u_theta": "velocity", "density": "density", "time": "time"}
"""What a column is; all others are pressures."""

SYMBOL = r"([^\W\d_]+)\^?([-+]?\d+)?"
SIGNS = str.maketrans("²³⁻¹−·⋅×µμ", "23-1-***uu")
"""A symbol in a unit and its power; signs that are written in several ways."""


def in_config(frame, texts, labels, path):
    """The frame, with columns by quantity, in the units of the config, which are called ``labels``.

    ``texts`` such as ``length=cm`` or ``velocity=0.01`` take precedence over units that the file states. A quantity
    without either is derived from the texts. ConfigError for a quantity or a unit that is not known.
    """
    given, factors, notes = {}, {}, []
    for text in texts or ():
        quantity, equals, unit = (part.strip() for part in text.partition("="))
        if not equals or quantity not in POWERS:
            raise ConfigError(f"--unit {text}: must look like length=cm, for one of {', '.join(POWERS)}")
        given[quantity] = _factor(quantity, unit, labels, f"--unit {text}")
    for name in (*frame.columns, "time"):
        quantity, unit = QUANTITIES.get(name, "pressure"), frame.units.get(name)
        factors[name] = given.get(quantity, 1.0)
        if unit and quantity in given:
            notes.append(f"the file says that {name} is in {unit}, --unit {quantity} was taken")
        elif unit:
            factors[name] = _factor(quantity, unit, labels, f"{path}: {name} [{unit}]")
            notes += [f"{name} is in {unit}, as the file says"] if factors[name] != 1.0 else []
        elif quantity not in given:
            for base, power in POWERS[quantity].items():
                factors[name] *= given.get(base, 1.0) ** power
    bare = [name for name in frame.columns if name in "xyuv" and not frame.units.get(name)]
    if bare and any(factors[name] != 1.0 for name in frame.columns if frame.units.get(name)) and not given:
        notes.append(f"{' and '.join(bare)}, without a unit in the file, is taken to be in that of the config")
    columns = {name: column * factors[name] for name, column in frame.columns.items()}
    time = None if frame.time is None else frame.time * factors["time"]
    return replace(frame, columns=columns, time=time, notes=(*frame.notes, *notes))


def _factor(quantity, unit, labels, where):
    """One ``unit`` of the data, such as ``mm``, ``kg/m^3`` or a number, in the unit of the config."""
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


def _symbols(labels):
    """Size in the config's units, and powers, of every symbol; of a quantity with an unknown label that label alone."""
    found = {}
    for base in ("length", "time", "mass"):
        label = getattr(labels, base)
        sizes = SIZES[base] if label in SIZES[base] else {label: 1.0}
        found |= {symbol: (size / sizes[label], POWERS[base]) for symbol, size in sizes.items()}
    if {"m", "s", "kg"} <= found.keys():
        pascal = found["kg"][0] / found["m"][0] / found["s"][0] ** 2
        found |= {symbol: (size * pascal, POWERS["pressure"]) for symbol, size in SIZES["pressure"].items()}
    return found
