"""Two-dimensional flow in the verification suite: Taylor-Green vortices against their exact decay, and a shear layer.

Every config has U = L = 1 and a density of 1, so that t* = t, and scheme ``auto``. But for what their names say the
vortices have Re = U L / nu = 100 and 50 x 50 particles that start up to a fifth of a spacing off a lattice.
"""

from tisph.studies.flows import across, at_times, jitter, merged
from tisph.studies.verification.criteria import at_least, at_most, order, same_bits, steps_at_most

TAYLOR_GREEN = {
    "scene": "taylor_green",
    "fluid": {"density": 1.0, "kinematic_viscosity": 0.01},
    "geometry": {"length": 1.0},
    "initial": {"velocity": 1.0, "jitter": 0.2, "seed": 0},
    "discretisation": {"particles_across": 50},
}

SHEAR_LAYER = {
    "scene": "shear_layer",
    "fluid": {"density": 1.0, "kinematic_viscosity": 2e-3},
    "geometry": {"length": 1.0},
    "initial": {"velocity": 1.0, "thickness": 1 / 30, "perturbation": 0.05, "jitter": 0.1, "seed": 0},
    "discretisation": {"particles_across": 64},
}

EARLY = (0.5, 1.0, 2.0)
LATE = (2.0, 5.0, 20.0)
ROLLED_UP = (0.8, 1.6)

HIGH = {"scheme": {"accuracy": "high"}}
FAST_FLOW = {"fluid": {"kinematic_viscosity": 1e-3}}
COURANT = {"time": {"cfl": 0.3}}

FULL = {
    "taylor_green": (TAYLOR_GREEN, (*EARLY, 20.0)),
    "taylor_green_repeat": (TAYLOR_GREEN, {"runtime": {"threads": 1}}, (*EARLY, 20.0)),
    "taylor_green_high": (TAYLOR_GREEN, HIGH, EARLY),
    "taylor_green_lattice": (TAYLOR_GREEN, jitter(0.0), EARLY),
    "taylor_green_re_1000": (TAYLOR_GREEN, FAST_FLOW, LATE),
    "taylor_green_25": (TAYLOR_GREEN, across(25), EARLY),
    "taylor_green_25_resumed": (TAYLOR_GREEN, across(25), {"output": {"checkpoint_every": 0.2}}, EARLY),
    "taylor_green_100": (TAYLOR_GREEN, across(100), EARLY),
    "taylor_green_100_high": (TAYLOR_GREEN, across(100), HIGH, EARLY),
    **{f"taylor_green_courant_{n}": (TAYLOR_GREEN, across(n), COURANT, (1.0,)) for n in (25, 50, 100)},
    "shear_layer": (SHEAR_LAYER, ROLLED_UP),
}
"""Of each run its config, changes of it, and the t* of its samples, the last one its end."""

QUICK = {"taylor_green": (TAYLOR_GREEN, EARLY), "taylor_green_25": FULL["taylor_green_25"]}

SPREAD = {"nearest_two": 0.55, "largest_hole": 1.15}
"""Distance of the two nearest particles, at least, and radius of the largest hole, at most, in spacings."""

MOMENTUM = {50: 2e-6, 100: 3e-8}
"""Mean velocity over U by particles across. It is conserved to the truncation error of the pressure's gradient, since
the rows are not antisymmetric in pairs, and not to the digit."""

ERRORS = {
    "taylor_green": {"l2": 6e-5, "l2_pressure": 1e-4},
    "taylor_green_high": {"l2": 2e-5, "l2_pressure": 1e-4},
    "taylor_green_lattice": {"l2": 1e-4, "l2_pressure": 1e-4},
    "taylor_green_25": {"l2": 1.2e-3, "l2_pressure": 3e-3},
    "taylor_green_100": {"l2": 6e-6, "l2_pressure": 1e-5},
    "taylor_green_100_high": {"l2": 2e-6, "l2_pressure": 1e-5},
}
"""Largest errors by run, at all of ``EARLY``."""

STEPS = {"taylor_green": 220, "taylor_green_25": 170, "taylor_green_100": 430}
"""Most steps to t* = 2, by run."""

LATE_ERRORS = {2.0: 3e-4, 5.0: 6e-4}
"""L2 of the velocity at Re = 1000, by t*."""


def runs(quick):
    """Configs by run name, as plain dicts."""
    return {name: _sampled(*parts) for name, parts in (QUICK if quick else FULL).items()}


def criteria(quick):
    """What the runs are held to, in the order of the table."""
    found = [*_errors("taylor_green"), *_balances("taylor_green", 50)]
    if quick:
        return [*found, *_errors("taylor_green_25"), *_orders({"taylor_green_25": 25, "taylor_green": 50})]
    return [
        *found,
        *_spread("taylor_green", (20.0,)),
        same_bits("taylor_green_repeat", "taylor_green"),
        same_bits("taylor_green_25_resumed", "taylor_green_25"),
        *(check for name in ERRORS if name != "taylor_green" for check in _errors(name)),
        *_spread("taylor_green_lattice", EARLY),
        *_balances("taylor_green_100", 100),
        *(at_most("taylor_green_re_1000", t_star, "l2", bound) for t_star, bound in LATE_ERRORS.items()),
        *_spread("taylor_green_re_1000", LATE),
        *_orders({f"taylor_green_courant_{number}": number for number in (25, 50, 100)}),
        *_spread("shear_layer", ROLLED_UP),
        *(at_most("shear_layer", t_star, "divergence_over_gradient", 1e-3) for t_star in ROLLED_UP),
    ]


def _sampled(config, *changes_and_times):
    *changes, times = changes_and_times
    return merged(config, *changes, at_times(times))


def _errors(name):
    steps = [steps_at_most(name, STEPS[name], t_star=2.0)] if name in STEPS else []
    return [*(at_most(name, t_star, key, bound) for key, bound in ERRORS[name].items() for t_star in EARLY), *steps]


def _balances(name, number):
    """Criteria of what the flow keeps or loses at a known rate, and of the particles' positions."""
    return [
        at_most(name, 2.0, "kinetic_energy off exact", 2e-4),
        at_most(name, 2.0, "dissipation off exact", 1e-3),
        *(at_most(name, t_star, "divergence_over_gradient", 1e-4) for t_star in EARLY),
        at_most(name, 2.0, "momentum_drift", MOMENTUM[number]),
        *_spread(name, EARLY),
    ]


def _spread(name, times):
    nearest = [at_least(name, t_star, "nearest_two", SPREAD["nearest_two"]) for t_star in times]
    return [*nearest, *(at_most(name, t_star, "largest_hole", SPREAD["largest_hole"]) for t_star in times)]


def _orders(resolutions):
    case = "taylor_green " + "/".join(str(number) for number in resolutions.values())
    return [order(case, resolutions, 1.0, 3, quantity) for quantity in ("l2", "l2_pressure")]
