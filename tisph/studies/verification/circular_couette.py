"""Flow between cylinders in the verification suite: steady, from jumps and oscillating, for several pairs of them.

But for what their names say the radii are 1 and 2 and the inner cylinder rotates at 1, at Re = 50 by its speed and the
gap, that between eccentric cylinders at Re = 0.01; the particles start up to a fifth of a spacing off an even
arrangement, and move.
"""

import math

from tisph.studies.flows import across, at_times, merged
from tisph.studies.verification.criteria import at_most, bounded, order, same_bits

VISCOSITY = 0.02

ANNULUS = {
    "scene": "annulus",
    "fluid": {"density": 1.0, "kinematic_viscosity": VISCOSITY},
    "geometry": {"inner_radius": 1.0, "outer_radius": 2.0},
    "walls": {"inner": {"angular_velocity": 1.0}},
    "initial": {"state": "developed", "jitter": 0.2, "seed": 0},
    "discretisation": {"particles_across": 25},
}

START = {"initial": {"state": "rest"}}
HIGH = {"scheme": {"accuracy": "high"}}


def _between(inner, outer, turning):
    """Change of the radii of the cylinders and of their angular velocities; the gap stays 1."""
    walls = {side: {"angular_velocity": speed} for side, speed in zip(("inner", "outer"), turning, strict=True)}
    return {"geometry": {"inner_radius": inner, "outer_radius": outer}, "walls": walls}


ELSEWHERE = {  # the same in millimetres and minutes
    "geometry": {"inner_radius": 1e3, "outer_radius": 2e3, "centre": [3.7e3, -1.9e4]},
    "fluid": {"density": 1e-9, "kinematic_viscosity": VISCOSITY * 6e7},
    "walls": {"inner": {"angular_velocity": 60.0}},
}

WIDE = {**_between(0.25, 1.25, (4.0, 0.0)), **HIGH}
"""Orders are those of the spacing: with balanced accuracy, or between the usual radii, errors of steps are the larger
part."""

OSCILLATING_INNER = {"walls": {"inner": {"angular_velocity": None, "amplitude": 1.0, "angular_frequency": 0.25}}}
"""At 25 across the layer at the cylinder is sqrt(2 nu/w) = 10 spacings deep."""

ECCENTRIC = {"scene": "eccentric_annulus", "fluid": {"kinematic_viscosity": 100.0}, "geometry": {"eccentricity": 0.5}}
"""By inertia the force is 1e-4 of itself away from that of Stokes flow, the velocity 3e-6."""

SLOW = 2.0
"""t* at which flow between eccentric cylinders, which starts from rest, is steady."""

STEADY = 0.03
"""t* of the samples of steady flows, in which the inner cylinder goes 1.5 gaps."""

LATE = (0.027, 0.2, 1.0)

FULL = {
    "annulus_12_wide": (ANNULUS, across(12), WIDE, (STEADY,)),
    "annulus_25": (ANNULUS, (STEADY,)),
    "annulus_50": (ANNULUS, across(50), (STEADY,)),
    "annulus_25_high": (ANNULUS, HIGH, (STEADY,)),
    "annulus_50_high": (ANNULUS, HIGH, across(50), (STEADY,)),
    "annulus_25_repeat": (ANNULUS, {"runtime": {"threads": 1}}, (STEADY,)),
    "annulus_25_elsewhere": (ANNULUS, ELSEWHERE, (STEADY,)),
    "annulus_25_against": (ANNULUS, _between(1.0, 2.0, (1.0, -0.5)), (STEADY,)),
    "annulus_25_outer": (ANNULUS, _between(1.0, 2.0, (0.0, 0.5)), (STEADY,)),
    "annulus_25_wide": (ANNULUS, WIDE, (STEADY,)),
    "annulus_25_narrow": (ANNULUS, _between(9.0, 10.0, (1 / 9, -0.1)), (STEADY / 3,)),
    "annulus_25_start": (ANNULUS, START, LATE),
    "annulus_50_start": (ANNULUS, START, across(50), LATE),
    "annulus_25_oscillating": (ANNULUS, OSCILLATING_INNER, (0.06, 0.12)),
    "eccentric_16": (ANNULUS, START, ECCENTRIC, across(16), (SLOW,)),
    "eccentric_25": (ANNULUS, START, ECCENTRIC, (SLOW,)),
    "eccentric_25_outer": (ANNULUS, START, ECCENTRIC, _between(1.0, 2.0, (0.0, 0.5)), (SLOW,)),
}
"""Of each run its config, changes of it, and the t* of its samples, the last one its end."""

