"""Lid-driven cavity in the verification suite: the sharp lid against tables, the regular one against a spectral flow.

Width, height and speed of the lid are 1, so that t* = t. Every flow starts from rest and is judged where it has become
steady, at Re = 100 but for the slow one, which has Re = 1. The particles start up to a fifth of a spacing off an even
arrangement.
"""

from tisph.studies.flows import across, at_times, merged
from tisph.studies.verification.criteria import at_least, at_most, order

SHARP = {
    "scene": "cavity",
    "fluid": {"density": 1.0, "kinematic_viscosity": 0.01},
    "geometry": {"width": 1.0, "height": 1.0},
    "walls": {"lid": {"velocity": 1.0, "profile": "sharp"}},
    "initial": {"jitter": 0.2, "seed": 0},
}
REGULAR = merged(SHARP, {"walls": {"lid": {"profile": "regular"}}})
SLOW = merged(REGULAR, {"fluid": {"kinematic_viscosity": 1.0}})

LATE, SLOW_LATE = 20.0, 1.2
"""t* of the samples."""

FULL = {
    "cavity_25": (SHARP, 25, LATE),
    "cavity_50": (SHARP, 50, LATE),
    "regular_lid_25": (REGULAR, 25, LATE),
    "regular_lid_50": (REGULAR, 50, LATE),
    "regular_lid_slow_16": (SLOW, 16, SLOW_LATE),
    "regular_lid_slow_25": (SLOW, 25, SLOW_LATE),
    "regular_lid_slow_50": (SLOW, 50, SLOW_LATE),
}
"""Of each run its config, the particles across, and the t* of its end."""

QUICK = {name: FULL[name] for name in ("cavity_25", "regular_lid_slow_16", "regular_lid_slow_25")}

EXTREMES = {"cavity_25": 8e-3, "cavity_50": 3e-3}
"""Largest error of the three extremes. At 25 across what is interpolated between particles scatters by 6e-3 from one
moment to another; at 50 by 5e-4."""

LINES = {"cavity_25": 3e-3, "cavity_50": 2e-3}
"""Largest difference from the tables on the centre lines; at 25 across 0.5 to 1.6e-3, from one moment to another."""


def runs(quick):
    """Configs by run name, as plain dicts."""
    chosen = QUICK if quick else FULL
    return {name: merged(config, across(number), at_times([end])) for name, (config, number, end) in chosen.items()}


def criteria(quick):
    """What the runs are held to, in the order of the table."""
    found = [*_sharp("cavity_25"), _order("regular_lid_slow", (16, 25) if quick else (16, 25, 50), SLOW_LATE)]
    return found if quick else [*found, *_sharp("cavity_50"), _order("regular_lid", (25, 50), LATE)]


def _sharp(name):
    extremes = (f"{kind} off exact" for kind in ("u_extreme", "v_max", "v_min"))
    return [
        at_least(name, LATE, "steady", 1),
        *(at_most(name, LATE, quantity, EXTREMES[name]) for quantity in extremes),
        at_most(name, LATE, "centre_line_error", LINES[name]),
    ]


def _order(name, resolutions, t_star):
    case = f"{name} {'/'.join(map(str, resolutions))}"
    return order(case, {f"{name}_{number}": number for number in resolutions}, t_star, 3, "l2")
