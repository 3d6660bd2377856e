"""Oldroyd-B liquids in the verification suite: start-up from rest, in which velocity and stress overshoot.

The base has Weissenberg number 1, by the wall's velocity, and a tenth of the viscosity from the solvent.
"""

from tisph.verification import flows
from tisph.verification.criteria import at_most, closes, order, same_velocities
from tisph.verification.flows import across, merged, oldroyd_b

FLOWS = {"oldroyd_b_couette": flows.OLDROYD_B_COUETTE, "oldroyd_b_poiseuille": flows.OLDROYD_B_POISEUILLE}

BOUNDS = {"l2": 2e-2, "shear_stress_l2": 2e-2, "normal_stress_l2": 4e-2, "wall_shear": 1e-2}

ORDER = 1.7

LATER = (1.0, 2.0)
"""t* at which the normal stress has an order too.

The layer that a wall makes when it jumps is at first thinner than a spacing. What the first row misses then stays in
its stress for a relaxation time, and is of first order there: it shows in the wall shear of slow liquids as well.
"""

VARIANTS = {
    "relaxation_0.1": oldroyd_b(relaxation_time=0.1),
    "relaxation_5": oldroyd_b(relaxation_time=5.0),
    "solvent_0.5": oldroyd_b(relaxation_time=0.2, solvent_fraction=0.5),
}

SLOW = {"oldroyd_b_couette_relaxation_5": {"wall_shear": 2e-2}}
"""Other bounds: at t* = 0.5 a liquid of relaxation time 5 remembers the jump of the wall, see ``LATER``."""

SHORT = (0.1,)
"""t*, long enough for a polymer to show."""


def runs(quick):
    """Configs by run name: a flow's own name for 50 across, and with what differs behind it."""
    return _quick_runs() if quick else _full_runs()


def criteria(quick):
    """What the runs are held to, in the order of the table."""
    return _quick_criteria() if quick else _full_criteria()


def _full_runs():
    found = {}
    for name, flow in FLOWS.items():
        found |= {name: flow.at(), f"{name}_25": flow.at(across(25)), f"{name}_100": flow.at(across(100))}
        found |= {f"{name}_{variant}": flow.at(change) for variant, change in VARIANTS.items()}
    return found | _without_polymer()


def _full_criteria():
    found = []
    for name, flow in FLOWS.items():
        for case in (name, *(f"{name}_{variant}" for variant in VARIANTS)):
            found += _accuracy(case, flow.samples)
        times = {"l2": flow.samples, "shear_stress_l2": flow.samples, "normal_stress_l2": LATER}
        resolutions = {f"{name}_25": 25, name: 50, f"{name}_100": 100}
        found += [order(name, resolutions, t, ORDER, quantity) for quantity in times for t in times[quantity]]
    return [*found, same_velocities("oldroyd_b_without_polymer", "newtonian", 1e-12)]


def _quick_runs():
    return {
        "oldroyd_b_couette": flows.OLDROYD_B_COUETTE.at(across(25), samples=(0.5, 1.0)),
        "oldroyd_b_poiseuille": flows.OLDROYD_B_POISEUILLE.at(across(25), samples=(0.5, 1.0)),
        **_without_polymer(),
    }


def _quick_criteria():
    return [
        *(criterion for name in FLOWS for criterion in _accuracy(name, (0.5, 1.0))),
        same_velocities("oldroyd_b_without_polymer", "newtonian", 1e-12),
    ]


def _accuracy(case, samples):
    """Bounds of velocity and stresses at every sample, and of the momentum balance."""
    bounds = {**BOUNDS, **SLOW.get(case, {})}
    criteria = [at_most(case, t_star, quantity, bound) for t_star in samples for quantity, bound in bounds.items()]
    return [*criteria, closes(case, 0.01)]


def _without_polymer():
    """The same liquid as an Oldroyd-B liquid whose viscosity is all the solvent's, and as a Newtonian one."""
    driven = flows.OLDROYD_B_POISEUILLE
    newtonian = merged(driven.config, across(25))
    newtonian["fluid"] = {"density": 1.0, "kinematic_viscosity": 1.0}
    return {
        "oldroyd_b_without_polymer": driven.at(across(25), oldroyd_b(solvent_fraction=1.0), samples=SHORT),
        "newtonian": flows.sampled(newtonian, SHORT),
    }
