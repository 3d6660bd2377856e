"""From the units of the data to those of the config: a factor a quantity."""

from tisph.errors import ConfigError

SIZES = {
    "length": {"m": 1.0, "dm": 0.1, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "km": 1e3, "in": 0.0254, "ft": 0.3048},
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0, "h": 3600.0},
    "mass": {"kg": 1.0, "g": 1e-3, "mg": 1e-6, "t": 1e3, "lb": 0.45359237},
}
"""Units by name, in those of the SI."""

DERIVED = {
    "velocity": {"length": 1, "time": -1},
    "density": {"mass": 1, "length": -3},
    "pressure": {"mass": 1, "length": -1, "time": -2},
}
"""What follows from length, time and mass: powers of each. Stresses are pressures."""

QUANTITIES = {"x": "length", "y": "length", "u": "velocity", "v": "velocity", "density": "density", "time": "time"}
"""What a column is; all others are pressures."""


def factors(texts, labels):
    """Factor of every quantity from texts such as ``length=cm`` or ``velocity=0.01``.

    ``labels`` are the units of the config. A quantity that is derived follows from those it is made of, unless it is
    given itself. ConfigError for a quantity or a unit that is not known.
    """
    given = {}
    for text in texts or ():
        quantity, equals, unit = (part.strip() for part in text.partition("="))
        if not equals or quantity not in (*SIZES, *DERIVED):
            raise ConfigError(f"--unit {text}: must look like length=cm, for one of {', '.join((*SIZES, *DERIVED))}")
        given[quantity] = _factor(quantity, unit, labels)
    found = {quantity: given.get(quantity, 1.0) for quantity in SIZES}
    for quantity, powers in DERIVED.items():
        value = 1.0
        for base, power in powers.items():
            value *= found[base] ** power
        found[quantity] = given.get(quantity, value)
    return found


def _factor(quantity, unit, labels):
    try:
        return float(unit)
    except ValueError:
        pass
    if quantity in SIZES:
        return _size(quantity, unit) / _size(quantity, getattr(labels, quantity))
    numerator, slash, denominator = unit.partition("/")
    if quantity == "velocity" and slash:
        return _factor("length", numerator, labels) / _factor("time", denominator, labels)
    raise ConfigError(f"--unit {quantity}={unit}: give a number, what one of the data's is in the config's units")


def _size(quantity, unit):
    if unit not in SIZES[quantity]:
        known = ", ".join(SIZES[quantity])
        raise ConfigError(f"--unit {quantity}: {unit} is not known; give a number, or one of {known}")
    return SIZES[quantity][unit]


def converted(columns, factor):
    """Columns by quantity in the units of the config."""
    return {name: array * factor[QUANTITIES.get(name, "pressure")] for name, array in columns.items()}
