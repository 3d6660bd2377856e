"""From the units of the data to those of the config: as the file's header states them, or as the user says."""

import re
from dataclasses import replace

import numpy as np

from tisph.errors import ConfigError

SIZES = {
    "length": {"m": 1.0, "dm": 0.1, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "km": 1e3, "in": 0.0254, "ft": 0.3048},
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0, "h": 3600.0},
    "mass": {"kg": 1.0, "g": 1e-3, "mg": 1e-6, "t": 1e3, "lb": 0.45359237},
}
"""Units by name, in those of the SI."""

PASCALS = {"Pa": 1.0, "hPa": 1e2, "kPa": 1e3, "MPa": 1e6, "mPa": 1e-3, "bar": 1e5}
"""Units of pressure by name, in kg/(m s^2)."""

POWERS = {
    **{base: {base: 1} for base in SIZES},
    "velocity": {"length": 1, "time": -1},
    "density": {"mass": 1, "length": -3},
    "pressure": {"mass": 1, "length": -1, "time": -2},
}
"""Powers of length, time and mass that a quantity is made of. Stresses are pressures."""

QUANTITIES = {"x": "length", "y": "length", "z": "length", "u": "velocity", "v": "velocity", "w": "velocity"}
QUANTITIES |= {"density": "density", "time": "time"}
"""What a column is; all others are pressures."""

KNOWN = {name: (size, {base: 1}) for base, sizes in SIZES.items() for name, size in sizes.items()}
KNOWN |= {name: (size, POWERS["pressure"]) for name, size in PASCALS.items()}
"""Size in the SI and powers of length, time and mass of every symbol."""

ATOM = re.compile(r"([^\W\d_]+)\^?([-+]?\d+)?")
SIGNS = str.maketrans("²³⁻¹−·⋅×µμ", "23-1-***uu")
"""One symbol of a unit and its power; signs that are written in several ways."""


def in_config(frame, texts, labels, path):
    """The frame, with columns by quantity, in the units of the config, which are called ``labels``.

    ``texts`` such as ``length=cm`` or ``velocity=0.01`` take precedence over units that the file states. A quantity
    without either is derived from the texts. ConfigError for a quantity or a unit that is not known.
    """
    given = {}
    for text in texts or ():
        quantity, equals, unit = (part.strip() for part in text.partition("="))
        if not equals or quantity not in POWERS:
            raise ConfigError(f"--unit {text}: must look like length=cm, for one of {', '.join(POWERS)}")
        given[quantity] = _given(quantity, unit, labels)
    factors, notes, bare = {}, [], []
    for name in (*frame.columns, "time"):
        quantity, unit = QUANTITIES.get(name, "pressure"), frame.units.get(name, "").strip(" -1")
        derived = np.prod([given.get(base, 1.0) ** power for base, power in POWERS[quantity].items()])
        factors[name] = given.get(quantity, float(derived))
        if unit and quantity in given:
            notes.append(f"the file says that {name} is in {unit}, --unit {quantity} was taken")
        elif unit:
            try:
                factors[name] = _factor(quantity, unit, labels)
            except ConfigError as error:
                raise ConfigError(f"{path}: {name} is in {unit}: {error}; --unit {quantity}= gives another") from None
            notes += [f"{name} is in {unit}, as the file says"] if factors[name] != 1.0 else []
        elif quantity not in given and name in "xyuv":
            bare.append(name)
    if bare and notes and not given:
        notes.append(f"{' and '.join(bare)}, without a unit in the file, is taken as in the config")
    columns = {name: column * factors[name] for name, column in frame.columns.items()}
    time = None if frame.time is None else frame.time * factors["time"]
    return replace(frame, columns=columns, time=time, notes=(*frame.notes, *notes))


def _given(quantity, unit, labels):
    try:
        return float(unit)
    except ValueError:
        pass
    try:
        return _factor(quantity, unit, labels)
    except ConfigError as error:
        raise ConfigError(f"--unit {quantity}={unit}: {error}") from None


def _factor(quantity, unit, labels):
    """One ``unit`` of the data, such as ``mm`` or ``kg/m^3``, in the unit of the config."""
    own = {getattr(labels, base): base for base in SIZES}
    value, powers = 1.0, dict.fromkeys(SIZES, 0)
    for number, part in enumerate(unit.translate(SIGNS).replace("**", "^").split("/")):
        if not re.fullmatch(rf"(?:{ATOM.pattern}|[\s().*1])*", part):
            raise ConfigError(f"{unit} is not known; give a number")
        for symbol, power in ATOM.findall(part):
            sign = int(power or 1) * (-1 if number else 1)
            size, made = (1.0, {own[symbol]: 1}) if symbol in own else KNOWN.get(symbol, (0.0, {}))
            if not made:
                raise ConfigError(f"{symbol} is not known; give a number, or one of {', '.join(KNOWN)}")
            for base, exponent in made.items():
                label = getattr(labels, base)
                if symbol != label and label not in SIZES[base]:
                    raise ConfigError(f"the size of {label}, the config's unit of {base}, is not known; give a number")
                size /= 1.0 if symbol == label else SIZES[base][label] ** exponent
                powers[base] += sign * exponent
            value *= size**sign
    if powers != dict.fromkeys(SIZES, 0) | POWERS[quantity]:
        raise ConfigError(f"{unit} is no unit of {quantity}")
    return value