QUICK = {name: FULL[name] for name in ("annulus_12_wide", "annulus_25_wide", "annulus_25")}
QUICK |= {name: FULL[name] for name in ("eccentric_16", "eccentric_25")}

TORQUES = ("torque_inner off exact", "torque_outer off exact")

ERRORS = {
    "annulus_25": (6e-5, 2e-4),
    "annulus_50": (6e-6, 3e-5),
    "annulus_25_high": (2e-5, 2e-4),
    "annulus_50_high": (2e-6, 3e-5),
    "annulus_25_elsewhere": (6e-5, 2e-4),
    "annulus_25_against": (1.8e-4, 6e-4),
    "annulus_25_outer": (1.8e-4, 6e-4),
    "annulus_25_wide": (1.8e-4, 6e-4),
    "annulus_25_narrow": (1.8e-4, 6e-4),
    "eccentric_25": (1.5e-5, 5e-5),
    "eccentric_25_outer": (2.5e-5, 5e-5),
}
"""Largest L2 of the velocity and error of both torques of steady flows, by run."""

STARTS = {0.027: 5e-5, 0.2: 2e-5, 1.0: 1e-5}
"""Largest L2 at 50 across after the inner cylinder has begun to rotate, by t*."""


def runs(quick):
    """Configs by run name, as plain dicts."""
    return {name: _sampled(*parts) for name, parts in (QUICK if quick else FULL).items()}


def criteria(quick):
    """What the runs are held to, in the order of the table."""
    orders = {"annulus_12_wide": 12, "annulus_25_wide": 25}
    found = [
        *_steady("annulus_25"),
        order("annulus, ratio 0.2, 12/25", orders, STEADY, 3.5, "l2"),
        *_steady("eccentric_25"),
        order("eccentric 16/25", {"eccentric_16": 16, "eccentric_25": 25}, SLOW, 3, "l2"),
    ]
    if quick:
        return found
    return [
        *found,
        *(check for name in ERRORS if name not in ("annulus_25", "eccentric_25") for check in _steady(name)),
        order("annulus 25/50", {"annulus_25_high": 25, "annulus_50_high": 50}, STEADY, 3.5, "l2"),
        same_bits("annulus_25_repeat", "annulus_25"),
        *(at_most("annulus_50_start", t_star, "l2", bound) for t_star, bound in STARTS.items()),
        *(at_most("annulus_50_start", t_star, "torque_inner off exact", 5e-4) for t_star in LATE),
        *(at_most("annulus_50_start", t_star, "l2_pressure", 1e-3) for t_star in LATE),
        *(order("annulus start 25/50", {"annulus_25_start": 25, "annulus_50_start": 50}, t, 3, "l2") for t in LATE),
        *(at_most("annulus_25_oscillating", t_star, "rms", 2e-4) for t_star in (0.06, 0.12)),
    ]


def _steady(name):
    t_star = FULL[name][-1][-1]
    error, torque = ERRORS[name]
    divergence = 1e-2 if name == "annulus_25_wide" else 1e-3
    return [
        at_most(name, t_star, "l2", error),
        *(at_most(name, t_star, quantity, torque) for quantity in TORQUES),
        at_most(name, t_star, "divergence_over_gradient", divergence),
        *([_force(name, t_star, 3e-4)] if name.startswith("eccentric") else []),
    ]


def _force(name, t_star, bound):
    """The force on the inner cylinder, both components, is that of Stokes flow, which has none along x."""

    def off(result):
        x, y, exact = (result.measure(t_star, f"force_{part}") for part in ("x", "y", "y_exact"))
        return math.hypot(x, y - exact) / abs(exact)

    return bounded(name, f"force off exact at t* = {t_star:g}", bound, off)


def _sampled(config, *changes_and_times):
    *changes, times = changes_and_times
    merged_config = merged(config, *changes)
    geometry, fluid = merged_config["geometry"], merged_config["fluid"]
    unit = (geometry["outer_radius"] - geometry["inner_radius"]) ** 2 / fluid["kinematic_viscosity"]
    return merged(merged_config, at_times([t_star * unit for t_star in times]))
