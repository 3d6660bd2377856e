"""Which column is which quantity: by names that codes use, or as the user says."""

from tisph.config.fields import nearest
from tisph.errors import ConfigError

NAMES = {
    "x": "x px pos_x position_x positions_x points_x coordinates_x coords_x r_x xu points:0 x_coordinate",
    "y": "y py pos_y position_y positions_y points_y coordinates_y coords_y r_y yu points:1 y_coordinate",
    "u": "u vx ux u_x v_x vel_x velocity_x velocities_x velocity:0 u:0 vel:0 x_velocity",
    "v": "v vy uy u_y v_y vel_y velocity_y velocities_y velocity:1 u:1 vel:1 y_velocity",
    "density": "density rho c_rho",
    "pressure": "pressure p",
    "stress_xx": "stress_xx sxx",
    "stress_xy": "stress_xy sxy",
    "stress_yy": "stress_yy syy",
}
"""What a quantity is called, the most likely name first; capitals do not count."""


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


def quantities(frame, chosen, path):
    """Arrays (points,) of a frame by quantity; ``chosen`` are names, or numbers from 1, of columns by quantity.

    Without it columns are recognised by their names. ConfigError where a chosen one is missing.
    """
    found = {}
    numbered = list(frame.columns.values())
    for quantity, names in NAMES.items():
        name = chosen.get(quantity)
        if name in frame.columns:
            found[quantity] = frame.columns[name]
        elif name and name.isdigit() and 0 < int(name) <= len(numbered):
            found[quantity] = numbered[int(name) - 1]
        elif name:
            raise ConfigError(f"{path}: has no column {name}; it has {_shown(frame)}")
        elif match := _recognised(frame, names, chosen):
            found[quantity] = frame.columns[match]
    missing = [name for name in ("y", "u") if name not in found]
    if missing:
        text = f"no column is recognised as {' or '.join(missing)}; say which it is with --columns {missing[0]}=NAME"
        raise ConfigError(f"{path}: {text}; the columns are {_shown(frame)}")
    return found


def _recognised(frame, names, chosen):
    free = [name for name in frame.columns if name not in chosen.values()]
    found = {name.lower(): name for name in free} | {name: name for name in free}  # PySPH's V is not its v
    return next((found[name] for name in names.split() if name in found), None)


def _shown(frame):
    names = list(frame.columns)
    return ", ".join(names[:12]) + (f" and {len(names) - 12} more" if len(names) > 12 else "")
